// The whole package in one file: `import { decompose, readMesh } from "hullwright"`.

import wasm from "#wasm";
import code from "#worker";
import { inlined, lazy } from "./inlined.js";
import type { PoolOptions, ReadingPool } from "./pool.js";

export * from "./public.js";

/** Workers of your own, for several jobs at a time. */
export const createPool: (options?: PoolOptions) => ReadingPool = /* @__PURE__ */ inlined(wasm, code);

/** One worker for the functions below. It starts with the first call. */
const shared = /* @__PURE__ */ lazy(createPool);

export const decompose: ReadingPool["decompose"] = (...args) => shared.pool().decompose(...args);
export const measure: ReadingPool["measure"] = (...args) => shared.pool().measure(...args);
export const mergeTree: ReadingPool["mergeTree"] = (...args) => shared.pool().mergeTree(...args);
export const simplify: ReadingPool["simplify"] = (...args) => shared.pool().simplify(...args);
export const readMesh: ReadingPool["readMesh"] = (...args) => shared.pool().readMesh(...args);

export const prepare: ReadingPool["prepare"] = () => shared.pool().prepare();

/** Ends that worker, and gives its memory back; the next call starts another. Jobs that are not done are rejected with
 * the code `closed`. After a minute without work it ends by itself. */
export const close = (): void => shared.close();
