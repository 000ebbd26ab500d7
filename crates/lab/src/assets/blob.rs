//! Smooth bodies: limbs that flow into each other, meshed by surface nets.

use std::collections::BTreeMap;

use super::shape::{Point, Shape};

/// A capsule whose radius changes from one end to the other.
#[derive(Debug, Clone, Copy)]
pub struct Limb {
    pub from: Point,
    pub to: Point,
    pub radii: [f64; 2],
}

/// Limbs that blend into each other over a distance.
#[derive(Debug)]
pub struct Blob {
    pub limbs: Vec<Limb>,
    pub blend: f64,
}

impl Limb {
    fn distance(&self, point: Point) -> f64 {
        let (axis, offset) = (self.to - self.from, point - self.from);
        let share = (offset.dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        (offset - axis * share).length() - radius
    }
}

impl Blob {
    /// Negative inside.
    fn value(&self, point: Point) -> f64 {
        let distances = self.limbs.iter().map(|limb| limb.distance(point));
        distances.fold(f64::INFINITY, |a, b| {
            // Quadratic smooth minimum.
            let overlap = (self.blend - (a - b).abs()).max(0.0);
            a.min(b) - 0.25 * overlap * overlap / self.blend
        })
    }

    fn gradient(&self, point: Point) -> Point {
        const STEP: f64 = 1e-4;
        Point::from_array([Point::X, Point::Y, Point::Z].map(|axis| {
            let step = axis * STEP;
            (self.value(point + step) - self.value(point - step)) / (2.0 * STEP)
        }))
    }

    fn project(&self, point: Point) -> Point {
        let gradient = self.gradient(point);
        let slope = gradient.length_squared().max(1e-6);
        point - gradient * (self.value(point) / slope)
    }

    fn bounds(&self) -> (Point, Point) {
        let (mut min, mut max) = (Point::INFINITY, Point::NEG_INFINITY);
        for limb in &self.limbs {
            for (end, radius) in [(limb.from, limb.radii[0]), (limb.to, limb.radii[1])] {
                min = min.min(end - radius - self.blend);
                max = max.max(end + radius + self.blend);
            }
        }
        (min, max)
    }

    /// The surface with about one vertex per cell of the given size (Gibson, Constrained elastic
    /// surface nets, 1998): a vertex in each cell that the surface crosses, a quad across each
    /// crossed grid edge.
    pub fn surface(&self, cell: f64) -> Shape {
        let (min, max) = self.bounds();
        let counts = ((max - min) / cell).ceil().to_array().map(|count| count as usize + 2);
        let size = Point::from_array(counts.map(|count| (count - 1) as f64));
        // Centred, so that a mirrored body gets a mirrored mesh.
        let start = 0.5 * (min + max - cell * size);
        let place = |node: [usize; 3]| start + cell * Point::from_array(node.map(|n| n as f64));
        let mut values = BTreeMap::new();
        for x in 0..counts[0] {
            for y in 0..counts[1] {
                for z in 0..counts[2] {
                    values.insert([x, y, z], self.value(place([x, y, z])));
                }
            }
        }
        let mut crossings: BTreeMap<[usize; 3], Vec<Point>> = BTreeMap::new();
        let mut quads = Vec::new();
        for (node, value) in &values {
            for axis in 0..3 {
                let mut end = *node;
                end[axis] += 1;
                let Some(end_value) = values.get(&end) else {
                    continue;
                };
                if (*value < 0.0) == (*end_value < 0.0) {
                    continue;
                }
                let share = value / (value - end_value);
                let crossing = place(*node) + (place(end) - place(*node)) * share;
                let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut around = [[1, 1], [0, 1], [0, 0], [1, 0]].map(|[s, t]| {
                    let mut cell = *node;
                    cell[second] -= s;
                    cell[third] -= t;
                    cell
                });
                for cell in around {
                    crossings.entry(cell).or_default().push(crossing);
                }
                if *value >= 0.0 {
                    around.reverse();
                }
                quads.push(around);
            }
        }
        let mut vertices: BTreeMap<[usize; 3], Point> = BTreeMap::new();
        for (cell, points) in crossings {
            let sum = points.iter().sum::<Point>();
            vertices.insert(cell, self.project(sum * (1.0 / points.len() as f64)));
        }
        for _ in 0..RELAXATIONS {
            vertices = self.relax(&vertices, &quads);
        }
        let corners = quads.iter().flat_map(|quad| {
            let [a, b, c, d] = quad.map(|cell| vertices[&cell]);
            let normal = |point| self.gradient(point).normalize_or_zero();
            let bend = |p: Point, q: Point| normal(p).dot(normal(q));
            if bend(a, c) >= bend(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        });
        Shape::from_corners(corners)
    }

    /// Moves each vertex to the middle of its neighbours and back onto the surface: even quads.
    fn relax(
        &self,
        vertices: &BTreeMap<[usize; 3], Point>,
        quads: &[[[usize; 3]; 4]],
    ) -> BTreeMap<[usize; 3], Point> {
        let mut sums: BTreeMap<[usize; 3], (Point, f64)> = BTreeMap::new();
        for quad in quads {
            for corner in 0..4 {
                let sum = sums.entry(quad[corner]).or_default();
                for neighbour in [quad[(corner + 1) % 4], quad[(corner + 3) % 4]] {
                    sum.0 += vertices[&neighbour];
                    sum.1 += 1.0;
                }
            }
        }
        let middle =
            |(cell, (sum, count)): (_, (Point, f64))| (cell, self.project(sum * (1.0 / count)));
        sums.into_iter().map(middle).collect()
    }
}

/// More would pull vertices out of thin limbs.
const RELAXATIONS: usize = 3;
