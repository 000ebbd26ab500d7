// Buffers of the hulls that are shown, and of the mesh.

import { BufferAttribute, BufferGeometry, SphereGeometry } from "three";
import { HullSet, Page, pointsOf, Surface } from "./data";

/** Neighbouring faces whose normals have a greater cosine are one face to the eye. */
const FLAT = 0.95;

/** Three numbers per vertex. */
class Vertices {
  private numbers: Float32Array;
  private used = 0;

  constructor(count: number) {
    this.numbers = new Float32Array(3 * count);
  }

  push(x: number, y: number, z: number) {
    this.numbers[this.used++] = x;
    this.numbers[this.used++] = y;
    this.numbers[this.used++] = z;
  }

  attribute() {
    return new BufferAttribute(this.numbers, 3);
  }
}

/** Middle of some vertices' bounding box. */
export function middle(positions: Float32Array, first: number, count: number): number[] {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 3 * first; i < 3 * (first + count); i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  return low.map((x, axis) => (x + high[axis]) / 2);
}

/** How far each hull goes when they are moved apart: away from the middle of all. */
export function ways(set: HullSet): number[][] {
  const { positions } = set.surface;
  const own = set.entry.hulls.map((hull, i) => middle(positions, set.places[i].vertex, hull.vertices));
  const last = set.places[set.entry.leaves];
  const all = middle(positions, 0, last ? last.vertex : positions.length / 3);
  return own.map((point) => point.map((x, axis) => x - all[axis]));
}

type Colour = readonly number[];

interface Hull {
  number: number;
  colour: Colour;
  way: number[];
}

/** The attributes that every vertex of a hull has. */
function hullAttributes(hulls: Hull[], counts: number[]): Record<string, BufferAttribute> {
  const total = counts.reduce((sum, count) => sum + count, 0);
  const away = new Float32Array(3 * total);
  const tint = new Float32Array(3 * total);
  const number = new Float32Array(total);
  let vertex = 0;
  hulls.forEach((hull, i) => {
    for (const end = vertex + counts[i]; vertex < end; vertex++) {
      away.set(hull.way, 3 * vertex);
      tint.set(hull.colour, 3 * vertex);
      number[vertex] = hull.number;
    }
  });
  return {
    away: new BufferAttribute(away, 3),
    tint: new BufferAttribute(tint, 3),
    hull: new BufferAttribute(number, 1),
  };
}

function geometry(
  positions: BufferAttribute,
  index: ArrayLike<number>,
  attributes: Record<string, BufferAttribute>,
): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", positions);
  made.setIndex(new BufferAttribute(new Uint32Array(index), 1));
  for (const [name, attribute] of Object.entries(attributes)) made.setAttribute(name, attribute);
  return made;
}

/** Hulls as plain triangles. */
export function hullFaces(set: HullSet, hulls: Hull[]): BufferGeometry {
  return ofVertices(set, hulls, (number, index, first) => {
    const { triangle } = set.places[number];
    const count = 3 * set.entry.hulls[number].triangles;
    for (let i = 3 * triangle; i < 3 * triangle + count; i++) {
      index.push(first + set.surface.triangles[i]);
    }
  });
}

/** Edges of hulls: creases alone, or those of all triangles. */
export function hullLines(set: HullSet, hulls: Hull[], edges: EdgeTable, all: boolean): BufferGeometry {
  return ofVertices(set, hulls, (number, index, first) => {
    for (const vertex of all ? edges.all(number) : edges.creases(number)) index.push(first + vertex);
  });
}

function ofVertices(
  set: HullSet,
  hulls: Hull[],
  fill: (hull: number, index: number[], first: number) => void,
): BufferGeometry {
  const counts = hulls.map(({ number }) => set.entry.hulls[number].vertices);
  const positions = new Float32Array(3 * counts.reduce((sum, count) => sum + count, 0));
  const index: number[] = [];
  let first = 0;
  hulls.forEach(({ number }, i) => {
    const start = 3 * set.places[number].vertex;
    positions.set(set.surface.positions.subarray(start, start + 3 * counts[i]), 3 * first);
    fill(number, index, first);
    first += counts[i];
  });
  return geometry(new BufferAttribute(positions, 3), index, hullAttributes(hulls, counts));
}

/** Hulls divided by their lattices, with the error of each point. */
export function hullErrors(set: HullSet, hulls: Hull[]): BufferGeometry {
  const { surface, places, entry, protrusions } = set;
  const end = (number: number) => places[number + 1]?.sample ?? protrusions.length;
  const counts = hulls.map(({ number }) => end(number) - places[number].sample);
  const total = counts.reduce((sum, count) => sum + count, 0);
  const vertices = new Vertices(total);
  const shares = new Uint8Array(total);
  const index: number[] = [];
  let first = 0;
  hulls.forEach(({ number }, i) => {
    const { vertex, triangle, sample } = places[number];
    shares.set(protrusions.subarray(sample, sample + counts[i]), first);
    for (let t = triangle, at = first; t < triangle + entry.hulls[number].triangles; t++) {
      at = divide(surface, t, vertex, at, vertices, index);
    }
    first += counts[i];
  });
  return geometry(vertices.attribute(), index, {
    ...hullAttributes(hulls, counts),
    share: new BufferAttribute(shares, 1, true),
  });
}

