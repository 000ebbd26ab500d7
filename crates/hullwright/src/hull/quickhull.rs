//! Quickhull (Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996): the
//! frame that brings points near 1, their first simplex, and the steps by which a hull grows from
//! there.
//!
//! A point in front of faces is in the outside set of one of them. The furthest point of an outside
//! set becomes the eye point: the visible faces make way for a cone between their outline, the
//! horizon, and the eye point, and their outside sets are partitioned among the faces of the cone.
//! The hull is complete when no outside set has a point farther out than the tolerance: a finer
//! hull would shatter flat sides into slivers. Visibility is exact (see `face.rs`): at each moment
//! the hull is the exact hull of the points added.
//!
//! The steps are so small that instructions count: no roots, no divisions, and slices, whose
//! addresses stay in registers, for vectors.

use std::ops::ControlFlow::{self, Break, Continue};

use super::face::{
    CERTAINLY_BEHIND, Face, FacePlane, GivenPoints, Margins, NONE, after, before, edge_of, face_of,
    half_edge, inverse_root, is_in_front, is_not_behind,
};
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::geometry::vector::{Vector, area_normal, larger};

/// In how many dimensions points extend, up to the hull's tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// They span a volume and have a hull.
    Solid,
    /// They lie in a plane.
    Flat,
    /// They lie on a line.
    Linear,
    /// They lie on one spot, or there are none.
    Point,
}

/// Moves points to their centre and scales them by a power of two, which rounds nothing, so that
/// their extent is between 1 and 2.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Frame {
    pub centre: Vector,
    pub factor: f64,
}

impl Frame {
    /// The frame of points within bounds, which are inside out without points.
    pub(super) fn around([low, high]: [Vector; 2]) -> Self {
        const MANTISSA: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;
        /// 2 to the powers -1000 and 1000, clear of the ends of the range.
        const LIMITS: [f64; 2] = [f64::from_bits(23 << 52), f64::from_bits(2023 << 52)];
        let mut frame = Self { centre: Vector::ZERO, factor: 1.0 };
        let centre = low * 0.5 + high * 0.5;
        if centre.is_finite() {
            frame.centre = centre;
        }
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if extent > 0.0 && extent.is_finite() {
            let extent = extent.clamp(LIMITS[0], LIMITS[1]);
            frame.factor = 1.0 / f64::from_bits(extent.to_bits() & !MANTISSA);
        }
        frame
    }

    /// A point in the frame.
    #[inline]
    pub(super) fn inward(&self, point: Vector) -> Vector {
        (point - self.centre) * self.factor
    }

    /// A point of the frame in the points' units.
    pub(super) fn outward(&self, point: Vector) -> Vector {
        point * (1.0 / self.factor) + self.centre
    }
}

/// Bounds of points, inside out without any; `None` if a coordinate is not finite.
pub(super) fn finite_bounds(points: &[Vector]) -> Option<[Vector; 2]> {
    let [mut low, mut high, mut zero] = [Vector::INFINITY, Vector::NEG_INFINITY, Vector::ZERO];
    for &point in points {
        (low, high) = (point.min(low), point.max(high));
        // Becomes NaN where a coordinate is not finite.
        zero += point * 0.0;
    }
    (zero == Vector::ZERO).then_some([low, high])
}

/// The first point for which `measure` is greatest.
#[inline]
fn farthest(points: &[Vector], measure: impl Fn(Vector) -> f64) -> (u32, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, &point) in (0..).zip(points) {
        let value = measure(point);
        if value > best.1 {
            best = (index, value);
        }
    }
    best
}

