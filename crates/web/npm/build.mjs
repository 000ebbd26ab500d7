// Builds the package into `dist`: the module without and with readers, its worker, and the entries. `node build.mjs
// --modules-as-they-are` takes the modules of the last build.

import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const run = (program, ...args) => execFileSync(program, args, { stdio: ["ignore", "inherit", "inherit"], cwd: here("../../..") });

/** Where cargo builds, whatever the machine's settings are. */
function targetFolder() {
  const metadata = execFileSync("cargo", ["metadata", "--no-deps", "--format-version", "1"], { cwd: here("."), maxBuffer: 1 << 26 });
  return JSON.parse(metadata).target_directory;
}

/** Features, and the file in `dist`. The page has a module of its own, and is built in `viewer/`. */
const VARIANTS = {
  core: { features: ["--no-default-features"], file: "hullwright-core.wasm" },
  full: { features: [], file: "hullwright.wasm" },
  page: { features: ["--features", "page"] },
};

/**
 * Two numbers at once, which each browser can since 2023 and which gives the same bits: a fifth less time. Less is inlined
 * and no loop unrolled: a sixth less code, which is as fast.
 */
const CODE = [
  "-Ctarget-feature=+simd128",
  ...["inline-threshold=50", "unroll-threshold=50", "unroll-partial-threshold=0"].map((flag) => `-Cllvm-args=-${flag}`),
  // The module holds the paths of sources, a kilobyte of them.
  "--remap-path-prefix=crates/hullwright/src=src",
];
const FLAGS = { CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS: CODE.join(" ") };

/** The module that cargo says it has built: where that is depends on the compiler that is taken. */
function artifact(program, ...args) {
  const options = { stdio: ["ignore", "pipe", "inherit"], cwd: here("../../.."), env: { ...process.env, ...FLAGS }, maxBuffer: 1 << 26 };
  const lines = execFileSync(program, args, options).toString().split("\n");
  const files = lines.filter((line) => line.startsWith("{")).flatMap((line) => JSON.parse(line).filenames ?? []);
  const built = files.findLast((file) => file.endsWith("hullwright_web.wasm"));
  if (!built) throw new Error("cargo has built no module");
  return built;
}

function buildModules() {
  run("cargo", "build", "--quiet", "--package", "hullwright_bindgen");
  const target = targetFolder();
  for (const [variant, { features }] of Object.entries(VARIANTS)) {
    const args = ["build", "--quiet", "--profile", "web", "--package", "hullwright-web", ...features];
    const built = artifact(here("../toolchain"), ...args, "--message-format", "json-render-diagnostics");
    const out = here(`build/${variant}`);
    run(`${target}/debug/hullwright_bindgen`, built, out);
    run(process.execPath, here("node_modules/binaryen/bin/wasm-opt"), ...OPTIMISE, `${out}/hullwright_web_bg.wasm`, "-o", `${out}/optimised.wasm`);
  }
}

/** As fast as `-O3`, which makes it larger. */
const OPTIMISE = ["-Oz", "--enable-simd"];

/** What the sources import under names that begin with `#`: the calls of a module, and texts. */
const made = (variant, known) => ({
  name: "made",
  setup(build) {
    // One class of errors for all entries. A worker is a script without imports.
    if (build.initialOptions.format === "esm") {
      build.onResolve({ filter: /^\.\/error\.js$/ }, ({ path }) => ({ path, external: true }));
    }
    build.onResolve({ filter: /^#glue$/ }, () => ({ path: here(`build/${variant}/hullwright_web.js`) }));
    build.onResolve({ filter: /^#/ }, ({ path }) => ({ path, namespace: "texts" }));
    build.onLoad({ filter: /.*/, namespace: "texts" }, ({ path }) => ({ contents: known[path], loader: "text" }));
  },
});

async function bundle(entry, variant, { format = "esm", known = {} } = {}) {
  const { outputFiles } = await build({
    entryPoints: [here(`src/${entry}.ts`)],
    bundle: true,
    minifyIdentifiers: true,
    minifySyntax: true,
    // Lines stay: Node prints that of an error that nobody catches, and one of them is the module.
    minifyWhitespace: format === "iife",
    write: false,
    format,
    target: "es2022",
    charset: "utf8",
    external: ["three"],
    plugins: [made(variant, known)],
    // The core has no readers, and `core` exports no `readMesh`.
    logOverride: { "import-is-undefined": "silent" },
    logLevel: "warning",
  });
  return outputFiles[0].text;
}

if (!process.argv.includes("--modules-as-they-are")) buildModules();
rmSync(here("dist"), { recursive: true, force: true });
mkdirSync(here("dist"));
const write = (file, text) => writeFileSync(here(`dist/${file}`), text);
for (const [variant, { file }] of Object.entries(VARIANTS)) {
  if (!file) continue;
  const wasm = readFileSync(here(`build/${variant}/optimised.wasm`));
  write(file, wasm);
  // No module: a worker made of text can be none in Node.
  const worker = await bundle("worker", variant, { format: "iife" });
  const known = { "#wasm": gzipSync(wasm, { level: 9 }).toString("base64"), "#worker": worker };
  write(variant === "core" ? "worker-core.js" : "worker.js", worker);
  write(variant === "core" ? "core.js" : "index.js", await bundle(variant === "core" ? "core" : "index", variant, { known }));
}
for (const entry of ["error", "files", "direct", "rapier", "three"]) write(`${entry}.js`, await bundle(entry, "full"));
run(process.execPath, here("node_modules/typescript/bin/tsc"), "--project", here("tsconfig.json"), "--declaration", "--emitDeclarationOnly");
for (const licence of ["LICENSE-APACHE", "LICENSE-MIT"]) copyFileSync(here(`../../../${licence}`), here(licence));
if (!existsSync(here("dist/index.d.ts"))) throw new Error("there are no types");
