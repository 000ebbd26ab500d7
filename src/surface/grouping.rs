//! Convex polygon grouping [3.4.1]: groups grow over neighbours by a queue, as long as the new
//! polygon bends inward by no more than the thresholds.
//!
//! As the paper has it, the test looks one way only: the new vertex against the planes of the
//! group, at the moment when the neighbour is considered. A polygon that waits in the queue is
//! not tested again when its turn comes.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, dot};
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};

use super::group_planes::{Plane, Planes};

/// No group yet.
const UNGROUPED: u32 = u32::MAX;

/// Polygons between two looks at the control: fewer would cost time, more would delay a stop.
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
    Ok(Grown { grouping, same_below: planes.least_refusal() })
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
    mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize])
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
        TriangleMesh {
            positions,
            triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            ..TriangleMesh::default()
        }
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
