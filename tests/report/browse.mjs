// Opens the pages of a comparison from disk and uses them as people do.
//
//     NODE_PATH=node_modules node tests/report/browse.mjs FOLDER CELL SCREENSHOTS
import { createRequire } from "node:module";
import { strict as assert } from "node:assert";
import path from "node:path";

const require = createRequire(path.resolve(process.env.NODE_PATH ?? "node_modules", "x.js"));
const { chromium } = require("playwright-core");
const axe = require.resolve("axe-core");
const [folder, cell, shots] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless=new", "--no-sandbox"],
});

/** A page opened from disk without a network; whatever it complains of is kept. */
async function open(file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, offline: true, ...options });
  const page = await context.newPage();
  page.complaints = [];
  page.on("pageerror", (e) => page.complaints.push(String(e)));
  page.on("console", (m) => page.complaints.push(m.text()));
  page.on("request", (r) => {
    if (!r.url().startsWith("file:") && !r.url().startsWith("data:")) page.complaints.push(`asks for ${r.url()}`);
  });
  await page.goto(`file://${path.resolve(folder, file)}`);
  return page;
}

async function accessible(page, name) {
  await page.addScriptTag({ path: axe });
  const found = await page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21aa", "wcag22aa", "best-practice"] }));
  const told = found.violations.map((v) => `${v.id}: ${v.help} at ${v.nodes.map((n) => n.target.join(" ")).slice(0, 4).join("; ")}`);
  assert.deepEqual(told, [], `${name}: axe finds nothing`);
}

const transforms = (page) => page.$$eval(".lens img", (all) => all.map((i) => i.style.transform));
const cut = (page) => page.$eval(".pair", (p) => p.style.getPropertyValue("--cut"));

async function zooms(page) {
  const first = page.locator(".lens").first();
  await first.scrollIntoViewIfNeeded();
  const box = await first.boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.dblclick(...middle);
  let all = await transforms(page);
  assert.ok(all.length >= 2 && all.every((t) => t === all[0] && t.startsWith("scale(2)")), `a double click zooms all alike: ${all}`);
  await page.mouse.move(...middle);
  await page.mouse.down();
  await page.mouse.move(middle[0] - 60, middle[1] - 40, { steps: 4 });
  await page.mouse.up();
  const dragged = await transforms(page);
  assert.ok(dragged[0] !== all[0] && dragged.every((t) => t === dragged[0]), `dragging moves all alike: ${dragged}`);
  await page.keyboard.down("Control");
  await page.mouse.wheel(0, -300);
  await page.keyboard.up("Control");
  await page.waitForFunction((t) => document.querySelector(".lens img").style.transform !== t, dragged[0]);
  await page.locator(".lens").nth(1).focus();
  const before = await transforms(page);
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("-");
  const keyed = await transforms(page);
  assert.ok(keyed[0] !== before[0] && keyed.every((t) => t === keyed[0]), `keys move and zoom all alike: ${keyed}`);
  await page.keyboard.press("0");
  assert.ok((await transforms(page)).every((t) => t.startsWith("scale(1)")), "0 shows all");
  await page.getByRole("button", { name: "Zoom in" }).click();
  assert.equal(await page.textContent("#zoom"), "1.5 x", "the button zooms and says so");
  await page.getByRole("button", { name: "Show all" }).click();
}

async function slides(page) {
  const pair = page.locator(".pair");
  await pair.scrollIntoViewIfNeeded();
  const box = await pair.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 50);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 5, box.y + 60, { steps: 5 });
  await page.mouse.up();
  assert.equal(await cut(page), "20%", "the cut follows the mouse");
  await page.locator("#cut").focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  assert.equal(await cut(page), "22%", "and the keys");
  const right = page.getByLabel("Right", { exact: true });
  const was = await page.$eval(".pair img:not(.over)", (i) => i.src);
  await right.selectOption("tiling");
  assert.notEqual(await page.$eval(".pair img:not(.over)", (i) => i.src), was, "another method is another picture");
}

async function shows(page) {
  const show = page.locator("#side-bar").getByLabel("Show", { exact: true });
  for (const [kind, name] of [["source", "places"], ["error", "errors"]]) {
    await show.selectOption(kind);
    const loaded = await page.$$eval(".lens img", (all) => Promise.all(all.map((i) => i.decode().then(() => i.naturalWidth))));
    assert.ok(loaded.every((w) => w > 0), `pictures of ${name} are there`);
    await page.screenshot({ path: path.join(shots, `report-${kind}.png`) });
  }
  await show.selectOption("texture");
}

const report = await open(`${cell}/report.html`);
await report.screenshot({ path: path.join(shots, "report.png") });
await zooms(report);
await shows(report);
await slides(report);
await report.locator("summary").first().click();
await report.locator("#figures").scrollIntoViewIfNeeded();
await report.screenshot({ path: path.join(shots, "report-figures.png") });
assert.ok((await report.locator("td.best").count()) > 5, "winners are marked");
assert.equal(await report.$$eval(".spot img", (all) => all.filter((i) => !i.naturalWidth).length), 0, "close-ups are there");
assert.deepEqual(report.complaints, [], "nothing to complain of");
await accessible(report, "the report");
await report.pdf({ path: path.join(shots, "report.pdf"), printBackground: true });

const dark = await open(`${cell}/report.html`, { colorScheme: "dark" });
await accessible(dark, "the report in the dark");
await dark.screenshot({ path: path.join(shots, "report-dark.png") });

const phone = await open(`${cell}/report.html`, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
const width = await phone.evaluate(() => document.documentElement.scrollWidth);
assert.ok(width <= 390, `nothing is wider than a phone: ${width}`);
await phone.screenshot({ path: path.join(shots, "report-phone.png") });
await phone.locator(".pair").tap();
assert.deepEqual(phone.complaints, [], "nothing to complain of on a phone");

const summary = await open("index.html");
await accessible(summary, "the page over all");
const order = () => summary.$$eval("#table tbody th", (all) => all.map((t) => t.textContent));
const first = await order();
await summary.getByRole("button", { name: "Pair", exact: true }).focus();
await summary.keyboard.press("Enter");
assert.deepEqual(await order(), [...first].reverse(), "a second press turns the order round");
assert.equal(await summary.getAttribute('th[data-key="name"]', "aria-sort"), "descending", "and says so");
await summary.getByRole("button", { name: "Tiling", exact: true }).click();
const values = await summary.$$eval("#table tbody tr", (all) => all.map((r) => parseFloat(r.lastChild.textContent.replace("\u2605", ""))));
assert.deepEqual(values, [...values].sort((a, b) => a - b), "sorted by a method's values");
await summary.getByLabel("Measure").selectOption("seconds");
assert.ok((await summary.textContent("#broken")).includes("missing"), "broken pairs are told");
assert.ok((await summary.locator(".spot img").count()) >= 7, "failures are shown");
await summary.screenshot({ path: path.join(shots, "summary.png"), fullPage: true });
assert.deepEqual(summary.complaints, [], "nothing to complain of");
await summary.locator("#table tbody a").first().click();
await summary.waitForURL(/report\.html$/);
await browser.close();
console.log("pages: mouse, keys, phone, dark, print and axe are content");
