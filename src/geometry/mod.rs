//! The ground floor: vectors, boxes, meshes.

mod mesh;
mod turns;
pub mod vector;

pub use mesh::{Bounds, Coordinate, MeshView, Sidedness, TriangleMesh};
pub(crate) use turns::Turns;
