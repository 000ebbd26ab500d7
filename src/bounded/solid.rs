//! The solid that hulls must not stand out of, and the fit test: whether a hull's surface stays
//! within the bound of it.
//!
//! Distance is 1-Lipschitz. So one query at the centre of a face of circumradius r decides it
//! where the distance d there is far enough from the bound ε: `d + r ≤ ε` accepts; outside of the
//! solid `d > ε` rejects; inside of it `r - d ≤ ε` accepts, since the surface must be crossed to
//! come out. Otherwise the face is halved.
//!
//! The same property lets a query be answered by an earlier one nearby: answers are kept for the
//! centres of the cells of a grid, and only where they leave a doubt is the field asked itself.
//! A cell's content depends on nothing but the cell, so threads may fill it in any order.

use std::sync::OnceLock;

use crate::field::Field;
use crate::vector::{Vector, add, distance, maximum, minimum, scale, subtract};

/// A face smaller than this share of the bound is decided by its centre.
const SMALL: f64 = 0.125;

/// Most cells of the grid.
const MOST_CELLS: f64 = 150_000.0;

#[derive(Debug, Clone, Copy)]
struct Cell {
    closest: [f32; 3],
    distance: f32,
    inside: bool,
}

/// What is known about a point.
struct Probe {
    lower: f64,
    upper: f64,
    /// Valid if `lower` is positive.
    inside: bool,
}

/// The source mesh as a solid.
pub(crate) struct Solid {
    pub field: Field,
    /// Whether the surface encloses the inside: only then does being inside say anything.
    pub is_closed: bool,
    origin: Vector,
    size: f64,
    dimensions: [usize; 3],
    cells: Vec<OnceLock<Cell>>,
}

impl Solid {
    pub fn new(positions: &[Vector], triangles: &[[u32; 3]], is_closed: bool, bound: f64) -> Self {
        let field = Field::new(positions, triangles);
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &p in positions {
            min = minimum(min, p);
            max = maximum(max, p);
        }
        let extent = [0, 1, 2].map(|k| (max[k] - min[k]).max(1e-6));
        let mut size = bound * 0.577;
        loop {
            let cells: f64 = extent.iter().map(|e| (e / size).ceil() + 1.0).product();
            if cells <= MOST_CELLS {
                break;
            }
            size *= 1.1;
        }
        let dimensions = extent.map(|e| (e / size).ceil() as usize + 1);
        let count: usize = dimensions.iter().product();
        let mut cells = Vec::new();
        cells.resize_with(count, OnceLock::new);
        let origin = [0, 1, 2].map(|k| {
            0.5 * (min[k] + max[k]) - 0.5 * size * dimensions[k] as f64
        });
        Self { field, is_closed, origin, size, dimensions, cells }
    }

    #[inline]
    fn probe(&self, point: Vector) -> Probe {
        let place = [0, 1, 2].map(|k| {
            let x = ((point[k] - self.origin[k]) / self.size).max(0.0) as usize;
            x.min(self.dimensions[k] - 1)
        });
        let index = (place[2] * self.dimensions[1] + place[1]) * self.dimensions[0] + place[0];
        let centre = [0, 1, 2].map(|k| self.origin[k] + (place[k] as f64 + 0.5) * self.size);
        let cell = self.cells[index].get_or_init(|| self.cell(centre));
        let away = distance(point, centre);
        let closest = cell.closest.map(f64::from);
        Probe {
            lower: f64::from(cell.distance) - away,
            upper: distance(point, closest) + 1e-7,
            inside: cell.inside,
        }
    }

    #[cold]
    fn cell(&self, centre: Vector) -> Cell {
        let Some(closest) = self.field.distance(centre, f64::INFINITY) else {
            return Cell { closest: [0.0; 3], distance: 0.0, inside: false };
        };
        // Nearer ones give no positive lower bound for points of the cell, unless those are nearer
        // to the centre.
        let inside = closest.distance > 0.5 * self.size && self.field.is_inside(centre);
        let distance = if closest.distance > 0.5 * self.size { closest.distance } else { 0.0 };
        Cell { closest: closest.point.map(|x| x as f32), distance: distance as f32 * (1.0 - 1e-6), inside }
    }

    /// Whether the point is in the solid or at most `bound` away from it.
    #[inline]
    pub fn holds(&self, point: Vector, bound: f64) -> bool {
        let probe = self.probe(point);
        if probe.upper <= bound {
            return true;
        }
        if probe.lower > 0.0 && (probe.inside || probe.lower > bound) {
            return probe.inside;
        }
        self.field.is_within(point, bound) || self.field.is_inside(point)
    }

    /// Whether the centre of a face is in the solid or at most `bound` away from it.
    pub fn centre_fits(&self, [a, b, c]: [Vector; 3], bound: f64) -> bool {
        self.holds(scale(add(add(a, b), c), 1.0 / 3.0), bound)
    }

    /// Whether some points between two of the solid are farther than `bound` from it.
    pub fn separates(&self, a: Vector, b: Vector, bound: f64) -> bool {
        let at = |share: f64| add(scale(a, 1.0 - share), scale(b, share));
        [0.5, 0.25, 0.75].into_iter().any(|share| !self.holds(at(share), bound))
    }

    /// Whether no point of the triangle is farther than `bound` from the solid.
    pub fn face_fits(&self, face: [Vector; 3], bound: f64, stack: &mut Vec<[Vector; 3]>) -> bool {
        stack.clear();
        stack.push(face);
        while let Some([a, b, c]) = stack.pop() {
            let centre = scale(add(add(a, b), c), 1.0 / 3.0);
            let radius = distance(centre, a).max(distance(centre, b)).max(distance(centre, c));
            let probe = self.probe(centre);
            if probe.upper + radius <= bound {
                continue;
            }
            if probe.lower > 0.0 {
                if probe.inside {
                    if self.is_closed && radius - probe.lower <= bound {
                        continue;
                    }
                } else if probe.lower > bound {
                    return false;
                }
            }
            let mut is_in = probe.upper <= bound || (probe.lower > 0.0 && probe.inside);
            if !is_in {
                is_in = self.field.is_within(centre, bound) || self.field.is_inside(centre);
                if !is_in {
                    return false;
                }
            }
            if radius <= SMALL * bound {
                continue;
            }
            let (ab, bc, ca) = (square(a, b), square(b, c), square(c, a));
            if ab >= bc && ab >= ca {
                let m = scale(add(a, b), 0.5);
                stack.push([a, m, c]);
                stack.push([m, b, c]);
            } else if bc >= ca {
                let m = scale(add(b, c), 0.5);
                stack.push([a, b, m]);
                stack.push([a, m, c]);
            } else {
                let m = scale(add(c, a), 0.5);
                stack.push([a, b, m]);
                stack.push([m, b, c]);
            }
        }
        true
    }
}

#[inline]
fn square(a: Vector, b: Vector) -> f64 {
    crate::vector::length_squared(subtract(a, b))
}
