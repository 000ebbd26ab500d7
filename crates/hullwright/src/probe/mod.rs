//! The probe: which places a ball can reach from outside, and how near it comes to a point. What no
//! ball reaches may be filled.
//!
//! Biochemistry calls what a probe leaves the solvent-excluded volume (Connolly, "Analytical
//! molecular surface calculation", 1983); in image processing it is a closing by a ball, restricted
//! to what is connected to the outside. No promise rests on a surface of it; `filled` makes one to
//! look at. A point is as safe as it is far from all centres that balls can have:
//!
//! ```text
//!        centres          no centre is nearer than `clearance`: no ball is entered
//!     ─────────────        by more than r - clearance
//!        ╲     ╱  ↕ r
//!   ▓▓▓▓▓▓╲▁▁▁╱▓▓▓▓▓▓
//!   ▓▓▓▓▓▓  •  ▓▓▓▓▓▓
//! ```
//!
//! Whatever is not certain counts as reached: so what is promised holds for balls and not only for
//! cells.
//!
//! | file | contents |
//! |---|---|
//! | `reach` | a grid of cells that may hold the centre of a ball, flooded from outside |
//! | `clearance` | how near the centre of a ball can come to a point, by cells that are divided on demand |
//! | `field` | samples of that distance |
//! | `filled` | the surface of what no ball reaches, for display |

mod clearance;
mod field;
#[cfg(feature = "fill")]
mod filled;
mod reach;

pub(crate) use clearance::{Extent, Probe};
#[cfg(feature = "fill")]
pub use filled::FilledSurface;
#[cfg(feature = "fill")]
pub(crate) use filled::filled;
pub(crate) use reach::ProbeSettings;
