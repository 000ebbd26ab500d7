// Hulls are those of a native program, bit by bit, in Node and in Chromium, in workers and without.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { createPool as createCorePool } from "hullwright/core";
import * as direct from "hullwright/direct";
import { createPool } from "hullwright";
import { launch, openPage, PACKAGE, serve } from "./browser.mjs";
import { bytesOf, digest, models, recorded } from "./common.mjs";

const pools = [];
const pool = (made) => (pools.push(made), made);
after(() => pools.forEach((each) => each.close()));

const known = recorded();

test("the hulls of the bundled models are those on record, in workers of Node", async () => {
  const { readMesh, decompose } = pool(createPool({ size: 2 }));
  const found = await Promise.all(
    models().map(async ({ name, bytes }) => {
      const mesh = await readMesh(bytes, "glb");
      return [name, digest((await decompose(mesh)).hullsFile)];
    }),
  );
  assert.deepEqual(Object.fromEntries(found), known);
});

test("the core without readers gives the same hulls, and so do the functions without a worker", async () => {
  const core = pool(createCorePool());
  await direct.load(bytesOf(`${PACKAGE}/dist/hullwright.wasm`));
  for (const { name, bytes } of models().filter(({ name }) => ["chair", "mug", "leaf"].includes(name))) {
    const mesh = direct.readMesh(bytes, "glb");
    assert.equal(digest((await core.decompose(mesh)).hullsFile), known[name], `${name}, core`);
    assert.equal(digest(direct.decompose(mesh).hullsFile), known[name], `${name}, direct`);
  }
});

test("the hulls of the bundled models are those on record, in Chromium, from one file and from several", async () => {
  const server = await serve(PACKAGE);
  const browser = await launch();
  try {
    const page = await openPage(browser, server.address);
    const inPage = async ([models, digestText, entry]) => {
      const digest = (0, eval)(`(${digestText})`);
      const { createPool } = await import(entry);
      const { readMesh, decompose, close } = createPool({ module: "/dist/hullwright.wasm", worker: "/dist/worker.js" });
      const found = {};
      for (const { name, text } of models) {
        const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
        found[name] = digest((await decompose(await readMesh(bytes, "glb"))).hullsFile);
      }
      close();
      return found;
    };
    const texts = models().map(({ name, bytes }) => ({ name, text: Buffer.from(bytes).toString("base64") }));
    assert.deepEqual(await page.evaluate(inPage, [texts, String(digest), "/dist/index.js"]), known);
    const some = texts.filter(({ name }) => ["chair", "torus"].includes(name));
    const found = await page.evaluate(inPage, [some, String(digest), "/dist/files.js"]);
    assert.deepEqual(found, { chair: known.chair, torus: known.torus });
  } finally {
    await browser.close();
    server.close();
  }
});
