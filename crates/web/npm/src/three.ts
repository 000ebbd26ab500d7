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
  return merged([{ geometry, matrix: new Matrix4(), isGrouped: false }]);
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
  const all = drawn(object);
  const toObject = object.matrixWorld.clone().invert();
  return merged(all.map(([node, matrix]) => part(node, toObject.clone().multiply(matrix))));
}

/** The same meshes for bodies of their own, each instance one. */
export function fromObjects(object: Object3D): Placed[] {
  return drawn(object).map(([node, matrix]) => {
    const [position, rotation] = [new Vector3(), new Quaternion()];
    matrix.decompose(position, rotation, new Vector3());
    const place = new Matrix4().compose(position, rotation, new Vector3(1, 1, 1));
    return { node, mesh: merged([part(node, place.invert().multiply(matrix))]), position, rotation };
  });
}

interface Part {
  geometry: BufferGeometry;
  matrix: Matrix4;
  /** Only what is in a group is drawn. */
  isGrouped: boolean;
}

const part = ({ geometry, material }: Drawn, matrix: Matrix4): Part => ({ geometry, matrix, isGrouped: Array.isArray(material) });

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

/** The triangles that are drawn of all parts. */
function merged(parts: Part[]): Mesh {
  const all = parts.map(({ geometry, matrix, isGrouped }) => {
    const position = typeof geometry?.getAttribute === "function" ? geometry.getAttribute("position") : undefined;
    if (!position) return refuse("a BufferGeometry with positions is expected, such as `mesh.geometry`");
    const index = geometry.getIndex();
    const { start: low, count } = geometry.drawRange;
    const high = Math.min((index ?? position).count, low + count);
    // Where each range starts, and how many triangles it has.
    const ranges = (isGrouped ? geometry.groups : [{ start: 0, count: high }]).map(({ start, count }) => {
      const from = Math.max(0, start, low);
      return [from, Math.max(0, Math.floor((Math.min(start + count, high) - from) / 3))];
    });
    return { position, index, matrix, ranges };
  });
  const positions = new Float32Array(all.reduce((sum, { position }) => sum + 3 * position.count, 0));
  const indices = new Uint32Array(all.reduce((sum, { ranges }) => ranges.reduce((sum, [, count]) => sum + 3 * count, sum), 0));
  let [vertices, end] = [0, 0];
  const point = new Vector3();
  for (const { position, index, matrix, ranges } of all) {
    const first = vertices;
    for (let i = 0; i < position.count; i++, vertices++) {
      point.fromBufferAttribute(position, i).applyMatrix4(matrix).toArray(positions, 3 * vertices);
    }
    const order = matrix.determinant() < 0 ? [0, 2, 1] : [0, 1, 2];
    for (const [from, count] of ranges) {
      for (let triangle = 0; triangle < count; triangle++) {
        for (const k of order) {
          const corner = from + 3 * triangle + k;
          indices[end++] = first + (index ? index.getX(corner) : corner);
        }
      }
    }
  }
  return { positions, indices };
}
