// Worker and module as text within this file: no bundler and no server has to know of them.

import { inflate } from "./inflate.js";
import { createPoolFrom, type Pool, type PoolOptions, type ReadingPool, type Source } from "./pool.js";
import { startThread } from "./thread.js";

/** Compiled once for all pools. */
const compiled = new Map<string, Promise<WebAssembly.Module>>();

/** Pools of a module, as base64 of gzip, and a worker's code. */
export function inlined(module: string, code: string): (options?: PoolOptions) => ReadingPool {
  const source: Source = {
    module() {
      const known = compiled.get(module) ?? inflate(module, "gzip").then((bytes) => WebAssembly.compile(bytes));
      compiled.set(module, known);
      // What failed may work next time.
      known.catch(() => compiled.delete(module));
      return known;
    },
    worker: () => startThread({ code }),
  };
  return (options) => createPoolFrom(source, options);
}

/** After so long without work the shared worker ends, and its memory is given back. */
const IDLE_SECONDS = 60;

/** A pool that is made when it is first used, and again after it was closed. */
export function lazy<P extends Pool>(create: (options: PoolOptions) => P): { pool(): P; close(): void } {
  let made: P | undefined;
  return {
    pool: () => (made ??= create({ idleSeconds: IDLE_SECONDS })),
    close() {
      made?.close();
      made = undefined;
    },
  };
}
