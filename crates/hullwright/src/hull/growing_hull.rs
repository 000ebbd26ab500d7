//! Convex hulls one after the other, in memory that is reused: how they start, grow and are read.
//! And a hull that grows by points, during the search: joint hulls are built by insertion into a
//! copy of the larger hull, which takes a quarter of the time of building them anew.

use super::face::{Face, FacePlane, Margins, NONE, after, before, edge_of, face_of};
use super::quickhull::{
    Frame, HullState, OutsideSet, Scratch, Shape, finite_bounds, first_simplex, height_of,
};
use crate::geometry::vector::{
    Vector, as_arrays, as_vectors, cubed, into_arrays, into_vectors, larger,
};
use crate::work;

/// A point is left out if it is closer to the hull than this fraction of the extent of the points.
/// Positions that come from `f32` are uncertain by about 6e-8 of their size, so a finer tolerance
/// would only turn noise into slivers; a coarser one would be seen in single precision.
pub const DEFAULT_TOLERANCE: f64 = 2e-7;

/// Points that are compared as one with each face before they are compared one by one with those
/// nearby: about as many as a patch of a scan has.
const POINTS_AT_ONCE: usize = 16;

/// Builds convex hulls, one after the other, in memory that is reused.
///
/// `build` starts a hull, `insert` adds points to it. Building takes O(n log n) expected time for
/// n points, an insertion of m points into a hull of f faces O(m f) with a small constant. A copy
/// goes on growing on its own.
#[derive(Debug, Default)]
pub struct HullBuilder {
    /// As a fraction of the points' extent.
    tolerance: Option<f64>,
    /// In the points' units; the greater tolerance counts.
    least_tolerance: f64,
    pub(super) hull: HullState,
    scratch: Scratch,
}

impl Clone for HullBuilder {
    fn clone(&self) -> Self {
        let mut clone = Self::default();
        clone.clone_from(self);
        clone
    }

    fn clone_from(&mut self, other: &Self) {
        self.tolerance = other.tolerance;
        self.least_tolerance = other.least_tolerance;
        self.hull.copy_from(&other.hull);
    }
}

/// Building and growing.
impl HullBuilder {
    /// A builder with the default tolerance.
    pub fn new() -> Self {
        Self::default()
    }

    /// Points closer to the hull than `tolerance` times the extent of the points are left out, from
    /// the next `build` on. Negative values and those that are not finite count as 0.
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
    /// Unless the result is [`Shape::Solid`] there is no hull: the points lie within the tolerance
    /// of a plane, a line or a point.
    pub fn build(&mut self, points: &[[f64; 3]]) -> Shape {
        self.take_points(as_vectors(points));
        let (hull, scratch) = (&mut self.hull, &mut self.scratch);
        let (shape, simplex) = first_simplex(&hull.points, hull.tolerance);
        if shape != Shape::Solid {
            return shape;
        }
        // With a tolerance finer than rounding errors what looked solid may yet be flat.
        if !hull.given().span_a_volume(simplex) {
            return Shape::Flat;
        }
        let corners = simplex.map(|corner| hull.points[corner as usize]);
        hull.simplex_height = height_of(corners) / hull.frame.factor;
        scratch.has_flat_places = false;
        hull.start(scratch, simplex);
        hull.grow(scratch);
        if scratch.has_flat_places {
            leave_out_redundant_vertices(hull, scratch);
        }
        Shape::Solid
    }

    /// Replaces the hull by finite points without faces.
    fn take_points(&mut self, points: &[Vector]) {
        let hull = &mut self.hull;
        hull.faces.clear();
        hull.growth.clear();
        hull.originals.clear();
        let bounds = finite_bounds(points);
        if bounds.is_some() {
            hull.originals.extend_from_slice(points);
        } else {
            hull.originals.extend(points.iter().filter(|point| point.is_finite()));
        }
        let bounds = bounds.or_else(|| finite_bounds(&hull.originals)).unwrap_or_default();
        let frame = Frame::around(bounds);
        let [low, high] = bounds.map(|corner| corner * frame.factor);
        let extent = Some(low.distance(high)).filter(|extent| extent.is_finite());
        let relative = self.tolerance.unwrap_or(DEFAULT_TOLERANCE) * extent.unwrap_or(0.0);
        hull.frame = frame;
        hull.tolerance = relative.max(self.least_tolerance * frame.factor);
        hull.is_coarse = self.least_tolerance > 0.0;
        hull.points.clear();
        hull.points.extend(hull.originals.iter().map(|&point| frame.inward(point)));
        hull.next_outside.clear();
        hull.next_outside.resize(hull.points.len(), NONE);
        let corners = bounds.map(|corner| frame.inward(corner));
        hull.margins = Margins::default().including(&corners, hull.tolerance);
        hull.generation = 0;
        hull.visit = 0;
        hull.has_close_points = false;
    }

