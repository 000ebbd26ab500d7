// The worker: gets the compiled module, then one call after the other, each answered once.

import { buffersIn, calls, start, type Call } from "./calls.js";
import { plain } from "./error.js";

interface Port {
  postMessage(message: unknown, transfer?: ArrayBuffer[]): void;
}

/** `module` comes with the first request. */
export interface Request {
  module?: WebAssembly.Module;
  call: Call;
  args: unknown[];
  isHeard: boolean;
}

/** A request has any number of `progress`, then one of the others. */
export type Reply =
  | { progress: { stage: string; fraction: number } }
  | { value: unknown }
  | { error: { code: string; message: string } };

function answer(port: Port, { module, call, args, isHeard }: Request) {
  try {
    if (module) start(module);
  } catch (error) {
    return port.postMessage({ error: { ...plain(error), code: "worker" } });
  }
  try {
    const heard = isHeard ? (progress: unknown) => port.postMessage({ progress }) : undefined;
    const value = (calls(heard)[call] as (...args: unknown[]) => unknown)(...args);
    port.postMessage({ value }, buffersIn(value));
  } catch (error) {
    port.postMessage({ error: plain(error) });
  }
}

if (typeof WorkerGlobalScope !== "undefined") {
  const port = self as unknown as Port;
  self.onmessage = ({ data }: MessageEvent<Request>) => answer(port, data);
} else {
  // Node: no bundler follows a name that it does not see.
  const name = "node:worker_threads";
  void import(name).then(({ parentPort }) => parentPort.on("message", (data: Request) => answer(parentPort, data)));
}

declare const WorkerGlobalScope: unknown;
