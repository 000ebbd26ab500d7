// What the package may weigh.

import assert from "node:assert/strict";
import { statSync } from "node:fs";
import { test } from "node:test";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { PACKAGE } from "./browser.mjs";
import { bytesOf } from "./common.mjs";

/** Bytes of the module, and compressed as servers do. */
const MOST = {
  "hullwright-core.wasm": [1_335_000, 450_000],
  "hullwright.wasm": [2_000_000, 700_000],
};

for (const [file, [most, mostCompressed]] of Object.entries(MOST)) {
  test(`${file} has at most ${most} bytes, ${mostCompressed} compressed`, (context) => {
    const bytes = bytesOf(`${PACKAGE}/dist/${file}`);
    const [brotli, gzip] = [brotliCompressSync(bytes).length, gzipSync(bytes, { level: 9 }).length];
    context.diagnostic(`${bytes.length} bytes, ${brotli} by Brotli, ${gzip} by gzip`);
    assert.ok(bytes.length <= most, `${bytes.length}`);
    assert.ok(brotli <= mostCompressed, `${brotli}`);
  });
}

test("what inlines all is a script of at most 1.1 MB", (context) => {
  const { size } = statSync(`${PACKAGE}/dist/index.js`);
  context.diagnostic(`${size} bytes`);
  assert.ok(size <= 1_100_000, `${size}`);
});
