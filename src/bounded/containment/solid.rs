//! The solid that hulls must not protrude from: distances to its surface, and what is inside.
//!
//! Distances come as bounds, from the distance grid where that is enough and from the tree where
//! not. Where the mesh was clustered, the solid is that of the reduced mesh, and distances to the
//! source follow from it.

use std::sync::Arc;

use super::boundary::Boundary;
use super::cavities::cavities;
use super::distance_grid::{CellClass, DistanceGrid, FilledGrid, LazyGrid};
use super::face_cache::FaceCache;
use super::inside::is_inside;
use crate::bounded::clustering::Clustered;
use crate::bounded::settings::{COARSE, MIN_SEARCH_SHARE, Settings};
use crate::bvh::Bvh;
use crate::bvh::closest_point::ClosestPoint;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, length_squared, scale, subtract};
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::parallel;

/// Beyond the bound by less than this factor, the grid's distance, which may be too large, is
/// verified by the tree. Its excess is a fraction of a cell, and most cells measure 0.58 bounds.
pub(super) const DOUBT: f64 = 1.5;

/// More than the rounding of the grid's distances, in diagonals: 2^-24 for coordinates up to 1,
/// over the few operations of a distance.
const SINGLE_PRECISION: f64 = 1e-6;

/// The source mesh as a solid, or a reduced one that represents it.
pub(crate) struct Solid {
    pub bvh: Bvh,
    /// Where the surface ends; empty if it is closed.
    pub boundary: Arc<Boundary>,
    pub(super) grid: DistanceGrid,
    /// A point of each cavity that no hull may contain, and its distance to the surface.
    pub cavities: Vec<(Vector, f64)>,
    /// Results of the fit test.
    pub(super) face_cache: FaceCache,
    /// Where the solid is that of a reduced mesh: what it represents.
    pub clustered: Option<Arc<Clustered>>,
}

/// Bounds on the distance from a point to the source.
pub(crate) struct SourceDistance {
    /// At least the distance.
    pub upper: f64,
    /// At most the depth, if the point is inside the source or that near to it.
    pub lower: f64,
    /// The distance to the solid's own surface.
    own: f64,
    /// A triangle of the source within `upper`.
    triangle: u32,
}

impl Solid {
    /// The solid of a mesh, or of the reduced mesh if there is one. O(n log n) for n triangles, and
    /// a grid of at most 1.5 million cells.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        prepared: &PreparedMesh,
        clustered: Option<Arc<Clustered>>,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Error> {
        let bound = settings.bound.protrusion();
        if let Some(clustered) = clustered {
            let TriangleMesh { positions, triangles, .. } = &clustered.mesh;
            let solid =
                Self::of_surface(positions, triangles, Boundary::default(), bound, control)?;
            return Ok(Self { clustered: Some(clustered), ..solid });
        }
        let mesh = &prepared.mesh;
        let triangles = prepared.triangles_of_solid();
        // Where triangles run along each edge as often one way as the other, the surface ends nowhere,
        // even where more than two meet. Sheets in both orientations can close an open one.
        let is_as_given = triangles.len() == mesh.triangles.len();
        let boundary = match is_as_given && prepared.closed.iter().all(|&closed| closed) {
            true => Boundary::default(),
            false => Boundary::new(&mesh.positions, &triangles),
        };
        if mesh.triangles.len() <= COARSE && !settings.keep_cavities {
            return Self::of_few_triangles(&mesh.positions, &triangles, boundary, bound, control);
        }
        let mut solid = Self::of_surface(&mesh.positions, &triangles, boundary, bound, control)?;
        if settings.keep_cavities {
            solid.keep_cavities(bound);
        }
        Ok(solid)
    }

