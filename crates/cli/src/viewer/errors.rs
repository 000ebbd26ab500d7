//! Errors of all hulls together, join after join: uncovered distances, and intersection over union.
//!
//! A joint hull holds more than the two that it replaces, so that uncovered distances only fall
//! from join to join, and few of them do: they are stored as changes.

use hullwright::measure::MeasuredHulls;
use hullwright::{Bounds, Error, Hull};
use rayon::prelude::*;

use super::subject::{Subject, byte, bytes};
use crate::{Vector, bounds};

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

/// `joints` are the joint hulls, in the order of the joins.
pub(super) fn uncovered(
    subject: &Subject<'_>,
    leaves: &[Hull],
    joints: &[MeasuredHulls],
) -> Result<Uncovered, Error> {
    let leaves = MeasuredHulls::new(leaves, &subject.mesh)?;
    let diagonal = subject.mesh.diagonal();
    let distance = |hulls: &MeasuredHulls, sample: usize, limit: f64| {
        let point = subject.samples.get(sample).copied().unwrap_or_default();
        (hulls.distance(point.to_array(), limit * diagonal) / diagonal).min(limit)
    };
    let samples = (0..subject.samples.len()).into_par_iter();
    let mut distances: Vec<f64> =
        samples.map(|sample| distance(&leaves, sample, f64::INFINITY)).collect();
    let (most, values) = bytes(&distances);

    let mut left: Vec<usize> = (0..values.len()).filter(|&sample| values[sample] > 0).collect();
    let mut changes = Vec::new();
    // The page counts joins with 16 bits, of which no decomposition comes near.
    for (join, joint) in (0..u16::MAX).zip(joints) {
        let found: Vec<f64> =
            left.par_iter().map(|&sample| distance(joint, sample, distances[sample])).collect();
        for (&sample, found) in left.iter().zip(found) {
            let value = byte(found, most);
            if value < byte(distances[sample], most) {
                changes.push(Change { join, sample: sample as u32, value });
            }
            distances[sample] = found;
        }
        left.retain(|&sample| byte(distances[sample], most) > 0);
    }
    Ok(Uncovered { most, values, changes })
}

/// Points in the box. Shares scatter by less than half a percent.
const POINTS: usize = 1 << 16;

/// 1/φ, 1/φ² and 1/φ³ for the root φ of x⁴ = x + 1: fractions of their multiples fill the unit cube
/// evenly (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
const STEPS: Vector =
    Vector::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);

/// For each state, from all leaves down to one hull, the volume of intersection over union of the
/// solid and the hulls, by points in the joint bounding box. Each point is tested once against each
/// hull. `parts` are the leaves, then the joint hulls.
pub(super) fn overlaps(
    parts: &[MeasuredHulls],
    leaves: usize,
    joined: &[[usize; 2]],
    subject: &Subject<'_>,
) -> Vec<f64> {
    let surface = subject.mesh.closed().mesh.positions.iter();
    let (mut min, mut max) = bounds(surface.map(|&point| Vector::from(point)));
    for part in parts {
        let Bounds { min: low, max: high } = part.bounds();
        (min, max) = (min.min(low.into()), max.max(high.into()));
    }
    let point =
        |index: usize| min + (Vector::splat(0.5) + index as f64 * STEPS).fract() * (max - min);
    let points: Vec<[f64; 3]> = (0..POINTS).map(|index| point(index).to_array()).collect();
    let is_in_solid = points.par_iter().map(|&point| subject.mesh.contains(point)).collect();
    let (leaves, joints) = parts.split_at(leaves.min(parts.len()));
    let members = leaves.par_iter().map(|part| {
        let held = (0..).zip(&points).filter(|&(_, &point)| part.contains(point));
        held.map(|(index, _)| index).collect()
    });
    let mut members: Vec<Vec<u32>> = members.collect();

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
        let is_held = is_in_child.par_iter().zip(&points);
        let is_held: Vec<bool> =
            is_held.map(|(&is_in_child, &point)| is_in_child || joint.contains(point)).collect();
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
