//! Openings: the sides that modellers leave out because they are never seen.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the flat
//! openings of the repaired mesh are found, and those are closed through which only the backs of
//! faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `opening` | the boundary as simple loops; what became of each opening |
//! | `cap` | flat polygons over loops, and zips for cracks |
//! | `decide` | rules 3 to 8 below, for each cap |
//! | `prepare` | the repaired mesh with its caps, without nested shells |
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
//! A closed mesh whose normals all point inward has no opening: repair turns it around, since exporters that
//! mirror are more common than rooms without a door.

mod cap;
mod decide;
mod opening;
pub(crate) mod prepare;

pub(crate) use decide::OpeningSettings;
pub use opening::{Opening, OpeningOutcome};
pub use prepare::{ClosedMesh, close_openings, surface_and_solid};
