//! A surface with few triangles, verified to be within a bound of its source.
//!
//! | file | contents |
//! |---|---|
//! | `simplify` | the public function, its parameters and its report |
//! | `hidden` | triangles that nothing can touch |
//! | `rounds` | collapses, and distances measured in between |
//! | `distance` | how far triangles are from a surface at most |

mod distance;
mod hidden;
mod rounds;
mod simplify;

pub use simplify::{SimplifiedSurface, SimplifyParameters, SimplifyReport, simplify_surface};
