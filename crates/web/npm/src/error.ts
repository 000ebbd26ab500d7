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
  // `hullwright/direct`: the module could not be loaded, or was not yet.
  | "module"
  /** A callback of the caller threw: `cause` is what. */
  | "callback"
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
    options?: ErrorOptions,
  ) {
    super(message, options);
  }
}

export const refuse = (message: string): never => {
  throw new HullwrightError("invalid_argument", message);
};

/** Any error as one of the package's. */
export function typed(error: unknown, code: ErrorCode): HullwrightError {
  return error instanceof HullwrightError ? error : new HullwrightError(code, wordsOf(error), { cause: error });
}

/** As it crosses from a worker to its owner. */
export interface PlainError {
  code: string;
  message: string;
}

/** Arguments that no type allows may throw anything. */
export function checked<T>(make: () => T): T {
  try {
    return make();
  } catch (error) {
    throw typed(error, "invalid_argument");
  }
}

/** The message of anything that was thrown. */
export const wordsOf = (error: unknown) => String((error as { message?: unknown } | null)?.message ?? error);

/** The library's names of options, as they are here. */
const NAMES = /\b(max_error|max_hulls|max_vertices|probe_radius|probe_from|keep_cavities|keep_hidden|up_axis)\b/g;

/** What the module throws: an error with a code, or, once it is unusable, any other. */
export function plain(error: unknown): PlainError {
  const { code } = (error ?? {}) as Partial<PlainError>;
  const words = wordsOf(error);
  if (typeof code === "string") {
    const camel = (name: string) => name.replace(/_([a-z])/g, (_, letter: string) => letter.toUpperCase());
    return { code, message: words.replace(NAMES, camel) };
  }
  return { code: "trap", message: `the module ended in the middle of its work, most often since memory ran out (${words})` };
}
