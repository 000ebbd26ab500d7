//! A hull that grows by points, during the search: joint hulls are built by insertion into a copy
//! of the larger hull, which takes a quarter of the time of building them anew.

use super::{HullBuilder, Shape};
use crate::geometry::vector::{Vector, as_arrays, into_vectors};
use crate::work;

/// The hull of the points inserted so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct GrowingHull {
    /// Contains the hull if `is_solid`.
    pub builder: HullBuilder,
    /// Whether the hull has volume.
    pub is_solid: bool,
    /// All points, unless `is_solid`.
    pub points: Vec<Vector>,
    /// Sum of the area normals of the inserted surface: which side of a flat hull is outside.
    pub outward: Vector,
    pub min: Vector,
    pub max: Vector,
    /// Set by those who insert: [`current_volume`](Self::current_volume) takes O(faces).
    pub volume: f64,
}

impl GrowingHull {
    /// Copies another hull, reusing memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.builder.clone_from(&other.builder);
        self.is_solid = other.is_solid;
        self.points.clone_from(&other.points);
        self.outward = other.outward;
        self.min = other.min;
        self.max = other.max;
        self.volume = other.volume;
    }

    /// The vertices, or all points of a hull without volume.
    pub fn vertices(&mut self) -> Vec<Vector> {
        if self.is_solid { into_vectors(self.builder.extract().0) } else { self.points.clone() }
    }

    /// Grows to the hull of the union with other points. Returns whether it had volume before: if
    /// so, only its new faces are different.
    pub fn insert(&mut self, points: &[Vector], outward: Vector) -> bool {
        work::count(work::POINT * points.len() as u64);
        for &point in points {
            self.min = self.min.min(point);
            self.max = self.max.max(point);
        }
        self.outward += outward;
        if self.is_solid {
            self.builder.insert_outside(points);
            return true;
        }
        self.points.extend_from_slice(points);
        self.is_solid = self.builder.build(as_arrays(&self.points)) == Shape::Solid;
        if self.is_solid {
            self.builder.forget_inner_points();
            self.points.clear();
        }
        false
    }

    /// Whether the hull has volume, and no point is farther than `tolerance` in front of a face. Within
    /// [`SEARCH_TOLERANCE`] inserting them changes nothing.
    pub fn contains(&self, points: &[Vector], tolerance: f64) -> bool {
        self.is_solid && self.builder.contains_all(as_arrays(points), tolerance)
    }

    pub fn new(points: &[Vector], outward: Vector) -> Self {
        let mut hull = Self {
            builder: HullBuilder::new().with_least_tolerance(SEARCH_TOLERANCE),
            min: Vector::INFINITY,
            max: Vector::NEG_INFINITY,
            ..Self::default()
        };
        hull.insert(points, outward);
        hull.volume = hull.current_volume();
        hull
    }

    pub fn current_volume(&self) -> f64 {
        if self.is_solid { self.builder.volume() } else { 0.0 }
    }
}

/// Points within this fraction of the diagonal do not change a hull during the search: far less than any
/// distance that counts, more than the rounding of repeated insertions.
pub(crate) const SEARCH_TOLERANCE: f64 = 1e-5;
