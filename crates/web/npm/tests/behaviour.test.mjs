// What callers rely on: results, progress, errors with codes, cancelling, traps.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import binaryen from "binaryen";
import { createPool, decompose, hullsAt, HullwrightError, measure, mergeTree, readMesh, simplify } from "hullwright";
import * as direct from "hullwright/direct";
import { createPool as createPoolOfFiles } from "hullwright/files";
import { PACKAGE } from "./browser.mjs";
import { bytesOf, root, stairs, withMemoryLimit } from "./common.mjs";

const pools = [];
const pool = (made) => (pools.push(made), made);
after(() => pools.forEach((each) => each.close()));

const dog = await readMesh(bytesOf(root("assets/dog.glb")), "glb");

/** Of a rejected promise, or a call that throws. */
async function errorOf(work) {
  try {
    await work();
  } catch (error) {
    return error;
  }
  return assert.fail("there is no error");
}

const refused = async (code, message, work) => {
  const error = await errorOf(work);
  assert.ok(error instanceof HullwrightError, String(error));
  assert.equal(error.code, code, error.message);
  assert.match(error.message, message);
};

test("hulls keep the bound, and arrays of a caller stay", async () => {
  const mesh = stairs();
  const { hulls, report, mass, hullsFile } = await decompose(mesh, { maxError: "1%" });
  assert.ok(hulls.length >= 1 && hulls.every(({ points, indices }) => points.length >= 12 && indices.length >= 12));
  assert.ok(hulls.every(({ points }) => points instanceof Float32Array));
  assert.ok(report.protrusionMax <= report.bound && report.uncoveredMax <= report.bound);
  assert.ok(Math.abs(report.bound - 0.01 * report.diagonal) < 1e-9);
  assert.equal(report.sourceTriangles, 48);
  assert.ok(Math.abs(mass.volume - 2 * (1 + 2 + 3 + 4)) < 0.1, `${mass.volume}`);
  assert.equal(String.fromCharCode(...hullsFile.slice(1, 6)), "HULLS");
  assert.equal(mesh.positions.length, 96);
  assert.equal(mesh.indices.length, 144);
});

test("options are those of the library, and their limits hold", async () => {
  const { hulls } = await decompose(dog, { maxHulls: 4, maxVertices: 16, preset: "fast", openings: "keep", upAxis: "z" });
  assert.ok(hulls.length <= 4 && hulls.every(({ points }) => points.length <= 3 * 16));
  const { report } = await decompose(stairs(), { maxError: "0.05 m", probeRadius: "6%" });
  assert.equal(report.bound, 0.05);
  assert.ok(report.probe.radius > 0);
  const rooms = await decompose(stairs(), { probeRadius: "1%", probeFrom: [[-5, -5, -5], [9, 9, 9]] });
  assert.ok(rooms.hulls.length > 0);
});

test("progress rises from the start to the end while the caller goes on", async () => {
  const heard = [];
  let turns = 0;
  const timer = setInterval(() => turns++, 1);
  const { report } = await decompose(dog, { maxError: "0.5%", onProgress: (progress) => heard.push(progress) });
  clearInterval(timer);
  assert.ok(turns > 10 && heard.length >= 7, `${turns} turns, ${heard.length} reports`);
  heard.reduce((before, { fraction }) => (assert.ok(fraction >= before), fraction), 0);
  assert.ok(heard.at(-1).fraction > 0.9 && heard.every(({ stage }) => stage.length > 0));
  assert.equal(report.times[0].stage, heard[0].stage);
});

test("hulls are measured, and joined down to one", async () => {
  const result = await decompose(dog);
  const found = await measure(dog, result);
  assert.equal(found.hulls, result.hulls.length);
  assert.ok(found.protrusion.max * found.diagonal <= result.report.protrusionMax + 1e-9);
  const tree = await mergeTree(dog, result);
  assert.equal(tree.curve.length, result.hulls.length);
  assert.deepEqual(tree.curve.map(({ hulls }) => hulls), result.hulls.map((_, i) => result.hulls.length - i));
  tree.curve.reduce((before, { error }) => (assert.ok(error >= before), error), 0);
  for (const { hulls } of tree.curve) assert.equal(hullsAt(tree, hulls).length, hulls);
  assert.deepEqual(hullsAt(tree, 99), result.hulls);
  // Hulls of any tool are points alone.
  const points = result.hulls.map(({ points }) => ({ points }));
  assert.equal((await measure(dog, points)).hulls, result.hulls.length);
  assert.equal((await mergeTree(dog, points)).curve.length, result.hulls.length);
});