/// Four points, far apart, that span a tetrahedron. For a lesser shape only as many of them count
/// as it has dimensions, and one more. O(n).
pub(super) fn first_simplex(points: &[Vector], tolerance: f64) -> (Shape, [u32; 4]) {
    let [a, b] = farthest_extremes(points);
    let corner = |index: u32| points[index as usize];
    if points.is_empty() || corner(a).distance(corner(b)) <= tolerance {
        return (Shape::Point, [a; 4]);
    }
    let direction = (corner(b) - corner(a)).normalize_or_zero();
    let (c, from_line) =
        farthest(points, |point| direction.cross(point - corner(a)).length_squared());
    if from_line.sqrt() <= tolerance {
        return (Shape::Linear, [a, b, a, a]);
    }
    let normal = area_normal(corner(a), corner(b), corner(c)).normalize_or_zero();
    let (d, from_plane) = farthest(points, |point| normal.dot(point - corner(a)).abs());
    if from_plane <= tolerance {
        return (Shape::Flat, [a, b, c, a]);
    }
    (Shape::Solid, [a, b, c, d])
}

/// Of the six extreme points along the axes the two that are farthest apart.
fn farthest_extremes(points: &[Vector]) -> [u32; 2] {
    let extremes = [0, 1, 2].map(|axis| {
        [farthest(points, |point| -point[axis]), farthest(points, |point| point[axis])]
    });
    let extremes = extremes.as_flattened();
    let mut best = (0.0, [0, 0]);
    for (place, &(first, _)) in extremes.iter().enumerate() {
        for &(second, _) in &extremes[place + 1..] {
            let Some((p, q)) = points.get(first as usize).zip(points.get(second as usize)) else {
                continue;
            };
            let apart = p.distance_squared(*q);
            if apart > best.0 {
                best = (apart, [first, second]);
            }
        }
    }
    best.1
}

/// Height of a tetrahedron over its first three corners.
pub(super) fn height_of([a, b, c, d]: [Vector; 4]) -> f64 {
    area_normal(a, b, c).normalize_or_zero().dot(d - a).abs()
}

/// A hull, and all that it needs to go on growing: what a copy copies.
#[derive(Debug, Default)]
pub(super) struct HullState {
    /// Set by `build`; `points` are in it.
    pub frame: Frame,
    /// All points given since `build` and not forgotten, in the frame.
    pub points: Vec<Vector>,
    /// The same points as given.
    pub originals: Vec<Vector>,
    /// A closed surface. While the hull grows some are retired; `close_gaps` removes those.
    pub faces: Vec<Face>,
    /// For each face what changes while the hull grows: apart, so that queries read less memory.
    pub growth: Vec<FaceGrowth>,
    /// For each point the next one in the same outside set.
    pub next_outside: Vec<u32>,
    /// Points closer to the hull are left out. In the frame, set by `build`.
    pub tolerance: f64,
    /// Whether points beyond sharp edges are left out too. Set by `build`.
    pub is_coarse: bool,
    /// For all `points` and the tolerance; what adds points includes them.
    pub margins: Margins,
    /// Number of insertions since `build`, by which the faces of the last one are known.
    pub generation: u32,
    /// Number of walks over faces since `build`.
    pub visit: u32,
    /// Whether an outside set may have points within the tolerance of its face. Cleared when inner
    /// points are forgotten.
    pub has_close_points: bool,
    /// Height of the first tetrahedron, in the units of the points. Set by `build`.
    pub simplex_height: f64,
}

impl HullState {
    /// Copies another hull into memory that is there already.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.points.clone_from(&other.points);
        self.originals.clone_from(&other.originals);
        self.faces.clone_from(&other.faces);
        self.growth.clone_from(&other.growth);
        self.next_outside.clone_from(&other.next_outside);
        self.frame = other.frame;
        self.tolerance = other.tolerance;
        self.is_coarse = other.is_coarse;
        self.margins = other.margins;
        self.generation = other.generation;
        self.visit = other.visit;
        self.has_close_points = other.has_close_points;
        self.simplex_height = other.simplex_height;
    }

    pub(super) fn given(&self) -> GivenPoints<'_> {
        GivenPoints { points: &self.originals, factor: self.frame.factor }
    }
}

/// What changes at a face while the hull grows.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceGrowth {
    pub outside: OutsideSet,
    /// The last walk that came to this face.
    visit: u32,
    /// The insertion that made this face.
    pub generation: u32,
}

