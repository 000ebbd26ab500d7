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
//! | `hierarchy` | [`Bvh`]: the tree, and its queries about one point |
//! | `rays` | the winding number of a closed mesh by a ray; the first hit of a ray; triangles near a box |
//! | `near_plane` | the triangles near a face |
//! | `closest_triangles` | for each triangle of a mesh the closest one of another |
//!
//! Queries are thread-safe. They neither allocate nor lock, except the first winding number, which computes the
//! expansions. Coordinates should be of the order of 1: boxes and expansions are in single precision.
//!
//! There are three queries for "inside": [`Bvh::winding_number`] for any mesh, [`Bvh::crossings`] for a closed
//! one, and [`Bvh::is_inside`], the first above one half.

#![expect(clippy::needless_range_loop, reason = "an index is a lane or an axis of several arrays")]

pub(crate) mod closest_point;
pub(crate) mod closest_triangles;
mod hierarchy;
pub(crate) mod near_plane;
mod rays;
mod tree;
mod winding_number;

pub(crate) use hierarchy::{Bvh, INSIDE};
pub(crate) use rays::SLOPES;

#[cfg(test)]
mod tests;
