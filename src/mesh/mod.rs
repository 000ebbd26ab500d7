//! The input as the pipeline works on it: repaired, normalised, simplified.

pub(crate) mod adjacency;
pub(crate) mod canonical_order;
pub(crate) mod grouping;
mod orientation;
pub(crate) mod refine;
pub(crate) mod repair;
#[cfg(test)]
pub(crate) mod shapes;
pub(crate) mod simplify;
pub(crate) mod weld;

pub use crate::geometry::TriangleMesh;
pub(crate) use repair::{CAP, HIDDEN_CAP};
pub use repair::{Normalization, PreparedMesh, Repairs};
