//! Quickhull (Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996), in
//! double precision, with scratch memory that is reused and a hull that can go on growing.
//!
//! A point is added only if it lies farther than a tolerance in front of some face, so that flat
//! sides don't shatter into slivers. Which faces it sees is decided exactly (see `face.rs`), so
//! that the result is at each moment the exact hull of the points added.
//!
//! The steps are in `grow.rs`, questions about the hull in `query.rs`.

use super::columns::Columns;
use super::extent::{bounds, height_of, is_finite, one_over_power_of_two};
use super::face::{Face, Given, Heights, Horizon, NONE, Plane, Waiting};
use super::redundant::mark_necessary_vertices;
use super::simplex::{Shape, first_simplex};
use crate::geometry::vector::{Vector, add, distance, scale, subtract};

/// A point is left out if it is closer to the hull than this share of the extent of the points.
/// Positions that come from `f32` are uncertain by about 6e-8 of their size, so a finer tolerance
/// would only turn noise into slivers; a coarser one would be seen in single precision.
pub const DEFAULT_TOLERANCE: f64 = 2e-7;

/// Builds convex hulls, one after the other, in memory that is reused.
///
/// `build` starts a hull, `insert` adds points to it. Building takes O(n log n) expected time for
/// n points, an insertion of m points into a hull of f faces O(m f) with a small constant.
#[derive(Debug, Default)]
pub struct HullBuilder {
    tolerance: Option<f64>,
    /// Tolerance in the units of the points, where that is more.
    least_tolerance: f64,
    /// Number of insertions since `build`, so that the faces of the last can be told apart.
    pub(super) generation: u32,
    /// Centre that is subtracted from the points, and a power of two that they are multiplied by.
    centre: Vector,
    pub(super) factor: f64,
    /// All points given since `build`, moved and scaled.
    pub(super) points: Vec<Vector>,
    /// The points that `build` was given, moved and scaled, by coordinate.
    pub(super) columns: Columns,
    /// All points given since `build`, as given.
    pub(super) originals: Vec<Vector>,
    pub(super) faces: Vec<Face>,
    /// For each face what waits there.
    pub(super) waiting: Vec<Waiting>,
    /// For each point the next one that waits in front of the same face.
    pub(super) next_waiting: Vec<u32>,
    /// Tolerance in the scaled space.
    pub(super) threshold: f64,
    pub(super) heights: Heights,
    pub(super) stamp: u32,
    /// Faces where a point may wait that is to be added.
    pub(super) work: Vec<u32>,
    /// Faces that a point sees, then those that replace them.
    pub(super) visible: Vec<u32>,
    /// Places in `faces` that are not used.
    pub(super) free: Vec<u32>,
    /// The planes of those.
    pub(super) planes: Vec<Plane>,
    pub(super) path: Vec<u32>,
    pub(super) horizon: Vec<Horizon>,
    /// First points of lists of waiting points that look for a new face.
    pub(super) lines: Vec<u32>,
    pub(super) inverses: Vec<f64>,
    pub(super) marks: Vec<u32>,
    /// While set, only points with a mark may become vertices.
    pub(super) only_marked: bool,
    /// Whether a point that was added lay within the tolerance of a plane: without such points no
    /// vertex lies inside a flat side.
    pub(super) has_flat_places: bool,
    /// Whether a point may wait within the tolerance of its face.
    pub(super) has_close_points: bool,
    /// Height of the first tetrahedron, in the units of the points.
    simplex_height: f64,
}

impl Clone for HullBuilder {
    fn clone(&self) -> Self {
        let mut clone = Self::default();
        clone.clone_from(self);
        clone
    }

    /// Copies the hull into memory that is there already. Scratch memory is not copied.
    fn clone_from(&mut self, other: &Self) {
        self.tolerance = other.tolerance;
        self.least_tolerance = other.least_tolerance;
        self.generation = other.generation;
        self.centre = other.centre;
        self.factor = other.factor;
        self.points.clone_from(&other.points);
        self.originals.clone_from(&other.originals);
        self.faces.clone_from(&other.faces);
        self.waiting.clone_from(&other.waiting);
        self.next_waiting.clone_from(&other.next_waiting);
        self.threshold = other.threshold;
        self.heights = other.heights;
        self.stamp = other.stamp;
        self.only_marked = other.only_marked;
        self.has_close_points = other.has_close_points;
        self.simplex_height = other.simplex_height;
        self.work.clear();
        self.free.clear();
    }
}

impl HullBuilder {
    /// A builder with the default tolerance.
    pub fn new() -> Self {
        Self::default()
    }

