// Colliders for Rapier's JavaScript builds, which this file only sees as an argument.

import { refuse } from "./error.js";
import type { Decomposition } from "./types.js";

/** What is taken of `@dimforge/rapier3d` or `@dimforge/rapier3d-compat`. */
export interface Rapier<Desc> {
  ColliderDesc: {
    convexMesh(vertices: Float32Array, indices?: Uint32Array | null): Desc | null;
    convexHull(points: Float32Array): Desc | null;
    compound?: (shapes: any[], positions: any[], rotations: any[], flags?: any) => Desc;
  };
  ConvexPolyhedron: new (vertices: Float32Array, indices?: Uint32Array | null) => any;
  CompoundFlags?: { FIX_INTERNAL_EDGES: number };
}

/** The methods of a collider description that are called. */
export interface Described {
  shape: unknown;
  setDensity(density: number): unknown;
  setMassProperties(mass: number, centre: Vector, moments: Vector, frame: Vector & { w: number }): unknown;
}

interface Vector {
  x: number;
  y: number;
  z: number;
}

export interface ColliderOptions {
  /** Mass per cubed unit of the scaled mesh. Default 1. */
  density?: number | undefined;
  /** Multiplies the mesh. Default 1. */
  scale?: number | undefined;
  /** One collider with all hulls, where Rapier has such (0.21). Default true. */
  compound?: boolean | undefined;
}

const vector = ([x, y, z]: readonly number[], factor = 1): Vector => ({ x: factor * x, y: factor * y, z: factor * z });

/** Collider descriptions for one body, which together have the mesh's mass, centre and inertia: one compound of all hulls,
 * or with versions of Rapier before 0.21 one for each hull. Throws if Rapier refuses a hull.
 *
 * ```js
 * const body = world.createRigidBody(RAPIER.RigidBodyDesc.dynamic());
 * for (const collider of toRapier(RAPIER, result, { density: 500 })) world.createCollider(collider, body);
 * ``` */
export function toRapier<Desc extends Described>(
  RAPIER: Rapier<Desc>,
  { hulls, mass }: Pick<Decomposition, "hulls" | "mass">,
  { density = 1, scale = 1, compound = true }: ColliderOptions = {},
): Desc[] {
  const isPositive = (value: unknown) => typeof value === "number" && value > 0 && value < Infinity;
  if (!isPositive(density)) return refuse(`\`density\` is above 0, not ${density}`);
  if (!isPositive(scale)) return refuse(`\`scale\` is above 0, not ${scale}`);
  const shapes = hulls.map(({ points, indices }, index) => {
    const scaled = scale === 1 ? points : points.map((x) => x * scale);
    const shape = usable(new RAPIER.ConvexPolyhedron(scaled, indices)) ?? usable(new RAPIER.ConvexPolyhedron(scaled));
    if (!shape) throw new Error(`Rapier refuses hull ${index}`);
    return shape;
  });
  const described = describe(RAPIER, shapes, compound);
  for (const desc of described.slice(1)) desc.setDensity(0);
  const weight = density * scale ** 3;
  const [x, y, z, w] = mass.principalRotation;
  const moments = vector(mass.principalMoments, weight * scale ** 2);
  described[0]?.setMassProperties(weight * mass.volume, vector(mass.centre, scale), moments, { x, y, z, w });
  return described;
}

/** The shape, if Rapier makes one of it. */
function usable(shape: any): any {
  try {
    const raw = shape.intoRaw();
    raw?.free();
    return raw ? shape : undefined;
  } catch {
    return undefined;
  }
}

function describe<Desc extends Described>(RAPIER: Rapier<Desc>, shapes: any[], isCompound: boolean): Desc[] {
  const { ColliderDesc, CompoundFlags } = RAPIER;
  if (isCompound && ColliderDesc.compound && shapes.length > 1) {
    const at = shapes.map(() => ({ x: 0, y: 0, z: 0 }));
    const turned = shapes.map(() => ({ x: 0, y: 0, z: 0, w: 1 }));
    return [ColliderDesc.compound(shapes, at, turned, CompoundFlags?.FIX_INTERNAL_EDGES)];
  }
  return shapes.map((shape, index) => {
    const desc = shape.indices ? ColliderDesc.convexMesh(shape.vertices, shape.indices) : ColliderDesc.convexHull(shape.vertices);
    if (!desc) throw new Error(`Rapier refuses hull ${index}`);
    return desc;
  });
}
