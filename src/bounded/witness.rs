//! Lower bounds on the protrusion of a joint hull that has not been built.
//!
//! A plane that touches two hulls, with both on one side, touches their joint hull along the bridge
//! between them. If a point of the bridge is far outside of the solid, the joint hull protrudes as
//! far. A point below the surface serves as well: the distance to the solid changes no faster than
//! the position, so its depth is subtracted. That makes each bound valid for all hulls that contain
//! the two, once the plane has moved.

use crate::geometry::vector::Vector;
use crate::solid::Solid;

/// A point outside of the solid, and the direction in which it is near to a joint hull's surface.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Witness {
    point: Vector,
    /// Of unit length.
    normal: Vector,
    /// No point of the solid is nearer.
    distance: f64,
}

/// Steps towards a plane that touches both hulls. Most bridges take two or three, and any plane
/// gives a valid bound.
const STEPS: usize = 4;

/// Shares of a bridge at which the distance to the solid is queried.
const MIDDLE: [f64; 1] = [0.5];
const ALONG: [f64; 3] = [0.5, 0.25, 0.75];

/// How many bridges are tried.
#[derive(Debug, Clone, Copy)]
pub(super) enum Effort {
    /// Four, at their middle: they rule out most pairs.
    Few,
    /// Twelve, at three points each: as long as a tenth of verifying a joint hull.
    Many,
}

impl Witness {
    /// The joint hull of two hulls protrudes at least as far. Negative if the witness is too deep in it.
    pub fn bound(&self, hulls: [&[Vector]; 2]) -> f64 {
        if self.distance == 0.0 {
            return 0.0;
        }
        let [a, b] = hulls.map(|points| support(points, self.normal));
        self.distance - (a.1.max(b.1) - self.normal.dot(self.point)).max(0.0)
    }
}

/// The witness with the greatest bound on the protrusion of the joint hull of two hulls, and that
/// bound; 0 if none is outside of the solid.
pub(super) fn find_witness(
    hulls: [&[Vector]; 2],
    centres: [Vector; 2],
    solid: &Solid,
    effort: Effort,
) -> (Witness, f64) {
    let (count, shares) = match effort {
        Effort::Few => (4, &MIDDLE[..]),
        Effort::Many => (12, &ALONG[..]),
    };
    let mut best = (Witness::default(), 0.0);
    let along = centres[1] - centres[0];
    let size = along.length();
    if size == 0.0 {
        return best;
    }
    let along = along * (1.0 / size);
    let axis = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).unwrap_or(0);
    let mut unit = Vector::ZERO;
    unit[axis] = 1.0;
    let first = along.cross(unit).normalize_or_zero();
    let second = along.cross(first);
    for index in 0..count {
        let angle = std::f64::consts::TAU * f64::from(index) / f64::from(count);
        let across = first * libm::cos(angle) + second * libm::sin(angle);
        let Some((normal, [from, to])) = bridge(hulls, across, along) else { continue };
        for &share in shares {
            let point = from + (to - from) * share;
            let Some(distance) = solid.outside(point, best.1) else { continue };
            if distance.lower <= best.1 {
                continue;
            }
            let witness = Witness { point, normal, distance: distance.lower };
            let bound = witness.bound(hulls);
            if bound > best.1 {
                best = (witness, bound);
            }
        }
    }
    best
}

/// The unit normal of a plane that touches both hulls, near `across`, and a vertex of each on it.
fn bridge(hulls: [&[Vector]; 2], across: Vector, along: Vector) -> Option<(Vector, [Vector; 2])> {
    let mut normal = across;
    let mut ends = hulls.map(|points| support(points, normal).0);
    for _ in 0..STEPS {
        let gap = ends[1] - ends[0];
        let advance = gap.dot(along);
        if advance <= 0.0 {
            return None;
        }
        normal = across - along * (gap.dot(across) / advance);
        let last = std::mem::replace(&mut ends, hulls.map(|points| support(points, normal).0));
        if ends == last {
            break;
        }
    }
    Some((normal.normalize_or_zero(), ends))
}

/// The farthest point in a direction, and how far it is.
fn support(points: &[Vector], direction: Vector) -> (Vector, f64) {
    let mut best = (Vector::ZERO, f64::NEG_INFINITY);
    for &point in points {
        let height = point.dot(direction);
        if height > best.1 {
            best = (point, height);
        }
    }
    best
}
