// Workers and their jobs. A worker has one job at a time; one that is cancelled or trapped is ended, and a fresh one takes
// its place. The module is compiled once.

import { checkedOptions, hullArrays, meshArrays, namedFiles, parameterText } from "./arguments.js";
import { buffersIn, type Call } from "./calls.js";
import { checked, HullwrightError, refuse, typed, wordsOf } from "./error.js";
import { torus } from "./torus.js";
import type { Reply, Request } from "./worker.js";
import type {
  Cancellable, Decomposition, Hulls, Measurement, MergeTree, Mesh, MeshFiles, MeshFormat, Options, Parameters, Progress,
  ReadMesh, SimplifiedSurface, SimplifyOptions,
} from "./types.js";

/** Where worker and module come from. */
export interface Source {
  /** Compiles the module. */
  module(): Promise<WebAssembly.Module>;
  /** Starts a worker. */
  worker(): Thread | Promise<Thread>;
}

/** A worker of a browser or of Node. */
export interface Thread {
  post(message: unknown, transfer: ArrayBuffer[]): void;
  /** At most one of each. */
  listen(onReply: (reply: Reply) => void, onError: (message: string) => void): void;
  /** Whether it keeps the process alive. */
  hold(isHeld: boolean): void;
  end(): void;
}

interface Job {
  request: Request;
  transfer: ArrayBuffer[];
  onProgress: ((progress: Progress) => void) | undefined;
  resolve(value: unknown): void;
  reject(error: unknown): void;
}

interface Seat {
  thread: Promise<Thread>;
  /** Whether it was sent the module. */
  hasModule: boolean;
  job?: Job | undefined;
  /** Ends it, unless there is work before. */
  idle?: ReturnType<typeof setTimeout>;
}

export interface PoolOptions {
  /** Workers at most, each with a memory of its own; they start when there is work. Default 1. */
  size?: number | undefined;
  /** After so many seconds without work a worker ends, and its memory is given back. Default: never. */
  idleSeconds?: number | undefined;
}

/** Runs after which the first call takes about twice the time of a later one; of 16 as long, but they take a second. */
const WARMING = 4;

/** A listener for each signal, however many jobs it has: runtimes warn of more than ten. */
const listeners = new WeakMap<AbortSignal, Set<() => void>>();

/** Calls `abort` when the signal is aborted, until what is returned is called. */
function onAbort(signal: AbortSignal, abort: () => void): () => void {
  let all = listeners.get(signal);
  if (!all) {
    const made = (all = new Set());
    signal.addEventListener("abort", () => [...made].forEach((listener) => listener()), { once: true });
    listeners.set(signal, all);
  }
  all.add(abort);
  return () => all.delete(abort);
}

/** The functions that run in workers. */
export interface Pool {
  /** Decomposes a mesh into convex hulls. */
  decompose(mesh: Mesh, options?: Options & Cancellable): Promise<Decomposition>;
  /** Samples how far hulls are from a mesh, and the mesh from them. `options` are what the hulls were made with. */
  measure(mesh: Mesh, hulls: Hulls, options?: Parameters & Cancellable): Promise<Measurement>;
  /** Joins hulls down to one: the pair that protrudes least goes first. `options` are what the hulls were made with. */
  mergeTree(mesh: Mesh, hulls: Hulls, options?: Parameters & Cancellable): Promise<MergeTree>;
  /** Makes a surface with few triangles within a bound of a mesh: for colliders of what never moves. */
  simplify(mesh: Mesh, options?: SimplifyOptions & Cancellable): Promise<SimplifiedSurface>;
  /** Starts a worker, and has it work for half a second on a mesh of its own: engines compile the module a second time, and
   * better, once it has run. Without it the first calls of a page take up to five times as long as later ones. */
  prepare(): Promise<void>;
  /** Ends all workers. What is not done yet is rejected with the code `closed`, and so is what comes later. */
  close(): void;
}

/** A pool whose module has the readers of mesh files. */
export interface ReadingPool extends Pool {
  /** Reads a mesh file. Of several files by their paths, one is the mesh and the others what it names. */
  readMesh(files: MeshFiles, format?: MeshFormat, options?: Cancellable): Promise<ReadMesh>;
}

