// Geometries for three.js, and meshes from them.

import {
  BufferAttribute, BufferGeometry, Matrix4, Quaternion, Vector3, type InstancedMesh, type Mesh as Drawn, type Object3D,
} from "three";
import { refuse } from "./error.js";
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

/** What `decompose` takes, of a geometry in its own space, as far as its `drawRange` goes. Interleaved and quantised
 * attributes are read as well. */
export function fromGeometry(geometry: BufferGeometry): Mesh {
  const mesh = { positions: [], indices: [] };
  add(mesh, geometry, new Matrix4(), false);
  return finished(mesh);
}

/** A mesh below an object, and where its body belongs in the world. */
export interface Placed {
  node: Object3D;
  /** In the node's axes, as large as it is in the world. */
  mesh: Mesh;
  position: Vector3;
  rotation: Quaternion;
}

/** All visible meshes below an object, such as the `scene` of a glTF, as one in the object's own space. Instances are
 * placed, groups without a material are left out, and skins are at rest. */
export function fromObject(object: Object3D): Mesh {
  const mesh = { positions: [], indices: [] };
  const toObject = new Matrix4();
  for (const [node, matrix] of drawn(object)) {
    toObject.copy(object.matrixWorld).invert().multiply(matrix);
    add(mesh, node.geometry, toObject, isGrouped(node));
  }
  return finished(mesh);
}

/** The same meshes for bodies of their own, each instance one. */
export function fromObjects(object: Object3D): Placed[] {
  return drawn(object).map(([node, matrix]) => {
    const [position, rotation] = [new Vector3(), new Quaternion()];
    matrix.decompose(position, rotation, new Vector3());
    const place = new Matrix4().compose(position, rotation, new Vector3(1, 1, 1));
    const mesh = { positions: [], indices: [] };
    add(mesh, node.geometry, place.invert().multiply(matrix), isGrouped(node));
    return { node, mesh: finished(mesh), position, rotation };
  });
}

interface Growing {
  positions: number[];
  indices: number[];
}

const finished = ({ positions, indices }: Growing): Mesh => ({
  positions: Float32Array.from(positions),
  indices: Uint32Array.from(indices),
});

const isGrouped = ({ material }: Drawn) => Array.isArray(material);

/** Meshes with their matrices in the world. */
function drawn(object: Object3D): [Drawn, Matrix4][] {
  if (typeof object?.traverseVisible !== "function") return refuse("an Object3D is expected, such as the `scene` of a glTF");
  object.updateWorldMatrix(true, true);
  const found: [Drawn, Matrix4][] = [];
  object.traverseVisible((node) => {
    if (!(node as Drawn).isMesh) return;
    const { isInstancedMesh, count } = node as InstancedMesh;
    if (!isInstancedMesh) return void found.push([node as Drawn, node.matrixWorld]);
    for (let i = 0; i < count; i++) {
      const matrix = new Matrix4();
      (node as InstancedMesh).getMatrixAt(i, matrix);
      found.push([node as Drawn, matrix.premultiply(node.matrixWorld)]);
    }
  });
  return found;
}

/** Adds the triangles of a geometry that are drawn. */
function add({ positions, indices }: Growing, geometry: BufferGeometry, matrix: Matrix4, grouped: boolean) {
  const position = typeof geometry?.getAttribute === "function" ? geometry.getAttribute("position") : undefined;
  if (!position) return refuse("a BufferGeometry with positions is expected, such as `mesh.geometry`");
  const first = positions.length / 3;
  const point = new Vector3();
  for (let i = 0; i < position.count; i++) {
    point.fromBufferAttribute(position, i).applyMatrix4(matrix);
    positions.push(point.x, point.y, point.z);
  }
  const index = geometry.getIndex();
  const all = index ? index.count : position.count;
  const { start, count } = geometry.drawRange;
  const [low, high] = [Math.max(0, start), Math.min(all, start + count)];
  const ranges = grouped ? geometry.groups.map(({ start, count }) => [start, start + count]) : [[0, all]];
  const isMirrored = matrix.determinant() < 0;
  for (const [from, to] of ranges) {
    const end = Math.min(to, high);
    for (let i = Math.max(from, low); i + 2 < end; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => first + (index ? index.getX(i + k) : i + k));
      indices.push(a, ...(isMirrored ? [c, b] : [b, c]));
    }
  }
}