    /// Points closer to the hull than `tolerance` times the extent of the points are left out.
    /// Negative and not finite values count as 0.
    ///
    /// ```
    /// use hullwright::hull::HullBuilder;
    ///
    /// // The sixth point is a tenth outside of a face: 5 % of the points' extent of 2.
    /// let points = [
    ///     [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.3, 0.3, -0.1_f64],
    /// ];
    /// let mut builder = HullBuilder::new().with_tolerance(0.2);
    /// builder.build(&points);
    /// assert_eq!(builder.extract().0.len(), 5);
    /// ```
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(if tolerance.is_finite() { tolerance.max(0.0) } else { 0.0 });
        self
    }

    /// Points closer to the hull than `tolerance`, in their own units, are left out too, and those
    /// within it of all faces' planes: beyond a sharp edge these may be farther from the hull.
    #[must_use]
    pub fn with_least_tolerance(mut self, tolerance: f64) -> Self {
        self.least_tolerance = if tolerance.is_finite() { tolerance.max(0.0) } else { 0.0 };
        self
    }

    /// Starts anew and builds the hull of `points`; those that are not finite are ignored.
    ///
    /// Unless the answer is [`Shape::Solid`] there is no hull: the points lie within the
    /// tolerance of a plane, a line or a point.
    ///
    /// ```
    /// use hullwright::hull::{HullBuilder, Shape};
    ///
    /// let mut builder = HullBuilder::new();
    /// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// assert_eq!(builder.build(&square), Shape::Flat);
    /// ```
    pub fn build(&mut self, points: &[[f64; 3]]) -> Shape {
        self.clear();
        self.take_points(points);
        let (shape, simplex) = first_simplex(&self.points, &self.columns, self.threshold);
        if shape != Shape::Solid {
            return shape;
        }
        // With a tolerance finer than rounding errors what looked solid may yet be flat.
        if !self.given().span_a_volume(simplex) {
            return Shape::Flat;
        }
        self.simplex_height =
            height_of(simplex.map(|corner| self.points[corner as usize])) / self.factor;
        self.grow_from(simplex);
        if self.has_flat_places {
            self.leave_out_redundant_vertices();
        }
        Shape::Solid
    }

    /// The hull of all points given so far, from a first tetrahedron.
    fn grow_from(&mut self, simplex: [u32; 4]) {
        self.faces.clear();
        self.waiting.clear();
        self.work.clear();
        self.start(simplex);
        self.grow();
    }

    /// The furthest point of a flat side may be any point of it. Where vertices turned out to lie
    /// inside a side or an edge, the hull is built again with the others first.
    #[cold]
    fn leave_out_redundant_vertices(&mut self) {
        let mut marks = std::mem::take(&mut self.marks);
        if mark_necessary_vertices(&self.faces, &self.points, self.threshold, &mut marks) {
            self.marks = marks;
            let corners: Vec<u32> =
                (0..self.points.len() as u32).filter(|&p| self.marks[p as usize] != NONE).collect();
            let positions: Vec<Vector> =
                corners.iter().map(|&corner| self.points[corner as usize]).collect();
            let columns = Columns::new(&positions);
            let (shape, simplex) = first_simplex(&positions, &columns, self.threshold);
            // Of a sheet hardly thicker than the tolerance there may be no corner at all: it stays as it is.
            if shape != Shape::Solid {
                return;
            }
            let simplex = simplex.map(|index| corners[index as usize]);
            if self.given().span_a_volume(simplex) {
                self.only_marked = true;
                self.grow_from(simplex);
                self.only_marked = false;
                self.consider_all_waiting();
                self.grow();
            }
        } else {
            self.marks = marks;
        }
    }

    /// Grows the hull over more points. Does nothing unless there is a hull.
    ///
    /// ```
    /// use hullwright::hull::HullBuilder;
    ///
    /// let mut builder = HullBuilder::new();
    /// builder.build(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    /// builder.insert(&[[1.0, 1.0, 1.0], [0.1, 0.1, 0.1]]);
    /// assert_eq!(builder.extract().0.len(), 5);
    /// ```
    pub fn insert(&mut self, points: &[[f64; 3]]) {
        if self.faces.is_empty() {
            return;
        }
        self.generation += 1;
        let first = self.points.len();
        for &point in points.iter().filter(|point| is_finite(point)) {
            let scaled = self.inward(point);
            self.points.push(scaled);
            self.originals.push(point);
        }
        self.next_waiting.resize(self.points.len(), NONE);
        self.bound_errors(first);
        self.assign_to_any(first);
        self.grow();
    }

    /// The same, for points of which many lie in the hull: those are not kept, nor those within
    /// the tolerance of it.
    pub(crate) fn insert_outside(&mut self, points: &[[f64; 3]]) {
        if self.faces.is_empty() {
            return;
        }
        self.generation += 1;
        let first = self.points.len();
        for &point in points {
            let scaled = self.inward(point);
            if let Some(found) = self.first_face_beyond(scaled) {
                let index = self.points.len() as u32;
                self.points.push(scaled);
                self.originals.push(point);
                self.next_waiting.push(NONE);
                self.attach(index, found);
            }
        }
        if self.points.len() == first {
            return;
        }
        self.bound_errors(first);
        self.grow();
    }

    /// Lets go of all points that are not vertices, those within the tolerance of the hull too: what is
    /// copied and grown again and again need not carry them along.
    pub(crate) fn forget_inner_points(&mut self) {
        self.marks.clear();
        self.marks.resize(self.points.len(), NONE);
        for face in &self.faces {
            for vertex in face.vertices {
                self.marks[vertex as usize] = 0;
            }
        }
        let mut kept = 0;
        for point in 0..self.points.len() {
            if self.marks[point] != NONE {
                self.marks[point] = kept as u32;
                self.points[kept] = self.points[point];
                self.originals[kept] = self.originals[point];
                kept += 1;
            }
        }
        self.points.truncate(kept);
        self.originals.truncate(kept);
        for face in &mut self.faces {
            face.vertices = face.vertices.map(|vertex| self.marks[vertex as usize]);
        }
        for waiting in &mut self.waiting {
            *waiting = Waiting::none(waiting.stamp, waiting.generation);
        }
        self.next_waiting.clear();
        self.next_waiting.resize(kept, NONE);
        self.has_close_points = false;
    }

    /// Whether more may be left out than the share of the extent asks for.
    pub(super) fn is_coarse(&self) -> bool {
        self.least_tolerance > 0.0
    }

    pub(super) fn given(&self) -> Given<'_> {
        Given { points: &self.originals, factor: self.factor }
    }

    /// A point in the scaled space.
    #[inline]
    pub(super) fn inward(&self, point: Vector) -> Vector {
        scale(subtract(point, self.centre), self.factor)
    }

    /// A point of the scaled space, in the points' units.
    pub(super) fn outward(&self, point: Vector) -> Vector {
        add(scale(point, 1.0 / self.factor), self.centre)
    }

    /// Height of the first tetrahedron; the width is at least an eighth of it.
    pub(super) fn simplex_height(&self) -> f64 {
        self.simplex_height
    }

    fn clear(&mut self) {
        self.points.clear();
        self.originals.clear();
        self.faces.clear();
        self.waiting.clear();
        self.next_waiting.clear();
        self.work.clear();
        self.free.clear();
        self.stamp = 0;
        self.generation = 0;
        self.heights = Heights::default();
        self.factor = 1.0;
        self.has_flat_places = false;
        self.has_close_points = false;
    }

    /// Takes points, centred and brought near 1 by a power of two, which rounds nothing.
    fn take_points(&mut self, points: &[[f64; 3]]) {
        let (low, high, all_finite) = bounds(points);
        let (low, high) = if all_finite {
            self.originals.extend_from_slice(points);
            (low, high)
        } else {
            self.originals.extend(points.iter().filter(|point| is_finite(point)));
            let (low, high, _) = bounds(&self.originals);
            (low, high)
        };
        self.centre = [0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]);
        if !is_finite(&self.centre) {
            self.centre = [0.0; 3];
        }
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if extent > 0.0 && extent.is_finite() {
            self.factor = one_over_power_of_two(extent);
        }
        let scaled_extent = distance(scale(low, self.factor), scale(high, self.factor));
        let tolerance = self.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        let scaled_extent = if scaled_extent.is_finite() { scaled_extent } else { 0.0 };
        self.threshold = (tolerance * scaled_extent).max(self.least_tolerance * self.factor);
        let (centre, factor) = (self.centre, self.factor);
        self.points
            .extend(self.originals.iter().map(|&point| scale(subtract(point, centre), factor)));
        self.columns.fill(&self.points);
        self.next_waiting.resize(self.points.len(), NONE);
        let corners = [self.inward(low), self.inward(high)];
        self.bound_errors_by(&corners);
    }

    /// Takes the points from `first` on into account in the bound on rounding errors.
    fn bound_errors(&mut self, first: usize) {
        let points = std::mem::take(&mut self.points);
        self.bound_errors_by(&points[first..]);
        self.points = points;
    }

    fn bound_errors_by(&mut self, points: &[Vector]) {
        let mut reach = self.heights.reach;
        for &x in points.as_flattened() {
            reach = reach.max(x.abs());
        }
        self.heights = Heights::new(reach, self.threshold);
    }
}

#[cfg(test)]
mod tests;
