// Workers of the page: one that keeps what is shown, and while a decomposition runs a second one. What is begun anew ends
// the one that runs, so that no old result comes late.

import { HullwrightError } from "../../../crates/web/npm/src/error";
import type { MeshArrays, NamedFiles } from "../../../crates/web/npm/src/arguments";
import { startThread } from "../../../crates/web/npm/src/thread";
import type { Thread } from "../../../crates/web/npm/src/pool";
import type { Hull, Mass, Progress, ReadMesh } from "../../../crates/web/npm/src/types";
import { inflate } from "../../../crates/web/npm/src/inflate";
import code from "#worker";
import { text } from "../data";

export interface ShownData {
  document: string;
  geometry: Uint8Array;
  remarks: string;
  mass: Mass;
}

/** What the worker answers. */
export interface Requests {
  read(files: NamedFiles): ReadMesh;
  show(mesh: MeshArrays, title: string, parameters: string, compares: boolean): ShownData;
  hulls(most: number): Hull[];
  file(name: string, most: number): Uint8Array;
  glb(most: number): Uint8Array;
}

let module: Promise<WebAssembly.Module> | undefined;

/** A worker that answers one call after the other. */
export class Desk {
  private readonly thread: Promise<Thread>;
  /** Sent with the first call. */
  private first: WebAssembly.Module | undefined;
  private last: Promise<unknown> = Promise.resolve();
  private refuse: (error: unknown) => void = () => undefined;
  private settle: ((reply: any) => void) | undefined;
  private readonly ended = new Promise<never>((_, reject) => (this.refuse = reject));

  constructor() {
    this.ended.catch(() => undefined);
    this.thread = (async () => {
      module ??= inflate(text("module"), "gzip").then((bytes) => WebAssembly.compile(bytes));
      const [thread, compiled] = [await startThread({ code }), await module];
      thread.listen((reply) => this.settle?.(reply), (message) => this.refuse(new HullwrightError("worker", message)));
      this.first = compiled;
      return thread;
    })();
  }

  call<K extends keyof Requests>(call: K, args: Parameters<Requests[K]>, onProgress?: (progress: Progress) => void): Promise<ReturnType<Requests[K]>> {
    const work = this.last.then(async () => {
      const thread = await this.thread;
      return new Promise<ReturnType<Requests[K]>>((resolve, reject) => {
        this.settle = (reply) => {
          if ("progress" in reply) return onProgress?.(reply.progress);
          if ("error" in reply) reject(new HullwrightError(reply.error.code, reply.error.message));
          else resolve(reply.value);
        };
        thread.post({ module: this.first, call, args }, []);
        this.first = undefined;
      });
    });
    this.last = work.catch(() => undefined);
    return Promise.race([work, this.ended]);
  }

  end(reason: unknown) {
    this.refuse(reason);
    void this.thread.then((thread) => thread.end(), () => undefined);
  }
}