    /// Grows the hull over more points. Does nothing unless there is a hull.
    pub fn insert(&mut self, points: &[[f64; 3]]) {
        let (hull, scratch) = (&mut self.hull, &mut self.scratch);
        if hull.faces.is_empty() {
            return;
        }
        hull.generation += 1;
        let first = hull.points.len();
        hull.originals.extend(as_vectors(points).iter().filter(|point| point.is_finite()));
        let frame = hull.frame;
        hull.points.extend(hull.originals[first..].iter().map(|&point| frame.inward(point)));
        hull.next_outside.resize(hull.points.len(), NONE);
        hull.margins = hull.margins.including(&hull.points[first..], hull.tolerance);
        hull.assign_new(scratch, first as u32..hull.points.len() as u32);
        hull.grow(scratch);
    }

    /// The same for finite points of which many lie in the hull: those are not kept, nor those
    /// within the tolerance of it.
    pub(crate) fn insert_outside(&mut self, points: &[Vector]) {
        let (hull, scratch) = (&mut self.hull, &mut self.scratch);
        if hull.faces.is_empty() {
            return;
        }
        hull.generation += 1;
        let first = hull.points.len();
        points.chunks(POINTS_AT_ONCE).for_each(|points| hull.add_those_beyond(scratch, points));
        if hull.points.len() > first {
            hull.margins = hull.margins.including(&hull.points[first..], hull.tolerance);
            hull.grow(scratch);
        }
    }

    /// Drops all points that are not vertices, those within the tolerance of the hull too: a hull
    /// that is copied and grown again and again need not carry them along.
    pub(crate) fn forget_inner_points(&mut self) {
        let (vertices, triangles) = self.extract();
        let hull = &mut self.hull;
        hull.points.clear();
        hull.points.extend(vertices.iter().map(|&vertex| hull.frame.inward(Vector::from(vertex))));
        hull.originals = into_vectors(vertices);
        for ((face, growth), triangle) in hull.faces.iter_mut().zip(&mut hull.growth).zip(triangles)
        {
            face.vertices = triangle;
            growth.outside = OutsideSet::EMPTY;
        }
        hull.next_outside.clear();
        hull.next_outside.resize(hull.points.len(), NONE);
        hull.has_close_points = false;
    }

    /// Builds the hull of points, for its vertices alone; `None` if there is no hull.
    pub(crate) fn vertices_of(&mut self, points: &[Vector]) -> Option<Vec<Vector>> {
        (self.build(as_arrays(points)) == Shape::Solid).then(|| self.extract().0).map(into_vectors)
    }
}

/// The furthest point of a flat side may be any point of it. Where vertices turn out to lie inside
/// a side or an edge, the hull is built again with the others first.
#[cold]
fn leave_out_redundant_vertices(hull: &mut HullState, scratch: &mut Scratch) {
    let Some(necessary) = hull.necessary_vertices() else { return };
    let corners: Vec<u32> =
        (0..).zip(&necessary).filter(|(_, mark)| **mark != NONE).map(|(point, _)| point).collect();
    let positions: Vec<Vector> =
        corners.iter().map(|&corner| hull.points[corner as usize]).collect();
    let (shape, simplex) = first_simplex(&positions, hull.tolerance);
    // A sheet hardly thicker than the tolerance may have no corner at all: it stays as it is.
    if shape != Shape::Solid {
        return;
    }
    let simplex = simplex.map(|index| corners[index as usize]);
    if hull.given().span_a_volume(simplex) {
        scratch.queue.necessary = necessary;
        hull.start(scratch, simplex);
        hull.grow(scratch);
        hull.requeue_all(&mut scratch.queue);
        hull.grow(scratch);
    }
}