impl FaceGrowth {
    #[inline]
    fn new(visit: u32, generation: u32) -> Self {
        Self { outside: OutsideSet::EMPTY, visit, generation }
    }
}

/// Points in front of a face, and of no other face's set: a linked list.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutsideSet {
    /// Height of the furthest point; 0 if there is none.
    height: f64,
    /// The highest of the points that are farther out than the tolerance.
    furthest: u32,
    /// The list's first point.
    first: u32,
}

impl OutsideSet {
    pub(super) const EMPTY: Self = Self { height: 0.0, furthest: NONE, first: NONE };
}

/// Memory that is reused. It carries nothing from one call to the next.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub queue: Queue,
    cone: Cone,
    /// Places of retired faces.
    free: Vec<u32>,
    /// Faces near some points.
    near: Vec<u32>,
    /// For each point its index among the vertices, or none.
    pub indices: Vec<u32>,
    /// Whether an eye point lay within the tolerance of a plane: without such points no vertex
    /// lies inside a flat side.
    pub has_flat_places: bool,
}

/// Furthest points that are to become eye points.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// Faces that got a furthest point, in that order. Some have lost it since.
    faces: Vec<u32>,
    /// Marks of points. Unless it is empty, points whose mark is `NONE` don't become furthest.
    pub necessary: Vec<u32>,
}

/// What one eye point changes.
#[derive(Debug, Default)]
struct Cone {
    /// The visible faces; then the places of the cone's faces, in the order of the horizon.
    visible: Vec<u32>,
    /// First points of the visible faces' outside sets.
    unassigned: Vec<u32>,
    /// In order: each ridge ends where the next one starts.
    horizon: Vec<Ridge>,
    /// Half-edges into faces that the search for the horizon has yet to visit.
    path: Vec<u32>,
    /// Planes of the cone's faces.
    planes: Vec<FacePlane>,
}

/// An edge between a visible face and one that is not.
#[derive(Debug, Clone, Copy)]
struct Ridge {
    start: u32,
    end: u32,
    /// The half-edge in the face that stays.
    outer: u32,
}

/// A face that a point is in front of.
#[derive(Debug, Clone, Copy)]
struct InFront {
    face: u32,
    height: f64,
    /// Whether the distance is more than the tolerance.
    is_beyond: bool,
}

/// The first of some planes that a point is farther in front of than the tolerance; if there is
/// none, the one that it is nearest to being in front of.
#[inline]
fn in_front_of(point: Vector, planes: &[FacePlane], margins: Margins) -> Option<InFront> {
    let mut best = None;
    let mut least = -CERTAINLY_BEHIND;
    for (face, plane) in (0..).zip(planes) {
        let height = plane.height(point);
        if height < margins.low {
            continue;
        }
        if margins.is_beyond(height, plane) {
            return Some(InFront { face, height, is_beyond: true });
        }
        let distance = height * inverse_root(plane.normal.length_squared());
        if distance > least {
            least = distance;
            best = Some(InFront { face, height, is_beyond: false });
        }
    }
    best
}

/// All outside sets, while points are added to them.
struct OutsideSets<'a> {
    points: &'a [Vector],
    growth: &'a mut [FaceGrowth],
    next_outside: &'a mut [u32],
    has_close_points: &'a mut bool,
    queue: &'a mut Queue,
}

impl OutsideSets<'_> {
    /// Adds a point to the outside set of a face.
    #[inline]
    fn add(&mut self, point: u32, InFront { face, height, is_beyond }: InFront) {
        let set = &mut self.growth[face as usize].outside;
        self.next_outside[point as usize] = set.first;
        set.first = point;
        if !is_beyond {
            *self.has_close_points = true;
        } else if height > set.height && self.queue.necessary.get(point as usize) != Some(&NONE) {
            if set.furthest == NONE {
                self.queue.faces.push(face);
            }
            set.height = height;
            set.furthest = point;
        }
    }
}

