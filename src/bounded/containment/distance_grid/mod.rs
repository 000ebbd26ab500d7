//! A grid over a mesh whose cells know the closest point of the surface and on which side of it
//! they are: it answers most questions of a fit test without the mesh.
//!
//! | file | contents |
//! |---|---|
//! | `vector_f32` | vectors in single precision |
//! | `lattice` | the cells and their indices |
//! | `distance_field` | closest points, by a distance transform |
//! | `flood` | sides of a closed surface, by flooding |
//! | `filled` | a grid whose cells are filled in advance |
//! | `blocks` | the cells of a lazy grid |
//! | `lazy` | a grid whose cells are filled when they are first asked |
//! | `open_sides` | sides of an open surface in a lazy grid |

mod blocks;
mod distance_field;
mod filled;
mod flood;
mod lattice;
mod lazy;
mod open_sides;
mod vector_f32;

use crate::bvh::Bvh;
use crate::geometry::vector::Vector;
pub(super) use filled::FilledGrid;
pub(super) use lazy::LazyGrid;

/// Half the diagonal of a cell, in cells.
const HALF_DIAGONAL: f64 = 0.8660254037844387;

/// What is true of all points of a cell. One byte each, so that more of them stay in the cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CellClass {
    /// Inside the solid, or near it.
    Near,
    /// Outside the solid and, as far as the grid knows, far from it.
    Far,
    /// Unknown, or different from point to point.
    Mixed,
}

/// The grid: filled in advance for dense meshes, lazy for coarse ones. See the module.
pub(crate) enum DistanceGrid {
    Filled(FilledGrid),
    Lazy(LazyGrid),
}

/// What the grid knows about a point.
pub(super) struct Probe {
    /// At least the distance to the surface; infinite beyond the band.
    pub upper: f64,
    /// At most the distance to the surface, up to the excess of the grid's distances; negative if
    /// nothing is known.
    pub lower: f64,
    /// The point's cell: its index in a filled grid, its place in a lazy one.
    pub(super) index: usize,
    pub(super) place: [usize; 3],
}

/// A ball around a point: all of it is on the same side, and no surface is in it.
pub(super) struct Clearance {
    pub radius: f64,
    pub inside: bool,
}

impl DistanceGrid {
    /// What the cells around a point's cell tell together, if that is anything.
    #[inline]
    pub(super) fn clearance(&self, point: Vector, bvh: &Bvh) -> Option<Clearance> {
        match self {
            Self::Filled(_) => None,
            Self::Lazy(grid) => grid.clearance(point, bvh),
        }
    }

    /// The class of a point's cell.
    #[inline]
    pub(super) fn class_of(&self, point: Vector, bvh: &Bvh) -> CellClass {
        match self {
            Self::Filled(grid) => grid.class_of(point),
            Self::Lazy(grid) => grid.class_of(point, bvh),
        }
    }

    /// What the grid knows about a point.
    #[inline]
    pub(super) fn probe(&self, point: Vector, bvh: &Bvh) -> Probe {
        match self {
            Self::Filled(grid) => grid.probe(point),
            Self::Lazy(grid) => grid.probe(point, bvh),
        }
    }

    /// The distance to the plane through the closest point of a point's cell, normal to the
    /// direction from there to the cell's centre: the distance to a surface that is flat there.
    /// Infinite beyond the band.
    #[inline]
    pub(super) fn distance_to_tangent(&self, point: Vector, bvh: &Bvh) -> f64 {
        match self {
            Self::Filled(grid) => grid.distance_to_tangent(point),
            Self::Lazy(grid) => grid.distance_to_tangent(point, bvh),
        }
    }

    /// The point of the surface closest to the centre of a point's cell; `None` beyond the band.
    #[inline]
    pub(super) fn nearest_point(&self, point: Vector, bvh: &Bvh) -> Option<Vector> {
        match self {
            Self::Filled(grid) => grid.nearest_point(point),
            Self::Lazy(grid) => grid.nearest_point(point, bvh),
        }
    }

    /// The triangle closest to the centre of a point's cell; `u32::MAX` beyond the band.
    #[inline]
    pub(super) fn nearest_triangle(&self, point: Vector, bvh: &Bvh) -> u32 {
        match self {
            Self::Filled(grid) => grid.nearest_triangle(point),
            Self::Lazy(grid) => grid.nearest_triangle(point, bvh),
        }
    }

    /// Whether the probe's point is inside; `None` if it may be on another side than its cell's
    /// centre.
    #[inline]
    pub(super) fn is_inside(&self, probe: &Probe, bvh: &Bvh) -> Option<bool> {
        match self {
            Self::Filled(grid) => grid.is_inside(probe, bvh),
            Self::Lazy(grid) => (probe.lower > 0.0).then(|| grid.is_inside(probe.place, bvh)),
        }
    }

    /// A lower bound on how far the inside extends around a point; `None` if the point's cell has
    /// its centre outside. If it is negative, the inside begins that far away at most.
    #[inline]
    pub(super) fn depth(&self, point: Vector, bvh: &Bvh) -> Option<f64> {
        match self {
            Self::Filled(grid) => grid.depth(point),
            Self::Lazy(grid) => grid.depth(point, bvh),
        }
    }

    /// See [`inside_reach`](super::inside::inside_reach).
    pub(super) fn inside_reach(
        &self,
        point: Vector,
        distance: f64,
        needed: f64,
        bvh: &Bvh,
    ) -> Option<f64> {
        match self {
            Self::Filled(grid) => grid.inside_reach(point, distance, needed, bvh),
            Self::Lazy(grid) => grid.inside_reach(point, distance, needed, bvh),
        }
    }

    /// Whether a point at `distance` from a closed surface is inside, if its cell tells. Where a
    /// surface is open, the inside may end without crossing it.
    #[inline]
    pub(super) fn side(&self, point: Vector, distance: f64, bvh: &Bvh) -> Option<bool> {
        match self {
            Self::Filled(grid) => grid.side(point, distance),
            Self::Lazy(grid) => grid.side(point, distance, bvh),
        }
    }
}
