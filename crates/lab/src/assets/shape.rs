//! Triangles and how to make them: boxes, prisms, lathes, tubes.
//!
//! Coordinates are metres, y is up. Every shape is welded: a vertex is one place.

use std::collections::BTreeMap;

pub type Point = crate::shapes::Vector;

/// Places are rounded to a micrometre, so that the last bit of a sine cannot change a file.
const RESOLUTION: f64 = 1e6;

/// Vertices, triangles, and for each triangle the number of its material.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shape {
    pub positions: Vec<Point>,
    pub triangles: Vec<[u32; 3]>,
    pub materials: Vec<usize>,
}

impl Shape {
    /// Welds corners that share a place and drops triangles that vanish by it.
    pub fn from_corners(corners: impl IntoIterator<Item = [Point; 3]>) -> Self {
        let mut shape = Self::default();
        let mut places = BTreeMap::new();
        for triangle in corners {
            let [a, b, c] = triangle.map(|corner| {
                let place = corner.to_array().map(|value| (value * RESOLUTION).round() as i64);
                *places.entry(place).or_insert_with(|| {
                    shape.positions.push(place.map(|steps| steps as f64 / RESOLUTION).into());
                    shape.positions.len() as u32 - 1
                })
            });
            if a != b && b != c && c != a {
                shape.triangles.push([a, b, c]);
                shape.materials.push(0);
            }
        }
        shape
    }

    pub fn corners(&self) -> impl Iterator<Item = [Point; 3]> {
        let place = |index: u32| self.positions[index as usize];
        self.triangles.iter().map(move |triangle| triangle.map(place))
    }

