//! Quickhull (Barber, Dobkin, Huhdanpaa, "The quickhull algorithm for convex hulls", 1996), in
//! double precision, with scratch memory that is reused and a hull that can go on growing.
//!
//! A point is added only if it lies farther than a tolerance in front of some face, so that flat
//! sides don't shatter into slivers. Which faces it sees is decided exactly (see `face.rs`), so
//! that the result is at each moment the exact hull of the points added.

use super::face::{Face, NONE, RETIRED, edge_of, face_of, half_edge};
use super::redundant::mark_necessary_vertices;
use super::simplex::{Shape, first_simplex};
use crate::vector::{Vector, cross, distance, dot, maximum, minimum, scale, subtract};

/// A point is left out if it is closer to the hull than this share of the extent of the points.
/// Positions that come from `f32` are uncertain by about 6e-8 of their size, so a finer tolerance
/// would only turn noise into slivers; a coarser one would be seen in single precision.
pub const DEFAULT_TOLERANCE: f64 = 2e-7;

/// A point this far behind a face, as a share of the extent, is certainly not in front of it.
/// Closer ones are kept until all faces are known.
const CERTAINLY_BEHIND: f64 = 1e-12;

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
    generation: u32,
    /// Centre that is subtracted from the points, and a power of two that they are multiplied by.
    centre: Vector,
    factor: f64,
    /// All points given since `build`, moved and scaled.
    points: Vec<Vector>,
    /// All points given since `build`, as given.
    originals: Vec<Vector>,
    faces: Vec<Face>,
    /// For each point the next one that waits in front of the same face.
    next_waiting: Vec<u32>,
    /// Largest coordinate of a point, for the bounds on rounding errors.
    reach: f64,
    /// Tolerance in the scaled space.
    threshold: f64,
    stamp: u32,
    work: Vec<u32>,
    visible: Vec<u32>,
    /// Places in `faces` that are not used.
    free: Vec<u32>,
    path: Vec<(u32, u32, u32)>,
    horizon: Vec<Horizon>,
    orphans: Vec<u32>,
    marks: Vec<u32>,
    /// While set, only points with a mark may become vertices.
    only_marked: bool,
    /// Height of the first tetrahedron, in the units of the points.
    simplex_height: f64,
}

