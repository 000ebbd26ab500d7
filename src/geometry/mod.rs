//! The ground floor: vectors, boxes, coordinates.

pub(crate) mod bounds;
mod coordinate;
pub mod vector;

pub use bounds::Bounds;
pub use coordinate::Coordinate;
