// Bevy programs as folders that a browser runs: what `game.mjs` and `window.mjs` share.

import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";

export const ROOT = fileURLToPath(new URL("../../..", import.meta.url));

export const folderOf = (name) => fileURLToPath(new URL(`build/${name}`, import.meta.url));

export const run = (program, ...args) => execFileSync(program, args, { cwd: ROOT, stdio: ["ignore", "pipe", "inherit"], maxBuffer: 1 << 26 }).toString();

/** Builds what cargo calls `name` and `target` selects into a fresh folder. */
export function buildProgram(folder, name, ...target) {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const flags = ["--quiet", "--profile", "web-game", "--ignore-rust-version", "--message-format", "json-render-diagnostics"];
  const made = run("crates/web/toolchain", "build", ...flags, ...target);
  const files = made.split("\n").filter((line) => line.startsWith("{")).flatMap((line) => JSON.parse(line).filenames ?? []);
  run("cargo", "run", "--quiet", "--package", "hullwright_bindgen", "--", files.findLast((file) => file.endsWith(`/${name}.wasm`)), folder);
}

/** The files for workers, which `npm run build` has made. */
export function copyWorker(folder) {
  mkdirSync(folder);
  for (const file of ["worker-core.js", "hullwright-core.wasm"]) copyFileSync(fileURLToPath(new URL(`dist/${file}`, import.meta.url)), `${folder}/${file}`);
}

/** Counts what workers answer: what is done without them has the same hulls. Runs in the page. */
export function countAnswers() {
  const { Worker } = window;
  Object.assign(window, { answers: 0, surfaces: 0 });
  window.Worker = function (script) {
    const worker = new Worker(script);
    worker.addEventListener("message", ({ data: { value } }) => {
      window.answers += Number(value?.hullsFile !== undefined);
      window.surfaces += Number(value?.sources !== undefined);
    });
    return worker;
  };
}