/// The steps.
impl HullState {
    /// The tetrahedron over four points in general position. All other points are partitioned among
    /// its faces.
    pub(super) fn start(&mut self, scratch: &mut Scratch, corners: [u32; 4]) {
        let [a, b, c, d] = corners;
        let given = GivenPoints { points: &self.originals, factor: self.frame.factor };
        // Turned so that d lies behind the base.
        let (b, c) = if given.is_in_front([a, b, c], d) { (c, b) } else { (b, c) };
        let triangles = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]];
        // Edge k of each face and the same edge of its neighbour.
        let twins = [
            [(3, 0), (2, 0), (1, 0)],
            [(0, 2), (2, 2), (3, 1)],
            [(0, 1), (3, 2), (1, 1)],
            [(0, 0), (1, 2), (2, 1)],
        ];
        self.faces.clear();
        for (vertices, twins) in triangles.into_iter().zip(twins) {
            let [first, second, last] = vertices;
            let edges = [first, second].map(|end| given.edge(last, end));
            let mut face = Face::spanned(vertices, edges, self.points[last as usize]);
            face.twins = twins.map(|(other, edge)| half_edge(other, edge));
            self.faces.push(face);
        }
        self.growth.clear();
        self.growth.resize(self.faces.len(), FaceGrowth::new(0, 0));
        let points = 0..self.points.len() as u32;
        self.assign_new(scratch, points.filter(|point| !corners.contains(point)));
    }

    /// Adds new points to the outside sets of faces that they are in front of.
    pub(super) fn assign_new(&mut self, scratch: &mut Scratch, points: impl Iterator<Item = u32>) {
        let (margins, planes) = (self.margins, &mut scratch.cone.planes);
        planes.clear();
        planes.extend(self.faces.iter().map(|face| face.plane));
        let mut sets = self.outside_sets(&mut scratch.queue);
        for point in points {
            if let Some(found) = in_front_of(sets.points[point as usize], planes, margins) {
                sets.add(point, found);
            }
        }
    }

    fn outside_sets<'a>(&'a mut self, queue: &'a mut Queue) -> OutsideSets<'a> {
        OutsideSets {
            points: &self.points,
            growth: &mut self.growth,
            next_outside: &mut self.next_outside,
            has_close_points: &mut self.has_close_points,
            queue,
        }
    }

    /// Adds furthest points until none is farther out than the tolerance.
    pub(super) fn grow(&mut self, scratch: &mut Scratch) {
        loop {
            // First in, first out, so that the hull grows on all sides: last in, first out would
            // make more faces that don't stay.
            let mut next = 0;
            while let Some(&face) = scratch.queue.faces.get(next) {
                next += 1;
                let OutsideSet { furthest, height, .. } = self.growth[face as usize].outside;
                if furthest == NONE {
                    continue;
                }
                if height > self.margins.error || self.is_visible(face, furthest) {
                    self.add(scratch, furthest, face);
                } else {
                    self.reject_furthest(scratch, face, furthest);
                }
            }
            scratch.queue.faces.clear();
            let has_close_points = self.has_close_points && scratch.queue.necessary.is_empty();
            if !(has_close_points
                && (self.add_a_point_beyond_another_face(scratch)
                    || self.add_points_beyond_sharp_edges(scratch)))
            {
                break;
            }
        }
        self.close_gaps(&mut scratch.free);
        self.measure_new_faces();
    }

    /// Adds an eye point. `seen_from` is one of the faces that are visible from it.
    fn add(&mut self, scratch: &mut Scratch, eye: u32, seen_from: u32) {
        let Scratch { cone, free, .. } = scratch;
        scratch.has_flat_places |= self.find_horizon(cone, eye, seen_from);
        // The cone's faces take the places of the visible ones.
        let edges = cone.horizon.len();
        let kept = edges.min(cone.visible.len());
        for unused in cone.visible.drain(kept..).rev() {
            self.faces[unused as usize] = Face::RETIRED;
            self.growth[unused as usize] = FaceGrowth::new(0, 0);
            free.push(unused);
        }
        while cone.visible.len() < edges {
            let place = free.pop().unwrap_or(self.faces.len() as u32);
            if place as usize == self.faces.len() {
                self.faces.push(Face::RETIRED);
                self.growth.push(FaceGrowth::new(0, 0));
            }
            cone.visible.push(place);
        }
        self.make_cone(cone, eye);
        self.partition(cone, &mut scratch.queue, eye);
    }

    /// Collects the visible faces, their outside sets, and the horizon in order. Returns whether
    /// the eye point lies within the tolerance of a plane.
    fn find_horizon(&mut self, cone: &mut Cone, eye: u32, seen_from: u32) -> bool {
        let position = self.points[eye as usize];
        self.visit += 1;
        let (visit, margins) = (self.visit, self.margins);
        let faces = self.faces.as_slice();
        let given = GivenPoints { points: &self.originals, factor: self.frame.factor };
        let growth = self.growth.as_mut_slice();
        let Cone { visible, unassigned, horizon, path, .. } = cone;
        let mut is_flat = false;
        visible.clear();
        horizon.clear();
        path.clear();
        unassigned.clear();
        let state = &mut growth[seen_from as usize];
        state.visit = visit;
        unassigned.push(state.outside.first);
        visible.push(seen_from);
        let [first, second, third] = faces[seen_from as usize].twins;
        path.extend([third, second]);
        // The half-edge that is next spares the way through `path`.
        let mut ahead = Some(first);
        while let Some(twin) = ahead {
            let other = face_of(twin);
            let state = &mut growth[other as usize];
            if state.visit == visit {
                ahead = path.pop();
                continue;
            }
            let neighbour = &faces[other as usize];
            let height = neighbour.plane.height(position);
            let is_visible = if height > margins.high {
                true
            } else if height < -margins.high {
                false
            } else {
                is_flat |= !margins.is_beyond(height.abs(), &neighbour.plane);
                if height.abs() > margins.error {
                    height > 0.0
                } else {
                    neighbour.is_visible(eye, height, given, margins.largest)
                }
            };
            let at = edge_of(twin);
            if is_visible {
                state.visit = visit;
                if state.outside.first != NONE {
                    unassigned.push(state.outside.first);
                }
                visible.push(other);
                path.push(neighbour.twins[before(at)]);
                ahead = Some(neighbour.twins[after(at)]);
            } else {
                let [start, end] = [neighbour.vertices[after(at)], neighbour.vertices[at]];
                horizon.push(Ridge { start, end, outer: twin });
                ahead = path.pop();
            }
        }
        is_flat
    }

    /// Puts a face between each ridge of the horizon and the eye point.
    fn make_cone(&mut self, cone: &mut Cone, eye: u32) {
        let position = self.points[eye as usize];
        let (visit, generation) = (self.visit, self.generation);
        let (faces, growth) = (self.faces.as_mut_slice(), self.growth.as_mut_slice());
        let given = GivenPoints { points: &self.originals, factor: self.frame.factor };
        let Cone { visible: places, horizon, planes, .. } = cone;
        planes.clear();
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else { return };
        let Some(&Ridge { start, .. }) = horizon.first() else { return };
        let mut edge = given.edge(eye, start);
        let mut place = first;
        let mut previous = last;
        for (index, &Ridge { start, end, outer }) in horizon.iter().enumerate() {
            let next = places.get(index + 1).copied().unwrap_or(first);
            let next_edge = given.edge(eye, end);
            let mut face = Face::spanned([start, end, eye], [edge, next_edge], position);
            face.twins = [outer, half_edge(next, 2), half_edge(previous, 1)];
            faces[face_of(outer) as usize].twins[edge_of(outer)] = half_edge(place, 0);
            growth[place as usize] = FaceGrowth::new(visit, generation);
            faces[place as usize] = face;
            planes.push(face.plane);
            (previous, place, edge) = (place, next, next_edge);
        }
    }

    /// Adds the unassigned points, except the eye point, to the outside sets of the cone's faces
    /// that they are in front of.
    fn partition(&mut self, cone: &Cone, queue: &mut Queue, eye: u32) {
        let margins = self.margins;
        let (places, planes) = (cone.visible.as_slice(), cone.planes.as_slice());
        let mut sets = self.outside_sets(queue);
        for &head in &cone.unassigned {
            let mut next = head;
            while next != NONE {
                let point = next;
                next = sets.next_outside[point as usize];
                if point == eye {
                    continue;
                }
                if let Some(found) = in_front_of(sets.points[point as usize], planes, margins) {
                    sets.add(point, InFront { face: places[found.face as usize], ..found });
                }
            }
        }
    }

    /// Closes the gaps that retired faces have left.
    fn close_gaps(&mut self, free: &mut Vec<u32>) {
        free.sort_unstable();
        while let Some(gap) = free.pop() {
            self.faces.swap_remove(gap as usize);
            self.growth.swap_remove(gap as usize);
            if let Some(moved) = self.faces.get(gap as usize).copied() {
                for (edge, twin) in (0..).zip(moved.twins) {
                    let neighbour = &mut self.faces[face_of(twin) as usize];
                    neighbour.twins[edge_of(twin)] = half_edge(gap, edge);
                }
            }
        }
    }

    /// Sets the inverse lengths of the new faces' normals.
    fn measure_new_faces(&mut self) {
        for (face, growth) in self.faces.iter_mut().zip(&self.growth) {
            if growth.generation == self.generation {
                face.inverse = inverse_root(face.plane.normal.length_squared());
            }
        }
    }

    /// The faces that the last insertion made; all faces after `build`.
    pub(super) fn newest(&self) -> impl Iterator<Item = &Face> + '_ {
        let faces = self.faces.iter().zip(&self.growth);
        faces.filter(|(_, growth)| growth.generation == self.generation).map(|(face, _)| face)
    }
}

