//! Volume, first and second moments of solids, and the mass properties that follow from them.

use super::{MassProperties, MassSource};
use crate::geometry::vector::{Vector, add, cross, cubed, dot, scale, squared};

/// Integrals over a solid of 1, of x, and of the products of two coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Moments {
    pub volume: f64,
    pub first: Vector,
    pub second: [Vector; 3],
}

impl Moments {
    /// What closed, outward-oriented triangles enclose, by the divergence theorem: the signed
    /// tetrahedra between each triangle and the origin. O(triangles).
    pub fn enclosed(corners: impl Iterator<Item = [Vector; 3]>) -> Self {
        let mut sum = Self::default();
        for [a, b, c] in corners {
            let six_volumes = dot(a, cross(b, c));
            let total = add(add(a, b), c);
            sum.volume += six_volumes / 6.0;
            sum.first = add(sum.first, scale(total, six_volumes / 24.0));
            for i in 0..3 {
                for j in 0..3 {
                    let products = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + total[i] * total[j];
                    sum.second[i][j] += six_volumes / 120.0 * products;
                }
            }
        }
        sum
    }

    /// The mass properties of a solid whose coordinates were divided by `unit` after `origin` was
    /// taken off.
    pub fn mass_properties(
        &self,
        unit: f64,
        origin: Vector,
        density: f64,
        source: MassSource,
    ) -> MassProperties {
        let centre = scale(self.first, 1.0 / self.volume);
        let mut central = self.second;
        for i in 0..3 {
            for j in 0..3 {
                central[i][j] -= self.volume * centre[i] * centre[j];
            }
        }
        let mass = density * cubed(unit);
        MassProperties {
            mass: mass * self.volume,
            centre: add(scale(centre, unit), origin),
            inertia: inertia_of(central).map(|row| scale(row, mass * squared(unit))),
            source,
        }
    }
}

/// The inertia tensor of central second moments, and the other way round up to a factor of 2:
/// trace times identity, minus the matrix.
pub(super) fn inertia_of(second: [Vector; 3]) -> [Vector; 3] {
    let trace = second[0][0] + second[1][1] + second[2][2];
    let mut inertia = second.map(|row| scale(row, -1.0));
    for (i, row) in inertia.iter_mut().enumerate() {
        row[i] += trace;
    }
    inertia
}

/// The central second moments of an inertia tensor.
pub(super) fn second_of(inertia: [Vector; 3]) -> [Vector; 3] {
    let half_trace = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 2.0;
    let mut second = inertia.map(|row| scale(row, -1.0));
    for (i, row) in second.iter_mut().enumerate() {
        row[i] += half_trace;
    }
    second
}
