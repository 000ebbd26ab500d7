// The whole package in one file: `import { decompose, readMesh } from "hullwright"`.

import wasm from "#wasm";
import code from "#worker";
import { inlined, lazy } from "./inlined.js";
import type { PoolOptions, ReadingPool } from "./pool.js";

export * from "./public.js";

/** Workers of your own, for several jobs at a time. */
export const createPool: (options?: PoolOptions) => ReadingPool = inlined(wasm, code);

/** One worker for the functions below. It starts with the first call. */
const shared = lazy(createPool);

export const decompose: ReadingPool["decompose"] = (...args) => shared().decompose(...args);
export const measure: ReadingPool["measure"] = (...args) => shared().measure(...args);
export const mergeTree: ReadingPool["mergeTree"] = (...args) => shared().mergeTree(...args);
export const readMesh: ReadingPool["readMesh"] = (...args) => shared().readMesh(...args);
