//! Convex grouping of triangles, section 3.4.1 of the paper: groups grow over neighbours by a
//! queue, as long as the new polygon bends inward by no more than the thresholds. The paper's
//! method takes groups as pieces, the default method divides them into patches.
//!
//! As the paper has it, the test looks one way only: the new vertex against the planes of the
//! group, at the moment when the neighbour is considered. A polygon in the queue is not
//! tested again when its turn comes.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::TriangleMesh;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, larger};

use super::adjacency::{Adjacency, NO_NEIGHBOUR};

/// No group yet.
const UNGROUPED: u32 = u32::MAX;

/// Polygons between two checks of the control: fewer would cost time, more would delay a stop.
const POLYGONS_PER_CHECK: usize = 256;

/// A group label per triangle, and the number of groups. Labels count up in the order in which
/// groups were started.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Grouping {
    /// The group of each triangle.
    pub labels: Vec<u32>,
    /// The number of groups.
    pub count: usize,
}

/// A grouping, and for which other planar thresholds it is the same.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Grown {
    pub grouping: Grouping,
    /// From its planar threshold up to just below this one, growing would have taken the same
    /// course: each refusal was by more.
    pub same_below: f64,
}

/// Grows convex groups. Thresholds are lengths in the mesh's space. O(n · group size).
pub(crate) fn group(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    planar_threshold: f64,
    angular_threshold: f64,
    control: &Control,
) -> Result<Grouping, Error> {
    grow(mesh, adjacency, planar_threshold, angular_threshold, control).map(|grown| grown.grouping)
}

/// As [`group`], with the thresholds for which it holds.
pub(crate) fn grow(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    planar_threshold: f64,
    angular_threshold: f64,
    control: &Control,
) -> Result<Grown, Error> {
    let count = mesh.triangles.len();
    let mut labels = vec![UNGROUPED; count];
    let mut queue: Vec<u32> = Vec::new();
    let mut planes = Planes::new(planar_threshold, mesh.positions.len());
    let mut groups = 0;
    let mut grouped: usize = 0;
    for start in 0..count {
        if labels[start] != UNGROUPED {
            continue;
        }
        queue.clear();
        queue.push(start as u32);
        planes.start_group(groups);
        let mut next = 0;
        while let Some(&current) = queue.get(next) {
            next += 1;
            if labels[current as usize] != UNGROUPED {
                continue;
            }
            labels[current as usize] = groups;
            let plane = plane(mesh, adjacency, current);
            let [corner, ..] = corners(mesh, current);
            planes.push(plane, corner);
            grouped += 1;
            if grouped.is_multiple_of(POLYGONS_PER_CHECK) {
                control.check()?;
            }
            for neighbour in adjacency.triangle_neighbours(current) {
                if neighbour == NO_NEIGHBOUR || labels[neighbour as usize] != UNGROUPED {
                    continue;
                }
                let far = farther_vertex(mesh, current, neighbour);
                let position = mesh.points()[far as usize];
                if plane.height(position) <= angular_threshold && planes.allow(far, position) {
                    queue.push(neighbour);
                }
            }
        }
        groups += 1;
    }
    let grouping = Grouping { labels, count: groups as usize };
    Ok(Grown { grouping, same_below: planes.least_refusal })
}

fn plane(mesh: &TriangleMesh, adjacency: &Adjacency, triangle: u32) -> Plane {
    let normal = adjacency.normals[triangle as usize];
    let [a, ..] = mesh.triangles[triangle as usize];
    Plane { normal, offset: normal.dot(mesh.points()[a as usize]) }
}

/// The vertex of `neighbour` that `current` does not have. For a flap, which has none, any.
fn farther_vertex(mesh: &TriangleMesh, current: u32, neighbour: u32) -> u32 {
    let own = mesh.triangles[current as usize];
    let [first, second, third] = mesh.triangles[neighbour as usize];
    match (own.contains(&first), own.contains(&second)) {
        (false, _) => first,
        (true, false) => second,
        (true, true) => third,
    }
}

/// The polygons of each group, in ascending order.
pub fn members(labels: &[u32], count: usize) -> Vec<Vec<u32>> {
    let mut sizes = vec![0; count];
    for &label in labels {
        if let Some(size) = sizes.get_mut(label as usize) {
            *size += 1;
        }
    }
    let mut members: Vec<Vec<u32>> = sizes.into_iter().map(Vec::with_capacity).collect();
    for (triangle, &label) in (0..).zip(labels) {
        if let Some(group) = members.get_mut(label as usize) {
            group.push(triangle);
        }
    }
    members
}

/// Corners of a triangle.
pub fn corners(mesh: &TriangleMesh, triangle: u32) -> [Vector; 3] {
    mesh.triangles[triangle as usize].map(|vertex| mesh.points()[vertex as usize])
}

