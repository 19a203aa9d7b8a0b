// What a browser shows of GLBs: three.js under headless Chromium, one picture each.
//
//     apt-get install chromium && npm install three playwright-core
//     NODE_PATH=node_modules node benches/peers/browser.mjs OUT_FOLDER MODEL.glb ...
import { createRequire } from "node:module";
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import path from "node:path";

const modules = process.env.NODE_PATH ?? "node_modules";
const { chromium } = createRequire(path.resolve(modules, "x.js"))("playwright-core");
const [folder, ...models] = process.argv.slice(2);

const page = `<!doctype html><style>body{margin:0}</style><script type="importmap">
{"imports":{"three":"/three/build/three.module.js","three/addons/":"/three/examples/jsm/"}}</script><script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(512, 512);
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xe8e8ec);
scene.add(new THREE.HemisphereLight(0xffffff, 0x888899, 1.6));
const sun = new THREE.DirectionalLight(0xffffff, 2.2);
scene.add(sun);
const gltf = await new GLTFLoader().loadAsync(location.hash.slice(1));
scene.add(gltf.scene);
const box = new THREE.Box3().setFromObject(gltf.scene);
const middle = box.getCenter(new THREE.Vector3());
const radius = box.getSize(new THREE.Vector3()).length() / 2;
const camera = new THREE.PerspectiveCamera(36, 1, radius / 50, radius * 20);
camera.position.copy(middle).add(new THREE.Vector3(0.48, 0.26, 0.83).multiplyScalar(radius * 3.2));
camera.lookAt(middle);
sun.position.copy(camera.position).add(new THREE.Vector3(radius, 2 * radius, 0));
renderer.render(scene, camera);
window.done = { triangles: renderer.info.render.triangles, textures: renderer.info.memory.textures, calls: renderer.info.render.calls };
</script>`;

const server = createServer(async (request, response) => {
  const url = decodeURIComponent(new URL(request.url, "http://x").pathname);
  try {
    if (url === "/") return response.setHeader("content-type", "text/html").end(page);
    const file = url.startsWith("/three/") ? path.join(modules, url) : url.slice("/file".length);
    const kind = file.endsWith(".js") ? "text/javascript" : "application/octet-stream";
    response.setHeader("content-type", kind).end(await readFile(file));
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
const at = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
let failed = 0;
for (const model of models) {
  const tab = await browser.newPage({ viewport: { width: 512, height: 512 } });
  tab.on("pageerror", (e) => console.log(`  ${e}`));
  await tab.goto(`${at}/#/file${path.resolve(model)}`);
  try {
    await tab.waitForFunction("window.done", undefined, { timeout: 120000 });
    const out = path.join(folder, `${path.basename(model).replace(/\.[^.]*$/, "")}-browser.png`);
    await tab.screenshot({ path: out });
    console.log(`${out}: ${JSON.stringify(await tab.evaluate("window.done"))}`);
  } catch (e) {
    console.log(`${model}: ${e}`);
    failed = 1;
  }
  await tab.close();
}
await browser.close();
server.close();
process.exit(failed);
