//! Vertices that a hull doesn't need, because they lie inside a flat side or a straight edge.

use super::face::{Face, NONE, after, before, edge_of, face_of};
use crate::geometry::vector::{Vector, distance, dot, length, scale, subtract};

/// Gives each vertex that is a true corner a mark (any value but `NONE`) and all other points
/// none. Returns whether some vertex is no corner. O(faces + points).
pub(super) fn mark_necessary_vertices(
    faces: &[Face],
    points: &[Vector],
    tolerance: f64,
    marks: &mut Vec<u32>,
) -> bool {
    if !has_flat_edge(faces, points, tolerance) {
        return false;
    }
    marks.clear();
    marks.resize(points.len(), NONE);
    // For now: number of edges at a vertex that bend, with NONE for "not a vertex".
    for face in faces {
        for edge in 0..3 {
            let mark = &mut marks[face.vertices[edge] as usize];
            *mark = if *mark == NONE { 0 } else { *mark };
            // Each edge is met from both its faces, and counts at its start.
            if bends(face, edge, faces, points, tolerance) {
                *mark += 1;
            }
        }
    }
    let mut redundant = false;
    for face in faces {
        for edge in 0..3 {
            let vertex = face.vertices[edge];
            let mark = marks[vertex as usize];
            let needed = match mark {
                NONE => continue,
                0 => false,
                1 | 2 => !is_on_straight_edge(vertex, faces, face, edge, points, tolerance),
                _ => true,
            };
            if !needed {
                marks[vertex as usize] = NONE;
                redundant = true;
            }
        }
    }
    redundant
}

/// Whether the hull is flat anywhere. Mostly it isn't, and there is nothing to look for.
fn has_flat_edge(faces: &[Face], points: &[Vector], tolerance: f64) -> bool {
    (0..).zip(faces).any(|(index, face)| {
        // Each edge is looked at from one of its faces.
        (0..3).any(|edge| {
            face_of(face.twins[edge]) > index && !bends(face, edge, faces, points, tolerance)
        })
    })
}

/// Whether the far vertex of one of an edge's faces is clearly behind the other face.
#[inline]
fn bends(face: &Face, edge: usize, faces: &[Face], points: &[Vector], tolerance: f64) -> bool {
    let twin = face.twins[edge];
    let other = &faces[face_of(twin) as usize];
    let far_of_other = other.vertices[before(edge_of(twin))];
    let far = face.vertices[before(edge)];
    face.distance(points[far_of_other as usize]) < -tolerance
        && other.distance(points[far as usize]) < -tolerance
}

/// Whether the edges that bend at a vertex lie on one line through it.
fn is_on_straight_edge(
    vertex: u32,
    faces: &[Face],
    face: &Face,
    edge: usize,
    points: &[Vector],
    tolerance: f64,
) -> bool {
    let mut ends = [NONE; 2];
    let mut count = 0;
    let (mut current, mut at) = (face, edge);
    // Around the vertex: the edge that starts here, then the one before it in the same face.
    loop {
        if bends(current, at, faces, points, tolerance) {
            if let Some(end) = ends.get_mut(count) {
                *end = current.vertices[after(at)];
            }
            count += 1;
        }
        let twin = current.twins[before(at)];
        (current, at) = (&faces[face_of(twin) as usize], edge_of(twin));
        if std::ptr::eq(current, face) {
            break;
        }
    }
    if count != 2 {
        return false;
    }
    let [start, end] = ends.map(|end| points[end as usize]);
    let along = subtract(end, start);
    let squared = dot(along, along);
    let position = points[vertex as usize];
    let share = dot(subtract(position, start), along) / squared;
    let foot = [0, 1, 2].map(|axis| start[axis] + scale(along, share)[axis]);
    (0.0..=1.0).contains(&share) && distance(position, foot) <= tolerance.min(1e-3 * length(along))
}
