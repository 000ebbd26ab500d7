//! How far the points of the surface are outside of all hulls. A joint hull holds more than the two
//! that it replaces, so that distances only fall from join to join: few of them, which are stored
//! as changes.

use super::samples;
use super::subject::Subject;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;
use crate::measure::solid::{Part, TOLERANCE, Union};
use crate::parallel::{map, map_indices};

/// The uncovered distance of a sample falls with a join.
pub(super) struct Change {
    pub join: u16,
    pub sample: u32,
    pub value: u8,
}

/// Uncovered distances, as [`samples::bytes`] has them.
pub(super) struct Uncovered {
    /// The greatest, in diagonals.
    pub most: f64,
    /// For each sample of the surface that of all leaves.
    pub values: Vec<u8>,
    /// By join.
    pub changes: Vec<Change>,
}

/// `parts` are the leaves, then the joint hulls in the order of `joined`.
pub(super) fn uncovered(
    subject: &Subject<'_>,
    mut parts: Vec<Part>,
    leaves: usize,
    joined: &[[usize; 2]],
) -> Uncovered {
    let joints = parts.split_off(leaves.min(parts.len()));
    let union = Union::new(parts);
    let (positions, triangles) = union.surface();
    let bvh = Bvh::new(positions, triangles);
    let mut distances = map(&subject.samples, |&point| {
        if union.multiplicity(point) > 0 { 0.0 } else { distance(&bvh, point, f64::INFINITY) }
    });
    let (most, values) = samples::bytes(&distances);

    let mut left: Vec<usize> = (0..values.len()).filter(|&sample| values[sample] > 0).collect();
    let mut changes = Vec::new();
    // The page counts joins with 16 bits, of which no decomposition comes near.
    for (join, part) in (0..u16::MAX).zip(&joints).take(joined.len()) {
        let bvh = Bvh::new(&part.points, &part.triangles);
        let found = map_indices(left.len(), |index| {
            let (point, before) = (subject.samples[left[index]], distances[left[index]]);
            if is_beyond(part, point, before) {
                before
            } else if part.holds(point, TOLERANCE) {
                0.0
            } else {
                distance(&bvh, point, before)
            }
        });
        for (&sample, found) in left.iter().zip(found) {
            let value = samples::byte(found, most);
            if value < samples::byte(distances[sample], most) {
                changes.push(Change { join, sample: sample as u32, value });
            }
            distances[sample] = distances[sample].min(found);
        }
        left.retain(|&sample| samples::byte(distances[sample], most) > 0);
    }
    Uncovered { most, values, changes }
}

/// Whether a point is farther than this from the box around a hull.
fn is_beyond(part: &Part, point: Vector, distance: f64) -> bool {
    (0..3).any(|axis| {
        part.min[axis] - point[axis] > distance || point[axis] - part.max[axis] > distance
    })
}

/// The distance to a surface, or `limit` if that is less.
fn distance(bvh: &Bvh, point: Vector, limit: f64) -> f64 {
    bvh.closest_point(point, limit).map_or(limit, |closest| closest.distance)
}
