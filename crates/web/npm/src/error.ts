// Errors with codes.

/** What went wrong, by name. The message says it in words, with numbers. */
export type ErrorCode =
  // The mesh.
  | "empty_mesh"
  | "index_out_of_range"
  | "nothing_usable"
  | "too_large"
  | "sidedness_count"
  // Options and arguments.
  | "invalid_parameter"
  | "invalid_argument"
  // Hulls.
  | "no_hull"
  | "no_hulls"
  | "unusable_hull"
  // Files.
  | "file"
  | "hulls_file"
  // Memory is short.
  | "simplification"
  /** The module ended in the middle of its work, most often since memory ran out. A pool has started a fresh worker. */
  | "trap"
  /** The worker could not be started: its files are missing, or the page's policy forbids it. */
  | "worker"
  /** The pool was closed. */
  | "closed"
  // Codes that a later version of the module may add.
  | (string & {});

/** Every promise of this package is rejected with this, or with the reason of its `AbortSignal`. */
export class HullwrightError extends Error {
  override readonly name = "HullwrightError";

  constructor(
    readonly code: ErrorCode,
    message: string,
  ) {
    super(message);
  }
}

/** As it crosses from a worker to its owner. */
export interface PlainError {
  code: string;
  message: string;
}

/** What the module throws: an error with a code, or, once it is unusable, any other. */
export function plain(error: unknown): PlainError {
  const { code, message } = (error ?? {}) as Partial<PlainError>;
  return { code: typeof code === "string" ? code : "trap", message: message ?? String(error) };
}
