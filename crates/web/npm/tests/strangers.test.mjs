// What callers do who read no types: every failure is an error with a code and one line, and nothing hangs.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { after, test } from "node:test";
import vm from "node:vm";
import { BoxGeometry, BufferGeometry, Group, InstancedMesh, Matrix4, Mesh } from "three";
import { close, createPool, decompose, hullsAt, HullwrightError, measure, mergeTree, readMesh } from "hullwright";
import * as direct from "hullwright/direct";
import { createPool as createPoolOfFiles } from "hullwright/files";
import { toRapier } from "hullwright/rapier";
import { fromGeometry, fromObject, fromObjects } from "hullwright/three";
import { launch, PACKAGE, serve } from "./browser.mjs";
import { bytesOf, root, stairs } from "./common.mjs";

const pools = [];
const pool = (made) => (pools.push(made), made);
after(() => pools.forEach((each) => each.close()));

const refused = async (code, message, work) => {
  try {
    await work();
  } catch (error) {
    assert.ok(error instanceof HullwrightError, String(error?.stack));
    assert.equal(error.code, code, error.message);
    assert.match(error.message, message);
    assert.ok(!error.message.includes("\n") && error.message.length < 300, error.message.slice(0, 400));
    return error;
  }
  return assert.fail("there is no error");
};

const TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

