// The same functions in the caller's own thread, for those who have a worker already: `await load(module)` once, then
// calls return when they are done. Nothing can cancel them but the end of the thread. After an error with the code `trap`
// the module is of no more use in this thread.

import { hullArrays, meshArrays, namedFiles, parameterText } from "./arguments.js";
import * as module from "./calls.js";
import { checked, HullwrightError, plain, typed } from "./error.js";
import type {
  Decomposition, Hulls, Measurement, MergeTree, Mesh, MeshFiles, MeshFormat, Options, Parameters, ReadMesh,
  SimplifiedSurface, SimplifyOptions,
} from "./types.js";

export * from "./public.js";

/** The module of `hullwright/hullwright.wasm`: its bytes, the response of a `fetch`, or compiled. */
export type ModuleSource = WebAssembly.Module | BufferSource | Response;

/** Makes the module ready. */
export async function load(given: ModuleSource | Promise<ModuleSource>): Promise<void> {
  try {
    const source = await given;
    const isResponse = typeof Response !== "undefined" && source instanceof Response;
    if (isResponse && !source.ok) throw new Error(`${source.url}: ${source.status} ${source.statusText}`);
    const bytes = isResponse ? await source.arrayBuffer() : source;
    module.start(bytes instanceof WebAssembly.Module ? bytes : await WebAssembly.compile(bytes as BufferSource));
    isLoaded = true;
  } catch (error) {
    throw typed(error, "module");
  }
}

let isLoaded = false;

/** Arguments that are sound for the module, and its errors as those of the package. */
function run<A, T>(makeArgs: () => A, call: (args: A) => T): T {
  const args = checked(makeArgs);
  if (!isLoaded) throw new HullwrightError("module", "the module is not loaded: `await load(module)` first");
  try {
    return call(args);
  } catch (error) {
    if (error instanceof HullwrightError) throw error;
    const { code, message } = plain(error);
    throw new HullwrightError(code, message);
  }
}

/** Decomposes a mesh into convex hulls. */
export function decompose(mesh: Mesh, options: Options = {}): Decomposition {
  return run(
    () => [meshArrays(mesh), parameterText(options)] as const,
    (args) => module.calls(options?.onProgress).decompose(...args),
  );
}

/** Samples how far hulls are from a mesh, and the mesh from them. */
export function measure(mesh: Mesh, hulls: Hulls, options: Parameters = {}): Measurement {
  return run(
    () => [meshArrays(mesh), hullArrays(hulls), parameterText(options)] as const,
    (args) => module.calls().measure(...args),
  );
}

/** Joins hulls down to one. */
export function mergeTree(mesh: Mesh, hulls: Hulls, options: Parameters = {}): MergeTree {
  return run(
    () => [meshArrays(mesh), hullArrays(hulls), parameterText(options)] as const,
    (args) => module.calls().mergeTree(...args),
  );
}

/** Makes a surface with few triangles within a bound of a mesh. */
export function simplify(mesh: Mesh, options: SimplifyOptions = {}): SimplifiedSurface {
  return run(
    () => [meshArrays(mesh), parameterText(options)] as const,
    (args) => module.calls(options?.onProgress).simplify(...args),
  );
}

/** Reads a mesh file. */
export function readMesh(files: MeshFiles, format?: MeshFormat): ReadMesh {
  return run(
    () => [namedFiles(files, format)] as const,
    (args) => module.calls().readMesh(...args),
  );
}