/// The vertices of a group, ascending, each once.
pub(crate) fn group_vertices(mesh: &TriangleMesh, group: &[u32]) -> Vec<u32> {
    let corners = group.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]);
    let words = mesh.positions.len().div_ceil(u64::BITS as usize);
    if group.len() < words {
        let mut vertices: Vec<u32> = corners.collect();
        vertices.sort_unstable();
        vertices.dedup();
        return vertices;
    }
    // A bit for each vertex of the mesh: no more words than the group has polygons.
    let mut used = vec![0_u64; words];
    for vertex in corners {
        used[(vertex / u64::BITS) as usize] |= 1 << (vertex % u64::BITS);
    }
    let mut vertices = Vec::with_capacity(group.len());
    for (first, mut word) in (0..).step_by(u64::BITS as usize).zip(used) {
        while word != 0 {
            vertices.push(first + word.trailing_zeros());
            word &= word - 1;
        }
    }
    vertices
}

// The planes of a forming group. Nearly all the time of grouping is spent on comparing vertices
// with them, and most of it is saved without changing an answer: planes only ever join a group, so
// a vertex that was refused stays refused, and one that was behind all planes is compared with
// those alone that came since. A comparison has three steps, each for what the one before leaves in
// doubt: bounds for several planes, single precision with room for its rounding, double precision.

/// Planes that are compared in one go, so that the compiler can use wide registers.
const BATCH: usize = 8;

/// Batches whose bounds are looked at in one go.
const ROW: usize = 4;

/// The planes of the forming group, and how vertices compared with them.
struct Planes {
    threshold: f64,
    /// In batches: normals by coordinate, then offsets. The rest of the last batch is behind
    /// everything.
    batches: Vec<[[f64; BATCH]; 4]>,
    /// What mostly suffices to see that nothing is in the way.
    rows: Vec<Row>,
    count: usize,
    /// The batch that refused last will often refuse again.
    refusing: Option<usize>,
    group: u32,
    /// For each vertex the last group that it was compared with, and how many batches, all of them
    /// full, allow it.
    known: Vec<(u32, u32)>,
    /// The least distance of all that were too large.
    least_refusal: f64,
}

/// In place of a group: none yet.
const NO_GROUP: u32 = u32::MAX;

/// In place of a number of batches: the group has refused the vertex.
const REFUSED: u32 = u32::MAX;

impl Planes {
    fn new(threshold: f64, vertices: usize) -> Self {
        Self {
            threshold,
            batches: Vec::new(),
            rows: Vec::new(),
            count: 0,
            refusing: None,
            group: NO_GROUP,
            known: vec![(NO_GROUP, 0); vertices],
            least_refusal: f64::INFINITY,
        }
    }

    /// Forgets the planes of the group before.
    fn start_group(&mut self, group: u32) {
        self.group = group;
        self.batches.clear();
        self.rows.clear();
        self.count = 0;
        self.refusing = None;
    }

    /// Adds a plane, and a point of it.
    #[inline]
    fn push(&mut self, Plane { normal: Vector { x, y, z }, offset }: Plane, point: Vector) {
        let place = self.count % BATCH;
        let lane = self.count / BATCH % ROW;
        if place == 0 {
            let none = [0.0; BATCH];
            self.batches.push([none, none, none, [f64::INFINITY; BATCH]]);
            if lane == 0 {
                self.rows.push(Row::EMPTY);
            }
        }
        if let (Some(batch), Some(row)) = (self.batches.last_mut(), self.rows.last_mut()) {
            for (axis, value) in [x, y, z, offset].into_iter().enumerate() {
                batch[axis][place] = value;
                row.batches[lane][axis][place] = value as f32;
            }
            row.bounds.height[lane] = f32::INFINITY;
            if place + 1 == BATCH {
                row.bounds.set(lane, batch, point);
            }
        }
        self.count += 1;
    }

    /// Whether no plane has the vertex farther than the threshold in front of it.
    #[inline]
    fn allow(&mut self, vertex: u32, position: Vector) -> bool {
        let (group, known) = &mut self.known[vertex as usize];
        if *group != self.group {
            (*group, *known) = (self.group, 0);
        }
        if *known == REFUSED {
            return false;
        }
        let start = *known as usize;
        let likely = self.refusing.filter(|&place| place >= start);
        let refusal = likely
            .and_then(|place| Some((place, self.refusal(place, position)?)))
            .or_else(|| self.first_refusal(start, position));
        if let Some((place, farthest)) = refusal {
            self.refusing = Some(place);
            self.least_refusal = self.least_refusal.min(farthest);
            self.known[vertex as usize].1 = REFUSED;
            return false;
        }
        self.known[vertex as usize].1 = (self.count / BATCH) as u32;
        true
    }