/// Outside sets between the steps.
impl HullState {
    /// Adds new points, close together, to the outside sets of the first faces that they are
    /// farther in front of than the tolerance, in a hull that has stopped growing. Drops those
    /// without one.
    pub(super) fn add_those_beyond(&mut self, scratch: &mut Scratch, points: &[Vector]) {
        let Scratch { queue, near, .. } = scratch;
        self.find_near(near, points);
        for &original in points {
            let point = self.frame.inward(original);
            let beyond = near.iter().find_map(|&face| {
                let Face { plane, inverse, .. } = &self.faces[face as usize];
                let height = plane.height(point);
                (height > 0.0 && height * inverse > self.tolerance).then_some((face, height))
            });
            if let Some((face, height)) = beyond {
                let index = self.points.len() as u32;
                self.points.push(point);
                self.originals.push(original);
                self.next_outside.push(NONE);
                self.outside_sets(queue).add(index, InFront { face, height, is_beyond: true });
            }
        }
    }

    /// Lists the faces that one of some points may be farther in front of than the tolerance, by a
    /// ball around them.
    fn find_near(&self, near: &mut Vec<u32>, points: &[Vector]) {
        let sum = points.iter().fold(Vector::ZERO, |sum, &point| sum + self.frame.inward(point));
        let centre = sum * (1.0 / points.len() as f64);
        let away = |&point: &Vector| self.frame.inward(point).distance_squared(centre);
        let radius = match points.len() {
            ..WORTH_A_BALL => f64::INFINITY,
            _ => points.iter().map(away).fold(0.0, larger).sqrt(),
        };
        let least = self.tolerance - radius - DISTANCE_ERROR * self.margins.largest.max(1.0);
        let faces = (0..).zip(&self.faces).filter(|(_, face)| face.distance(centre) > least);
        near.clear();
        near.extend(faces.map(|(index, _)| index));
    }

