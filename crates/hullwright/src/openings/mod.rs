//! Openings: the sides that modellers leave out because they are never seen.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the
//! flat openings of the repaired mesh are found, and those are closed through which only the backs
//! of faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `opening` | the boundary as simple loops; what became of each opening |
//! | `cap` | flat polygons over loops, zips for cracks, and whether the surface goes through a cap |
//! | `decide` | the rules of `docs/openings.md`, by the same numbers, and what is seen through an opening |
//! | `narrow` | openings that no ball passes, in what is there both ways round |
//! | `prepare` | the repaired mesh with its caps, without nested shells; also as a public result |
//!
//! A closed mesh whose normals all point inward has no opening: repair turns it around, since
//! exporters that mirror are more common than rooms without a door.

mod cap;
mod decide;
mod narrow;
mod opening;
pub(crate) mod prepare;

pub(crate) use decide::OpeningSettings;
pub use opening::{Opening, OpeningOutcome};
pub use prepare::{ClosedMesh, close_openings};
