// The package without readers of mesh files, two thirds as large: `import { decompose } from "hullwright/core"`.

import wasm from "#wasm";
import code from "#worker";
import { inlined, lazy } from "./inlined.js";
import type { Pool, PoolOptions } from "./pool.js";

export * from "./public.js";

/** Workers of your own, for several jobs at a time. */
export const createPool: (options?: PoolOptions) => Pool = inlined(wasm, code);

/** One worker for the functions below. It starts with the first call. */
const shared = lazy(createPool);

export const decompose: Pool["decompose"] = (...args) => shared().decompose(...args);
export const measure: Pool["measure"] = (...args) => shared().measure(...args);
export const mergeTree: Pool["mergeTree"] = (...args) => shared().mergeTree(...args);
