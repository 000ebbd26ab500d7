//! The ground floor: vectors, boxes, coordinates, meshes.

mod bounds;
mod coordinate;
mod mesh;
mod turns;
pub mod vector;

pub use bounds::Bounds;
pub use coordinate::Coordinate;
pub use mesh::{MeshView, Sidedness, TriangleMesh};
pub(crate) use turns::Turns;
