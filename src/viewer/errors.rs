//! Errors of all hulls together, join after join: uncovered distances, and intersection over union.
//!
//! A joint hull holds more than the two that it replaces, so that uncovered distances only fall from join to
//! join, and few of them do: they are stored as changes.

use super::subject::{Subject, byte, bytes};
use crate::bvh::Bvh;
use crate::geometry::vector::{Vector, bounds};
use crate::measure::hulls::{MeasuredHull, TOLERANCE, Union};
use crate::measure::sampling::in_unit_cube;
use crate::parallel::{map, map_indices};

/// The uncovered distance of a sample falls with a join.
pub(super) struct Change {
    pub join: u16,
    pub sample: u32,
    pub value: u8,
}

/// Uncovered distances, as [`bytes`] has them.
pub(super) struct Uncovered {
    /// The greatest, as a fraction of the diagonal.
    pub most: f64,
    /// For each sample of the surface that of all leaves.
    pub values: Vec<u8>,
    /// By join.
    pub changes: Vec<Change>,
}

/// `parts` are the leaves, then the joint hulls in the order of `joined`.
pub(super) fn uncovered(
    subject: &Subject<'_>,
    mut parts: Vec<MeasuredHull>,
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
    let (most, values) = bytes(&distances);

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
            let value = byte(found, most);
            if value < byte(distances[sample], most) {
                changes.push(Change { join, sample: sample as u32, value });
            }
            distances[sample] = distances[sample].min(found);
        }
        left.retain(|&sample| byte(distances[sample], most) > 0);
    }
    Uncovered { most, values, changes }
}

/// Whether a point is farther than this from the box around a hull.
fn is_beyond(part: &MeasuredHull, point: Vector, distance: f64) -> bool {
    (0..3).any(|axis| {
        part.min[axis] - point[axis] > distance || point[axis] - part.max[axis] > distance
    })
}

/// The distance to a surface, or `limit` if that is less.
fn distance(bvh: &Bvh, point: Vector, limit: f64) -> f64 {
    bvh.closest_point(point, limit).map_or(limit, |closest| closest.distance)
}

/// Points in the box. Shares scatter by less than half a percent.
const POINTS: usize = 1 << 16;

/// For each state, from all leaves down to one hull, the volume of intersection over union of the solid and
/// the hulls, by points in the joint bounding box. Each point is tested once against each hull. `parts` are the leaves, then the joint hulls.
pub(super) fn overlaps(
    parts: &[MeasuredHull],
    leaves: usize,
    joined: &[[usize; 2]],
    subject: &Subject<'_>,
) -> Vec<f64> {
    let (mut min, mut max) = bounds(subject.surface.points().iter().copied());
    for part in parts {
        (min, max) = (min.min(part.min), max.max(part.max));
    }
    let points: Vec<Vector> = (0..POINTS)
        .map(|index| {
            let share = in_unit_cube(index, None);
            min + Vector::from(share) * (max - min)
        })
        .collect();
    let is_in_solid = map_indices(POINTS, |index| subject.contains(points[index]));
    let (leaves, joints) = parts.split_at(leaves.min(parts.len()));
    let mut members: Vec<Vec<u32>> = map(leaves, |part| {
        let held = (0..).zip(&points).filter(|&(_, &point)| part.holds(point, TOLERANCE));
        held.map(|(index, _)| index).collect()
    });

    let mut counts = Counts::new(is_in_solid);
    members.iter().for_each(|members| counts.add(members));
    let mut overlaps = vec![counts.overlap()];
    for (joint, children) in joints.iter().zip(joined) {
        let of_children = children.map(|child| members.get_mut(child).map(std::mem::take));
        let mut is_in_child = vec![false; POINTS];
        for &point in of_children.iter().flatten().flatten() {
            is_in_child[point as usize] = true;
        }
        // A joint hull holds what its parts hold.
        let is_held = map_indices(POINTS, |index| {
            is_in_child[index] || joint.holds(points[index], TOLERANCE)
        });
        let held = (0..).zip(is_held).filter(|&(_, is_held)| is_held);
        let of_joint: Vec<u32> = held.map(|(index, _)| index).collect();
        counts.add(&of_joint);
        of_children.iter().flatten().for_each(|members| counts.remove(members));
        members.push(of_joint);
        overlaps.push(counts.overlap());
    }
    overlaps
}

/// In how many hulls each point is, and what that says about all.
struct Counts {
    is_in_solid: Vec<bool>,
    in_solid: usize,
    multiplicity: Vec<u32>,
    in_hulls: usize,
    in_both: usize,
}

impl Counts {
    fn new(is_in_solid: Vec<bool>) -> Self {
        let in_solid = is_in_solid.iter().filter(|&&is_in| is_in).count();
        let multiplicity = vec![0; is_in_solid.len()];
        Self { is_in_solid, in_solid, multiplicity, in_hulls: 0, in_both: 0 }
    }

    fn add(&mut self, points: &[u32]) {
        for &point in points {
            let point = point as usize;
            if self.multiplicity[point] == 0 {
                self.in_hulls += 1;
                self.in_both += usize::from(self.is_in_solid[point]);
            }
            self.multiplicity[point] += 1;
        }
    }

    fn remove(&mut self, points: &[u32]) {
        for &point in points {
            let point = point as usize;
            self.multiplicity[point] -= 1;
            if self.multiplicity[point] == 0 {
                self.in_hulls -= 1;
                self.in_both -= usize::from(self.is_in_solid[point]);
            }
        }
    }

    fn overlap(&self) -> f64 {
        let union = self.in_solid + self.in_hulls - self.in_both;
        self.in_both as f64 / union.max(1) as f64
    }
}