    /// Lets all points become furthest, necessary or not.
    pub(super) fn requeue_all(&mut self, queue: &mut Queue) {
        queue.necessary.clear();
        for (index, face) in (0..).zip(&self.faces) {
            let set = &mut self.growth[index as usize].outside;
            let mut point = set.first;
            while point != NONE {
                let height = face.plane.height(self.points[point as usize]);
                if height > set.height && self.margins.is_beyond(height, &face.plane) {
                    set.height = height;
                    set.furthest = point;
                }
                point = self.next_outside[point as usize];
            }
            if set.furthest != NONE {
                queue.faces.push(index);
            }
        }
    }
}

/// Fewer points are compared with all faces: a ball around them is compared with all faces, too.
const WORTH_A_BALL: usize = 8;

/// More than the rounding errors of a distance between points whose coordinates are at most 1.
const DISTANCE_ERROR: f64 = 16.0 * f64::EPSILON;

/// What seldom happens: planes of slivers are uncertain, and points near one face may be far from
/// others, or from the hull.
impl HullState {
    /// Whether a face is visible from a point, exactly.
    fn is_visible(&self, face: u32, point: u32) -> bool {
        let face = &self.faces[face as usize];
        let height = face.plane.height(self.points[point as usize]);
        face.is_visible(point, height, self.given(), self.margins.largest)
    }