export function createPoolFrom(source: Source, options?: PoolOptions | null): ReadingPool {
  const { size = 1, idleSeconds = Infinity } = checkedOptions(options);
  if (!(typeof size === "number" && size >= 1)) return refuse(`\`size\` is at least 1, not ${size}`);
  if (!(typeof idleSeconds === "number" && idleSeconds >= 0)) return refuse(`\`idleSeconds\` is at least 0, not ${idleSeconds}`);
  const seats: Seat[] = [];
  const queue: Job[] = [];
  let module: Promise<WebAssembly.Module> | undefined;
  let isClosed = false;

  const remove = <T>(list: T[], item: T) => {
    const index = list.indexOf(item);
    if (index >= 0) list.splice(index, 1);
  };

  /** The worker is no more, or of no more use. */
  function dismiss(seat: Seat) {
    remove(seats, seat);
    clearTimeout(seat.idle);
    seat.job = undefined;
    seat.thread.then((thread) => thread.end(), () => undefined);
  }

  function seat(): Seat {
    const made: Seat = { thread: Promise.resolve().then(() => source.worker()), hasModule: false };
    const fail = (error: unknown) => {
      const { job } = made;
      dismiss(made);
      job?.reject(typed(error, "worker"));
      work();
    };
    const onReply = (reply: Reply) => {
      const { job } = made;
      if (!job) return;
      if ("progress" in reply) {
        try {
          job.onProgress?.(reply.progress);
        } catch (error) {
          fail(new HullwrightError("callback", `onProgress: ${wordsOf(error)}`, { cause: error }));
        }
        return;
      }
      if ("error" in reply) {
        const error = new HullwrightError(reply.error.code, reply.error.message);
        if (error.code === "trap" || error.code === "worker") return fail(error);
        release(made);
        job.reject(error);
      } else {
        release(made);
        job.resolve(reply.value);
      }
      work();
    };
    made.thread.then((thread) => thread.listen(onReply, (message) => fail(new HullwrightError("worker", message))), fail);
    seats.push(made);
    return made;
  }

  function release(seat: Seat) {
    seat.job = undefined;
    void seat.thread.then((thread) => thread.hold(false));
    if (idleSeconds === Infinity) return;
    seat.idle = setTimeout(() => seat.job ?? dismiss(seat), 1000 * idleSeconds);
    // In Node, where it would keep the process alive.
    (seat.idle as { unref?(): void }).unref?.();
  }

  /** Gives jobs to workers, as long as there are both. */
  function work() {
    while (queue.length > 0) {
      const idle = seats.find(({ job }) => !job);
      if (!idle && seats.length >= Math.max(1, size)) return;
      const free = idle ?? seat();
      const job = (free.job = queue.shift()!);
      clearTimeout(free.idle);
      module ??= source.module();
      const sent = free.hasModule ? undefined : module;
      Promise.all([free.thread, sent]).then(
        ([thread, module]) => {
          if (free.job !== job) return;
          free.hasModule = true;
          thread.hold(true);
          thread.post(module ? { ...job.request, module } : job.request, job.transfer);
        },
        (error: unknown) => {
          // What could not be fetched may be there next time.
          module = undefined;
          if (free.job !== job) return;
          dismiss(free);
          job.reject(typed(error, "worker"));
          work();
        },
      );
    }
  }

  function run(call: Call, makeArgs: () => unknown[], options?: ((Options | SimplifyOptions) & Cancellable) | null): Promise<any> {
    return new Promise((resolve, reject) => {
      const { signal, onProgress } = checkedOptions(options);
      if (signal && typeof signal.throwIfAborted !== "function") refuse("`signal` is no `AbortSignal`");
      if (onProgress && typeof onProgress !== "function") refuse("`onProgress` is no function");
      signal?.throwIfAborted();
      if (isClosed) throw new HullwrightError("closed", "the pool is closed");
      const args = checked(makeArgs);
      let stopListening: (() => void) | undefined;
      const settle = <T>(then: (value: T) => void) => (value: T) => {
        stopListening?.();
        then(value);
      };
      const job: Job = {
        request: { call, args, isHeard: onProgress !== undefined },
        transfer: buffersIn(args),
        onProgress,
        resolve: settle(resolve),
        reject: settle(reject),
      };
      function abort() {
        remove(queue, job);
        const busy = seats.find((seat) => seat.job === job);
        if (busy) dismiss(busy);
        job.reject(signal?.reason);
        // The fresh worker starts now, before there is work for it.
        if (busy && !isClosed && queue.length === 0) seat();
        work();
      }
      stopListening = signal && onAbort(signal, abort);
      queue.push(job);
      work();
    });
  }

  return {
    decompose: (mesh, options) => run("decompose", () => [meshArrays(mesh), parameterText(options)], options),
    measure: (mesh, hulls, options) =>
      run("measure", () => [meshArrays(mesh), hullArrays(hulls), parameterText(options)], options),
    mergeTree: (mesh, hulls, options) =>
      run("mergeTree", () => [meshArrays(mesh), hullArrays(hulls), parameterText(options)], options),
    simplify: (mesh, options) => run("simplify", () => [meshArrays(mesh), parameterText(options)], options),
    readMesh: (files, format, options) => run("readMesh", () => [namedFiles(files, format)], options),
    async prepare() {
      for (let i = 0; i < WARMING; i++) await run("decompose", () => [meshArrays(torus()), ""]);
    },
    close() {
      isClosed = true;
      const error = new HullwrightError("closed", "the pool is closed");
      const jobs = [...queue.splice(0), ...seats.flatMap(({ job }) => job ?? [])];
      for (const seat of [...seats]) dismiss(seat);
      for (const job of jobs) job.reject(error);
    },
  };
}
