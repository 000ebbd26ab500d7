// From what a caller gives to what the module takes: flat arrays and the library's own text of parameters.

import { HullwrightError } from "./error.js";
import type { Hulls, Mesh, MeshFiles, MeshFormat, Options, Parameters } from "./types.js";

export interface MeshArrays {
  /** In single precision as they came: half as many bytes to send. */
  positions: Float32Array | Float64Array;
  indices: Uint32Array;
  doubleSided: Uint8Array;
}

/** The file that is read, and all files by their paths. */
export interface NamedFiles {
  format: string;
  main: Uint8Array;
  others: [string, Uint8Array][];
}

/** Bytes of a `.hulls` file, or points of all hulls with their counts. */
export type HullArrays = Uint8Array | { points: Float64Array; counts: Uint32Array };

const refuse = (message: string): never => {
  throw new HullwrightError("invalid_argument", message);
};

/** A copy of the mesh in buffers of its own, which can be handed over to a worker. */
export function meshArrays(mesh: Mesh): MeshArrays {
  const { positions, indices, doubleSided } = mesh ?? {};
  if (!positions || typeof positions.length !== "number") return refuse("`positions` is no array of numbers");
  if (indices && typeof indices.length !== "number") return refuse("`indices` is no array of numbers");
  // A number that is no index would turn into another one.
  const isIndex = (index: number) => index >= 0 && index <= 0xffffffff && Number.isInteger(index);
  if (indices && !(indices instanceof Uint32Array || indices instanceof Uint16Array || indices instanceof Uint8Array)) {
    if (!Array.prototype.every.call(indices, isIndex)) return refuse("`indices` holds a number that is no index");
  }
  return {
    positions: positions instanceof Float32Array ? positions.slice() : Float64Array.from(positions),
    indices: indices ? Uint32Array.from(indices) : Uint32Array.from({ length: positions.length / 3 }, (_, i) => i),
    doubleSided: Uint8Array.from(doubleSided ?? []),
  };
}

/** What is no parameter of the library. */
const OTHERS = new Set(["onProgress", "signal"]);

/** As the library reads it: `max_error=2% max_hulls=8`. It says what is wrong with names and values. */
export function parameterText(options: Options & Parameters = {}): string {
  const items = Object.entries(options)
    .filter(([name, value]) => !OTHERS.has(name) && value !== undefined && value !== null)
    .map(([name, value]) => {
      const key = name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
      const text = name === "probeFrom" && Array.isArray(value) ? value.join(";") || "none" : String(value);
      // Spaces separate items.
      return `${key}=${text.replace(/\s+/g, "")}`;
    });
  return items.join(" ");
}

export function hullArrays(hulls: Hulls): HullArrays {
  const bytes = hulls instanceof Uint8Array ? hulls : (hulls as { hullsFile?: Uint8Array })?.hullsFile;
  // Unlike `slice`, which shares the memory of Node's `Buffer`.
  if (bytes) return new Uint8Array(bytes);
  if (!Array.isArray(hulls)) return refuse("`hulls` is neither a decomposition nor a list of hulls");
  const counts = Uint32Array.from(hulls, ({ points }) => points.length / 3);
  const points = new Float64Array(hulls.reduce((sum, { points }) => sum + points.length, 0));
  let end = 0;
  for (const hull of hulls) {
    points.set(hull.points, end);
    end += hull.points.length;
  }
  return { points, counts };
}

const SUFFIX = /\.(obj|off|ply|stl|gltf|glb)$/i;

/** Of several files the one that names the others, or the only mesh. */
export function namedFiles(files: MeshFiles, format?: MeshFormat): NamedFiles {
  // A copy, since what is handed over is gone.
  const copy = (bytes: Uint8Array | ArrayBuffer) => new Uint8Array(bytes instanceof Uint8Array ? bytes : bytes.slice(0));
  if (files instanceof Uint8Array || files instanceof ArrayBuffer) {
    return { format: format ?? refuse("bytes need a `format`"), main: copy(files), others: [] };
  }
  const paths = Object.keys(files ?? {});
  const isMesh = (path: string) => (format ? path.toLowerCase().endsWith(`.${format}`) : SUFFIX.test(path));
  const meshes = paths.filter(isMesh);
  if (meshes.length !== 1) return refuse(`one mesh file is expected, not ${meshes.length}: ${paths.join(", ")}`);
  const folder = meshes[0].slice(0, meshes[0].lastIndexOf("/") + 1);
  const others = paths.filter((path) => path !== meshes[0]);
  return {
    format: format ?? (SUFFIX.exec(meshes[0])?.[1] ?? "").toLowerCase(),
    main: copy(files[meshes[0]]),
    // Relative to the file that names them.
    others: others.map((path) => [path.startsWith(folder) ? path.slice(folder.length) : path, copy(files[path])]),
  };
}