test("a surface has few triangles within the bound, by workers and without them", async () => {
  // Hills of 800 triangles, and a box below them that nothing can touch.
  const at = (i, j) => [i / 20, 0.02 * Math.sin(i / 5) * Math.cos(j / 5), j / 20];
  const cells = Array.from({ length: 400 }, (_, k) => [k % 20, Math.floor(k / 20)]);
  const positions = cells.flatMap(([i, j]) => [[i, j], [i, j + 1], [i + 1, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]].flatMap(([i, j]) => at(i, j)));
  const stages = [];
  const made = await simplify({ positions }, { maxError: "0.005m", onProgress: ({ stage }) => stages.push(stage) });
  assert.ok(stages.includes("simplify"), stages.join());
  const { report } = made;
  assert.equal(report.sourceTriangles, 800);
  assert.ok(report.triangles < 200 && report.triangles === made.indices.length / 3, `${report.triangles}`);
  assert.ok(report.fromSource <= 0.005 && report.toSource <= 0.005 && report.bound === 0.005);
  assert.equal(made.sources.length, report.triangles);
  await direct.load(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  assert.deepEqual(direct.simplify({ positions }, { maxError: "0.005m" }), made);
  // One box within another: it goes, and stays if that is wished.
  const box = (r) => stairs(1).positions.map((x) => r * (x - 0.5));
  // Outward.
  const indices = stairs(1).indices.reverse();
  const nested = { positions: [...box(4), ...box(1)], indices: [...indices, ...indices.map((i) => i + 8)] };
  assert.equal((await simplify(nested)).hidden.length, 12);
  assert.equal((await simplify(nested, { keepHidden: true })).hidden.length, 0);
  await refused("invalid_parameter", /maxError/, () => simplify(nested, { maxError: "-1m" }));
  await refused("invalid_parameter", /maxHulls.*keepHidden/, () => simplify(nested, { maxHulls: 3 }));
});

test("bad input is refused with a code and a reason, by workers and without them", async () => {
  await direct.load(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  const mesh = stairs();
  const cases = [
    ["empty_mesh", /empty/, { positions: [], indices: [] }],
    ["index_out_of_range", /vertex 99/, { positions: mesh.positions, indices: [0, 1, 99] }],
    ["nothing_usable", /no usable triangle/, { positions: [0, 0, 0, 0, 0, 0, 0, 0, 0] }],
    ["nothing_usable", /not finite/, { positions: [NaN, 0, 0, 1, 0, 0, 0, 1, 0] }],
    ["sidedness_count", /sidedness of 1/, { ...mesh, doubleSided: new Uint8Array(1) }],
    ["invalid_argument", /multiple of 3/, { positions: [0, 0, 0, 1] , indices: [0, 0, 0] }],
    ["invalid_argument", /multiple of 3/, { positions: mesh.positions, indices: [0, 1] }],
    ["invalid_argument", /no index/, { positions: mesh.positions, indices: [0, 1, -1] }],
    ["invalid_argument", /no index/, { positions: mesh.positions, indices: [0, 1, 1.5] }],
    ["invalid_argument", /`positions`/, {}],
    ["invalid_argument", /`positions`/, undefined],
    ["invalid_parameter", /a percentage of the diagonal/, mesh, { maxError: 0.02 }],
    ["invalid_parameter", /must be positive/, mesh, { maxError: "-1%" }],
    ["invalid_parameter", /at least 8/, mesh, { maxVertices: 3 }],
    ["invalid_parameter", /maxHulls/, mesh, { maxHulls: 0 }],
    ["invalid_parameter", /fast, balanced or fine/, mesh, { preset: "best" }],
    ["invalid_parameter", /max_eror/, mesh, { maxEror: "2%" }],
  ];
  for (const [code, message, input, options] of cases) {
    await refused(code, message, () => decompose(input, options));
    await refused(code, message, () => direct.decompose(input, options));
  }
  await refused("no_hulls", /no hulls/, () => measure(mesh, []));
  await refused("hulls_file", /no .hulls file/, () => measure(mesh, new Uint8Array(50)));
  await refused("no_hull", /plane|distinct/, () => mergeTree(mesh, [{ points: [0, 0, 0, 1, 0, 0, 0, 1, 0] }]));
  await refused("invalid_argument", /neither/, () => measure(mesh, 3));
  assert.ok((await decompose(mesh)).hulls.length > 0);
});

test("a cancelled job ends at once with the signal's reason, and the next one works", async (context) => {
  const { decompose } = pool(createPool());
  await decompose(stairs());
  for (const wait of [0, 30, 300]) {
    const stop = new AbortController();
    const job = decompose(dog, { maxError: "0.1%", preset: "fine", signal: stop.signal });
    await new Promise((resolve) => setTimeout(resolve, wait));
    const [start, reason] = [performance.now(), new Error("another wish")];
    stop.abort(reason);
    assert.equal(await errorOf(() => job), reason);
    const ended = performance.now() - start;
    const { hulls } = await decompose(stairs());
    context.diagnostic(`after ${wait} ms: ended in ${ended.toFixed(1)} ms, the next done after ${(performance.now() - start).toFixed(0)} ms`);
    assert.ok(hulls.length > 0);
  }
});

test("a job that waits is cancelled without harm to the one that works, and a signal may be aborted before", async () => {
  const { decompose } = pool(createPool());
  const [first, stop] = [decompose(dog), new AbortController()];
  const second = decompose(stairs(), { signal: stop.signal });
  stop.abort();
  assert.equal((await errorOf(() => second)).name, "AbortError");
  assert.ok((await first).hulls.length > 0);
  assert.equal((await errorOf(() => decompose(stairs(), { signal: AbortSignal.abort() }))).name, "AbortError");
});

test("a pool has several jobs at a time, and a closed one refuses", async () => {
  const { decompose, close } = createPool({ size: 2 });
  const all = await Promise.all([1, 2, 3, 4, 5].map((steps) => decompose(stairs(steps))));
  assert.deepEqual(all.map(({ report }) => report.sourceTriangles), [12, 24, 36, 48, 60]);
  const late = decompose(dog);
  close();
  await refused("closed", /closed/, () => late);
  await refused("closed", /closed/, () => decompose(stairs()));
});

test("a trap becomes an error, and a fresh worker takes the next job", async () => {
  // The module, but that its `measure` ends in the middle.
  const broken = binaryen.readBinary(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  const { MutableGlobals, NontrappingFPToInt, SignExt, BulkMemory, BulkMemoryOpt, ReferenceTypes, Multivalue } = binaryen.Features;
  broken.setFeatures(MutableGlobals | NontrappingFPToInt | SignExt | BulkMemory | BulkMemoryOpt | ReferenceTypes | Multivalue);
  const target = Array.from({ length: broken.getNumExports() }, (_, i) => binaryen.getExportInfo(broken.getExportByIndex(i)));
  const { value } = target.find(({ name }) => name === "measure");
  binaryen._BinaryenFunctionSetBody(broken.getFunction(value), broken.unreachable());
  const module = await WebAssembly.compile(broken.emitBinary());
  const files = { module, worker: new URL("../dist/worker.js", import.meta.url) };
  const { decompose, measure } = pool(createPoolOfFiles(files));
  const result = await decompose(stairs());
  await refused("trap", /unreachable/, () => measure(stairs(), result));
  assert.deepEqual((await decompose(stairs())).hulls, result.hulls);
});

test("where memory runs out it is an error that says so, and a fresh worker takes the next job", async () => {
  const module = await WebAssembly.compile(withMemoryLimit(bytesOf(`${PACKAGE}/dist/hullwright.wasm`), 512));
  const worker = new URL("../dist/worker.js", import.meta.url);
  const { decompose } = pool(createPoolOfFiles({ module, worker }));
  const result = await decompose(stairs());
  // 32 MB do not hold the corners of a million triangles, and of a hundred thousand not what is made of them.
  for (const triangles of [1e6, 1e5]) {
    const positions = Float32Array.from({ length: 9 * triangles }, (_, i) => Math.sin(i * i));
    await refused("trap", /memory ran out/, () => decompose({ positions }));
    assert.deepEqual((await decompose(stairs())).hulls, result.hulls);
  }
});

test("a worker or a module that is not there is an error of the pool", async () => {
  const worker = new URL("../dist/worker.js", import.meta.url);
  const nothing = pool(createPoolOfFiles({ module: "http://127.0.0.1:1/none.wasm", worker }));
  await refused("worker", /./, () => nothing.decompose(stairs()));
  const module = await WebAssembly.compile(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  const unmanned = pool(createPoolOfFiles({ module, worker: new URL("./none.js", import.meta.url) }));
  await refused("worker", /./, () => unmanned.decompose(stairs()));
});
