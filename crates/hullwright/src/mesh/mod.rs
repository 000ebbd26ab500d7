//! The input as the pipeline works on it: repaired, normalised, simplified.
//!
//! | file | contents |
//! |---|---|
//! | `repair` | any triangle soup as a clean, normalised mesh; counts of what was changed |
//! | `weld`, `orientation`, `canonical_order` | its steps: vertices at one place, winding, an order by place |
//! | `adjacency` | half-edges, neighbours, components and shells |
//! | `regions` | the parts of space that faces bound, and on which side of a face the solid is |
//! | `grouping` | the paper's convex groups of triangles |
//! | `refine` | long edges halved |
//! | `simplification` | the exact surface and the coarse one: fewer triangles, and how far they have moved |
//! | `collapse`, `flip` | its steps: edge collapses, and diagonals within planes |
//! | `simplify` | a number of triangles, by meshoptimizer |
//! | `shapes` | small meshes for tests |

pub(crate) mod adjacency;
pub(crate) mod canonical_order;
pub(crate) mod collapse;
pub(crate) mod flip;
pub(crate) mod grouping;
mod orientation;
pub(crate) mod refine;
pub(crate) mod regions;
pub(crate) mod repair;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod simplification;
pub(crate) mod simplify;
pub(crate) mod weld;

pub use crate::geometry::TriangleMesh;
pub(crate) use repair::{CAP, HIDDEN_CAP};
pub use repair::{Normalization, PreparedMesh, Repairs};
