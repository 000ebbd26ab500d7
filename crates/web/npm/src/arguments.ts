// From what a caller gives to what the module takes: flat arrays and the library's own text of parameters.

import { refuse } from "./error.js";
import type { Hulls, Mesh, MeshFiles, MeshFormat, Options, SimplifyOptions } from "./types.js";

export interface MeshArrays {
  /** In single precision as they came: half as many bytes to send. */
  positions: Float32Array | Float64Array;
  indices: Uint32Array;
  doubleSided: Uint8Array;
}

/** The file that is read, and all files by their paths. */
export interface NamedFiles {
  /** As messages call it. */
  name: string;
  format: string;
  main: Uint8Array;
  others: [string, Uint8Array][];
}

/** Bytes of a `.hulls` file, or points of all hulls with their counts. */
export type HullArrays = Uint8Array | { points: Float64Array; counts: Uint32Array };

/** Whether a value has numbers by index. Also arrays of another realm, such as another window's. */
function isNumbers(value: unknown): value is ArrayLike<number> {
  if (value === null || typeof value !== "object") return false;
  const { length } = value as { length?: unknown };
  return typeof length === "number" && !(length > 0 && typeof (value as ArrayLike<unknown>)[0] !== "number");
}

/** A copy of the mesh in buffers of its own, which can be handed over to a worker. */
export function meshArrays(mesh: Mesh): MeshArrays {
  const { positions, indices, doubleSided } = mesh ?? {};
  if (!isNumbers(positions)) return refuse("`positions` is no array of numbers");
  if (indices !== undefined && indices !== null && !isNumbers(indices)) return refuse("`indices` is no array of numbers");
  if (doubleSided !== undefined && doubleSided !== null && !isNumbers(doubleSided)) {
    return refuse("`doubleSided` is no array of numbers");
  }
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
export function parameterText(options?: Options | SimplifyOptions | null): string {
  const items = Object.entries(checkedOptions(options))
    .filter(([name, value]) => !OTHERS.has(name) && value !== undefined && value !== null)
    .map(([name, value]) => {
      const key = name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
      const text = name === "probeFrom" && Array.isArray(value) ? value.join(";") || "none" : String(value);
      // Spaces separate items.
      return `${key}=${text.replace(/\s+/g, "")}`;
    });
  return items.join(" ");
}

/** What a caller gave as options, if it is such. */
export function checkedOptions<T extends object>(options: T | null | undefined): Partial<T> {
  if (options === undefined || options === null) return {};
  if (typeof options !== "object" || Array.isArray(options)) return refuse("the options are no object");
  return options;
}

/** A copy of a file's bytes, since what is handed over is gone; text as UTF-8. Also of another realm. */
function fileBytes(value: unknown): Uint8Array | undefined {
  if (typeof value === "string") return new TextEncoder().encode(value);
  if (ArrayBuffer.isView(value)) return new Uint8Array(value.buffer.slice(value.byteOffset, value.byteOffset + value.byteLength));
  const kind = Object.prototype.toString.call(value);
  if (kind === "[object ArrayBuffer]" || kind === "[object SharedArrayBuffer]") return new Uint8Array(value as ArrayBuffer).slice();
  return undefined;
}

export function hullArrays(hulls: Hulls): HullArrays {
  const bytes = fileBytes(ArrayBuffer.isView(hulls) ? hulls : (hulls as { hullsFile?: unknown })?.hullsFile);
  if (bytes) return bytes;
  if (!Array.isArray(hulls)) return refuse("`hulls` is neither a decomposition nor a list of hulls");
  hulls.forEach((hull, index) => isNumbers(hull?.points) || refuse(`hull ${index} has no \`points\``));
  const counts = Uint32Array.from(hulls, ({ points }) => points.length / 3);
  const points = new Float64Array(hulls.reduce((sum, { points }) => sum + points.length, 0));
  let end = 0;
  for (const hull of hulls) {
    points.set(hull.points, end);
    end += hull.points.length;
  }
  return { points, counts };
}

/** The first of many. */
const list = (names: string[]) => names.slice(0, MOST_NAMED).join(", ") + (names.length > MOST_NAMED ? ", …" : "");
const MOST_NAMED = 5;

const SUFFIX = /\.(obj|off|ply|stl|gltf|glb)$/i;

/** Of several files the one that names the others, or the only mesh. */
export function namedFiles(files: MeshFiles, format?: MeshFormat): NamedFiles {
  const single = fileBytes(files);
  if (single) {
    const known = format ?? refuse("bytes need a `format`");
    return { name: `the ${known} file`, format: known, main: single, others: [] };
  }
  if (files === null || typeof files !== "object" || Array.isArray(files)) {
    return refuse("`files` are neither bytes nor text nor files by their paths");
  }
  const named = files as Record<string, unknown>;
  const copy = (path: string) => fileBytes(named[path]) ?? refuse(`${path}: neither bytes nor text`);
  const paths = Object.keys(named);
  const isMesh = (path: string) => (format ? path.toLowerCase().endsWith(`.${format}`) : SUFFIX.test(path));
  const meshes = paths.filter(isMesh);
  if (meshes.length !== 1) return refuse(`one mesh file is expected, not ${meshes.length}: ${list(paths)}`);
  const folder = meshes[0].slice(0, meshes[0].lastIndexOf("/") + 1);
  const others = paths.filter((path) => path !== meshes[0]);
  return {
    name: meshes[0],
    format: format ?? (SUFFIX.exec(meshes[0])?.[1] ?? "").toLowerCase(),
    main: copy(meshes[0]),
    // Relative to the file that names them.
    others: others.map((path) => [path.startsWith(folder) ? path.slice(folder.length) : path, copy(path)]),
  };
}
