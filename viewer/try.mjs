// Builds the page on which anyone tries the method, one file: `node try.mjs` writes `dist/try.html`. The module comes from
// `npm run build` in `crates/web/npm`.

import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";
import { gzipSync } from "node:zlib";
import { bundle, fill, here } from "./bundle.mjs";

const MODULE = here("../crates/web/npm/build/page");
const RAPIER = here("node_modules/@dimforge/rapier3d-compat/dist");

const pack = (bytes) => gzipSync(bytes, { level: 9 }).toString("base64");

const made = (texts = {}) => ({
  name: "made",
  setup(build) {
    build.onResolve({ filter: /^#glue$/ }, () => ({ path: `${MODULE}/hullwright_web.js` }));
    build.onResolve({ filter: /^#worker$/ }, ({ path }) => ({ path, namespace: "texts" }));
    build.onLoad({ filter: /.*/, namespace: "texts" }, ({ path }) => ({ contents: texts[path], loader: "text" }));
  },
});

/** Rapier's script without its module, which is inlined as base64 there, and its module. */
function rapier() {
  const script = readFileSync(`${RAPIER}/rapier.mjs`, "utf8");
  const bare = script.replace(/[\w$]+\.toByteArray\("AGFzb[^"]*"\)\.buffer/, "globalThis.rapierModule").replace(/\/\/# sourceMapping.*/, "");
  if (bare.length > script.length / 2) throw new Error("Rapier's script has its module elsewhere");
  return [bare, readFileSync(`${RAPIER}/rapier_wasm3d_bg.wasm`)];
}

const models = readdirSync(here("../assets")).filter((file) => file.endsWith(".glb"));
const [rapierScript, rapierModule] = rapier();
const data = {
  module: pack(readFileSync(`${MODULE}/optimised.wasm`)),
  rapier: pack(rapierScript),
  "rapier-module": pack(rapierModule),
  models: JSON.stringify(Object.fromEntries(models.map((file) => [basename(file, ".glb"), pack(readFileSync(here(`../assets/${file}`)))]))),
};
const style = await bundle("src/try/try.css");
const worker = await bundle("src/try/worker.ts", [made()]);
const script = await bundle("src/try/try.ts", [made({ "#worker": worker })]);
const blocks = Object.entries(data).map(([id, text]) => `<script type="text/plain" id="${id}">${text}</script>`);
// Rapier's script and the workers are made of the page's own text.
const page = fill({ style, script, scripts: " 'wasm-unsafe-eval' blob:", policies: ["worker-src blob:"] })
  .replace("<main>", () => `${readFileSync(here("src/try/try.html"), "utf8")}<main>`)
  .replace("<!--data-->", () => blocks.join("\n"));
mkdirSync(here("dist"), { recursive: true });
writeFileSync(here("dist/try.html"), page);
const sizes = { ...data, script, style };
console.log(`try.html: ${page.length} characters, of them ${Object.entries(sizes).map(([id, text]) => `${id} ${text.length}`).join(", ")}`);
