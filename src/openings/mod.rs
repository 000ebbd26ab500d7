//! Openings: the sides that modellers leave out because they are never seen.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the flat
//! openings of the repaired mesh are found, and those are closed through which only the backs of
//! faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the boundary as simple loops |
//! | `cap` | flat polygons over loops, and zips for cracks |
//! | `crossing` | whether the surface goes through a cap |
//! | `look` | what is seen through an opening |
//! | `decide` | rules 3 to 6 below, for each cap |
//! | `fragments` | rule 7 |
//! | `nested` | closed components that nothing can reach |
//! | `report` | what became of each opening |
//! | `prepare` | the repaired mesh with its caps |
//! | `closed_mesh` | the same as a public result |
//!
//! The rules, in this order:
//!
//! 1. Cracks and T-junctions within the weld distance are no openings: they are zipped.
//! 2. A loop that is not flat within the tolerance stays open.
//! 3. So does one whose cap would meet the surface around it at less than 30° in the median: a sheet;
//!    or whose cap the surface goes through.
//! 4. A loop around which most of the surface is drawn from both sides, or is there both ways round, stays
//!    open unless it lies in the lowest plane of the mesh.
//! 5. Rays go inward from the caps that are left, all of them closed. One from which more than 5 % of
//!    the rays see the front of a face, or a way out, stays open; so does one from which most see
//!    only another cap. This is repeated until no more caps fall.
//! 6. One beyond which is inside already stays open: parts of an open skin, as the planks of a chest without
//!    backs, enclose a solid together.
//! 7. The caps of a component most of whose boundary stays open are left, and all caps of a mesh nine tenths of
//!    whose boundary do.
//! 8. Where nothing else stays open, those of 6 are closed after all, as a leg's end within a table's top, but
//!    are no surface: the mesh is closed then, and nothing can touch them. One that reaches out of the solid is.
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
pub use prepare::{ClosedMesh, close_openings};
pub use report::{Opening, OpeningOutcome};
