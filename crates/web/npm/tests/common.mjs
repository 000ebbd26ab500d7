// The bundled models, and the digests of hulls on record.

import { readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

export const root = (path) => fileURLToPath(new URL(`../../../../${path}`, import.meta.url));

export const bytesOf = (path) => new Uint8Array(readFileSync(path));

export const models = () =>
  readdirSync(root("assets"))
    .filter((name) => name.endsWith(".glb"))
    .map((name) => ({ name: name.replace(".glb", ""), bytes: bytesOf(root(`assets/${name}`)) }));

/** By name, as `crates/hullwright/tests/digests.rs` writes them. */
export const recorded = () =>
  Object.fromEntries(readFileSync(root("crates/hullwright/tests/data/digests.txt"), "utf8").trim().split("\n").map((line) => line.split(" ")));

/** FNV-1a of all points and triangles of a `.hulls` file, as in `crates/hullwright/tests/digests.rs`. Stands alone, to run in a page too. */
export function digest(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  let at = 24;
  let hash = 0xcbf29ce484222325n;
  const add = (bytes) => {
    for (const byte of bytes) hash = ((hash ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
  };
  const u32 = () => view.getUint32((at += 4) - 4, true);
  const skip = (count) => (at += count);
  const optional = (size) => skip(view.getUint8(skip(1) - 1) * size);
  const part = (size) => file.subarray(skip(size) - size, at);
  skip(u32());
  skip(u32());
  skip(8 + 8 + 8);
  optional(8);
  optional(16);
  optional(1 + 8 + 24 + 48);
  for (let hulls = u32(); hulls > 0; hulls--) {
    skip(4 + 8 + 8 + 8);
    optional(8);
    const [points, triangles] = [u32(), u32()];
    add(part(24 * points));
    add(part(12 * triangles));
    add([..."hull"].map((letter) => letter.charCodeAt(0)));
  }
  return hash.toString(16).padStart(16, "0");
}

/** A box without a side, and a step inside: some hulls, quickly. */
export function stairs(steps = 4) {
  const positions = [];
  for (let i = 0; i < steps; i++) {
    const [x, y] = [i, i];
    for (const [dx, dy] of [[0, 0], [1, 0], [1, 1], [0, 1]]) {
      for (const z of [0, 2]) positions.push(x + dx, dy === 0 ? 0 : y + 1, z);
    }
  }
  // Each step is a box: corners in pairs of z, around.
  const faces = [[0, 2, 6], [2, 4, 6], [1, 7, 3], [3, 7, 5], [0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4], [4, 5, 6], [5, 7, 6], [6, 7, 0], [7, 1, 0]];
  const indices = [];
  for (let i = 0; i < steps; i++) for (const face of faces) indices.push(...face.map((corner) => 8 * i + corner));
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}

/** A module as its bytes, whose memory does not grow beyond so many pages of 64 kB. */
export function withMemoryLimit(bytes, pages) {
  const MEMORY = 5;
  const leb = (value) => (value < 128 ? [value] : [(value % 128) + 128, ...leb(Math.floor(value / 128))]);
  let at = 8;
  const number = () => {
    const byte = bytes[at++];
    return byte < 128 ? byte : byte - 128 + 128 * number();
  };
  for (;;) {
    const start = at;
    const id = bytes[at++];
    const end = number() + at;
    if (id !== MEMORY) {
      at = end;
      continue;
    }
    // One memory without a limit: its flags are zero, then come the pages that it begins with.
    at += 2;
    const section = [1, 1, ...leb(number()), ...leb(pages)];
    return Buffer.concat([bytes.subarray(0, start), Uint8Array.of(MEMORY, ...leb(section.length), ...section), bytes.subarray(end)]);
  }
}
