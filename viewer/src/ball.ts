// A ball at the pointer, as large as the probe: where the mesh stops it.

import { Ray, Sphere, Triangle, Vector3 } from "three";
import { Surface } from "./data";

/** A ball touches the mesh if its gap is less than this share of its radius. */
const TOUCHING = 1e-3;

/** Steps at most: beside a face the gap shrinks slowly. */
const STEPS = 300;

/** The centre of a ball of some radius that moves along a ray and touches the mesh; `null` if it passes. O(triangles). */
export function rest(ray: Ray, radius: number, { positions, triangles }: Surface): Vector3 | null {
  const near: Triangle[] = [];
  const [around, corners] = [new Sphere(), [new Vector3(), new Vector3(), new Vector3()]];
  let end = 0;
  for (let at = 0; at < triangles.length; at += 3) {
    corners.forEach((corner, k) => corner.fromArray(positions, 3 * triangles[at + k]));
    around.setFromPoints(corners);
    around.radius += radius;
    if (!ray.intersectsSphere(around)) continue;
    near.push(new Triangle().setFromPointsAndIndices(corners, 0, 1, 2));
    end = Math.max(end, around.center.sub(ray.origin).dot(ray.direction) + around.radius);
  }
  const [centre, closest] = [ray.origin.clone(), new Vector3()];
  for (let [step, way] = [0, 0]; step < STEPS && way < end; step++) {
    let gap = Infinity;
    for (const triangle of near) {
      triangle.closestPointToPoint(centre, closest);
      gap = Math.min(gap, closest.distanceTo(centre) - radius);
    }
    if (gap < TOUCHING * radius) return centre;
    way += gap;
    ray.at(way, centre);
  }
  return null;
}
