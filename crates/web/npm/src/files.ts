// Worker and module as files of their own, which the page's server hands out: `import { createPool } from
// "hullwright/files"`. For pages whose policy forbids workers made of text, and for those who count bytes.

import { checkedOptions } from "./arguments.js";
import { refuse } from "./error.js";
import { createPoolFrom, type PoolOptions, type ReadingPool } from "./pool.js";
import { startThread } from "./thread.js";

export * from "./public.js";

export interface Files {
  /** Where `hullwright/hullwright.wasm` is, or the module itself. With `hullwright-core.wasm` there is no `readMesh`. */
  module: URL | string | WebAssembly.Module;
  /** Where `hullwright/worker.js` is; of the page's origin. */
  worker: URL | string;
}

export function createPool(files: Files & PoolOptions): ReadingPool {
  const { module, worker, ...options } = checkedOptions(files);
  if (!module || !worker) return refuse("`module` and `worker` say where the files are");
  const absolute = (url: URL | string) => new URL(url, globalThis.location?.href);
  const compile = async () => {
    if (module instanceof WebAssembly.Module) return module;
    const response = await fetch(absolute(module));
    if (!response.ok) throw new Error(`${module}: ${response.status} ${response.statusText}`);
    // Not while it streams: many servers name another type of content.
    return WebAssembly.compile(await response.arrayBuffer());
  };
  return createPoolFrom({ module: compile, worker: () => startThread({ url: absolute(worker) }) }, options);
}
