//! Largest distances between a mesh and hulls by brute force: every distance is the least over all
//! triangles, and the inside is where the winding number, summed over all triangles, says so. It
//! shares no code with the crate.
//!
//! A face is sampled at the centres of its parts, which are divided until none can hold a distance
//! that is larger than the largest sample by more than a tolerance.

use std::rc::Rc;

use hullwright::Hull;

use crate::shapes::Mesh;

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn middle(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
}

/// A triangle, with a ball around it that tells most triangles apart from the nearest.
pub struct Triangle {
    corners: [Point; 3],
    centre: Point,
    radius: f64,
}

impl Triangle {
    fn new(corners: [Point; 3]) -> Self {
        let centre = [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
        let radius = corners.iter().map(|&corner| norm(minus(corner, centre))).fold(0.0, f64::max);
        Self { corners, centre, radius }
    }

    fn quarters(&self) -> [Self; 4] {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(Self::new)
    }

    /// No point of it is nearer than this.
    fn least_distance(&self, point: Point) -> f64 {
        norm(minus(point, self.centre)) - self.radius
    }

    /// The distance to a point: to the inside where the point is above it, else to an edge.
    fn distance(&self, point: Point) -> f64 {
        let [a, b, c] = self.corners;
        let normal = cross(minus(b, a), minus(c, a));
        let edges = [(a, b), (b, c), (c, a)];
        let is_above = edges
            .iter()
            .all(|&(from, to)| dot(cross(normal, minus(to, from)), minus(point, from)) >= 0.0);
        let area = norm(normal);
        if is_above && area > 0.0 {
            return (dot(normal, minus(point, a)) / area).abs();
        }
        let to_edge = |&(from, to): &(Point, Point)| {
            let (along, offset) = (minus(to, from), minus(point, from));
            let squared = dot(along, along);
            let share =
                if squared > 0.0 { (dot(offset, along) / squared).clamp(0.0, 1.0) } else { 0.0 };
            norm([0, 1, 2].map(|k| offset[k] - share * along[k]))
        };
        edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
    }

    /// The solid angle under which a point sees it, positive from inside (van Oosterom and
    /// Strackee).
    fn solid_angle(&self, point: Point) -> f64 {
        let [a, b, c] = self.corners.map(|corner| minus(corner, point));
        let lengths = [a, b, c].map(norm);
        let below = lengths[0] * lengths[1] * lengths[2]
            + dot(a, b) * lengths[2]
            + dot(b, c) * lengths[0]
            + dot(c, a) * lengths[1];
        2.0 * dot(a, cross(b, c)).atan2(below)
    }
}

pub fn triangles(mesh: &Mesh) -> Vec<Triangle> {
    let (positions, indices) = mesh;
    let corners = indices.iter().map(|triangle| triangle.map(|v| positions[v as usize]));
    corners.map(Triangle::new).collect()
}

fn faces(hull: &Hull) -> Vec<Triangle> {
    triangles(&(hull.shape.points.clone(), hull.shape.triangles.clone()))
}

fn distance_to<'a>(triangles: impl IntoIterator<Item = &'a Triangle>, point: Point) -> f64 {
    triangles.into_iter().fold(f64::INFINITY, |least, triangle| {
        let may_be_nearer = triangle.least_distance(point) < least;
        if may_be_nearer { least.min(triangle.distance(point)) } else { least }
    })
}

/// Whether a point is inside a surface, whichever way that is oriented. Where it is open, both
/// sides of a sheet are outside.
fn is_inside(surface: &[Triangle], point: Point) -> bool {
    let angle: f64 = surface.iter().map(|triangle| triangle.solid_angle(point)).sum();
    angle.abs() / (4.0 * std::f64::consts::PI) > 0.52
}

/// A part of a hull's face, with the triangles of the solid that can be nearest to any of it.
struct Part<'a> {
    face: Triangle,
    near: Rc<Vec<&'a Triangle>>,
    /// On which side its centre is, where that is known.
    is_inside: Option<bool>,
}

impl<'a> Part<'a> {
    fn all(hull: &Hull, solid: &'a [Triangle]) -> Vec<Self> {
        let near = Rc::new(solid.iter().collect());
        let part = |face| Part { face, near: Rc::clone(&near), is_inside: None };
        faces(hull).into_iter().map(part).collect()
    }

