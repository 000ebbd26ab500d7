// A worker of a browser, or of Node, behind one interface.

import type { Thread } from "./pool.js";
import type { Reply } from "./worker.js";

/** Starts a worker from its code, or from a file. */
export async function startThread(script: { code: string } | { url: URL }): Promise<Thread> {
  return typeof Worker === "undefined" ? nodeThread(script) : webThread(script);
}

/** One for all workers: they are few, and the page keeps it. */
const codeUrls = new Map<string, string>();

interface Policies {
  createPolicy(name: string, rules: { createScriptURL(url: string): string }): { createScriptURL(url: string): unknown };
}

/** Made once: pages mostly allow each name once. */
let policy: ReturnType<Policies["createPolicy"]> | undefined;

/** For pages that want Trusted Types: those that allow the policy `hullwright`. */
function trusted(url: string | URL): string | URL {
  const { trustedTypes } = globalThis as { trustedTypes?: Policies };
  if (!trustedTypes) return url;
  policy ??= trustedTypes.createPolicy("hullwright", { createScriptURL: (url) => url });
  return policy.createScriptURL(String(url)) as string;
}

function webThread(script: { code: string } | { url: URL }): Thread {
  let url: string | URL;
  if ("url" in script) url = script.url;
  else {
    const known = codeUrls.get(script.code);
    url = known ?? URL.createObjectURL(new Blob([script.code], { type: "text/javascript" }));
    codeUrls.set(script.code, String(url));
  }
  const worker = new Worker(trusted(url));
  return {
    post: (message, transfer) => worker.postMessage(message, transfer),
    listen(onReply, onError) {
      worker.onmessage = ({ data }: MessageEvent<Reply>) => onReply(data);
      worker.onerror = (event) => onError(event.message || "the worker could not be started");
      // Chromium's workers have the event, but no `onmessageerror`.
      worker.addEventListener("messageerror", () => onError("the worker sent what can't be read"));
    },
    hold: () => undefined,
    end: () => worker.terminate(),
  };
}

async function nodeThread(script: { code: string } | { url: URL }): Promise<Thread> {
  // No bundler follows a name that it does not see.
  const name = "node:worker_threads";
  const { Worker } = (await import(/* @vite-ignore */ /* webpackIgnore: true */ name)) as typeof import("node:worker_threads");
  const worker = "url" in script ? new Worker(script.url) : new Worker(script.code, { eval: true });
  worker.unref();
  return {
    post: (message, transfer) => worker.postMessage(message, transfer),
    listen(onReply, onError) {
      worker.on("message", onReply);
      worker.on("error", (error) => onError(error instanceof Error ? error.message : String(error)));
      worker.on("messageerror", () => onError("the worker sent what can't be read"));
      // Also where something else has ended it.
      worker.on("exit", () => onError("the worker has ended"));
    },
    // An idle worker does not keep the process alive.
    hold: (isHeld) => (isHeld ? worker.ref() : worker.unref()),
    end: () => void worker.terminate(),
  };
}