    /// Positive if the triangles of a closed shape are wound counter-clockwise seen from outside.
    pub fn volume(&self) -> f64 {
        self.corners().map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// Turns a closed shape's triangles so that they face outward.
    pub fn outward(mut self) -> Self {
        if self.volume() < 0.0 {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        self
    }

    /// Adds another shape without joining the two.
    pub fn with(mut self, other: Self) -> Self {
        let offset = self.positions.len() as u32;
        let shifted = other.triangles.iter().map(|triangle| triangle.map(|index| index + offset));
        self.triangles.extend(shifted);
        self.positions.extend(other.positions);
        self.materials.extend(other.materials);
        self
    }

    pub fn map(mut self, place: impl Fn(Point) -> Point) -> Self {
        for position in &mut self.positions {
            *position = (place(*position) * RESOLUTION).round() / RESOLUTION;
        }
        self
    }

    /// Least and greatest coordinates.
    pub fn bounds(&self) -> (Point, Point) {
        let nothing = (Point::INFINITY, Point::NEG_INFINITY);
        self.positions.iter().fold(nothing, |(low, high), &place| (low.min(place), high.max(place)))
    }

    /// Stands it on the ground, centred above the origin.
    pub fn grounded(self) -> Self {
        let (min, max) = self.bounds();
        let middle = (min + max) * 0.5;
        self.map(|place| place - middle.with_y(min.y))
    }
}

fn centroid(points: &[Point]) -> Point {
    points.iter().sum::<Point>() * (1.0 / points.len() as f64)
}

/// Two triangles, split along the shorter diagonal.
fn quad([a, b, c, d]: [Point; 4]) -> [[Point; 3]; 2] {
    // A tie must not be decided by rounding.
    const TIE: f64 = 1.0 + 1e-9;
    if a.distance(c) <= b.distance(d) * TIE {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    }
}

/// Quads between rings of equally many points; `around` closes each ring, `along` joins the last
/// to the first.
pub fn skin(rings: &[Vec<Point>], along: bool, around: bool) -> Vec<[Point; 3]> {
    let mut corners = Vec::new();
    for (index, ring) in rings.iter().enumerate() {
        let Some(next) = rings.get(index + 1).or(rings.first().filter(|_| along)) else {
            break;
        };
        let count = if around { ring.len() } else { ring.len() - 1 };
        for point in 0..count {
            let other = (point + 1) % ring.len();
            corners.extend(quad([ring[point], ring[other], next[other], next[point]]));
        }
    }
    corners
}

/// A profile, radii and heights in turn, about the y axis. It starts and ends on the axis, so the
/// result is closed. `bands` gives the material of each piece of the profile.
pub fn lathe(profile: &[f64], segments: usize, bands: impl Fn(usize) -> usize) -> Shape {
    let angle =
        |segment: usize| std::f64::consts::TAU * (segment % segments) as f64 / segments as f64;
    let mut corners = Vec::new();
    let mut materials = Vec::new();
    for (band, ends) in profile.as_chunks::<2>().0.windows(2).enumerate() {
        let rings: Vec<Vec<Point>> = (0..segments)
            .map(|segment| {
                let (sine, cosine) = angle(segment).sin_cos();
                ends.iter().map(|[r, y]| Point::new(r * cosine, *y, r * sine)).collect()
            })
            .collect();
        let band_corners = Shape::from_corners(skin(&rings, true, false));
        materials.extend(vec![bands(band); band_corners.triangles.len()]);
        corners.extend(band_corners.corners());
    }
    let shape = Shape { materials, ..Shape::from_corners(corners) };
    shape.outward()
}

/// Points on a Catmull-Rom curve through `controls`, `steps` per piece.
pub fn curve(controls: &[Point], steps: usize) -> Vec<Point> {
    let control = |index: isize| {
        let last = controls.len() as isize - 1;
        controls[index.clamp(0, last) as usize]
    };
    let mut points = Vec::new();
    for piece in 0..controls.len() as isize - 1 {
        let [a, b, c, d] = [-1, 0, 1, 2].map(|offset| control(piece + offset));
        for step in 0..steps {
            let t = step as f64 / steps as f64;
            let cubic = (3.0 * b - 3.0 * c + d - a) * t.powi(3);
            let square = (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t;
            points.push(b + 0.5 * (cubic + square + (c - a) * t));
        }
    }
    points.extend(controls.last());
    points
}

/// A closed tube along a path, with an elliptical section of `sides` corners. `reference` is
/// across the path everywhere; `half_size` gives the half axes at a share of the path: square to
/// `reference`, and along it.
pub fn tube(
    path: &[Point],
    sides: usize,
    reference: Point,
    half_size: impl Fn(f64) -> [f64; 2],
) -> Shape {
    let last = path.len() - 1;
    let ring = |index: usize| -> Vec<Point> {
        let tangent = path[(index + 1).min(last)] - path[index.saturating_sub(1)];
        let side = reference.cross(tangent).normalize_or_zero();
        let other = tangent.cross(side).normalize_or_zero();
        let [a, b] = half_size(index as f64 / last as f64);
        (0..sides)
            .map(|corner| {
                let angle = std::f64::consts::TAU * (corner as f64 + 0.5) / sides as f64;
                path[index] + (side * (a * angle.cos()) + other * (b * angle.sin()))
            })
            .collect()
    };
    let rings: Vec<Vec<Point>> = (0..=last).map(ring).collect();
    let mut corners = skin(&rings, false, true);
    for (ring, at_end) in [(&rings[0], false), (&rings[last], true)] {
        let middle = centroid(ring);
        for corner in 0..sides {
            let (a, b) = (ring[corner], ring[(corner + 1) % sides]);
            corners.push(if at_end { [middle, a, b] } else { [middle, b, a] });
        }
    }
    Shape::from_corners(corners).outward()
}

/// A simple outline in x and y, counter-clockwise, pushed along z: the fewest triangles that it
/// can have.
pub fn prism(outline: &[[f64; 2]], depth: f64) -> Shape {
    let place = |index: usize, z: f64| Point::new(outline[index][0], outline[index][1], z);
    let mut corners = Vec::new();
    for [a, b, c] in clip_ears(outline) {
        corners.push([place(a, 0.0), place(c, 0.0), place(b, 0.0)]);
        corners.push([place(a, depth), place(b, depth), place(c, depth)]);
    }
    for index in 0..outline.len() {
        let next = (index + 1) % outline.len();
        let side = [place(index, 0.0), place(next, 0.0), place(next, depth), place(index, depth)];
        corners.extend(quad(side));
    }
    Shape::from_corners(corners).outward()
}

/// Triangles of a simple counter-clockwise polygon.
fn clip_ears(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let turn = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [a, b, c].map(|index| outline[index]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let count = left.len();
        let ear = (0..count).find(|ear| {
            let [a, b, c] = [count - 1, 0, 1].map(|step| left[(ear + step) % count]);
            let holds =
                |p: &usize| turn(a, b, *p) >= 0.0 && turn(b, c, *p) >= 0.0 && turn(c, a, *p) >= 0.0;
            let others = left.iter().filter(|p| ![a, b, c].contains(p));
            turn(a, b, c) > 0.0 && !others.clone().any(holds)
        });
        let ear = ear.expect("a simple polygon has an ear");
        triangles.push([count - 1, 0, 1].map(|step| left[(ear + step) % count]));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// The surface of the filled cells of a grid, in one piece where cells touch.
pub fn cells(planes: [&[f64]; 3], filled: impl Fn([usize; 3]) -> bool) -> Shape {
    let counts = planes.map(|planes| planes.len() - 1);
    let is_filled = |cell: [isize; 3]| {
        let inside = (0..3).all(|axis| (0..counts[axis] as isize).contains(&cell[axis]));
        inside && filled(cell.map(|index| index as usize))
    };
    let mut corners = Vec::new();
    for x in 0..counts[0] as isize {
        for y in 0..counts[1] as isize {
            for z in 0..counts[2] as isize {
                let cell = [x, y, z];
                if !is_filled(cell) {
                    continue;
                }
                for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
                    let mut neighbour = cell;
                    neighbour[axis] += 2 * side - 1;
                    if is_filled(neighbour) {
                        continue;
                    }
                    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut face = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[s, t]| {
                        let mut corner = cell;
                        corner[axis] += side;
                        corner[second] += s;
                        corner[third] += t;
                        Point::from_array([0, 1, 2].map(|axis| planes[axis][corner[axis] as usize]))
                    });
                    if side == 0 {
                        face.reverse();
                    }
                    corners.extend(quad(face));
                }
            }
        }
    }
    Shape::from_corners(corners)
}