    /// How far the point is in front of a plane of a batch, if that is too far.
    #[inline]
    fn refusal(&self, place: usize, position: Vector) -> Option<f64> {
        let farthest = farthest(&self.batches[place], position);
        (farthest > self.threshold).then_some(farthest)
    }

    /// The first batch from `start` on with a plane that has the point too far in front of it, and
    /// how far.
    fn first_refusal(&self, start: usize, position: Vector) -> Option<(usize, f64)> {
        let point = position.as_vec3().to_array();
        let threshold = (self.threshold - ROUNDING) as f32;
        for (index, row) in self.rows.iter().enumerate().skip(start / ROW) {
            let excess = row.bounds.excess(point, threshold);
            if largest(excess) <= 0.0 {
                continue;
            }
            #[expect(clippy::needless_range_loop, reason = "by value the whole loop is slower")]
            for lane in 0..ROW {
                let place = index * ROW + lane;
                if excess[lane] > 0.0
                    && place >= start
                    && is_any_above(&row.batches[lane], point, threshold)
                    && let Some(farthest) = self.refusal(place, position)
                {
                    return Some((place, farthest));
                }
            }
        }
        None
    }
}

/// A few batches in single precision.
struct Row {
    bounds: Bounds,
    batches: [[[f32; BATCH]; 4]; ROW],
}

impl Row {
    const EMPTY: Self = {
        let none = [0.0; BATCH];
        Self { bounds: Bounds::EMPTY, batches: [[none, none, none, [f32::INFINITY; BATCH]]; ROW] }
    };
}

/// Distances from the planes of a batch are bounded by that from a plane between them; here for
/// a few batches side by side, in single precision and with room for its rounding.
///
/// With a mean normal m and a point c, n · x − o = m · (x − c) + (n − m) · (x − c) + (n · c − o),
/// where the second term is at most the spread of the normals times ‖x − c‖.
struct Bounds {
    /// Mean normals by coordinate.
    normal: [[f32; ROW]; 3],
    centre: [[f32; ROW]; 3],
    /// Greatest squared ‖n − m‖.
    squared_spread: [f32; ROW],
    /// Greatest n · c − o. Infinite where a batch is not full, and less than anything where there
    /// is none.
    height: [f32; ROW],
}

/// What a threshold is lowered by in single precision: far above the rounding errors of coordinates
/// of the order of 1, far below any usual threshold.
const ROUNDING: f64 = 1e-5;

impl Bounds {
    const EMPTY: Self = Self {
        normal: [[0.0; ROW]; 3],
        centre: [[0.0; ROW]; 3],
        squared_spread: [0.0; ROW],
        height: [f32::NEG_INFINITY; ROW],
    };

    /// Sets the bound of a batch that is full. The centre should be near its planes.
    fn set(&mut self, lane: usize, [x, y, z, offset]: &[[f64; BATCH]; 4], centre: Vector) {
        let normals: [Vector; BATCH] =
            std::array::from_fn(|lane| Vector::new(x[lane], y[lane], z[lane]));
        let sum = normals.iter().fold(Vector::ZERO, |sum, &normal| sum + normal);
        let normal = sum * (1.0 / BATCH as f64);
        let spread = |&other: &Vector| other.distance_squared(normal);
        let height = normals.iter().zip(offset).map(|(&n, o)| n.dot(centre) - o);
        for axis in 0..3 {
            self.normal[axis][lane] = normal[axis] as f32;
            self.centre[axis][lane] = centre[axis] as f32;
        }
        self.squared_spread[lane] = normals.iter().map(spread).fold(0.0, f64::max) as f32;
        self.height[lane] = height.fold(f64::NEG_INFINITY, f64::max) as f32;
    }

    /// For each batch a number that is positive unless no distance can be above the threshold.
    #[inline]
    fn excess(&self, [x, y, z]: [f32; 3], threshold: f32) -> [f32; ROW] {
        std::array::from_fn(|lane| {
            let arm =
                [x - self.centre[0][lane], y - self.centre[1][lane], z - self.centre[2][lane]];
            let along = self.normal[0][lane] * arm[0]
                + self.normal[1][lane] * arm[1]
                + self.normal[2][lane] * arm[2];
            let squared = arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2];
            let room = threshold - self.height[lane] - along;
            self.squared_spread[lane] * squared - room * room.abs()
        })
    }
}

