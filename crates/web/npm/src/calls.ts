// The module's functions in their public form: what a worker runs, and what `direct` hands to those who have one.

import type { HullArrays, MeshArrays, NamedFiles } from "./arguments.js";
import type {
  Bytes, Decomposition, Float64s, Hull, Measurement, MergeTree, Progress, ReadMesh, SimplifiedSurface, Uint32s,
} from "./types.js";
import * as glue from "#glue";

/** What a worker is sent: a function and its arguments, of which functions can't be sent. */
export interface Calls {
  decompose(mesh: MeshArrays, parameters: string): Decomposition;
  measure(mesh: MeshArrays, hulls: HullArrays, parameters: string): Measurement;
  mergeTree(mesh: MeshArrays, hulls: HullArrays, parameters: string): MergeTree;
  simplify(mesh: MeshArrays, parameters: string): SimplifiedSurface;
  readMesh(files: NamedFiles): ReadMesh;
}

export type Call = keyof Calls;

/** Instantiates the module, once for each thread. */
export function start(module: WebAssembly.Module) {
  glue.initSync({ module });
}

export function algorithmVersion(): number {
  return glue.algorithmVersion();
}

/** JSON in the library's names, as objects in JavaScript's. */
export function parse(json: string): any {
  const camel = (name: string) => name.replace(/_([a-z])/g, (_, letter: string) => letter.toUpperCase());
  const turn = (value: unknown): unknown => {
    if (Array.isArray(value)) return value.map(turn);
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([name, inner]) => [camel(name), turn(inner)]));
  };
  return turn(JSON.parse(json));
}

/** Frees what the module holds. After a trap that fails, too, and what counts is the trap. */
export function using<T extends { free(): void }, R>(value: T, use: (value: T) => R): R {
  try {
    return use(value);
  } finally {
    try {
      value.free();
    } catch {}
  }
}

/** @internal The page's worker takes it from here; the package's types can't name the module's. */
export function withMesh<R>({ positions, indices, doubleSided }: MeshArrays, use: (mesh: glue.Mesh) => R): R {
  return using(new glue.Mesh(Float64Array.from(positions), indices, doubleSided), use);
}

function hullList(hulls: HullArrays): glue.HullList {
  if (hulls instanceof Uint8Array) return glue.HullList.fromFile(hulls);
  return glue.HullList.fromPoints(hulls.points, hulls.counts);
}

/** Each hull in buffers of its own.
 * @internal The page's worker takes it from here; the package's types can't name the module's. */
export function separate(arrays: glue.HullArrays): Hull[] {
  const { points, indices, pointCounts, indexCounts, protrusions } = arrays;
  let [point, index] = [0, 0];
  return Array.from(pointCounts, (count, hull) => {
    const own = points.slice(point, (point += 3 * count));
    return { points: own, indices: indices.slice(index, (index += indexCounts[hull])), protrusion: protrusions[hull] };
  });
}

const listenerOf = (onProgress?: (progress: Progress) => void) =>
  onProgress && ((stage: string, fraction: number) => onProgress({ stage, fraction }));

export const calls = (onProgress?: (progress: Progress) => void): Calls => ({
  decompose(mesh, parameters) {
    const listener = listenerOf(onProgress);
    return withMesh(mesh, (mesh) =>
      using(glue.decompose(mesh, parameters, listener), (result) => {
        const { report, run, remarks, mass } = parse(result.report);
        const hulls = using(result.arrays(), separate);
        return { hulls, report: { ...report, ...run, remarks }, mass, hullsFile: result.file as Bytes };
      }),
    );
  },

  measure(mesh, hulls, parameters) {
    return withMesh(mesh, (mesh) => using(hullList(hulls), (list) => parse(glue.measure(mesh, list, parameters))));
  },

  mergeTree(mesh, hulls, parameters) {
    return withMesh(mesh, (mesh) =>
      using(hullList(hulls), (list) =>
        using(glue.mergeTree(mesh, list, parameters), (tree) => {
          const { joined } = tree;
          const joins = Array.from({ length: joined.length / 2 }, (_, i): [number, number] => [
            joined[2 * i],
            joined[2 * i + 1],
          ]);
          const all = [...using(list.arrays(), separate), ...using(tree.arrays(), separate)];
          return { curve: parse(tree.curve), hulls: all, joined: joins };
        }),
      ),
    );
  },

  simplify(mesh, parameters) {
    const listener = listenerOf(onProgress);
    return withMesh(mesh, (mesh) =>
      using(glue.simplify(mesh, parameters, listener), ({ positions, indices, sources, hidden, report }) => ({
        positions: positions as Float64s,
        indices: indices as Uint32s,
        sources: sources as Uint32s,
        hidden: hidden as Uint32s,
        report: { ...parse(report), algorithmVersion: algorithmVersion() },
      })),
    );
  },

  readMesh({ name, format, main, others }) {
    return using(new glue.MeshReader(), (reader) => {
      const read = () => {
        try {
          return reader.read(format, main);
        } catch (error) {
          // The module has no names of files.
          if (error instanceof Error) error.message = error.message.replace(/^\w+ in memory/, name);
          throw error;
        }
      };
      for (const [path, bytes] of others) reader.add(path, bytes);
      return using(read(), ({ positions, indices, doubleSided, objects }) => ({
        positions: positions as Float64s,
        indices: indices as Uint32s,
        doubleSided: doubleSided as Bytes,
        objects: JSON.parse(objects),
      }));
    });
  },
});

/** The buffers of arrays anywhere in a value, which are handed over instead of copied. */
export function buffersIn(value: unknown): ArrayBuffer[] {
  if (ArrayBuffer.isView(value)) return [value.buffer as ArrayBuffer];
  if (value === null || typeof value !== "object") return [];
  return [...new Set(Object.values(value).flatMap(buffersIn))];
}
