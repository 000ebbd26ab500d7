//! A bounding-volume hierarchy over a triangle mesh: closest points and winding numbers.
//!
//! Any mesh is accepted: open, non-manifold, of several components, self-intersecting. Inside is
//! where the generalized winding number exceeds one half, which tolerates holes.
//!
//! | file | contents |
//! |---|---|
//! | `tree`, `build` | the four-wide tree and its construction, O(n log n) |
//! | `closest_point` | distances by branch and bound |
//! | `winding_number` | winding numbers by multipole expansion |
//! | `inside_nearby` | the way to the inside of an open surface |
//! | `near_plane` | the triangles near a face |
//! | `closest_triangles` | for each triangle of a mesh the closest one of another |
//! | `crossings` | what a closed mesh encloses |
//! | `ray` | the first hit of a ray, and triangles near a box |
//!
//! Queries do not depend on threads; but for the first winding number, which makes the expansions, they
//! allocate nothing and take no lock. Coordinates should be of the order of 1: boxes and expansions are in single
//! precision.

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
