// Geometries for three.js, and meshes from them.

import { BufferAttribute, BufferGeometry } from "three";
import type { Hull, Mesh } from "./types.js";

/** A geometry for each hull. Its faces are flat: render with `flatShading`. */
export function toGeometries(hulls: readonly Pick<Hull, "points" | "indices">[]): BufferGeometry[] {
  return hulls.map(({ points, indices }) => {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    geometry.setIndex(new BufferAttribute(indices, 1));
    return geometry;
  });
}

/** What `decompose` takes, of a geometry in its own space. Interleaved and quantised attributes are read as well. */
export function fromGeometry(geometry: BufferGeometry): Mesh {
  const position = geometry.getAttribute("position");
  const positions = new Float32Array(3 * position.count);
  for (let i = 0; i < position.count; i++) {
    positions[3 * i] = position.getX(i);
    positions[3 * i + 1] = position.getY(i);
    positions[3 * i + 2] = position.getZ(i);
  }
  const index = geometry.getIndex();
  return index ? { positions, indices: Uint32Array.from(index.array) } : { positions };
}