/// Which vertices are true corners, in a hull that has stopped growing.
impl HullState {
    /// For each point a mark, `NONE` unless it is a vertex that is a true corner; `None` if all
    /// vertices are. O(faces + points).
    fn necessary_vertices(&self) -> Option<Vec<u32>> {
        // For now: the number of edges at a vertex that bend.
        let mut marks = vec![NONE; self.points.len()];
        for face in &self.faces {
            for edge in 0..3 {
                let mark = &mut marks[face.vertices[edge] as usize];
                *mark = if *mark == NONE { 0 } else { *mark };
                // Each edge is met from both its faces, and counts at its start.
                *mark += u32::from(self.bends(face, edge));
            }
        }
        let mut is_any_redundant = false;
        for face in &self.faces {
            for edge in 0..3 {
                let mark = &mut marks[face.vertices[edge] as usize];
                let is_necessary = match *mark {
                    NONE => continue,
                    0 => false,
                    1 | 2 => !self.is_on_straight_edge(face, edge),
                    _ => true,
                };
                if !is_necessary {
                    *mark = NONE;
                    is_any_redundant = true;
                }
            }
        }
        is_any_redundant.then_some(marks)
    }

    /// Whether the far vertex of each of an edge's faces is clearly behind the other face.
    #[inline]
    fn bends(&self, face: &Face, edge: usize) -> bool {
        let twin = face.twins[edge];
        let other = &self.faces[face_of(twin) as usize];
        let far_of_other = other.vertices[before(edge_of(twin))];
        let far = face.vertices[before(edge)];
        face.distance(self.points[far_of_other as usize]) < -self.tolerance
            && other.distance(self.points[far as usize]) < -self.tolerance
    }

    /// Whether the edges that bend at the start of an edge lie on one line through it.
    fn is_on_straight_edge(&self, face: &Face, edge: usize) -> bool {
        let mut ends = Vec::new();
        let (mut current, mut at) = (face, edge);
        // Around the vertex: the edge that starts here, then the one before it in the same face.
        loop {
            if self.bends(current, at) {
                ends.push(self.points[current.vertices[after(at)] as usize]);
            }
            let twin = current.twins[before(at)];
            (current, at) = (&self.faces[face_of(twin) as usize], edge_of(twin));
            if std::ptr::eq(current, face) {
                break;
            }
        }
        let &[start, end] = ends.as_slice() else { return false };
        let along = end - start;
        let position = self.points[face.vertices[edge] as usize];
        let share = (position - start).dot(along) / along.dot(along);
        let foot = start + along * share;
        (0.0..=1.0).contains(&share)
            && position.distance(foot) <= self.tolerance.min(1e-3 * along.length())
    }
}

/// Reading a hull that has been built.
impl HullBuilder {
    /// Number of triangles of the hull; 0 if there is none.
    pub fn triangle_count(&self) -> usize {
        self.hull.faces.len()
    }

    /// The hull's vertices, as given, and its triangles; both empty if there is no hull.
    pub fn extract(&mut self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let (hull, indices) = (&self.hull, &mut self.scratch.indices);
        indices.clear();
        indices.resize(hull.points.len(), NONE);
        let mut vertices = Vec::with_capacity(hull.faces.len() / 2 + 2);
        let mut triangles = Vec::with_capacity(hull.faces.len());
        for face in &hull.faces {
            triangles.push(face.vertices.map(|vertex| {
                let index = &mut indices[vertex as usize];
                if *index == NONE {
                    *index = vertices.len() as u32;
                    vertices.push(hull.originals[vertex as usize]);
                }
                *index
            }));
        }
        (into_arrays(vertices), triangles)
    }

    /// For each of the points, if all were finite, a triangle of `extract` that it is a corner of.
    pub(crate) fn faces_of_points(&self, faces: &mut Vec<Option<u32>>) {
        faces.clear();
        faces.resize(self.hull.points.len(), None);
        for (index, face) in (0..).zip(&self.hull.faces) {
            for vertex in face.vertices {
                faces[vertex as usize] = Some(index);
            }
        }
    }

