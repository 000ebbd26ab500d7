// Mesh files of every format, from bytes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { decompose, HullwrightError, measure, readMesh } from "hullwright";
import { bytesOf, root } from "./common.mjs";

const text = (lines) => new TextEncoder().encode(lines);

const CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
const FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
const spaced = (rows) => rows.map((row) => row.join(" ")).join("\n");

function binaryStl() {
  const bytes = new Uint8Array(84 + 50 * FACES.length);
  const view = new DataView(bytes.buffer);
  view.setUint32(80, FACES.length, true);
  FACES.forEach((face, i) => face.forEach((corner, j) =>
    CORNERS[corner].forEach((x, k) => view.setFloat32(84 + 50 * i + 12 + 12 * j + 4 * k, x, true))));
  return bytes;
}

/** As JSON, with its buffer in another file. */
function gltf(uri) {
  const buffer = new Uint8Array(48 + 24);
  const view = new DataView(buffer.buffer);
  CORNERS.flat().forEach((x, i) => view.setFloat32(4 * i, x, true));
  FACES.flat().forEach((index, i) => view.setUint16(48 + 2 * i, index, true));
  const document = {
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, name: "pyramid" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3" },
      { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" },
    ],
    bufferViews: [{ buffer: 0, byteLength: 48 }, { buffer: 0, byteOffset: 48, byteLength: 24 }],
    buffers: [{ byteLength: 72, uri }],
    images: [{ uri: "clay.png" }],
  };
  return [text(JSON.stringify(document)), buffer];
}

const isPyramid = ({ positions, indices }) => {
  assert.ok(positions instanceof Float64Array && indices instanceof Uint32Array);
  assert.equal(indices.length, 12);
};

test("OBJ, OFF, PLY, STL and glTF are read", async () => {
  const obj = `${CORNERS.map((p) => `v ${p.join(" ")}`).join("\n")}\no pyramid\n${FACES.map((f) => `f ${f.map((i) => i + 1).join(" ")}`).join("\n")}`;
  const read = await readMesh(text(obj), "obj");
  isPyramid(read);
  assert.deepEqual(read.objects, [{ name: "pyramid", start: 0, count: 4 }]);
  isPyramid(await readMesh(text(`OFF\n4 4 0\n${spaced(CORNERS)}\n${spaced(FACES.map((f) => [3, ...f]))}`), "off"));
  const header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header";
  isPyramid(await readMesh(text(`${header}\n${spaced(CORNERS)}\n${spaced(FACES.map((f) => [3, ...f]))}\n`), "ply"));
  isPyramid(await readMesh(binaryStl(), "stl"));
  isPyramid(await readMesh(binaryStl().buffer, "stl"));
});

test("a glTF finds its buffer among several files, below its folder, with escapes, or by its name alone", async () => {
  const [document, buffer] = gltf("parts/a%20buffer.bin");
  const image = new Uint8Array(9);
  isPyramid(await readMesh({ "model.gltf": document, "parts/a buffer.bin": buffer, "clay.png": image }));
  isPyramid(await readMesh({ "things/model.gltf": document, "things/parts/a buffer.bin": buffer }));
  isPyramid(await readMesh({ "model.gltf": document, "a buffer.bin": buffer }));
  await assert.rejects(readMesh({ "model.gltf": document }), (error) => error.code === "file" && /a buffer\.bin/.test(error.message));
  const [outside] = gltf("../a buffer.bin");
  await assert.rejects(readMesh({ "model.gltf": outside, "a buffer.bin": buffer }), { code: "file" });
});

test("Draco and meshopt are read, and give the hulls of the same model", async () => {
  for (const name of ["mug_draco", "mug_draco_valence", "mug_draco_quantized", "leaf_draco_sequential", "mug_meshopt_ext", "mug_meshopt_khr"]) {
    const mesh = await readMesh({ [`${name}.glb`]: bytesOf(root(`crates/formats/tests/data/${name}.glb`)) });
    assert.ok(mesh.indices.length > 100, name);
    assert.ok((await decompose(mesh, { preset: "fast" })).hulls.length >= 1, name);
  }
});

test("what is no mesh is refused with a reason", async () => {
  const refused = (files, format, code, message) =>
    assert.rejects(readMesh(files, format), (error) => {
      assert.ok(error instanceof HullwrightError);
      assert.equal(error.code, code);
      assert.match(error.message, message);
      return true;
    });
  for (const format of ["obj", "off", "ply", "stl", "gltf", "glb"]) {
    await readMesh(text("\u0000nothing of the kind"), format).then(
      ({ indices }) => assert.equal(indices.length, 0, format),
      (error) => assert.equal(error.code, "file", format),
    );
  }
  await refused(bytesOf(root("assets/mug.glb")).slice(0, 500), "glb", "file", /header announces/);
  await refused(new Uint8Array(3), undefined, "invalid_argument", /format/);
  await refused(new Uint8Array(3), "fbx", "invalid_argument", /fbx/);
  await refused({ "a.obj": new Uint8Array(3), "b.obj": new Uint8Array(3) }, undefined, "invalid_argument", /one mesh file/);
  await refused({ "notes.txt": new Uint8Array(3) }, undefined, "invalid_argument", /one mesh file/);
});

test("bytes stay the caller's, also those of Node's Buffer", async () => {
  // As those of a file: not in the pool that Node never hands over.
  const own = (array) => Buffer.from(array.slice().buffer);
  const bytes = own(binaryStl());
  const result = await decompose(await readMesh(bytes, "stl"));
  const hulls = own(result.hullsFile);
  for (let again = 0; again < 2; again++) {
    const mesh = await readMesh(bytes, "stl");
    assert.equal(mesh.indices.length, 3 * FACES.length);
    const found = await measure(mesh, hulls);
    assert.ok(found.hausdorff < 1e-6);
  }
});
