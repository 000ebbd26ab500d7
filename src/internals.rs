<<<<<<< HEAD
//! Parts of the decomposition for the laboratory in `crates/lab`: it runs HACD on the same mesh
//! repair, simplification and group merging as the methods here.
//!
//! There is no promise of stability: any version may change or drop what is here.

pub use crate::geometry::vector;
pub use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
pub use crate::mesh::canonical_order::MeshOrder;
pub use crate::mesh::grouping::{Grouping, corners, members};
pub use crate::mesh::repair::prepare;
pub use crate::mesh::{Normalization, PreparedMesh, TriangleMesh, shapes};
pub use crate::openings::surface_and_solid;
pub use crate::parallel::with as with_parallelism;
pub use crate::surface::cost::{CostScratch, cost};
pub use crate::surface::group_merging::merge_groups;
pub use crate::surface::pieces::Pieces;
pub use crate::surface::resolution_selection::{
    LEAST_CUT_OFF_RESOLUTION, Level, Levels, MOST_PIECES_FACTOR,
};
=======
//! What the command and the laboratory print.
//!
//! There is no promise of stability: any version may change or drop what is here.

#[cfg(feature = "io")]
pub mod terminal;
>>>>>>> lab
