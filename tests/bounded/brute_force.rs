//! Largest distances between a mesh and hulls by brute force: every distance is the least over all
//! triangles, and the inside is where the winding number, summed over all triangles, says so. It
//! shares no code with the crate (see `oracle`).
//!
//! A face is sampled at the centres of its parts, which are divided until none can hold a distance
//! that is larger than the largest sample by more than a tolerance.

use std::rc::Rc;

use hullwright::Hull;

use crate::common::Mesh;
use crate::independent::oracle::{Convex, Triangle, distance_to, minus, norm, winding_number};

pub fn triangles((positions, indices): &Mesh) -> Vec<Triangle> {
    Triangle::all(positions, indices)
}

fn faces(hull: &Hull) -> Vec<Triangle> {
    Triangle::all(&hull.shape.points, &hull.shape.triangles)
}

/// Whether a point is inside a surface, whichever way that is oriented. Where it is open, both
/// sides of a sheet are outside.
fn is_inside(surface: &[Triangle], point: [f64; 3]) -> bool {
    winding_number(surface, point).abs() > 0.52
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

/// The largest sampled distance of a surface outside all hulls. The true one is larger by at most
/// `tolerance`.
pub fn uncovered(surface: Vec<Triangle>, hulls: &[Hull], tolerance: f64) -> f64 {
    let shapes = hulls.iter().map(|hull| &hull.shape);
    let hulls: Vec<Convex> =
        shapes.map(|shape| Convex::new(&shape.points, &shape.triangles)).collect();
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
