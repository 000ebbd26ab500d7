// Times in the worker over those of the command on one thread: `npm run speed -- COMMAND MESH…`, for example
// `npm run speed -- ../../../target/release/hullwright ../../../assets/*.glb`. Each is the best of five, in turns, so that
// what else the machine does hits both.

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { basename, extname } from "node:path";
import { createPool } from "hullwright";

const ROUNDS = 5;
const [command, ...paths] = process.argv.slice(2);
if (paths.length === 0) throw new Error("usage: npm run speed -- COMMAND MESH…");

const native = (path) => JSON.parse(execFileSync(command, ["decompose", path, "--threads", "1", "--json"], { encoding: "utf8" }));
const { readMesh, decompose, close } = createPool();
const ratios = [];
for (const path of paths) {
  const mesh = await readMesh(readFileSync(path), extname(path).slice(1).toLowerCase());
  let [web, own] = [Infinity, Infinity];
  for (let round = 0; round < ROUNDS; round++) {
    const start = performance.now();
    await decompose(mesh);
    web = Math.min(web, performance.now() - start);
    own = Math.min(own, 1000 * native(path).seconds);
  }
  ratios.push(web / own);
  console.log(`${(web / own).toFixed(2)}  ${web.toFixed(0)} ms, native ${own.toFixed(0)} ms  ${basename(path)}`);
}
close();
ratios.sort((a, b) => a - b);
console.log(`median ${ratios[Math.floor(ratios.length / 2)].toFixed(2)} of ${ratios.length} meshes, worst ${ratios.at(-1).toFixed(2)}`);