    /// Whether a face is visible from a point, and the point farther out than the tolerance. A
    /// sliver's plane may err: only the exact answer makes progress certain.
    fn is_visible_beyond(&self, index: u32, point: u32) -> bool {
        let plane = &self.faces[index as usize].plane;
        let height = plane.height(self.points[point as usize]);
        self.margins.is_beyond(height, plane) && self.is_visible(index, point)
    }

    /// Removes the furthest point from the outside set of a sliver that is not visible from it, and
    /// adds it to the hull if it is beyond another face.
    #[cold]
    fn reject_furthest(&mut self, scratch: &mut Scratch, face: u32, furthest: u32) {
        let set = &mut self.growth[face as usize].outside;
        let cone = &mut scratch.cone;
        cone.unassigned = vec![set.first];
        cone.visible = vec![face];
        cone.planes = vec![self.faces[face as usize].plane];
        *set = OutsideSet::EMPTY;
        self.partition(cone, &mut scratch.queue, furthest);
        let mut others = (0..self.faces.len() as u32).filter(|&other| other != face);
        if let Some(other) = others.find(|&other| self.is_visible_beyond(other, furthest)) {
            self.add(scratch, furthest, other);
        }
    }

    /// A point within the tolerance of its face may yet be farther out from another visible face.
    /// Adds the first such point. Returns whether there was one.
    fn add_a_point_beyond_another_face(&mut self, scratch: &mut Scratch) -> bool {
        for face in 0..self.faces.len() as u32 {
            let mut point = self.growth[face as usize].outside.first;
            while point != NONE {
                if let Some(other) = self.face_beyond(&mut scratch.cone.visible, point, face) {
                    self.add(scratch, point, other);
                    return true;
                }
                point = self.next_outside[point as usize];
            }
        }
        false
    }

    /// The first visible face that a point is beyond, on a walk over the faces that it is in front
    /// of.
    fn face_beyond(&mut self, ahead: &mut Vec<u32>, point: u32, start: u32) -> Option<u32> {
        let position = self.points[point as usize];
        self.walk(ahead, start, |hull, index| {
            if hull.is_visible_beyond(index, point) {
                return Break(index);
            }
            let plane = &hull.faces[index as usize].plane;
            Continue(is_in_front(plane.height(position), plane))
        })
    }

    /// Walks from face to neighbour: on from those for which `enter` is true, until it breaks.
    /// `ahead` is memory.
    fn walk<B>(
        &mut self,
        ahead: &mut Vec<u32>,
        start: u32,
        mut enter: impl FnMut(&Self, u32) -> ControlFlow<B, bool>,
    ) -> Option<B> {
        self.visit += 1;
        self.growth[start as usize].visit = self.visit;
        ahead.clear();
        ahead.push(start);
        while let Some(face) = ahead.pop() {
            for twin in self.faces[face as usize].twins {
                let neighbour = face_of(twin);
                let growth = &mut self.growth[neighbour as usize];
                if growth.visit == self.visit {
                    continue;
                }
                growth.visit = self.visit;
                match enter(self, neighbour) {
                    Break(result) => return Some(result),
                    Continue(true) => ahead.push(neighbour),
                    Continue(false) => {}
                }
            }
        }
        None
    }