    /// The solid of a surface of few triangles, with a grid that is filled where it is asked.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn of_few_triangles(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Boundary,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let bvh = Bvh::with_control(positions, triangles, control)?;
        let boundary = Arc::new(boundary);
        let (near, far) = (MIN_SEARCH_SHARE * bound, DOUBT * bound);
        let grid = LazyGrid::new(positions, bound, Arc::clone(&boundary), near, far);
        Ok(Self::with_grid(bvh, boundary, DistanceGrid::Lazy(grid)))
    }

    fn with_grid(bvh: Bvh, boundary: Arc<Boundary>, grid: DistanceGrid) -> Self {
        Self {
            bvh,
            boundary,
            grid,
            cavities: Vec::new(),
            face_cache: FaceCache::new(),
            clustered: None,
        }
    }

    /// The solid of a surface and its boundary.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn of_surface(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Boundary,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let boundary = Arc::new(boundary);
        let (bvh, grid) = parallel::join(
            || Bvh::with_control(positions, triangles, control),
            || FilledGrid::new(positions, triangles, Arc::clone(&boundary), bound, control),
        );
        let (bvh, mut grid) = (bvh?, grid?);
        if boundary.is_empty() {
            grid.flood(&bvh, (positions, triangles), control)?;
        } else {
            bvh.expect_winding_numbers(control)?;
        }
        control.check()?;
        grid.classify_cells(MIN_SEARCH_SHARE * bound, DOUBT * bound);
        Ok(Self::with_grid(bvh, boundary, DistanceGrid::Filled(grid)))
    }

    /// Makes hulls that contain a cavity deeper than `bound` not fit.
    fn keep_cavities(&mut self, bound: f64) {
        let DistanceGrid::Filled(grid) = &self.grid else { return };
        let points = cavities(grid, &self.bvh, bound).into_iter();
        let depth =
            |point| self.bvh.closest_point(point, f64::INFINITY).map(|closest| closest.distance);
        self.cavities = points.filter_map(|point| Some((point, depth(point)?))).collect();
    }

    /// Whether the surface encloses the inside. Only then is a point's side also that of all points
    /// nearer to it than the surface.
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.boundary.is_empty()
    }

    /// Whether it has so few triangles that a face may ask those near it.
    #[inline]
    pub fn is_coarse(&self) -> bool {
        matches!(self.grid, DistanceGrid::Lazy(_))
    }

    /// How far the solid's own surface may be from the source, and what is inside it from what is
    /// inside the source.
    pub fn displacement(&self) -> f64 {
        self.clustered.as_ref().map_or(0.0, |clustered| clustered.displacement)
    }

    /// The distance from a point to the source. `guess` is a triangle of the solid that may be near
    /// and makes it faster. `None` if the solid has no surface.
    pub fn source_distance(&self, point: Vector, guess: u32) -> Option<SourceDistance> {
        let ClosestPoint { distance, triangle, .. } =
            self.bvh.closest_point_near(point, f64::INFINITY, guess)?;
        let Some(clustered) = &self.clustered else {
            return Some(SourceDistance {
                upper: distance,
                lower: distance,
                own: distance,
                triangle,
            });
        };
        let (upper, nearest) =
            clustered.closest_around(clustered.mesh.triangles[triangle as usize], point, distance);
        let lower = distance - clustered.displacement;
        Some(SourceDistance { upper, lower, own: distance, triangle: nearest })
    }

    /// Whether a point is inside the source, or not farther outside than
    /// [`displacement`](Self::displacement).
    pub fn is_inside(&self, point: Vector, distance: &SourceDistance) -> bool {
        match self.grid.side(point, distance.own, &self.bvh) {
            Some(inside) => inside,
            None => is_inside(&self.bvh, &self.boundary, point),
        }
    }

    /// See [`inside_reach`](super::inside::inside_reach).
    pub fn inside_reach(&self, point: Vector, distance: f64, needed: f64) -> Option<f64> {
        self.grid.inside_reach(point, distance, needed, &self.bvh)
    }

    /// An upper bound on the distance to the source from any point of a face, by the triangle of
    /// the source that is near one of them.
    pub fn upper_distance_to_source(&self, face: [Vector; 3], distance: &SourceDistance) -> f64 {
        let triangle = distance.triangle;
        match &self.clustered {
            None => self.upper_distance_to_triangle(face, triangle),
            Some(clustered) => {
                largest(face.map(|corner| clustered.squared_distance_to(corner, triangle))).sqrt()
            }
        }
    }

    /// An upper bound on the distance to the solid's own surface, by the grid.
    #[inline]
    pub fn upper_distance(&self, point: Vector) -> f64 {
        self.grid.probe(point, &self.bvh).upper + SINGLE_PRECISION
    }

    /// An upper bound on the distance to the solid's own surface from any point of a face with this
    /// centre. Once it is known to be at most `enough`, it is not refined.
    ///
    /// The distance to a point of the surface, or to one of its triangles, is a convex function:
    /// its maximum over the face is at a corner. Point and triangle are those of the grid.
    #[inline]
    pub fn upper_distance_of_face(&self, face: [Vector; 3], centre: Vector, enough: f64) -> f64 {
        let Some(nearest) = self.grid.nearest_point(centre, &self.bvh) else {
            return f64::INFINITY;
        };
        let to_point = largest(face.map(|corner| length_squared(subtract(corner, nearest))));
        let to_point = to_point.sqrt() + SINGLE_PRECISION;
        if to_point <= enough {
            return to_point;
        }
        let triangle = self.grid.nearest_triangle(centre, &self.bvh);
        self.upper_distance_to_triangle(face, triangle).min(to_point)
    }

    /// The greatest distance from any point of a face to a triangle of the solid.
    #[inline]
    pub(super) fn upper_distance_to_triangle(&self, face: [Vector; 3], triangle: u32) -> f64 {
        largest(face.map(|corner| self.bvh.distance_to_triangle(corner, triangle)))
    }

    /// The triangle closest to the centre of a point's cell, and the point's distance to it; or
    /// `u32::MAX` and infinity.
    #[inline]
    pub fn nearest_triangle_of_cell(&self, point: Vector) -> (f64, u32) {
        let triangle = self.grid.nearest_triangle(point, &self.bvh);
        (self.bvh.distance_to_triangle(point, triangle), triangle)
    }

    /// A lower bound on how far the inside extends around a point; `None` if that is unknown. If it
    /// is negative, the inside begins that far away at most.
    #[inline]
    pub fn depth(&self, point: Vector) -> Option<f64> {
        self.grid.depth(point, &self.bvh)
    }

    /// Whether a point is in the solid or at most `bound` away from it, for a bound between
    /// [`MIN_SEARCH_SHARE`] of the solid's bound and all of it.
    #[inline]
    pub fn point_fits(&self, point: Vector, bound: f64) -> bool {
        match self.grid.clearance(point, &self.bvh) {
            Some(clearance) if clearance.inside => return true,
            Some(clearance) if clearance.radius > bound => return false,
            _ => {}
        }
        match self.grid.class_of(point, &self.bvh) {
            CellClass::Near => return true,
            CellClass::Far => return false,
            CellClass::Mixed => {}
        }
        let probe = self.grid.probe(point, &self.bvh);
        if probe.upper <= bound {
            return true;
        }
        match self.grid.is_inside(&probe, &self.bvh) {
            Some(inside) => {
                inside || probe.upper <= DOUBT * bound && self.bvh.is_within(point, bound)
            }
            None => self.bvh.is_within(point, bound) || is_inside(&self.bvh, &self.boundary, point),
        }
    }

    /// Whether the point halfway between two others does not fit, so that no hull that fits contains
    /// both. Points at a quarter of the way find more conflicts, and save no hulls.
    pub fn separates(&self, a: Vector, b: Vector, bound: f64) -> bool {
        !self.point_fits(scale(add(a, b), 0.5), bound)
    }
}

#[inline]
fn largest([a, b, c]: [f64; 3]) -> f64 {
    a.max(b).max(c)
}
