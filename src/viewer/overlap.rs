//! Volume of intersection over union, join after join: by points in the joint bounding box, each
//! of which is asked once for each hull.

use super::subject::Subject;
use crate::geometry::vector::{Vector, add, bounds, maximum, minimum};
use crate::measure::sampling::in_unit_cube;
use crate::measure::solid::{Part, TOLERANCE};
use crate::parallel::{map, map_indices};

/// Points in the box. Shares scatter by less than half a percent.
const POINTS: usize = 1 << 16;

/// For each state, from all leaves down to one hull, the volume that the solid and the hulls share
/// over the volume of both together. `parts` are the leaves, then the joint hulls.
pub(super) fn overlaps(
    parts: &[Part],
    leaves: usize,
    joined: &[[usize; 2]],
    subject: &Subject<'_>,
) -> Vec<f64> {
    let (mut min, mut max) = bounds(subject.surface.positions.iter().copied());
    for part in parts {
        (min, max) = (minimum(min, part.min), maximum(max, part.max));
    }
    let points: Vec<Vector> = (0..POINTS)
        .map(|index| {
            let share = in_unit_cube(index, None);
            add(min, [0, 1, 2].map(|axis| share[axis] * (max[axis] - min[axis])))
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