test("before its module is loaded, `direct` says so; a page that is missing, or no module, is said when it is loaded", async () => {
  await refused("module", /not loaded/, () => direct.decompose(stairs()));
  await refused("module", /404/, () => direct.load(new Response("", { status: 404 })));
  await refused("module", /./, () => direct.load(new Uint8Array(8)));
  await direct.load(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  assert.ok(direct.decompose(stairs()).hulls.length > 0);
});

test("text is read, and files and arrays of another realm, as in jsdom", async () => {
  assert.equal((await readMesh(TETRAHEDRON, "obj")).indices.length, 12);
  assert.equal((await readMesh({ "a/b.obj": TETRAHEDRON })).indices.length, 12);
  const foreign = vm.createContext({ text: TETRAHEDRON });
  const bytes = vm.runInContext("Uint8Array.from(text, (letter) => letter.charCodeAt(0))", foreign);
  assert.ok(!(bytes instanceof Uint8Array));
  assert.equal((await readMesh(bytes, "obj")).indices.length, 12);
  assert.equal((await readMesh(bytes.buffer, "obj")).indices.length, 12);
  const { positions, indices } = await readMesh(TETRAHEDRON, "obj");
  const mesh = vm.runInContext("(p, i) => ({ positions: Float32Array.from(p), indices: Uint32Array.from(i) })", foreign);
  assert.equal((await decompose(mesh(positions, indices))).hulls.length, 1);
});

test("arguments that no type allows are refused, by workers and without them", async () => {
  const mesh = stairs();
  const detached = Float32Array.from(mesh.positions);
  structuredClone(detached.buffer, { transfer: [detached.buffer] });
  for (const [work, alone] of [[decompose, direct.decompose]]) {
    for (const call of [work, alone]) {
      await refused("invalid_argument", /./, () => call({ positions: detached, indices: mesh.indices }));
      await refused("invalid_argument", /`positions`/, () => call({ positions: new BigInt64Array(9) }));
      await refused("invalid_argument", /`positions`/, () => call({ positions: "0 0 0" }));
      await refused("invalid_argument", /`doubleSided`/, () => call({ ...mesh, doubleSided: 3 }));
      await refused("invalid_argument", /options/, () => call(mesh, "2%"));
      assert.ok((await call(mesh, null)).hulls.length > 0);
    }
  }
  await refused("invalid_argument", /`signal`/, () => decompose(mesh, { signal: new AbortController() }));
  await refused("invalid_argument", /`onProgress`/, () => decompose(mesh, { onProgress: "loud" }));
  await refused("invalid_argument", /mug\.glb/, () => readMesh({ "mug.glb": null }));
  await refused("invalid_argument", /neither/, () => readMesh([1, 2, 3], "obj"));
  await refused("invalid_argument", /not 9: .*…/, () =>
    readMesh(Object.fromEntries(Array.from({ length: 9 }, (_, i) => [`${i}.obj`, TETRAHEDRON]))));
  await refused("invalid_argument", /hull 0/, () => measure(mesh, [null]));
  for (const size of [NaN, 0, "two"]) await refused("invalid_argument", /`size`/, () => createPool({ size }));
  await refused("invalid_argument", /`idleSeconds`/, () => createPool({ idleSeconds: NaN }));
  await refused("invalid_argument", /`module`/, () => createPoolOfFiles(null));
  pool(createPool(null));
});

test("nothing accepts NaN or zero where it must not", async () => {
  const result = await decompose(stairs());
  for (const [options, message] of [[{ scale: NaN }, /scale/], [{ scale: 0 }, /scale/], [{ scale: -1 }, /scale/], [{ density: -1 }, /density/], [{ density: Infinity }, /density/]]) {
    await refused("invalid_argument", message, () => toRapier({}, result, options));
  }
  const tree = await mergeTree(stairs(), result);
  await refused("invalid_argument", /number of hulls/, () => hullsAt(tree, NaN));
  assert.equal(hullsAt(tree, 0).length, 1);
  await refused("invalid_argument", /mesh\.geometry/, () => fromGeometry(new Mesh(new BoxGeometry())));
  await refused("invalid_argument", /positions/, () => fromGeometry(new BufferGeometry()));
  await refused("invalid_argument", /Object3D/, () => fromObject(new BoxGeometry()));
});

test("messages have JavaScript's names", async () => {
  await refused("invalid_parameter", /maxHulls/, () => decompose(stairs(), { maxHulls: 0 }));
  await refused("invalid_parameter", /maxVertices/, () => decompose(stairs(), { maxVertices: 3 }));
});

test("messages name the file that they are about", async () => {
  await refused("file", /^chairs\/broken\.off: /, () => readMesh({ "chairs/broken.off": "OFF\n3 1 0\n0 0 0\n" }));
  await refused("file", /^the off file: /, () => readMesh("OFF\n3 1 0\n0 0 0\n", "off"));
});

test("a callback that throws ends its job alone", async () => {
  const { decompose } = pool(createPool());
  const wrong = new Error("a button that is not there");
  const error = await refused("callback", /a button/, () => decompose(stairs(), { onProgress: () => { throw wrong; } }));
  assert.equal(error.cause, wrong);
  assert.ok((await decompose(stairs())).hulls.length > 0);
});

test("a worker that something else ends is an error, and a fresh one takes the next job", async () => {
  const dog = await readMesh(bytesOf(root("assets/dog.glb")), "glb");
  const program = `
    import { Worker } from "node:worker_threads";
    const started = [];
    const post = Worker.prototype.postMessage;
    Worker.prototype.postMessage = function (...args) { started.push(this); return post.apply(this, args); };
    const { decompose, createPool } = await import(${JSON.stringify(`${PACKAGE}/dist/index.js`)});
    const mesh = ${JSON.stringify({ positions: [...dog.positions], indices: [...dog.indices] })};
    const job = decompose(mesh, { maxError: "0.1%", preset: "fine" });
    setTimeout(() => started[0].terminate(), 300);
    const code = await job.then(() => "done", (error) => error.code);
    const small = await decompose({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3] });
    console.log(code, small.hulls.length);`;
  const said = execFileSync("node", ["--input-type=module"], { input: program, encoding: "utf8", timeout: 60_000 });
  assert.equal(said.trim(), "worker 1");
});

test("one signal may be for any number of jobs", async () => {
  const program = `
    import { createPool } from ${JSON.stringify(`${PACKAGE}/dist/index.js`)};
    process.on("warning", (warning) => console.log(warning.name));
    const { decompose, close } = createPool();
    const stop = new AbortController();
    const mesh = { positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3] };
    const jobs = Array.from({ length: 30 }, () => decompose(mesh, { signal: stop.signal }));
    await jobs[0];
    stop.abort();
    const settled = await Promise.allSettled(jobs);
    console.log(settled.filter(({ status }) => status === "rejected").length > 0);
    close();`;
  assert.equal(execFileSync("node", ["--input-type=module"], { input: program, encoding: "utf8" }).trim(), "true");
});

test("the shared worker can be closed, and the next call starts another; an idle one of a pool ends", async () => {
  assert.ok((await decompose(stairs())).hulls.length > 0);
  const late = decompose(stairs());
  close();
  await refused("closed", /closed/, () => late);
  assert.ok((await decompose(stairs())).hulls.length > 0);
  const { decompose: once } = pool(createPool({ idleSeconds: 0 }));
  assert.ok((await once(stairs())).hulls.length > 0);
  await new Promise((resolve) => setTimeout(resolve, 50));
  assert.ok((await once(stairs())).hulls.length > 0);
});

test("a prepared worker's first call takes little longer than later ones", (context) => {
  const program = `
    import { readFileSync } from "node:fs";
    import { decompose, prepare, readMesh, close } from ${JSON.stringify(`${PACKAGE}/dist/index.js`)};
    const mesh = await readMesh(readFileSync(${JSON.stringify(root("assets/mug.glb"))}), "glb");
    if (process.env.PREPARED) await prepare();
    const times = [];
    for (let i = 0; i < 7; i++) {
      const start = performance.now();
      await decompose(mesh);
      times.push(performance.now() - start);
    }
    close();
    console.log(times.map(Math.round).join(" "));`;
  const timed = (env) => execFileSync("node", ["--input-type=module"], { input: program, encoding: "utf8", env: { ...process.env, ...env } }).trim();
  const [cold, prepared] = [timed({}), timed({ PREPARED: "1" })];
  context.diagnostic(`milliseconds of calls: ${cold} as they come, ${prepared} when prepared`);
  assert.equal(prepared.split(" ").length, 7);
});

test("objects of three.js come as one and one by one, with transforms, instances, groups and what is drawn", async () => {
  const box = new Mesh(new BoxGeometry());
  box.position.set(10, 0, 0);
  box.scale.set(-2, 1, 1);
  const hidden = new Mesh(new BoxGeometry());
  hidden.visible = false;
  const many = new InstancedMesh(new BoxGeometry(), box.material, 2);
  many.setMatrixAt(0, new Matrix4().makeTranslation(0, 5, 0));
  many.setMatrixAt(1, new Matrix4().makeTranslation(0, 9, 0));
  // Of six sides only those with a material, and of these what is drawn.
  const grouped = new Mesh(new BoxGeometry(), [box.material]);
  grouped.geometry.groups.length = 3;
  grouped.geometry.setDrawRange(0, 12);
  const scene = new Group().add(box, hidden, many, grouped);
  scene.scale.setScalar(3);
  const whole = fromObject(scene);
  assert.equal(whole.indices.length, 3 * (12 + 2 * 12 + 4));
  const xs = whole.positions.filter((_, i) => i % 3 === 0);
  assert.deepEqual([Math.min(...xs), Math.max(...xs)], [-0.5, 11]);
  assert.ok((await decompose({ positions: whole.positions, indices: whole.indices.slice(0, 36) })).mass.volume > 1.99);
  const each = fromObjects(scene);
  assert.equal(each.length, 4);
  assert.deepEqual(each[0].position.toArray(), [30, 0, 0]);
  const { mass } = await decompose(each[0].mesh);
  assert.ok(Math.abs(mass.volume - 2 * 27) < 1e-3, `${mass.volume}`);
  assert.equal(each[3].mesh.indices.length, 12);
});

test("without the stream of a `Blob`, as under jsdom, the module is unpacked", () => {
  const program = `
    delete Blob.prototype.stream;
    const { decompose } = await import(${JSON.stringify(`${PACKAGE}/dist/index.js`)});
    const mesh = { positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3] };
    console.log((await decompose(mesh)).hulls.length);`;
  assert.equal(execFileSync("node", ["--input-type=module"], { input: program, encoding: "utf8" }).trim(), "1");
});

test("a page with an import map and no bundler decomposes, also where it wants Trusted Types", async () => {
  const policy = "require-trusted-types-for 'script'; trusted-types hullwright; worker-src blob:; script-src 'self' 'unsafe-inline' 'wasm-unsafe-eval'";
  const body = `<!doctype html>
    <script type="importmap">{ "imports": { "hullwright": "/dist/index.js" } }</script>
    <script>
      const mesh = { positions: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], indices: [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3] };
      const say = (text) => { document.title = text; };
      import("hullwright").then(({ decompose }) => decompose(mesh)).then(({ hulls }) => say(hulls.length + " hull"), (error) => say(error.message));
    </script>`;
  const [server, browser] = [await serve(PACKAGE), await launch()];
  try {
    for (const headers of [{}, { "Content-Security-Policy": policy }]) {
      const page = await browser.newPage();
      await page.route("**/page.html", (route) => route.fulfill({ body, headers, contentType: "text/html" }));
      await page.goto(`${server.address}/page.html`);
      await page.waitForFunction(() => document.title !== "", undefined, { timeout: 30_000 });
      assert.equal(await page.title(), "1 hull");
    }
  } finally {
    await browser.close();
    server.close();
  }
});