/** Adds the lattice of one triangle; returns the number of the vertex after its last. */
function divide(
  surface: Surface,
  triangle: number,
  firstVertex: number,
  at: number,
  vertices: Vertices,
  index: number[],
): number {
  const { positions, triangles, divisions } = surface;
  const parts = divisions[triangle];
  const corner = (k: number) => 3 * (firstVertex + triangles[3 * triangle + k]);
  const [a, b, c] = [corner(0), corner(1), corner(2)];
  const coordinate = (axis: number, i: number, j: number) => {
    const from = positions[a + axis];
    const [toB, toC] = [positions[b + axis] - from, positions[c + axis] - from];
    return from + (toB * i + toC * j) / parts;
  };
  let row = at;
  for (let i = 0; i <= parts; i++) {
    const length = parts - i + 1;
    for (let j = 0; j < length; j++) {
      vertices.push(coordinate(0, i, j), coordinate(1, i, j), coordinate(2, i, j));
      const [here, next] = [row + j, row + length + j];
      if (j < parts - i) index.push(here, next, here + 1);
      if (j + 1 < parts - i) index.push(next, next + 1, here + 1);
    }
    row += length;
  }
  return row;
}

/** The mesh, each triangle divided by its lattice, its caps in a colour of their own. */
export function meshFaces(page: Page, clay: Colour, cap: Colour): BufferGeometry {
  const { mesh, document } = page;
  const count = mesh.triangles.length / 3;
  const samples = mesh.divisions.reduce((sum, parts) => sum + pointsOf(parts), 0);
  const vertices = new Vertices(samples);
  const tint = new Float32Array(3 * samples);
  const index: number[] = [];
  let at = 0;
  for (let t = 0; t < count; t++) {
    const end = divide(mesh, t, 0, at, vertices, index);
    const colour = t < count - document.mesh.caps ? clay : cap;
    for (; at < end; at++) tint.set(colour, 3 * at);
  }
  return geometry(vertices.attribute(), index, {
    away: new BufferAttribute(new Float32Array(3 * samples), 3),
    hull: new BufferAttribute(new Float32Array(samples).fill(-1), 1),
    tint: new BufferAttribute(tint, 3),
    share: new BufferAttribute(new Uint8Array(samples), 1, true),
  });
}

/** What a probe does not reach. */
export function filledFaces({ filled }: Page, colour: Colour): BufferGeometry {
  const positions = filled?.positions ?? new Float32Array();
  return plain(positions, filled?.triangles ?? [], colour);
}

/** A ball of radius 1. */
export function ball(colour: Colour): BufferGeometry {
  const { attributes, index } = new SphereGeometry(1, 48, 24);
  return plain(attributes.position.array as Float32Array, index?.array ?? [], colour);
}

/** One surface in one colour, which stays where it is. */
function plain(positions: Float32Array, index: ArrayLike<number>, colour: Colour): BufferGeometry {
  const count = positions.length / 3;
  const tint = new Float32Array(positions.length);
  for (let v = 0; v < count; v++) tint.set(colour, 3 * v);
  return geometry(new BufferAttribute(positions, 3), index, {
    away: new BufferAttribute(new Float32Array(positions.length), 3),
    hull: new BufferAttribute(new Float32Array(count).fill(-1), 1),
    tint: new BufferAttribute(tint, 3),
  });
}

/** Edges of the mesh: creases alone, or those of all triangles. */
export function meshLines(page: Page, all: boolean, clay: Colour): BufferGeometry {
  const { positions, triangles } = page.mesh;
  const edges = surfaceEdges(positions, triangles, 0, triangles.length / 3, 0, all ? 2 : 0.8);
  return plain(positions, edges, clay);
}

/** Edges of each hull, found when they are first asked for. */
export class EdgeTable {
  private creaseTable: (Uint32Array | undefined)[] = [];
  private allTable: (Uint32Array | undefined)[] = [];

  constructor(private set: HullSet) {}

  creases(hull: number): Uint32Array {
    return (this.creaseTable[hull] ??= this.find(hull, FLAT));
  }

  all(hull: number): Uint32Array {
    return (this.allTable[hull] ??= this.find(hull, 2));
  }

  private find(hull: number, flat: number): Uint32Array {
    const { surface, places, entry } = this.set;
    const { vertex, triangle } = places[hull];
    const { triangles } = entry.hulls[hull];
    return surfaceEdges(surface.positions, surface.triangles, triangle, triangles, vertex, flat);
  }
}

/** Pairs of vertices: edges of one triangle, and those between faces that differ. */
function surfaceEdges(
  positions: Float32Array,
  triangles: Uint32Array,
  first: number,
  count: number,
  firstVertex: number,
  flat: number,
): Uint32Array {
  const normals = new Float32Array(3 * count);
  const faces = new Map<number, number>();
  const edges: number[] = [];
  for (let t = 0; t < count; t++) {
    const corners = [0, 1, 2].map((k) => triangles[3 * (first + t) + k]);
    normals.set(normal(positions, corners.map((vertex) => 3 * (firstVertex + vertex))), 3 * t);
    for (let k = 0; k < 3; k++) {
      const [a, b] = [corners[k], corners[(k + 1) % 3]];
      const key = Math.min(a, b) * 2 ** 26 + Math.max(a, b);
      const other = faces.get(key);
      if (other === undefined) {
        faces.set(key, t);
      } else {
        faces.delete(key);
        let cosine = 0;
        for (let axis = 0; axis < 3; axis++) cosine += normals[3 * t + axis] * normals[3 * other + axis];
        if (cosine < flat) edges.push(a, b);
      }
    }
  }
  for (const key of faces.keys()) edges.push(Math.floor(key / 2 ** 26), key % 2 ** 26);
  return Uint32Array.from(edges);
}

function normal(positions: Float32Array, [a, b, c]: number[]): number[] {
  const u = [0, 1, 2].map((axis) => positions[b + axis] - positions[a + axis]);
  const v = [0, 1, 2].map((axis) => positions[c + axis] - positions[a + axis]);
  const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...cross) || 1;
  return cross.map((x) => x / length);
}
