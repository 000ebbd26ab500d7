//! A surface with few triangles, verified to be within a bound of its source.
//!
//! | file | contents |
//! |---|---|
//! | `compare` | the public function that measures two surfaces against each other |
//! | `simplify` | the public function, its parameters and its report |
//! | `hidden` | triangles that nothing can touch |
//! | `rounds` | collapses, measured, and taken back where they are beyond the bound |
//! | `guesses` | collapses that samples allow, and that can be taken back |
//! | `distance` | how far triangles are from a surface at most |

mod compare;
mod distance;
mod guesses;
mod hidden;
mod rounds;
mod simplify;

pub use compare::{
    HiddenTriangles, MeasuredSurface, SurfaceDistance, SurfaceDistances, surface_distances,
};
pub use simplify::{SimplifiedSurface, SimplifyParameters, SimplifyReport, simplify_surface};