    /// `distance` is that of its centre, on the side `is_inside`.
    fn quarters(self, distance: f64, is_inside: bool) -> impl Iterator<Item = Self> {
        let Self { face, near, .. } = self;
        let reach = distance + 2.0 * face.radius;
        let can_be_nearest =
            |triangle: &&&Triangle| triangle.least_distance(face.centre) <= reach * (1.0 + 1e-9);
        let near: Rc<Vec<_>> = Rc::new(near.iter().filter(can_be_nearest).copied().collect());
        let centre = face.centre;
        face.quarters().into_iter().map(move |face| {
            // The side changes at the surface only.
            let is_same_side = norm(minus(face.centre, centre)) < distance * (1.0 - 1e-9);
            Self { face, near: Rc::clone(&near), is_inside: is_same_side.then_some(is_inside) }
        })
    }
}

/// The largest sampled distance of a hull's surface outside a solid, which is closed. The true one
/// is larger by at most `tolerance`. What is below `floor` is not looked for.
pub fn protrusion(hull: &Hull, solid: &[Triangle], floor: f64, tolerance: f64) -> f64 {
    let (mut largest, mut parts) = (floor, Part::all(hull, solid));
    while let Some(part) = parts.pop() {
        let (centre, radius) = (part.face.centre, part.face.radius);
        let distance = distance_to(part.near.iter().copied(), centre);
        // Distances, and depths, change by no more than the way that is gone.
        if distance <= largest && distance + radius <= largest + tolerance {
            continue;
        }
        let is_inside = part.is_inside.unwrap_or_else(|| is_inside(solid, centre));
        if !is_inside {
            largest = largest.max(distance);
        }
        let height = if is_inside { -distance } else { distance };
        if height + radius > largest + tolerance {
            parts.extend(part.quarters(distance, is_inside));
        }
    }
    largest
}

/// The largest distance of a hull's surface outside an open surface, at samples that are `spacing`
/// apart.
pub fn sampled_protrusion(hull: &Hull, surface: &[Triangle], floor: f64, spacing: f64) -> f64 {
    let (mut largest, mut parts) = (floor, faces(hull));
    while let Some(part) = parts.pop() {
        if part.radius > spacing {
            parts.extend(part.quarters());
            continue;
        }
        let distance = distance_to(surface, part.centre);
        if distance > largest && !is_inside(surface, part.centre) {
            largest = distance;
        }
    }
    largest
}

/// A hull as planes that face outward, and faces, with a ball around it.
struct Convex {
    planes: Vec<(Point, f64)>,
    faces: Vec<Triangle>,
    centre: Point,
    radius: f64,
}

impl Convex {
    fn new(hull: &Hull) -> Self {
        let faces = faces(hull);
        let planes = faces.iter().map(|face| {
            let [a, b, c] = face.corners;
            let normal = cross(minus(b, a), minus(c, a));
            (normal, dot(normal, a))
        });
        let planes = planes.collect();
        let centre = faces[0].centre;
        let far = |face: &Triangle| norm(minus(face.centre, centre)) + face.radius;
        let radius = faces.iter().map(far).fold(0.0, f64::max);
        Self { planes, faces, centre, radius }
    }

    /// No point of it is nearer than this.
    fn least_distance(&self, point: Point) -> f64 {
        norm(minus(point, self.centre)) - self.radius
    }

    /// The distance of a point outside the hull.
    fn outside(&self, point: Point) -> f64 {
        let is_inside = self.planes.iter().all(|&(normal, offset)| dot(normal, point) <= offset);
        if is_inside { 0.0 } else { distance_to(&self.faces, point) }
    }
}

/// The largest sampled distance of a surface outside all hulls. The true one is larger by at most
/// `tolerance`.
pub fn uncovered(surface: Vec<Triangle>, hulls: &[Hull], tolerance: f64) -> f64 {
    let hulls: Vec<Convex> = hulls.iter().map(Convex::new).collect();
    let (mut largest, mut parts) = (0.0_f64, surface);
    while let Some(part) = parts.pop() {
        // Distances to a hull are convex: on a part they are largest at a corner.
        let (mut most, mut sample) = (f64::INFINITY, f64::INFINITY);
        for hull in &hulls {
            if most <= largest {
                break;
            }
            if hull.least_distance(part.corners[0]) < most {
                let corners = part.corners.map(|corner| hull.outside(corner));
                most = most.min(corners.into_iter().fold(0.0, f64::max));
            }
        }
        if most <= largest {
            continue;
        }
        for hull in &hulls {
            if hull.least_distance(part.centre) < sample {
                sample = sample.min(hull.outside(part.centre));
            }
        }
        largest = largest.max(sample);
        if most > largest + tolerance && sample + part.radius > largest + tolerance {
            parts.extend(part.quarters());
        }
    }
    largest
}
