// A mesh to work on before there is one.

import type { Mesh } from "./types.js";

/** Squares around it, and around its tube: as many as most stages have something to do with. */
const [AROUND, TUBE] = [24, 12];

export function torus(): Mesh {
  const positions: number[] = [];
  const indices: number[] = [];
  const at = (i: number, j: number) => (i % AROUND) * TUBE + (j % TUBE);
  for (let i = 0; i < AROUND; i++) {
    for (let j = 0; j < TUBE; j++) {
      const [a, b] = [(i * 2 * Math.PI) / AROUND, (j * 2 * Math.PI) / TUBE];
      const radius = 1 + 0.3 * Math.cos(b);
      positions.push(radius * Math.cos(a), radius * Math.sin(a), 0.3 * Math.sin(b));
      indices.push(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return { positions, indices };
}
