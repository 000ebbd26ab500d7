//! The solid: how far is this point from it, and on which side? Does this hull stay within the bound?
//!
//! [`Solid`] is the only door. A second solid is another surface, as triangles, for [`Solid::of_surface`]: how far these may
//! be off adds to [`Solid::displacement`].
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the edges where a surface ends, and how fast the winding number changes near them |
//! | `surface` | the side of a point, by the surface itself |
//! | `grid` | a grid of cells that answers most questions about distance and side |
//! | `solid` | the solid: what a point is, and what it is to the source |
//! | `remainder` | faces without what lies along the surface |
//! | `subdivide` | the loop that halves faces until each part is decided |
//! | `fit` | the lenient test of the search: whether hulls fit |
//! | `protrusion` | the exact test of verification: how far hulls protrude |
//! | `uncovered` | how far the source lies outside the hulls |

mod boundary;
mod fit;
mod grid;
mod protrusion;
mod remainder;
#[expect(clippy::module_inception, reason = "the room is named after its door")]
mod solid;
mod subdivide;
mod surface;
mod uncovered;

#[cfg(test)]
pub(crate) use boundary::Boundary;
pub(crate) use fit::FitTester;
pub(crate) use protrusion::{SharedSuspects, keeps_bound, protrusion};
pub(crate) use solid::{COARSE, Solid};
pub(crate) use subdivide::{Scratch, centre};
pub(crate) use surface::Side;
pub(crate) use uncovered::{HullDistance, PointGroups, distance_outside, uncovered_distance};
