// The package without readers of mesh files, two thirds as large: `import { decompose } from "hullwright/core"`.

import wasm from "#wasm";
import code from "#worker";
import { inlined, lazy } from "./inlined.js";
import type { Pool, PoolOptions } from "./pool.js";

export * from "./public.js";

/** Workers of your own, for several jobs at a time. */
export const createPool: (options?: PoolOptions) => Pool = /* @__PURE__ */ inlined(wasm, code);

/** One worker for the functions below. It starts with the first call. */
const shared = /* @__PURE__ */ lazy(createPool);

export const decompose: Pool["decompose"] = (...args) => shared.pool().decompose(...args);
export const measure: Pool["measure"] = (...args) => shared.pool().measure(...args);
export const mergeTree: Pool["mergeTree"] = (...args) => shared.pool().mergeTree(...args);
export const simplify: Pool["simplify"] = (...args) => shared.pool().simplify(...args);

export const prepare: Pool["prepare"] = () => shared.pool().prepare();

/** Ends that worker, and gives its memory back; the next call starts another. Jobs that are not done are rejected with
 * the code `closed`. After a minute without work it ends by itself. */
export const close = (): void => shared.close();
