//! The solid: how far is this point from it, and on which side? Does this hull stay within the
//! bound?
//!
//! [`Solid`] answers both; the tree and the grid stay inside. With a [probe](crate::probe), a point
//! that is farther than the bound from the solid fits all the same where no ball is entered by
//! more.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the edges where a surface ends, and how fast the winding number changes near them |
//! | `surface` | the side of a point, by the surface itself |
//! | `grid` | a grid of cells that answers most questions about distance and side |
//! | `solid` | the solid: on which side a point is, how far from the surface, and what a probe allows |
//! | `remainder` | faces without what lies along the surface |
//! | `subdivide` | the loop that halves faces until each part is decided |
//! | `fit` | the lenient test of the search: whether hulls fit |
//! | `protrusion` | the exact test of verification: how far hulls protrude |

mod boundary;
mod fit;
mod grid;
mod protrusion;
mod remainder;
#[expect(clippy::module_inception, reason = "the folder is named after its main type")]
mod solid;
mod subdivide;
mod surface;

#[cfg(test)]
pub(crate) use boundary::Boundary;
pub(crate) use fit::{FitTester, Refusal};
pub(crate) use protrusion::{keeps_bound, protrusion};
pub(crate) use solid::{COARSE, Solid, SolidSettings};
pub(crate) use subdivide::Scratch;
pub(crate) use surface::Side;
