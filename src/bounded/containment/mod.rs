//! Containment: whether hulls stay within the bound of the solid.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the edges where a surface ends |
//! | `swept` | the winding number of edges that are swept to infinity |
//! | `inside` | which points are inside a surface |
//! | `distance_grid/` | a grid that answers most questions about distance and side |
//! | `cavities` | the empty space that hulls must not swallow |
//! | `face_cache` | which faces fit, as far as they have been tested |
//! | `solid` | the solid: distance, side, and whether points fit |
//! | `polygon`, `remainder` | faces without what lies along the surface |
//! | `triangle` | halving of faces until each part is decided |
//! | `fit_test` | whether faces fit |
//! | `suspects` | where earlier hulls have protruded |
//! | `fit_tester` | whether hulls fit |

pub(super) mod boundary;
mod cavities;
mod distance_grid;
mod face_cache;
pub(super) mod fit_test;
pub(super) mod fit_tester;
pub(super) mod inside;
mod polygon;
pub(super) mod remainder;
pub(crate) mod solid;
pub(super) mod suspects;
mod swept;
pub(super) mod triangle;
