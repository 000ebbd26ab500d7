//! Convex polygon grouping [3.4.1]: groups grow over neighbours by a queue, as long as the new
//! polygon bends inward by no more than the thresholds.
//!
//! As the paper has it, the test looks one way only: the new vertex against the planes of the
//! group, at the moment when the neighbour is considered. A polygon that waits in the queue is
//! not tested again when its turn comes.
//!
//! Nearly all the time goes into comparing vertices with the planes of a group, and most of that
//! is spared without changing an answer: planes only ever join a group, so a vertex that was
//! refused stays refused, and one that was behind all planes need only be held against those that
//! came since.

use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::vector::{Vector, add, dot, length_squared, scale, subtract};
use crate::{Control, Error};

/// No group yet.
const UNGROUPED: u32 = u32::MAX;

/// Polygons between two looks at the control: fewer would cost time, more would delay a stop.
const POLYGONS_PER_CHECK: usize = 256;

/// A group label per triangle, and the number of groups. Labels count up in the order in which
/// groups were started.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Grouping {
    pub labels: Vec<u32>,
    pub count: usize,
}

/// A grouping, and for which other planar thresholds it is the same.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Grown {
    pub grouping: Grouping,
    /// From the planar threshold that was asked for up to just below this one, growing would have
    /// taken the same course: each refusal was by more.
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

/// As [`group`], telling for which thresholds it holds.
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
                let position = mesh.positions[far as usize];
                if plane.distance(position) <= angular_threshold && planes.allow(far, position) {
                    queue.push(neighbour);
                }
            }
        }
        groups += 1;
    }
    let grouping = Grouping { labels, count: groups as usize };
    Ok(Grown { grouping, same_below: planes.least_refusal })
}

#[derive(Debug, Clone, Copy)]
struct Plane {
    normal: Vector,
    offset: f64,
}

