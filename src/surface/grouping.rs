//! Convex polygon grouping [3.4.1]: groups grow over neighbours by a queue, as long as the new
//! polygon bends inward by no more than the thresholds.
//!
//! As the paper has it, the test looks one way only: the new vertex against the planes of the
//! group, at the moment when the neighbour is considered. A polygon that waits in the queue is
//! not tested again when its turn comes.

use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::vector::{Vector, dot, subtract};
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

/// Grows convex groups. Thresholds are lengths in the mesh's space. O(n · group size).
pub(crate) fn group(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    planar_threshold: f64,
    angular_threshold: f64,
    control: &Control,
) -> Result<Grouping, Error> {
    let count = mesh.triangles.len();
    let planes: Vec<Plane> = (0..count).map(|triangle| plane(mesh, adjacency, triangle)).collect();
    let mut labels = vec![UNGROUPED; count];
    let mut queue: Vec<u32> = Vec::new();
    let mut members: Vec<Plane> = Vec::new();
    let mut groups = 0;
    let mut grouped: usize = 0;
    for start in 0..count {
        if labels[start] != UNGROUPED {
            continue;
        }
        queue.clear();
        queue.push(start as u32);
        members.clear();
        let mut next = 0;
        while let Some(&current) = queue.get(next) {
            next += 1;
            if labels[current as usize] != UNGROUPED {
                continue;
            }
            labels[current as usize] = groups;
            members.push(planes[current as usize]);
            grouped += 1;
            if grouped.is_multiple_of(POLYGONS_PER_CHECK) {
                control.check()?;
            }
            for neighbour in adjacency.triangle_neighbours(current) {
                if neighbour == NO_NEIGHBOUR || labels[neighbour as usize] != UNGROUPED {
                    continue;
                }
                let far = farther_vertex(mesh, current, neighbour);
                if planes[current as usize].distance(far) <= angular_threshold
                    && is_behind_all(&mut members, far, planar_threshold)
                {
                    queue.push(neighbour);
                }
            }
        }
        groups += 1;
    }
    Ok(Grouping { labels, count: groups as usize })
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

fn plane(mesh: &TriangleMesh, adjacency: &Adjacency, triangle: usize) -> Plane {
    let normal = adjacency.normals[triangle];
    let [a, ..] = mesh.triangles[triangle];
    Plane { normal, offset: dot(normal, mesh.positions[a as usize]) }
}

/// The vertex of `neighbour` that `current` does not have. For a flap, which has none, any.
fn farther_vertex(mesh: &TriangleMesh, current: u32, neighbour: u32) -> Vector {
    let own = mesh.triangles[current as usize];
    let [first, second, third] = mesh.triangles[neighbour as usize];
    let far = if !own.contains(&first) {
        first
    } else if !own.contains(&second) {
        second
    } else {
        third
    };
    mesh.positions[far as usize]
}

/// Whether no plane has the point farther than the threshold in front of it. The plane that
/// refused last is asked first, since it will often refuse again.
fn is_behind_all(planes: &mut [Plane], point: Vector, threshold: f64) -> bool {
    match planes.iter().position(|plane| plane.distance(point) > threshold) {
        Some(refusing) => {
            planes.swap(0, refusing);
            false
        }
        None => true,
    }
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
    fn cancelling_stops_it() {
        let control = Control::new();
        control.cancel();
        let mesh = crate::mesh::shapes::torus(32, 16);
        let result = group(&mesh, &Adjacency::new(&mesh), 0.0, 0.0, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}
