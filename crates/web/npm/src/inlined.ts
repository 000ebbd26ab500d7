// Worker and module as text within this file: no bundler and no server has to know of them.

import { createPoolFrom, type PoolOptions, type ReadingPool, type Source } from "./pool.js";
import { startThread } from "./thread.js";

/** Base64 of gzip. */
async function unpack(text: string): Promise<ArrayBuffer> {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** Compiled once for all pools. */
const compiled = new Map<string, Promise<WebAssembly.Module>>();

export function inlined(module: string, code: string): (options?: PoolOptions) => ReadingPool {
  const source: Source = {
    module() {
      const known = compiled.get(module) ?? unpack(module).then((bytes) => WebAssembly.compile(bytes));
      compiled.set(module, known);
      return known;
    },
    worker: () => startThread({ code }),
  };
  return (options) => createPoolFrom(source, options);
}

/** A pool that is made when it is first used. */
export function lazy(create: () => ReadingPool): () => ReadingPool {
  let pool: ReadingPool | undefined;
  return () => (pool ??= create());
}