/// An edge between a face that a new point sees and one that it does not.
#[derive(Debug, Clone, Copy)]
struct Horizon {
    start: u32,
    end: u32,
    /// The edge in the face that stays.
    outside: u32,
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
        self.next_waiting.clone_from(&other.next_waiting);
        self.reach = other.reach;
        self.threshold = other.threshold;
        self.stamp = other.stamp;
        self.only_marked = other.only_marked;
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
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(if tolerance.is_finite() { tolerance.max(0.0) } else { 0.0 });
        self
    }

    /// Points closer to the hull than `tolerance`, in their own units, are left out too.
    #[must_use]
    pub fn with_least_tolerance(mut self, tolerance: f64) -> Self {
        self.least_tolerance = if tolerance.is_finite() { tolerance.max(0.0) } else { 0.0 };
        self
    }

    /// Starts anew and builds the hull of `points`; those that are not finite are ignored.
    ///
    /// Unless the answer is [`Shape::Solid`] there is no hull: the points lie within the
    /// tolerance of a plane, a line or a point.
    pub fn build(&mut self, points: &[[f64; 3]]) -> Shape {
        self.clear();
        self.take_frame(points);
        self.append(points);
        let (shape, simplex) = first_simplex(&self.points, self.threshold);
        if shape != Shape::Solid {
            return shape;
        }
        self.grow_from(simplex);
        let apex = self.points[simplex[3] as usize];
        self.simplex_height = self.base_distance(simplex, apex) / self.factor;
        self.leave_out_redundant_vertices();
        Shape::Solid
    }

    /// The hull of all points given so far, from a first tetrahedron.
    fn grow_from(&mut self, simplex: [u32; 4]) {
        self.faces.clear();
        self.work.clear();
        self.start(simplex);
        self.assign_to_any(0..self.points.len() as u32, &simplex);
        self.grow();
    }

    fn base_distance(&self, [a, b, c, _]: [u32; 4], point: Vector) -> f64 {
        Face::new([a, b, c], &self.points, self.reach).distance(point).abs()
    }

    /// The furthest point of a flat side may be any point of it. Where vertices turned out to lie
    /// inside a side or an edge, the hull is built again with the others first.
    fn leave_out_redundant_vertices(&mut self) {
        let mut marks = std::mem::take(&mut self.marks);
        if mark_necessary_vertices(&self.faces, &self.points, self.threshold, &mut marks) {
            self.marks = marks;
            let corners: Vec<u32> =
                (0..self.points.len() as u32).filter(|&p| self.marks[p as usize] != NONE).collect();
            let positions: Vec<Vector> =
                corners.iter().map(|&corner| self.points[corner as usize]).collect();
            if let (Shape::Solid, simplex) = first_simplex(&positions, self.threshold) {
                self.only_marked = true;
                self.grow_from(simplex.map(|index| corners[index as usize]));
                self.only_marked = false;
                self.consider_all_waiting();
                self.grow();
            }
        } else {
            self.marks = marks;
        }
    }

    /// Lets each waiting point count, marked or not.
    fn consider_all_waiting(&mut self) {
        for index in 0..self.faces.len() {
            let mut point = self.faces[index].waiting;
            while point != NONE {
                let face = &mut self.faces[index];
                let distance = face.distance(self.points[point as usize]);
                if distance > face.furthest_distance {
                    face.furthest_distance = distance;
                    face.furthest = point;
                }
                point = self.next_waiting[point as usize];
            }
            if self.faces[index].furthest_distance > self.threshold {
                self.work.push(index as u32);
            }
        }
    }

    /// Grows the hull over more points. Does nothing unless there is a hull.
    pub fn insert(&mut self, points: &[[f64; 3]]) {
        if self.faces.is_empty() {
            return;
        }
        self.generation += 1;
        let first = self.points.len() as u32;
        let reach = self.reach;
        self.append(points);
        if self.reach > reach {
            self.refresh_error_bounds();
        }
        self.assign_to_any(first..self.points.len() as u32, &[]);
        self.grow();
    }

    /// The same, for points of which many lie in the hull: those are not kept.
    pub(crate) fn insert_outside(&mut self, points: &[[f64; 3]]) {
        if self.faces.is_empty() {
            return;
        }
        self.generation += 1;
        let first = self.points.len();
        let reach = self.reach;
        for &point in points {
            let scaled = scale(subtract(point, self.centre), self.factor);
            if self.faces.iter().any(|face| face.distance(scaled) > self.threshold) {
                self.reach = scaled.iter().fold(self.reach, |reach, x| reach.max(x.abs()));
                self.points.push(scaled);
                self.originals.push(point);
            }
        }
        if self.points.len() == first {
            return;
        }
        self.next_waiting.resize(self.points.len(), NONE);
        if self.reach > reach {
            self.refresh_error_bounds();
        }
        self.assign_to_any(first as u32..self.points.len() as u32, &[]);
        self.grow();
    }

    /// The farthest that one of the points lies in front of a face, in their units; negative if
    /// all are inside.
    pub(crate) fn farthest_outside(&self, points: &[[f64; 3]]) -> f64 {
        let mut farthest = f64::NEG_INFINITY;
        for &point in points {
            let scaled = scale(subtract(point, self.centre), self.factor);
            for face in &self.faces {
                farthest = face.distance(scaled).max(farthest);
            }
        }
        farthest / self.factor
    }

    /// The corners of the faces that the last insertion made; of all faces after `build`.
    pub(crate) fn new_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        let newest = self.faces.iter().filter(|face| face.generation == self.generation);
        newest.map(|face| face.vertices.map(|vertex| self.originals[vertex as usize]))
    }

    /// Corners of all faces.
    pub(crate) fn all_faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.faces.iter().map(|face| face.vertices.map(|vertex| self.originals[vertex as usize]))
    }

    /// Enclosed volume, in cubed units of the points.
    pub(crate) fn volume(&self) -> f64 {
        let Some(apex) = self.faces.first().map(|face| self.points[face.vertices[0] as usize])
        else {
            return 0.0;
        };
        let six: f64 = self
            .faces
            .iter()
            .map(|face| {
                let [a, b, c] =
                    face.vertices.map(|vertex| subtract(self.points[vertex as usize], apex));
                dot(a, cross(b, c))
            })
            .sum();
        six / (6.0 * self.factor.powi(3))
    }

    /// Number of triangles of the hull; 0 if there is none.
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// The hull's vertices, as given, and its triangles; both empty if there is no hull.
    pub fn extract(&mut self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        self.marks.clear();
        self.marks.resize(self.points.len(), NONE);
        let mut vertices = Vec::with_capacity(self.faces.len() / 2 + 2);
        let mut triangles = Vec::with_capacity(self.faces.len());
        for face in &self.faces {
            triangles.push(face.vertices.map(|vertex| {
                let mark = &mut self.marks[vertex as usize];
                if *mark == NONE {
                    *mark = vertices.len() as u32;
                    vertices.push(self.originals[vertex as usize]);
                }
                *mark
            }));
        }
        (vertices, triangles)
    }

    /// The smallest distance between a face and the vertex farthest behind it, with that face's
    /// outward normal: the width of the hull, in the units of the points.
    pub(super) fn width(&self) -> Option<(f64, Vector)> {
        let mut used: Vec<u32> = self.faces.iter().flat_map(|face| face.vertices).collect();
        used.sort_unstable();
        used.dedup();
        let depth = |face: &Face| {
            used.iter().map(|&v| -face.distance(self.points[v as usize])).fold(0.0, f64::max)
        };
        let widths = self.faces.iter().map(|face| (depth(face) / self.factor, face.normal));
        widths.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Height of the first tetrahedron; the width is at least an eighth of it.
    pub(super) fn simplex_height(&self) -> f64 {
        self.simplex_height
    }

    fn clear(&mut self) {
        self.points.clear();
        self.originals.clear();
        self.faces.clear();
        self.next_waiting.clear();
        self.work.clear();
        self.free.clear();
        self.stamp = 0;
        self.generation = 0;
        self.reach = 0.0;
        self.factor = 1.0;
    }

    /// Centres the points and brings them near 1 by a power of two, which rounds nothing.
    fn take_frame(&mut self, points: &[[f64; 3]]) {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &point in points.iter().filter(|point| is_finite(point)) {
            low = minimum(low, point);
            high = maximum(high, point);
        }
        self.centre = [0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]);
        if !is_finite(&self.centre) {
            self.centre = [0.0; 3];
        }
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if extent > 0.0 && extent.is_finite() {
            self.factor = (-extent.log2().floor()).clamp(-1000.0, 1000.0).exp2();
        }
        let scaled_extent = distance(scale(low, self.factor), scale(high, self.factor));
        let tolerance = self.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        let scaled_extent = if scaled_extent.is_finite() { scaled_extent } else { 0.0 };
        self.threshold = (tolerance * scaled_extent).max(self.least_tolerance * self.factor);
    }

    fn append(&mut self, points: &[[f64; 3]]) {
        for &point in points.iter().filter(|point| is_finite(point)) {
            let scaled = scale(subtract(point, self.centre), self.factor);
            self.reach = scaled.iter().fold(self.reach, |reach, x| reach.max(x.abs()));
            self.points.push(scaled);
            self.originals.push(point);
        }
        self.next_waiting.resize(self.points.len(), NONE);
    }

    /// Points farther out make the distances of all faces less certain.
    fn refresh_error_bounds(&mut self) {
        for face in &mut self.faces {
            face.error = Face::new(face.vertices, &self.points, self.reach).error;
        }
    }

    /// The tetrahedron over four points in general position.
    fn start(&mut self, [a, b, c, d]: [u32; 4]) {
        let corner = |vertex: u32| self.points[vertex as usize];
        let base = [corner(a), corner(b), corner(c)];
        // Turned so that d lies behind the base.
        let (b, c) = if super::face::is_in_front(base, corner(d)) { (c, b) } else { (b, c) };
        let triangles = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]];
        // Edge k of each face and the same edge of its neighbour.
        let twins = [
            [(3, 0), (2, 0), (1, 0)],
            [(0, 2), (2, 2), (3, 1)],
            [(0, 1), (3, 2), (1, 1)],
            [(0, 0), (1, 2), (2, 1)],
        ];
        for (vertices, twins) in triangles.into_iter().zip(twins) {
            let mut face = Face::new(vertices, &self.points, self.reach);
            face.twins = twins.map(|(other, edge)| half_edge(other, edge));
            self.faces.push(face);
        }
    }

    /// Lets each point wait in front of the first face that it is in front of.
    fn assign_to_any(&mut self, points: std::ops::Range<u32>, except: &[u32]) {
        let faces = 0..self.faces.len() as u32;
        for point in points.filter(|point| !except.contains(point)) {
            self.assign(point, faces.clone());
        }
    }

    #[inline]
    fn assign(&mut self, point: u32, candidates: impl Iterator<Item = u32>) {
        let position = self.points[point as usize];
        let mut best = (-CERTAINLY_BEHIND, NONE);
        for candidate in candidates {
            let distance = self.faces[candidate as usize].distance(position);
            if distance > best.0 {
                best = (distance, candidate);
                if distance > self.threshold {
                    break;
                }
            }
        }
        let (distance, candidate) = best;
        if candidate == NONE {
            return;
        }
        let face = &mut self.faces[candidate as usize];
        self.next_waiting[point as usize] = face.waiting;
        face.waiting = point;
        if distance > face.furthest_distance
            && !(self.only_marked && self.marks[point as usize] == NONE)
        {
            if distance > self.threshold && face.furthest_distance <= self.threshold {
                self.work.push(candidate);
            }
            face.furthest_distance = distance;
            face.furthest = point;
        }
    }

    /// Adds waiting points until none is farther out than the tolerance.
    fn grow(&mut self) {
        loop {
            while let Some(face) = self.work.pop() {
                let Some(&Face { furthest, furthest_distance, .. }) = self.faces.get(face as usize)
                else {
                    continue;
                };
                if furthest_distance > self.threshold {
                    let position = self.points[furthest as usize];
                    if self.faces[face as usize].sees(position, &self.points) {
                        self.add(furthest, face);
                    } else {
                        self.send_elsewhere(furthest, face);
                    }
                }
            }
            if self.only_marked || !self.add_a_point_that_other_faces_see() {
                self.close_gaps();
                return;
            }
        }
    }

    /// A sliver's plane is so uncertain that a point may wait there in vain.
    #[cold]
    fn send_elsewhere(&mut self, point: u32, face: u32) {
        let Face { waiting, .. } = self.faces[face as usize];
        let unwanted = &mut self.faces[face as usize];
        unwanted.waiting = NONE;
        unwanted.furthest_distance = 0.0;
        let mut next = waiting;
        while next != NONE {
            let current = next;
            next = self.next_waiting[current as usize];
            if current != point {
                self.assign(current, std::iter::once(face));
            }
        }
        let position = self.points[point as usize];
        let others = (0..self.faces.len() as u32).filter(|&other| other != face);
        let seen = others.clone().find(|&other| {
            let other = &self.faces[other as usize];
            other.distance(position) > self.threshold && other.sees(position, &self.points)
        });
        if let Some(other) = seen {
            self.add(point, other);
        }
    }

    /// A point within the tolerance of the face that it waits at may yet be farther from another
    /// one that it sees. Adds the first such point.
    fn add_a_point_that_other_faces_see(&mut self) -> bool {
        for face in 0..self.faces.len() as u32 {
            let mut point = self.faces[face as usize].waiting;
            while point != NONE {
                if let Some(other) = self.farther_face_in_sight(point, face) {
                    self.add(point, other);
                    return true;
                }
                point = self.next_waiting[point as usize];
            }
        }
        false
    }

    fn farther_face_in_sight(&mut self, point: u32, start: u32) -> Option<u32> {
        let position = self.points[point as usize];
        self.stamp += 1;
        self.visible.clear();
        self.visible.push(start);
        self.faces[start as usize].stamp = self.stamp;
        while let Some(face) = self.visible.pop() {
            for twin in self.faces[face as usize].twins {
                let neighbour = &mut self.faces[face_of(twin) as usize];
                if neighbour.stamp == self.stamp {
                    continue;
                }
                neighbour.stamp = self.stamp;
                let distance = neighbour.distance(position);
                // A sliver's plane may lie: only the exact answer makes progress certain.
                if distance > self.threshold && neighbour.sees(position, &self.points) {
                    return Some(face_of(twin));
                }
                if distance > CERTAINLY_BEHIND {
                    self.visible.push(face_of(twin));
                }
            }
        }
        None
    }

    /// Replaces the faces that a point sees by faces between their outline and the point.
    fn add(&mut self, point: u32, seen_from: u32) {
        let position = self.points[point as usize];
        self.find_horizon(position, seen_from);
        self.orphans.clear();
        for &face in &self.visible {
            let mut waiting = self.faces[face as usize].waiting;
            while waiting != NONE {
                if waiting != point {
                    self.orphans.push(waiting);
                }
                waiting = self.next_waiting[waiting as usize];
            }
        }
        // New faces take the places of those that vanish; `visible` becomes the list of places.
        let edges = self.horizon.len();
        while self.visible.len() > edges {
            if let Some(unused) = self.visible.pop() {
                self.faces[unused as usize].retire();
                self.free.push(unused);
            }
        }
        while self.visible.len() < edges {
            let place = self.free.pop().unwrap_or(self.faces.len() as u32);
            if place as usize == self.faces.len() {
                self.faces.push(RETIRED);
            }
            self.visible.push(place);
        }
        for index in 0..edges {
            let Horizon { start, end, outside } = self.horizon[index];
            let place = self.visible[index];
            let before = self.visible[if index == 0 { edges - 1 } else { index - 1 }];
            let after = self.visible[if index + 1 == edges { 0 } else { index + 1 }];
            let mut face = Face::new([start, end, point], &self.points, self.reach);
            face.twins = [outside, half_edge(after, 2), half_edge(before, 1)];
            face.stamp = self.stamp;
            face.generation = self.generation;
            self.faces[face_of(outside) as usize].twins[edge_of(outside)] = half_edge(place, 0);
            self.faces[place as usize] = face;
        }
        let orphans = std::mem::take(&mut self.orphans);
        let places = std::mem::take(&mut self.visible);
        for &orphan in &orphans {
            self.assign(orphan, places.iter().copied());
        }
        self.orphans = orphans;
        self.visible = places;
    }

    /// Closes the gaps that retired faces have left.
    fn close_gaps(&mut self) {
        self.free.sort_unstable();
        while let Some(gap) = self.free.pop() {
            self.faces.swap_remove(gap as usize);
            if let Some(moved) = self.faces.get(gap as usize).copied() {
                for (edge, twin) in (0..).zip(moved.twins) {
                    let neighbour = &mut self.faces[face_of(twin) as usize];
                    neighbour.twins[edge_of(twin)] = half_edge(gap, edge);
                }
            }
        }
    }

    /// Collects the faces that a point sees, and their outline in order.
    fn find_horizon(&mut self, position: Vector, seen_from: u32) {
        self.stamp += 1;
        self.visible.clear();
        self.horizon.clear();
        self.path.clear();
        self.faces[seen_from as usize].stamp = self.stamp;
        self.visible.push(seen_from);
        self.path.push((seen_from, 0, 3));
        while let Some((face, edge, left)) = self.path.pop() {
            if left > 1 {
                self.path.push((face, (edge + 1) % 3, left - 1));
            }
            let Face { vertices, twins, .. } = self.faces[face as usize];
            let twin = twins[edge as usize];
            let neighbour = &mut self.faces[face_of(twin) as usize];
            if neighbour.stamp == self.stamp {
                continue;
            }
            if neighbour.sees(position, &self.points) {
                neighbour.stamp = self.stamp;
                self.visible.push(face_of(twin));
                self.path.push((face_of(twin), (edge_of(twin) as u32 + 1) % 3, 2));
            } else {
                let [start, end] = [vertices[edge as usize], vertices[(edge as usize + 1) % 3]];
                self.horizon.push(Horizon { start, end, outside: twin });
            }
        }
    }
}

fn is_finite(point: &Vector) -> bool {
    point.iter().all(|x| x.is_finite())
}
