// What the page is about: the block of data that the program wrote, and its arrays of numbers.

import { inflate } from "../../crates/web/npm/src/inflate";

/** Where an array begins in the bytes, and how many numbers it has. */
interface ArrayPlace {
  offset: number;
  count: number;
}

/** Points as 16-bit shares of their bounding box. */
interface PointsPlace {
  min: number[];
  size: number[];
  shares: ArrayPlace;
}

export interface HullEntry {
  vertices: number;
  triangles: number;
  volume: number;
  protrusion: number;
  is_verified: boolean;
  objects: number[];
}

export interface State {
  hulls: number;
  vertices: number;
  error: number;
  protrusion: number;
  uncovered: number;
  iou: number | null;
}

interface SetEntry {
  name: string;
  facts: [string, string][];
  leaves: number;
  is_verified: boolean;
  hulls: HullEntry[];
  joins: [number, number][];
  states: State[];
  positions: PointsPlace;
  triangles: ArrayPlace;
  divisions: ArrayPlace;
  protrusion_most: number;
  protrusions: ArrayPlace;
  uncovered: {
    most: number;
    values: ArrayPlace;
    change_joins: ArrayPlace;
    change_samples: ArrayPlace;
    change_values: ArrayPlace;
  };
}

/** What a probe does not reach, and the probe's radius as a fraction of the diagonal. */
interface FilledEntry {
  radius: number;
  colour: [number, number, number];
  ball: [number, number, number];
  positions: PointsPlace;
  triangles: ArrayPlace;
}

interface Document {
  title: string;
  program: string;
  diagonal: number;
  bound: number;
  up: "y" | "z";
  colours: [number, number, number][];
  clay: [number, number, number];
  cap: [number, number, number];
  mesh: {
    source_vertices: number;
    source_triangles: number;
    caps: number;
    positions: PointsPlace;
    triangles: ArrayPlace;
    divisions: ArrayPlace;
  };
  filled: FilledEntry | null;
  /** Whether the one set is a surface that stands for the mesh, whose caps are hidden triangles. */
  is_simplified: boolean;
  openings: { outcome: string; centre: number[] }[];
  names: string[];
  sets: SetEntry[];
}

/** A surface, its triangles divided by a lattice whose points have errors. */
export interface Surface {
  positions: Float32Array;
  triangles: Uint32Array;
  /** For each triangle the number of parts that its edges are divided into. */
  divisions: Uint8Array;
}

/** Where a hull's own vertices, triangles and samples begin in those of its set. */
export interface HullPlace {
  vertex: number;
  triangle: number;
  sample: number;
}

export interface HullSet {
  entry: SetEntry;
  surface: Surface;
  places: HullPlace[];
  protrusions: Uint8Array;
  uncovered: {
    most: number;
    values: Uint8Array;
    joins: Uint16Array;
    samples: Uint32Array;
    changed: Uint8Array;
  };
}

export interface Page {
  document: Document;
  mesh: Surface;
  /** What a probe does not reach. */
  filled: { positions: Float32Array; triangles: Uint32Array } | null;
  sets: HullSet[];
}

/** Points of a triangle whose edges are divided into so many parts. */
export function pointsOf(parts: number): number {
  return ((parts + 1) * (parts + 2)) / 2;
}

export function text(id: string): string {
  const element = document.getElementById(id);
  if (!element?.textContent) throw new Error("This page holds no data.");
  return element.textContent;
}

/** Reads the page's two blocks of data. */
export async function readPage(): Promise<Page> {
  return pageOf(text("data"), await inflate(text("geometry"), "deflate"));
}

/** A page of its text, which is JSON, and the bytes of its arrays. */
export function pageOf(json: string, bytes: ArrayBuffer): Page {
  const doc: Document = JSON.parse(json);
  const u8 = ({ offset, count }: ArrayPlace) => new Uint8Array(bytes, offset, count);
  const u16 = ({ offset, count }: ArrayPlace) => new Uint16Array(bytes, offset, count);
  const u32 = ({ offset, count }: ArrayPlace) => new Uint32Array(bytes, offset, count);
  const points = ({ min, size, shares }: PointsPlace) => {
    const numbers = Float32Array.from(u16(shares));
    for (let i = 0; i < numbers.length; i++) numbers[i] = min[i % 3] + (numbers[i] / 65535) * size[i % 3];
    return numbers;
  };
  const surface = (of: {
    positions: PointsPlace;
    triangles: ArrayPlace;
    divisions: ArrayPlace;
  }): Surface => ({
    positions: points(of.positions),
    triangles: u32(of.triangles),
    divisions: u8(of.divisions),
  });
  const sets = doc.sets.map((entry): HullSet => {
    const own = surface(entry);
    return {
      entry,
      surface: own,
      places: places(entry, own.divisions),
      protrusions: u8(entry.protrusions),
      uncovered: {
        most: entry.uncovered.most,
        values: u8(entry.uncovered.values),
        joins: u16(entry.uncovered.change_joins),
        samples: u32(entry.uncovered.change_samples),
        changed: u8(entry.uncovered.change_values),
      },
    };
  });
  const filled = doc.filled && { positions: points(doc.filled.positions), triangles: u32(doc.filled.triangles) };
  return { document: doc, mesh: surface(doc.mesh), filled, sets };
}

function places(entry: SetEntry, divisions: Uint8Array): HullPlace[] {
  let [vertex, triangle, sample] = [0, 0, 0];
  return entry.hulls.map((hull) => {
    const place = { vertex, triangle, sample };
    vertex += hull.vertices;
    for (let i = 0; i < hull.triangles; i++) sample += pointsOf(divisions[triangle + i]);
    triangle += hull.triangles;
    return place;
  });
}

/** The hulls that are left after some joins. */
export function alive(set: HullSet, joins: number): number[] {
  const { leaves, joins: joined } = set.entry;
  const gone = new Set(joined.slice(0, joins).flat());
  const hulls: number[] = [];
  for (let hull = 0; hull < leaves + joins; hull++) if (!gone.has(hull)) hulls.push(hull);
  return hulls;
}

/** For each hull the number of its colour: a joint hull has that of the larger it replaces. */
export function colourNumbers(set: HullSet): number[] {
  const { leaves, joins, hulls } = set.entry;
  const numbers = Array.from({ length: leaves }, (_, hull) => hull);
  for (const [a, b] of joins) {
    numbers.push(hulls[a].volume >= hulls[b].volume ? numbers[a] : numbers[b]);
  }
  return numbers;
}

/** The uncovered distances after some joins, as bytes. */
export function uncoveredAfter(set: HullSet, joins: number): Uint8Array {
  const { values, joins: at, samples, changed } = set.uncovered;
  const left = values.slice();
  for (let i = 0; i < at.length && at[i] < joins; i++) left[samples[i]] = changed[i];
  return left;
}
