//! Openings: the sides that modellers leave out because they are never seen.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the flat
//! openings of the repaired mesh are found, and those are closed through which only the backs of
//! faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the boundary as simple loops |
//! | `cap` | flat polygons over loops, zips for cracks, and whether the surface goes through a cap |
//! | `look` | what is seen through an opening |
//! | `decide` | the rules of `docs/openings.md`, by the same numbers |
//! | `nested` | closed components that nothing can reach |
//! | `report` | what became of each opening |
//! | `prepare` | the repaired mesh with its caps, also as a public result |
//!
//! A closed mesh whose normals all point inward is no opening's matter: repair turns it around, since
//! exporters that mirror are more common than rooms without a door.

mod boundary;
mod cap;
mod decide;
mod look;
mod nested;
pub(crate) mod prepare;
mod report;

pub(crate) use decide::OpeningSettings;
pub use prepare::{ClosedMesh, close_openings, surface_and_solid};
pub use report::{Opening, OpeningOutcome};
