// Hulls in Rapier's own wasm build, and in three.js.

import assert from "node:assert/strict";
import { test } from "node:test";
import RAPIER from "@dimforge/rapier3d-compat";
import { decompose, readMesh } from "hullwright";
import { toRapier } from "hullwright/rapier";
import { fromGeometry, toGeometries } from "hullwright/three";
import { BoxGeometry } from "three";
import { models, stairs } from "./common.mjs";

await RAPIER.init();

/** Models are tens of centimetres: at this size contacts are sound without the library's dispatcher. */
const SCALE = 10;

const results = await Promise.all(
  models().map(async ({ name, bytes }) => ({ name, result: await decompose(await readMesh(bytes, "glb")) })),
);

for (const compound of [true, false]) {
  test(`a hundred bodies of the models come to rest on a floor, ${compound ? "as compounds" : "a collider for each hull"}`, () => {
    const world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
    world.createCollider(RAPIER.ColliderDesc.cuboid(200, 1, 200).setTranslation(0, -1, 0));
    const bodies = [];
    for (let i = 0; i < 100; i++) {
      const { name, result } = results[i % results.length];
      const place = RAPIER.RigidBodyDesc.dynamic().setTranslation(15 * (i % 10) - 70, 8, 15 * Math.floor(i / 10) - 70);
      const body = world.createRigidBody(place.setRotation({ x: 0, y: Math.sin(i), z: 0, w: Math.cos(i) }));
      const descriptions = toRapier(RAPIER, result, { density: 500, scale: SCALE, compound });
      assert.equal(descriptions.length, compound ? 1 : result.hulls.length, name);
      for (const description of descriptions) assert.ok(world.createCollider(description, body), name);
      const mass = 500 * SCALE ** 3 * result.mass.volume;
      assert.ok(Math.abs(body.mass() - mass) < 1e-3 * mass, `${name}: ${body.mass()} instead of ${mass}`);
      bodies.push({ name, body });
    }
    for (let step = 0; step < 240; step++) world.step();
    for (const { name, body } of bodies) {
      const { y } = body.translation();
      assert.ok(Number.isFinite(y) && y > -5 && y < 15, `${name} is at ${y}`);
      const { x, z } = body.translation();
      assert.ok(Math.abs(x) < 150 && Math.abs(z) < 150, name);
    }
    world.free();
  });
}

test("mass, centre and inertia in Rapier are those of the mesh", async () => {
  const result = await decompose({ ...stairs(1) }, {});
  const world = new RAPIER.World({ x: 0, y: 0, z: 0 });
  const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic());
  for (const description of toRapier(RAPIER, result, { density: 3, scale: 2 })) world.createCollider(description, body);
  world.step();
  // A box of 2, 2, 4.
  const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-3 * Math.abs(b), `${a} instead of ${b}`);
  near(body.mass(), 48);
  const { x, y, z } = body.localCom();
  [[x, 1], [y, 1], [z, 2]].forEach(([found, known]) => near(found, known));
  const moments = Object.values(body.principalInertia()).sort((a, b) => a - b);
  [32, 80, 80].forEach((known, i) => near(moments[i], known));
  world.free();
});

test("geometries of three.js go in and out", async () => {
  const { hulls } = await decompose(fromGeometry(new BoxGeometry(1, 2, 3)));
  const [geometry, ...others] = toGeometries(hulls);
  assert.equal(others.length, 0);
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox;
  assert.deepEqual([max.x - min.x, max.y - min.y, max.z - min.z].map((size) => Number(size.toFixed(6))), [1, 2, 3]);
});
