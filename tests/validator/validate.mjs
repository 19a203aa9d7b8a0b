// The Khronos glTF validator over files: no errors, no warnings.
//
//     npm install --no-save gltf-validator
//     NODE_PATH=node_modules node tests/validator/validate.mjs FILE.glb FILE.gltf ...
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import path from "node:path";

const require = createRequire(path.resolve(process.env.NODE_PATH ?? "node_modules", "x.js"));
const validator = require("gltf-validator");

let bad = 0;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: path.basename(file),
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes`);
  for (const m of messages.filter((m) => m.severity < 2).slice(0, 10)) console.log(`  ${m.code} ${m.pointer ?? ""} ${m.message}`);
  bad += numErrors + numWarnings;
}
process.exit(bad === 0 ? 0 : 1);