/// The distance of a point from the plane of a batch that it is farthest in front of.
#[inline]
fn farthest([x, y, z, offset]: &[[f64; BATCH]; 4], point: Vector) -> f64 {
    let mut distances = [0.0; BATCH];
    for lane in 0..BATCH {
        distances[lane] =
            x[lane] * point[0] + y[lane] * point[1] + z[lane] * point[2] - offset[lane];
    }
    // Halves, not one after the other: a chain of comparisons would not use wide registers.
    let [a, b, c, d, e, f, g, h] = distances;
    let quarters = [larger(a, e), larger(b, f), larger(c, g), larger(d, h)];
    larger(larger(quarters[0], quarters[2]), larger(quarters[1], quarters[3]))
}

/// Whether a distance of a point from the planes of a batch is above the threshold.
#[inline]
fn is_any_above([x, y, z, offset]: &[[f32; BATCH]; 4], point: [f32; 3], threshold: f32) -> bool {
    let mut any = false;
    for lane in 0..BATCH {
        let distance = x[lane] * point[0] + y[lane] * point[1] + z[lane] * point[2] - offset[lane];
        // Not a choice between ways, which would be taken lane by lane.
        any |= distance > threshold;
    }
    any
}

#[inline]
fn largest([a, b, c, d]: [f32; 4]) -> f32 {
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    larger(larger(a, c), larger(b, d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join, torus};

    fn groups_of(mesh: &TriangleMesh, p: f64, a: f64) -> Grouping {
        group(mesh, &Adjacency::new(mesh), p, a, &Control::new()).unwrap()
    }

    /// A strip of two unit squares along x whose second one rises by `rise` at its end.
    fn strip(rise: f64) -> TriangleMesh {
        let row = |y: f64| [[0.0, y, 0.0], [1.0, y, 0.0], [2.0, y, rise]];
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        TriangleMesh::new([row(0.0), row(1.0)].concat(), triangles)
    }

    #[test]
    fn bending_outward_goes_on_and_bending_inward_stops_where_a_threshold_does_not_allow_it() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let boxes = join(&[cube.clone(), cuboid([2.0; 3], [3.0; 3])]);
        for (mesh, p, a, count) in [
            (cube, 0.01, 0.01, 1),
            (boxes, 1.0, 1.0, 2),
            (strip(-0.5), 0.01, 0.01, 1),
            (strip(0.5), 0.01, 0.01, 2),
            (strip(0.05), 0.1, 0.1, 1),
            (strip(0.05), 0.01, 0.1, 2),
            (strip(0.05), 0.1, 0.01, 2),
        ] {
            assert_eq!(groups_of(&mesh, p, a).count, count, "{p}, {a}");
        }
        assert_eq!(groups_of(&strip(0.5), 0.01, 0.01).labels, [0, 0, 1, 1]);
    }

    #[test]
    fn thresholds_up_to_the_least_refusal_give_the_same_groups() {
        let mesh = torus(24, 12);
        let adjacency = Adjacency::new(&mesh);
        for p in [0.0, 0.001, 0.01, 0.05, 0.1] {
            let grown = grow(&mesh, &adjacency, p, 0.01, &Control::new()).unwrap();
            assert!(grown.same_below > p);
            let same = groups_of(&mesh, grown.same_below.next_down(), 0.01);
            assert_eq!(same, grown.grouping, "{p} and just below {}", grown.same_below);
        }
    }

    #[test]
    fn what_is_remembered_of_vertices_changes_no_answer() {
        // As in the paper: each vertex against each plane, each time.
        let mesh = torus(40, 20);
        let adjacency = Adjacency::new(&mesh);
        for p in [0.0, 0.003, 0.02, 0.1] {
            let mut labels = vec![UNGROUPED; mesh.triangles.len()];
            let mut groups = 0;
            while let Some(start) = labels.iter().position(|&label| label == UNGROUPED) {
                let mut queue = std::collections::VecDeque::from([start as u32]);
                let mut planes: Vec<Plane> = Vec::new();
                while let Some(current) = queue.pop_front() {
                    if labels[current as usize] != UNGROUPED {
                        continue;
                    }
                    labels[current as usize] = groups;
                    let own = plane(&mesh, &adjacency, current);
                    planes.push(own);
                    for neighbour in adjacency.triangle_neighbours(current) {
                        let far = farther_vertex(&mesh, current, neighbour);
                        let far = mesh.points()[far as usize];
                        if labels[neighbour as usize] == UNGROUPED
                            && own.height(far) <= 0.01
                            && planes.iter().all(|plane| plane.height(far) <= p)
                        {
                            queue.push_back(neighbour);
                        }
                    }
                }
                groups += 1;
            }
            assert!(groups > 1);
            assert_eq!(groups_of(&mesh, p, 0.01).labels, labels, "{p}");
        }
    }

    #[test]
    fn cancelling_stops_it() {
        let control = Control::new();
        control.cancel();
        let mesh = torus(32, 16);
        let result = group(&mesh, &Adjacency::new(&mesh), 0.0, 0.0, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}
