const done = data.cells.filter((c) => !c.failed);
const methods = [];
for (const cell of done) for (const m of cell.methods) if (!methods.some((o) => o.method === m.method)) methods.push(m);
const state = { row: "coherence99", by: "name", down: false };

/** What a cell has for a method in the row shown. */
function value(cell, method, key = state.row) {
  const row = cell.rows.find((r) => r.key === key);
  const i = cell.methods.findIndex((m) => m.method === method);
  return { value: i < 0 ? null : row.values[i], best: row.winners.includes(method), floor: row.floor };
}

function cells() {
  const table = document.getElementById("table");
  const row = data.rows.find((r) => r.key === state.row);
  document.getElementById("explains").textContent = `${row.explains} (${good(row.good)})`;
  const columns = [["name", "Pair"], ["seconds", "Seconds"], ["floor", "Floor"], ...methods.map((m) => [m.method, m.label])];
  const of = (cell, by) => (by === "name" || by === "seconds" ? cell[by] : by === "floor" ? value(cell, null).floor : value(cell, by).value);
  const order = [...done].sort((a, b) => {
    const [x, y] = [of(a, state.by), of(b, state.by)];
    // What was not measured stays below.
    if (x == null || y == null) return (x == null) - (y == null);
    const way = typeof x === "string" ? x.localeCompare(y) : x - y;
    return state.down ? -way : way;
  });
  const head = make("tr");
  for (const [key, label] of columns) {
    const button = make("button", { type: "button" }, label);
    button.addEventListener("click", () => {
      state.down = state.by === key && !state.down;
      state.by = key;
      cells();
      document.querySelector(`th[data-key="${key}"] button`).focus();
    });
    const sorted = state.by === key ? (state.down ? "descending" : "ascending") : "none";
    head.append(make("th", { scope: "col", "aria-sort": sorted, "data-key": key }, button));
  }
  const body = make("tbody");
  for (const cell of order) {
    const line = make("tr", {}, make("th", { scope: "row" }, make("a", { href: cell.page }, cell.name)),
      make("td", {}, shown(cell.seconds)), make("td", {}, shown(value(cell, null).floor)));
    for (const m of methods) {
      const found = value(cell, m.method);
      const td = make("td", found.best ? { class: "best" } : {}, (found.best ? "\u2605\u00a0" : "") + shown(found.value));
      if (found.best) td.append(make("span", { class: "hidden" }, " best"));
      line.append(td);
    }
    body.append(line);
  }
  table.replaceChildren(make("caption", {}, `${row.label}${row.unit ? ` (${row.unit})` : ""}; \u2605 marks the best of each pair.`), make("thead", {}, head), body);
}

function broken() {
  const at = document.getElementById("broken");
  for (const cell of data.cells.filter((c) => c.failed)) at.append(make("p", { class: "failed" }, `${cell.name}: ${cell.failed}`));
  for (const cell of done) {
    for (const m of cell.methods.filter((m) => m.failed)) at.append(make("p", { class: "failed" }, `${cell.name}, ${m.label}: ${m.failed}`));
  }
}

function wins() {
  const head = make("tr", {}, make("th", { scope: "col" }, "Measure"), ...methods.map((m) => make("th", { scope: "col" }, m.label)));
  const table = document.getElementById("won");
  table.append(make("caption", {}, `Of ${done.length} pairs.`), make("thead", {}, head));
  let group = null, body = null;
  for (const row of data.rows.filter((r) => r.good !== "neither")) {
    if (row.group !== group) {
      group = row.group;
      body = make("tbody", {}, make("tr", {}, make("th", { scope: "rowgroup", colspan: String(methods.length + 1) }, group)));
      table.append(body);
    }
    const counts = methods.map((m) => done.filter((c) => value(c, m.method, row.key).best).length);
    const most = Math.max(...counts, 1);
    body.append(make("tr", {}, make("th", { scope: "row" }, row.label),
      ...counts.map((n) => make("td", n === most ? { class: "best" } : {}, String(n)))));
  }
}

function failures() {
  const at = document.getElementById("places");
  for (const m of methods) {
    const close = data.failures.filter((f) => f.method === m.method).map((f) => make("figure", {},
      make("div", { class: "spot" }, make("img", { src: f.image ?? "data:,", alt: `${f.label} on ${f.cell}: the place least like the exemplar` })),
      make("figcaption", {}, make("strong", {}, make("a", { href: f.page }, f.cell)), `${shown(f.timesFloor)} times the floor`)));
    at.append(make("h3", {}, m.label), make("div", { class: "worst" }, ...close));
  }
}

document.getElementById("about").textContent =
  `${done.length} of ${data.cells.length} pairs of a mesh and an exemplar, ${methods.length} methods, by lapped ${data.version}. Each pair has a page of its own.`;
if (done.length > 0) {
  document.getElementById("bar").append(choice("Measure", data.rows.map((r) => [r.key, r.label]), state.row, (key) => { state.row = key; cells(); }));
  cells();
  wins();
  failures();
}
broken();