    /// Beyond a sharp edge a point may be within the tolerance of both planes, and yet far from the
    /// hull: the farther, the thinner the hull. Adds each outside set's farthest point that is
    /// farther from the hull than the tolerance. Returns whether there was any.
    fn add_points_beyond_sharp_edges(&mut self, scratch: &mut Scratch) -> bool {
        if self.is_coarse {
            return false;
        }
        let limit = self.tolerance + DISTANCE_ERROR * self.margins.largest;
        let limit = limit * limit;
        let mut is_any = false;
        for face in 0..self.faces.len() as u32 {
            let (mut farthest, mut best) = (limit, None);
            let mut point = self.growth[face as usize].outside.first;
            while point != NONE {
                let ahead = &mut scratch.cone.visible;
                if self.squared_distance_to_face(point, face) > farthest
                    && let Some((squared, visible)) =
                        self.squared_distance(ahead, point, face, limit)
                    && squared > farthest
                {
                    (farthest, best) = (squared, Some((point, visible)));
                }
                point = self.next_outside[point as usize];
            }
            if let Some((point, visible)) = best {
                self.add(scratch, point, visible);
                is_any = true;
            }
        }
        is_any
    }

    fn squared_distance_to_face(&self, point: u32, face: u32) -> f64 {
        let position = self.points[point as usize];
        let [a, b, c] = self.faces[face as usize]
            .vertices
            .map(|vertex| self.points[vertex as usize] - position);
        closest_point_on_triangle(a, b, c).length_squared()
    }

    /// The squared distance of a point to the nearest of the faces that it is not behind, and a
    /// visible one of those; `None` if none is visible, or if a face is within `limit`, squared.
    /// `start` is one of those faces, farther than that.
    fn squared_distance(
        &mut self,
        ahead: &mut Vec<u32>,
        point: u32,
        start: u32,
        limit: f64,
    ) -> Option<(f64, u32)> {
        let position = self.points[point as usize];
        let mut least = self.squared_distance_to_face(point, start);
        let mut visible = self.is_visible(start, point).then_some(start);
        let too_near = self.walk(ahead, start, |hull, index| {
            let plane = &hull.faces[index as usize].plane;
            if !is_not_behind(plane.height(position), plane) {
                return Continue(false);
            }
            least = least.min(hull.squared_distance_to_face(point, index));
            if least <= limit {
                return Break(());
            }
            if visible.is_none() && hull.is_visible(index, point) {
                visible = Some(index);
            }
            Continue(true)
        });
        if too_near.is_some() {
            return None;
        }
        visible.map(|visible| (least, visible))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_as_high_as_its_last_corner_is_above_the_others() {
        for height in [0.0, 0.25, 1.0, 7.0] {
            for side in [1.0, -1.0] {
                let last = Vector::new(0.4, 0.9, side * height);
                let corners =
                    [Vector::ZERO, Vector::new(2.0, 0.0, 0.0), Vector::new(0.0, 3.0, 0.0), last];
                assert!((height_of(corners) - height).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn one_coordinate_that_is_not_finite_is_noticed_wherever_it_is() {
        for count in 1..8 {
            let points: Vec<Vector> =
                (0..count).map(|k| Vector::new(f64::from(k), 2.0, -3.0)).collect();
            let last = f64::from(count - 1);
            assert_eq!(
                finite_bounds(&points),
                Some([Vector::new(0.0, 2.0, -3.0), Vector::new(last, 2.0, -3.0)])
            );
            for place in 0..3 * points.len() {
                for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut points = points.clone();
                    points[place / 3][place % 3] = strange;
                    assert_eq!(finite_bounds(&points), None, "{strange} at {place}");
                }
            }
        }
    }

    #[test]
    fn of_equals_the_first_is_farthest() {
        let points = [0.0, 1.0, 1.0, 0.5].map(|x| Vector::new(x, 0.0, 1.0));
        assert_eq!(farthest(&points, |point| point.x), (1, 1.0));
        assert_eq!(farthest(&points, |point| -point.x), (0, 0.0));
    }
}