impl Plane {
    #[inline]
    fn distance(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

fn plane(mesh: &TriangleMesh, adjacency: &Adjacency, triangle: u32) -> Plane {
    let normal = adjacency.normals[triangle as usize];
    let [a, ..] = mesh.triangles[triangle as usize];
    Plane { normal, offset: dot(normal, mesh.positions[a as usize]) }
}

/// The vertex of `neighbour` that `current` does not have. For a flap, which has none, any.
fn farther_vertex(mesh: &TriangleMesh, current: u32, neighbour: u32) -> u32 {
    let own = mesh.triangles[current as usize];
    let [first, second, third] = mesh.triangles[neighbour as usize];
    if !own.contains(&first) {
        first
    } else if !own.contains(&second) {
        second
    } else {
        third
    }
}

/// Planes that are compared in one go, so that the compiler can use wide registers.
const BLOCK: usize = 8;

/// The planes of the forming group, and what is known of vertices held against them.
struct Planes {
    threshold: f64,
    /// In blocks: normals by coordinate, then offsets. The rest of the last block is behind
    /// everything.
    blocks: Vec<[[f64; BLOCK]; 4]>,
    /// For each full block what may spare a look into it.
    bounds: Vec<Bound>,
    count: usize,
    /// The block that refused last will often refuse again.
    refusing: usize,
    group: u32,
    /// For each vertex the last group that it was held against, and with how many blocks, all of
    /// them full, it got on.
    known: Vec<(u32, u32)>,
    /// The least distance of all that were too large.
    least_refusal: f64,
}

/// In place of a number of blocks: the group has refused the vertex.
const REFUSED: u32 = u32::MAX;

impl Planes {
    fn new(threshold: f64, vertices: usize) -> Self {
        Self {
            threshold,
            blocks: Vec::new(),
            bounds: Vec::new(),
            count: 0,
            refusing: 0,
            group: UNGROUPED,
            known: vec![(UNGROUPED, 0); vertices],
            least_refusal: f64::INFINITY,
        }
    }

    /// Forgets the planes of the group before.
    fn start_group(&mut self, group: u32) {
        self.group = group;
        self.blocks.clear();
        self.bounds.clear();
        self.count = 0;
        self.refusing = 0;
    }

    /// Adds a plane, and a point of it.
    fn push(&mut self, Plane { normal: [x, y, z], offset }: Plane, point: Vector) {
        let place = self.count % BLOCK;
        if place == 0 {
            let none = [0.0; BLOCK];
            self.blocks.push([none, none, none, [f64::INFINITY; BLOCK]]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (row, value) in block.iter_mut().zip([x, y, z, offset]) {
                row[place] = value;
            }
            if place + 1 == BLOCK {
                self.bounds.push(Bound::new(block, point));
            }
        }
        self.count += 1;
    }

    /// Whether no plane has the vertex farther than the threshold in front of it.
    fn allow(&mut self, vertex: u32, position: Vector) -> bool {
        let (group, known) = &mut self.known[vertex as usize];
        if *group != self.group {
            (*group, *known) = (self.group, 0);
        }
        if *known == REFUSED {
            return false;
        }
        let start = *known as usize;
        let may_refuse = |place: usize| {
            let block = &self.blocks[place];
            let bound = self.bounds.get(place);
            if bound.is_some_and(|bound| bound.is_below(position, self.threshold)) {
                return None;
            }
            let farthest = farthest(block, position);
            (farthest > self.threshold).then_some((place, farthest))
        };
        let likely = if self.refusing >= start { may_refuse(self.refusing) } else { None };
        if let Some((place, farthest)) =
            likely.or_else(|| (start..self.blocks.len()).find_map(may_refuse))
        {
            self.refusing = place;
            self.least_refusal = self.least_refusal.min(farthest);
            *known = REFUSED;
            return false;
        }
        *known = (self.count / BLOCK) as u32;
        true
    }
}

/// Distances from the planes of a block are bounded by that from a plane between them.
///
/// With a mean normal m and a point c, n · x − o = m · (x − c) + (n − m) · (x − c) + (n · c − o),
/// where the second term is at most the spread of the normals times ‖x − c‖.
struct Bound {
    normal: Vector,
    centre: Vector,
    /// Greatest squared ‖n − m‖.
    squared_spread: f64,
    /// Greatest n · c − o, and what rounding may add.
    height: f64,
}

/// Far above the rounding errors of coordinates of the order of 1, far below any threshold.
const ROUNDING: f64 = 1e-12;

impl Bound {
    fn new([x, y, z, offset]: &[[f64; BLOCK]; 4], centre: Vector) -> Self {
        let normals: [Vector; BLOCK] = std::array::from_fn(|lane| [x[lane], y[lane], z[lane]]);
        let sum = normals.iter().fold([0.0; 3], |sum, &normal| add(sum, normal));
        let normal = scale(sum, 1.0 / BLOCK as f64);
        let spread = |&other: &Vector| length_squared(subtract(other, normal));
        let height = normals.iter().zip(offset).map(|(&n, o)| dot(n, centre) - o);
        Self {
            normal,
            centre,
            squared_spread: normals.iter().map(spread).fold(0.0, f64::max) + ROUNDING,
            height: height.fold(f64::NEG_INFINITY, f64::max) + ROUNDING,
        }
    }

    /// Whether no distance can be above the threshold.
    #[inline]
    fn is_below(&self, point: Vector, threshold: f64) -> bool {
        let arm = subtract(point, self.centre);
        let room = threshold - self.height - dot(self.normal, arm);
        room >= 0.0 && self.squared_spread * length_squared(arm) <= room * room
    }
}

/// The distance of a point from the plane of a block that it is farthest in front of.
#[inline]
fn farthest([x, y, z, offset]: &[[f64; BLOCK]; 4], point: Vector) -> f64 {
    let mut distances = [0.0; BLOCK];
    for lane in 0..BLOCK {
        distances[lane] =
            x[lane] * point[0] + y[lane] * point[1] + z[lane] * point[2] - offset[lane];
    }
    // Halves, not one after the other: a chain of comparisons would not use wide registers.
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let [a, b, c, d, e, f, g, h] = distances;
    let quarters = [larger(a, e), larger(b, f), larger(c, g), larger(d, h)];
    larger(larger(quarters[0], quarters[2]), larger(quarters[1], quarters[3]))
}

/// The polygons of each group, in ascending order: offsets and a list.
pub(crate) fn members(labels: &[u32], count: usize) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); count];
    for (triangle, &label) in (0..).zip(labels) {
        if let Some(group) = members.get_mut(label as usize) {
            group.push(triangle);
        }
    }
    members
}

