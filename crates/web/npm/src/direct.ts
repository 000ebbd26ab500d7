// The same functions in the caller's own thread, for those who have a worker already: `await load(module)` once, then
// calls return when they are done. Nothing can cancel them but the end of the thread. After an error with the code `trap`
// the module is of no more use in this thread.

import { hullArrays, meshArrays, namedFiles, parameterText } from "./arguments.js";
import * as module from "./calls.js";
import { HullwrightError, plain } from "./error.js";
import type {
  Decomposition, Hulls, Measurement, MergeTree, Mesh, MeshFiles, MeshFormat, Options, Parameters, ReadMesh,
} from "./types.js";

export * from "./public.js";

/** The module of `hullwright/hullwright.wasm`: its bytes, the response of a `fetch`, or compiled. */
export type ModuleSource = WebAssembly.Module | BufferSource | Response;

/** Makes the module ready. */
export async function load(given: ModuleSource | Promise<ModuleSource>): Promise<void> {
  const source = await given;
  const isResponse = typeof Response !== "undefined" && source instanceof Response;
  const bytes = isResponse ? await source.arrayBuffer() : source;
  module.start(bytes instanceof WebAssembly.Module ? bytes : await WebAssembly.compile(bytes as BufferSource));
}

/** The module's errors as those of the package. */
function typed<T>(call: () => T): T {
  try {
    return call();
  } catch (error) {
    if (error instanceof HullwrightError) throw error;
    const { code, message } = plain(error);
    throw new HullwrightError(code, message);
  }
}

/** Decomposes a mesh into convex hulls. */
export function decompose(mesh: Mesh, options: Options = {}): Decomposition {
  return typed(() => module.calls(options.onProgress).decompose(meshArrays(mesh), parameterText(options)));
}

/** Samples how far hulls are from a mesh, and the mesh from them. */
export function measure(mesh: Mesh, hulls: Hulls, options: Parameters = {}): Measurement {
  return typed(() => module.calls().measure(meshArrays(mesh), hullArrays(hulls), parameterText(options)));
}

/** Joins hulls down to one. */
export function mergeTree(mesh: Mesh, hulls: Hulls, options: Parameters = {}): MergeTree {
  return typed(() => module.calls().mergeTree(meshArrays(mesh), hullArrays(hulls), parameterText(options)));
}

/** Reads a mesh file. */
export function readMesh(files: MeshFiles, format?: MeshFormat): ReadMesh {
  return typed(() => module.calls().readMesh(namedFiles(files, format)));
}
