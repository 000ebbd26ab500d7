// What every entry exports.

export { HullwrightError, type ErrorCode } from "./error.js";
export { hullsAt, type Hullset } from "./states.js";
export type { Pool, PoolOptions, ReadingPool } from "./pool.js";
export type * from "./types.js";
