const methods = data.methods.filter((m) => m.figures);
const views = data.setting.views.map((name, i) => [String(i), name]);
const KINDS = [["texture", "texture"], ["source", "where it comes from"], ["error", "where it errs"]];
const aspect = data.setting.size[0] / data.setting.size[1];
const named = (key) => methods.find((m) => m.method === key);
const image = (method, view, kind) => data.images[method.pictures[view]?.[kind]];
const state = { view: 0, kind: "texture", zoom: 1, x: 0, y: 0 };

function facts() {
  const s = data.setting;
  const list = document.getElementById("facts");
  const all = [
    `${s.faces.toLocaleString("en")} faces`,
    `exemplar ${s.exemplarSize.join(" x ")} pixels${s.tiles ? ", tiles" : ""}`,
    `one width is ${shown(s.scale)} long, the surface ${shown(s.ratio)} exemplars large`,
    s.ways === 0 ? "no direction" : s.ways === 1 ? "one direction" : `a field of ${s.ways} ways`,
    `made in ${shown(data.seconds)} s by lapped ${data.version}`,
  ];
  list.append(...all.map((text) => make("li", {}, text)));
}

/* Side by side: one zoom for all. */
const lenses = [];
function place() {
  const most = 1 - 1 / state.zoom;
  state.x = Math.min(Math.max(state.x, 0), most);
  state.y = Math.min(Math.max(state.y, 0), most);
  for (const lens of lenses) {
    lens.classList.toggle("near", state.zoom > 1);
    lens.firstChild.style.transform = `scale(${state.zoom}) translate(${-100 * state.x}%, ${-100 * state.y}%)`;
  }
  document.getElementById("zoom").textContent = `${state.zoom.toFixed(1)} x`;
}
/** Zooms about a point of the pictures, shares of their sides. */
function zoom(factor, u = 0.5, v = 0.5) {
  const next = Math.min(Math.max(state.zoom * factor, 1), 12);
  state.x += u / state.zoom - u / next;
  state.y += v / state.zoom - v / next;
  state.zoom = next;
  place();
}
function move(u, v) {
  state.x -= u / state.zoom;
  state.y -= v / state.zoom;
  place();
}
function reset() {
  Object.assign(state, { zoom: 1, x: 0, y: 0 });
  place();
}
const share = (lens, event) => {
  const box = lens.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
};

function lens(method) {
  const img = make("img", { alt: "", draggable: "false" });
  const box = make("div", { class: "lens", tabindex: "0", role: "group", "aria-describedby": "zoom" }, img);
  box.style.aspectRatio = aspect;
  const fingers = new Map();
  const apart = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  box.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, share(box, event));
    if (state.zoom > 1 || fingers.size > 1) box.setPointerCapture(event.pointerId);
    box.classList.add("drag");
  });
  box.addEventListener("pointermove", (event) => {
    const from = fingers.get(event.pointerId);
    if (!from) return;
    const to = share(box, event);
    if (fingers.size === 2) {
      const before = apart();
      fingers.set(event.pointerId, to);
      zoom(apart() / Math.max(before, 1e-6), ...to);
    } else {
      fingers.set(event.pointerId, to);
      move(to[0] - from[0], to[1] - from[1]);
    }
  });
  const lift = (event) => {
    fingers.delete(event.pointerId);
    box.classList.remove("drag");
  };
  for (const name of ["pointerup", "pointercancel", "pointerleave"]) box.addEventListener(name, lift);
  box.addEventListener("dblclick", (event) => zoom(event.shiftKey ? 0.5 : 2, ...share(box, event)));
  box.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 300), ...share(box, event));
  }, { passive: false });
  box.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "+" || event.key === "=") zoom(1.5);
    else if (event.key === "-") zoom(1 / 1.5);
    else if (event.key === "0") reset();
    else if (steps[event.key] && state.zoom > 1) move(...steps[event.key]);
    else return;
    event.preventDefault();
  });
  const caption = make("figcaption", {}, make("strong", {}, method.label), method.says);
  lenses.push(box);
  box.method = method;
  return make("figure", {}, box, caption);
}

function shownIn(kind) {
  for (const box of lenses) {
    const what = KINDS.find(([key]) => key === kind)[1];
    box.firstChild.src = image(box.method, state.view, kind) ?? "data:,";
    box.setAttribute("aria-label", `${box.method.label}, ${what}, ${views[state.view][1]}: plus and minus zoom, arrows move`);
  }
  const legend = document.getElementById("legend");
  const exemplar = make("img", { src: data.images.exemplar, alt: "The exemplar" });
  const text = {
    texture: [exemplar, make("span", {}, "The exemplar.")],
    source: [exemplar, make("img", { src: data.images.places, alt: "Colours of the exemplar's places" }),
      make("span", {}, "Each point in the colour of the place of the exemplar that it shows: smooth ramps were copied in one piece.")],
    error: [make("span", {}, "0"), make("span", { class: "ramp", role: "img", "aria-label": "Light is no error, dark is much" }),
      make("span", {}, `${shown(data.setting.errorScale)}: distance of the patch around a point to the nearest of the exemplar.`)],
  };
  legend.replaceChildren(...text[kind]);
}

function sideBySide() {
  const bar = document.getElementById("side-bar");
  const again = () => shownIn(state.kind);
  const button = (text, label, deed) => {
    const made = make("button", { type: "button", "aria-label": label }, text);
    made.addEventListener("click", deed);
    return made;
  };
  bar.append(
    choice("View", views, "0", (value) => { state.view = Number(value); again(); }),
    choice("Show", KINDS, "texture", (value) => { state.kind = value; again(); }),
    button("+", "Zoom in", () => zoom(1.5)), button("\u2212", "Zoom out", () => zoom(1 / 1.5)), button("1:1", "Show all", reset),
    make("output", { id: "zoom", "aria-live": "polite" }, "1.0 x"),
  );
  document.getElementById("grid").append(...methods.map(lens));
  for (const failed of data.methods.filter((m) => m.failed)) {
    document.getElementById("grid").append(make("p", { class: "failed" }, `${failed.label}: ${failed.failed}`));
  }
  again();
}

