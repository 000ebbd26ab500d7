//! A bounding-volume hierarchy over a triangle mesh: closest points and winding numbers.
//!
//! Any mesh is accepted: open, non-manifold, of several components, self-intersecting. Inside is
//! where the generalized winding number exceeds one half, which tolerates holes.
//!
//! | file | contents |
//! |---|---|
//! | `tree` | the four-wide tree and its construction, O(n log n) |
//! | `closest_point` | distances by branch and bound |
//! | `winding_number` | winding numbers by multipole expansion |
//! | `hierarchy` | [`Bvh`]: the tree; winding numbers; triangles near a box or a face, or closest to those of another mesh |
//! | `edges` | the edges where a surface ends, and how fast its winding number changes |
//! | `rays` | the winding number of a closed mesh by a ray; the first hit of a ray |
//!
//! Queries are thread-safe. They neither allocate nor lock, except the first winding number, which
//! computes the expansions. Coordinates should be of the order of 1: boxes and expansions are in
//! single precision.
//!
//! There are four queries for "inside": [`Bvh::winding_number`] for any mesh and
//! [`Bvh::is_inside`], the same above one half; [`Bvh::crossings`] for a closed mesh and
//! [`Bvh::encloses`], the same above zero.

#![expect(clippy::needless_range_loop, reason = "an index is a lane or an axis of several arrays")]

pub(crate) mod closest_point;
mod edges;
mod hierarchy;
mod rays;
mod tree;
mod winding_number;

pub(crate) use edges::{Edge, EdgeTree};
pub(crate) use hierarchy::{Bvh, INSIDE, Slab, closest_labels, closest_triangles};
pub(crate) use rays::{Hit, SLOPES};
