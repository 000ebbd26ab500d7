// The states of a merge tree.

import { refuse } from "./error.js";
import type { Hull, MergeTree } from "./types.js";

export type Hullset = Hull[];

/** The hulls of the state with at most `most` hulls: `most`, or all there are, or one if `most` is 0. */
export function hullsAt({ hulls, joined }: MergeTree, most: number): Hullset {
  if (!(most >= 0)) return refuse(`the number of hulls is at least 0, not ${most}`);
  const leaves = hulls.length - joined.length;
  const joins = Math.max(0, Math.min(joined.length, leaves - Math.max(1, Math.floor(most))));
  const gone = new Set(joined.slice(0, joins).flat());
  return hulls.slice(0, leaves + joins).filter((_, hull) => !gone.has(hull));
}