/* Before and after: two pictures, one cut. */
function beforeAfter() {
  const options = methods.map((m) => [m.method, m.label]);
  if (methods.length < 2) return;
  const now = { left: methods[0].method, right: (named("wei-levoy") ?? methods[1]).method, view: 0, kind: "texture" };
  if (now.left === now.right) now.right = methods[1].method;
  const under = make("img", { alt: "", draggable: "false" });
  const over = make("img", { class: "over", alt: "", draggable: "false" });
  const tags = [make("span", { class: "tag left" }), make("span", { class: "tag right" })];
  const pair = make("div", { class: "pair" }, under, over, make("div", { class: "rule" }), ...tags);
  const range = make("input", { type: "range", min: "0", max: "100", value: "50", step: "1", id: "cut", "aria-label": "How much of the left picture is shown" });
  const cut = () => {
    pair.style.setProperty("--cut", `${range.value}%`);
    range.setAttribute("aria-valuetext", `${range.value} % ${named(now.left).label}, the rest ${named(now.right).label}`);
  };
  const again = () => {
    const of = (key) => image(named(key), now.view, now.kind) ?? "data:,";
    over.src = of(now.left);
    under.src = of(now.right);
    over.alt = `Left: ${named(now.left).label}`;
    under.alt = `Right: ${named(now.right).label}`;
    tags[0].textContent = named(now.left).label;
    tags[1].textContent = named(now.right).label;
    cut();
  };
  range.addEventListener("input", cut);
  const drag = (event) => {
    const box = pair.getBoundingClientRect();
    range.value = String(Math.round(100 * (event.clientX - box.left) / box.width));
    cut();
  };
  pair.addEventListener("pointerdown", (event) => { pair.setPointerCapture(event.pointerId); drag(event); });
  pair.addEventListener("pointermove", (event) => { if (pair.hasPointerCapture(event.pointerId)) drag(event); });
  document.getElementById("slider").append(pair, range);
  const set = (name, value) => { now[name] = value; again(); };
  document.getElementById("slide-bar").append(
    choice("Left", options, now.left, (value) => set("left", value)),
    choice("Right", options, now.right, (value) => set("right", value)),
    choice("View", views, "0", (value) => set("view", Number(value))),
    choice("Show", KINDS, "texture", (value) => set("kind", value)),
  );
  again();
}

function figures() {
  const table = document.getElementById("table");
  const head = make("tr", {}, make("th", { scope: "col" }, "Measure"), make("th", { scope: "col" }, "Floor"));
  head.append(...data.methods.map((m) => make("th", { scope: "col" }, m.label)));
  table.append(make("caption", {}, "\u2605 marks the best; \u2013 where a method has no such thing."), make("thead", {}, head));
  let group = null, body = null;
  for (const row of data.rows) {
    if (row.group !== group) {
      group = row.group;
      body = make("tbody", {}, make("tr", {}, make("th", { scope: "rowgroup", colspan: String(data.methods.length + 2) }, group)));
      table.append(body);
    }
    const unit = row.unit ? ` (${row.unit})` : "";
    const explained = make("details", {}, make("summary", {}, row.label + unit),
      make("p", {}, row.explains), make("p", {}, `Here: ${row.why} (${good(row.good)})`), make("p", {}, `Source: ${row.source}.`));
    const line = make("tr", { "data-row": row.key }, make("th", { scope: "row" }, explained), make("td", {}, shown(row.floor)));
    row.values.forEach((value, i) => {
      const best = row.winners.includes(data.methods[i].method);
      const cell = make("td", best ? { class: "best" } : {}, (best ? "\u2605\u00a0" : "") + shown(value));
      if (best) cell.append(make("span", { class: "hidden" }, " best"));
      line.append(cell);
    });
    body.append(line);
  }
}

const WORST = {
  coherence: "Least like the exemplar", seams: "Hardest border", chartSeams: "Hardest chart border", stretch: "Most stretched",
  direction: "Farthest off the field", alpha: "Least covered",
};
const VALUE = {
  coherence: (v) => `error ${shown(v)}`, seams: (v) => `step ${shown(v)}`, chartSeams: (v) => `step ${shown(v)}`,
  stretch: (v) => `${shown(v)} times as long`, direction: (v) => `${shown(v)} degrees`, alpha: (v) => `opacity ${shown(v)}`,
};
function worst() {
  const all = document.getElementById("places");
  for (const method of methods) {
    const close = method.worst.map((w) => make("figure", {},
      make("div", { class: "spot" }, make("img", { src: data.images[w.picture], alt: `${method.label}: ${WORST[w.measure]}` })),
      make("figcaption", {}, make("strong", {}, WORST[w.measure]), VALUE[w.measure](w.value))));
    all.append(make("h3", {}, method.label), make("div", { class: "worst" }, ...close));
  }
}

function redo() {
  const at = document.getElementById("redo");
  at.append(make("p", {}, `lapped ${data.version}, seed ${data.setting.seed}. The numbers are in report.json, the pictures without loss in pictures/.`),
    make("pre", { tabindex: "0", role: "region", "aria-label": "Command" }, data.asked.command));
}

facts();
sideBySide();
beforeAfter();
figures();
worst();
redo();
place();