    /// Corners of all faces.
    pub(crate) fn all_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.hull.faces.iter().map(|face| self.corners(face))
    }

    /// Corners of the faces that the last insertion made; of all faces after `build`.
    pub(crate) fn new_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.hull.newest().map(|face| self.corners(face))
    }

    fn corners(&self, face: &Face) -> [Vector; 3] {
        face.vertices.map(|vertex| self.hull.originals[vertex as usize])
    }

    /// Enclosed volume, in cubed units of the points.
    pub(crate) fn volume(&self) -> f64 {
        // A face's offset is six times the volume of the tetrahedron between it and the centre.
        let six: f64 = self.hull.faces.iter().map(|face| face.plane.offset).sum();
        six / (6.0 * cubed(self.hull.frame.factor))
    }

    /// Whether no point lies farther than `tolerance`, in the points' units, in front of a face.
    /// False if there is no hull. O(faces) for a point inside, far less for most others.
    pub fn contains_all(&self, points: &[[f64; 3]], tolerance: f64) -> bool {
        let HullState { faces, frame, .. } = &self.hull;
        let limit = tolerance * frame.factor;
        !faces.is_empty()
            && points.iter().all(|&point| {
                let point = frame.inward(Vector::from(point));
                faces.iter().all(|face| face.distance(point) <= limit)
            })
    }

    /// The farthest that one of the points lies in front of a face, in their units; negative if
    /// all are inside.
    pub(crate) fn farthest_outside(&self, points: &[Vector]) -> f64 {
        farthest_outside(&self.hull.faces, 1, self.hull.frame, points)
    }

    /// Height of the first tetrahedron; the width is at least an eighth of it.
    pub(super) fn simplex_height(&self) -> f64 {
        self.hull.simplex_height
    }

    /// The smallest distance between a face and the vertex farthest behind it, with that face's
    /// outward normal: the width of the hull, in the units of the points.
    pub(super) fn width(&self) -> Option<(f64, Vector)> {
        let HullState { faces, points, frame, .. } = &self.hull;
        let mut used: Vec<u32> = faces.iter().flat_map(|face| face.vertices).collect();
        used.sort_unstable();
        used.dedup();
        let depth = |face: &Face| {
            used.iter().map(|&v| -face.distance(points[v as usize])).fold(0.0, f64::max)
        };
        let widths = faces
            .iter()
            .filter(|face| face.inverse > 0.0)
            .map(|face| (depth(face) / frame.factor, face.plane.normal.map(|x| x * face.inverse)));
        widths.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// The faces of a hull that goes on growing.
#[derive(Debug, Default)]
pub(crate) struct EarlierFaces {
    faces: Vec<Face>,
    frame: Frame,
}

/// A bound on how far points lie in front of a hull takes one of this many faces: an eighth of the
/// time, and most bounds of far points are near the distance.
const FACES_PER_BOUND: usize = 8;

impl EarlierFaces {
    /// Replaces them by the faces that a hull has now.
    pub fn copy_from(&mut self, hull: &HullBuilder) {
        self.faces.clone_from(&hull.hull.faces);
        self.frame = hull.hull.frame;
    }

    /// See [`HullBuilder::farthest_outside`].
    pub fn farthest_outside(&self, points: &[Vector]) -> f64 {
        farthest_outside(&self.faces, 1, self.frame, points)
    }

    /// No more than that, by some of the faces.
    pub fn least_outside(&self, points: &[Vector]) -> f64 {
        farthest_outside(&self.faces, FACES_PER_BOUND, self.frame, points)
    }
}

/// The farthest that one of the points lies in front of one of every `step` faces.
fn farthest_outside(faces: &[Face], step: usize, frame: Frame, points: &[Vector]) -> f64 {
    let mut farthest = f64::NEG_INFINITY;
    let (blocks, rest) = points.as_chunks::<4>();
    for &block in blocks {
        farthest = larger(farthest, farthest_of(faces, step, frame, block));
    }
    let (pairs, rest) = rest.as_chunks::<2>();
    for &pair in pairs {
        farthest = larger(farthest, farthest_of(faces, step, frame, pair));
    }
    for &point in rest {
        // With a copy of itself: a single lane would not vectorise.
        farthest = larger(farthest, farthest_of(faces, step, frame, [point; 2]));
    }
    farthest / frame.factor
}

/// The same in the frame, for a few points at once, so that the loop vectorises.
#[inline]
fn farthest_of<const N: usize>(
    faces: &[Face],
    step: usize,
    frame: Frame,
    points: [Vector; N],
) -> f64 {
    let points = points.map(|point| frame.inward(point));
    let [x, y, z] = [points.map(|p| p.x), points.map(|p| p.y), points.map(|p| p.z)];
    let mut farthest = [f64::NEG_INFINITY; N];
    for face in faces.iter().step_by(step) {
        let Face { plane: FacePlane { normal, offset }, inverse, .. } = *face;
        for lane in 0..N {
            let height = normal[0] * x[lane] + normal[1] * y[lane] + normal[2] * z[lane];
            let distance = (height - offset) * inverse;
            farthest[lane] = if distance > farthest[lane] { distance } else { farthest[lane] };
        }
    }
    farthest.into_iter().fold(f64::NEG_INFINITY, larger)
}

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
    /// As set after an insertion: [`current_volume`](Self::current_volume) takes O(faces).
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

    /// Whether the hull has volume, and no point is farther than `tolerance` in front of a face.
    /// Within [`SEARCH_TOLERANCE`] inserting them changes nothing.
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

/// Points within this fraction of the diagonal do not change a hull during the search: far less
/// than any distance that counts, more than the rounding of repeated insertions.
pub(crate) const SEARCH_TOLERANCE: f64 = 1e-5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::area_normal;
    use crate::mesh::shapes::{cuboid, uv_sphere};

    /// Points inside a ball, and points around it.
    fn ball() -> (Vec<Vector>, Vec<Vector>) {
        let sphere = |n, radius| uv_sphere(n, [0.0; 3], radius).positions;
        (into_vectors([sphere(14, 0.5), sphere(14, 1.0)].concat()), into_vectors(sphere(5, 1.3)))
    }

    fn built(points: &[Vector]) -> HullBuilder {
        let mut builder = HullBuilder::new();
        assert_eq!(builder.build(as_arrays(points)), Shape::Solid);
        builder
    }

    fn sorted(mut points: Vec<Vector>) -> Vec<Vector> {
        points.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap());
        points
    }

    #[test]
    fn without_its_inner_points_a_hull_is_the_same_and_goes_on_growing_the_same_way() {
        let (points, far) = ball();
        let mut whole = built(&points);
        let mut forgetful = whole.clone();
        forgetful.forget_inner_points();
        assert_eq!(forgetful.hull.points.len(), forgetful.extract().0.len());
        assert!(forgetful.hull.points.len() < whole.hull.points.len());
        assert_eq!(forgetful.extract(), whole.extract());
        whole.insert_outside(&far);
        forgetful.insert_outside(&far);
        assert_eq!(forgetful.extract(), whole.extract());
        let faces = |builder: &HullBuilder| builder.new_faces().collect::<Vec<_>>();
        assert_eq!(faces(&forgetful), faces(&whole));
    }

    #[test]
    fn of_points_inside_and_outside_only_those_outside_are_kept_and_the_hull_is_that_of_all() {
        let (points, far) = ball();
        let mut whole = built(&points);
        let mut sparing = whole.clone();
        let more: Vec<Vector> =
            far.iter().flat_map(|&point| [point * 0.1, point, point * 0.6]).collect();
        whole.insert(as_arrays(&more));
        sparing.insert_outside(&more);
        assert_eq!(sparing.hull.points.len(), points.len() + far.len());
        let vertices = sorted(into_vectors(sparing.extract().0));
        assert_eq!(vertices, sorted(into_vectors(whole.extract().0)));
        assert!(far.iter().all(|point| vertices.contains(point)));
    }

    #[test]
    fn the_farthest_of_any_number_of_points_is_as_far_as_one_by_one_over_all_planes() {
        let (points, far) = ball();
        let builder = built(&points);
        let height = |point: &Vector| {
            let heights = builder
                .all_faces()
                .map(|[a, b, c]| area_normal(a, b, c).normalize_or_zero().dot(*point - a));
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        for count in 1..far.len() {
            for some in [&far[..count], &points[..count]] {
                let expected = some.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
                assert!((builder.farthest_outside(some) - expected).abs() < 1e-12, "{count}");
            }
        }
    }

    #[test]
    fn volume_vertices_and_heights_are_those_of_the_points_at_any_scale() {
        for size in [1e-6, 0.3, 1.0, 1e6] {
            let corners =
                into_vectors(cuboid([0.0; 3], [2.0 * size, 3.0 * size, 5.0 * size]).positions);
            let points = [corners.clone(), vec![Vector::splat(size)]].concat();
            let mut builder = built(&points);
            assert!((builder.volume() / (30.0 * size.powi(3)) - 1.0).abs() < 1e-12, "{size}");
            let height = builder.farthest_outside(&[Vector::new(size, size, 7.0 * size)]);
            assert!((height / (2.0 * size) - 1.0).abs() < 1e-12, "{size}");
            assert_eq!(sorted(builder.vertices_of(&points).unwrap()), sorted(corners));
            assert!(builder.vertices_of(&points[..3]).is_none(), "a triangle has no hull");
        }
    }
}