/// Corners of a triangle.
pub(crate) fn corners(mesh: &TriangleMesh, triangle: u32) -> [Vector; 3] {
    mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize])
}

/// The vertices of a group, ascending, each once.
pub(crate) fn group_vertices(mesh: &TriangleMesh, group: &[u32]) -> Vec<u32> {
    let mut vertices: Vec<u32> =
        group.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Diagonal of the bounding box of a group.
pub(crate) fn diagonal(positions: impl Iterator<Item = Vector>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for position in positions {
        low = crate::vector::minimum(low, position);
        high = crate::vector::maximum(high, position);
    }
    let diagonal = crate::vector::length(subtract(high, low));
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join};

    fn groups_of(mesh: &TriangleMesh, p: f64, a: f64) -> Grouping {
        group(mesh, &Adjacency::new(mesh), p, a, &Control::new()).unwrap()
    }

    /// A strip of two unit squares along x whose second one rises by `rise` at its end.
    fn strip(rise: f64) -> TriangleMesh {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.0, 0.0, rise],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
            [2.0, 1.0, rise],
        ];
        TriangleMesh { positions, triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]] }
    }

    #[test]
    fn a_cube_is_one_group() {
        assert_eq!(groups_of(&cuboid([0.0; 3], [1.0; 3]), 0.01, 0.01).count, 1);
    }

    #[test]
    fn disjoint_boxes_are_two_groups() {
        let boxes = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([2.0; 3], [3.0; 3])]);
        assert_eq!(groups_of(&boxes, 1.0, 1.0).count, 2);
    }

    #[test]
    fn bending_outward_goes_on_and_bending_inward_stops() {
        assert_eq!(groups_of(&strip(-0.5), 0.01, 0.01).count, 1);
        assert_eq!(groups_of(&strip(0.5), 0.01, 0.01).count, 2);
    }

    #[test]
    fn both_thresholds_must_allow_a_bend() {
        assert_eq!(groups_of(&strip(0.05), 0.1, 0.1).count, 1);
        assert_eq!(groups_of(&strip(0.05), 0.01, 0.1).count, 2);
        assert_eq!(groups_of(&strip(0.05), 0.1, 0.01).count, 2);
    }

    #[test]
    fn every_triangle_has_a_group_below_the_count() {
        let grouping = groups_of(&strip(0.5), 0.01, 0.01);
        assert_eq!(grouping.labels, [0, 0, 1, 1]);
    }

    #[test]
    fn thresholds_up_to_the_least_refusal_give_the_same_groups() {
        let mesh = crate::mesh::shapes::torus(24, 12);
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
        // As the paper says it: each vertex against each plane, each time.
        let mesh = crate::mesh::shapes::torus(40, 20);
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
                        let far = mesh.positions[far as usize];
                        if labels[neighbour as usize] == UNGROUPED
                            && own.distance(far) <= 0.01
                            && planes.iter().all(|plane| plane.distance(far) <= p)
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
        let mesh = crate::mesh::shapes::torus(32, 16);
        let result = group(&mesh, &Adjacency::new(&mesh), 0.0, 0.0, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}
