//! Openings that no ball passes, in surfaces that are there both ways round.
//!
//! Where faces are there both ways round, nothing but its openings says whether a surface is a sheet or the skin
//! of a solid. An opening counts as closed if no ball passes whose radius is the bound, and if a cap there
//! has an enclosed region behind it: so a missing triangle changes nothing. What is wider follows
//! the rules of `decide`.
//!
//! Where all of a cap is within the radius of its rim, no ball crosses it: its centre would come too near to the rim.

use super::cap::{Cap, LoopFill, fill_loops};
use super::decide::{Closing, OpeningSettings, SHEET_ANGLE};
use super::opening::{Loop, Opening, OpeningOutcome, boundary_loops, sides};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, centre};
use crate::mesh::PreparedMesh;
use crate::mesh::regions::Regions;

/// A rim with more sides is not looked at, since each side is compared with each triangle of its cap.
const MOST_SIDES: usize = 2000;

/// A part of a cap that is smaller than this, as a fraction of the radius, is as near to the rim as its centre.
const LEAST_PART: f64 = 0.02;

/// Closes the openings that no ball passes; `None` where there are none. Linear time where nothing is there both ways round.
pub(super) fn close_narrow(
    prepared: &PreparedMesh,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Option<Closing>, Error> {
    if !prepared.is_both_ways.contains(&true) {
        return Ok(None);
    }
    let PreparedMesh { mesh, components, is_both_ways, .. } = prepared;
    let radius = settings.flatness_in(prepared);
    let loops = boundary_loops(mesh.points(), &mesh.triangles);
    let is_of_both_ways = |triangle: u32| is_both_ways[triangle as usize];
    let (mut triangles, mut caps) = (Vec::new(), Vec::new());
    for fill in fill_loops(mesh.points(), &loops, radius) {
        control.check()?;
        match fill {
            LoopFill::Crack { triangles: zip, .. } => triangles.extend(zip),
            LoopFill::Cap(cap)
                if cap.is_most_of_rim(mesh, &loops, is_of_both_ways)
                    && cap.rim_angle(mesh, &loops) >= SHEET_ANGLE
                    && is_narrow(&cap, mesh.points(), &loops, radius) =>
            {
                caps.push(cap);
            }
            _ => {}
        }
    }
    if caps.is_empty() {
        return Ok(None);
    }
    let mut has_both_ways = vec![false; prepared.closed.len()];
    for (&component, &both_ways) in components.iter().zip(is_both_ways) {
        has_both_ways[component as usize] |= both_ways;
    }
    let of_components = mesh.triangles.iter().zip(components);
    let own = of_components.filter(|&(_, &component)| has_both_ways[component as usize]);
    let mut all: Vec<[u32; 3]> = own.map(|(&triangle, _)| triangle).collect();
    all.extend(&triangles);
    let first = all.len();
    all.extend(caps.iter().flat_map(|cap| &cap.triangles));
    let regions = Regions::new(mesh.points(), &all);
    let mut openings = Vec::new();
    let mut start = first;
    for cap in &caps {
        let own = start..start + cap.triangles.len();
        start = own.end;
        if own.into_iter().all(|triangle| regions.closes(triangle)) {
            triangles.extend(&cap.triangles);
            let vertices = cap.loops.iter().flat_map(|&index| &loops[index].vertices);
            let outcome = OpeningOutcome::Closed;
            openings.push(Opening::new(vertices.copied(), cap.area, prepared, outcome));
        }
    }
    let closing = Closing { triangles, hidden: Vec::new(), openings, are_both_ways: true };
    Ok((!closing.openings.is_empty()).then_some(closing))
}

fn is_narrow(cap: &Cap, positions: &[Vector], loops: &[Loop], radius: f64) -> bool {
    let own = cap.loops.iter().map(|&index| &loops[index]);
    let at = |vertex: u32| positions[vertex as usize];
    let rim: Vec<[Vector; 2]> =
        own.flat_map(|own| sides(&own.vertices).map(|(&a, &b)| [at(a), at(b)])).collect();
    let mut corners = cap.triangles.iter().map(|triangle| triangle.map(at));
    rim.len() <= MOST_SIDES && corners.all(|corners| is_near(corners, &rim, radius))
}

/// Whether all points of a triangle are within the radius of the rim.
fn is_near(corners: [Vector; 3], rim: &[[Vector; 2]], radius: f64) -> bool {
    let middle = centre(corners);
    let size = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let distances = rim.iter().map(|&side| distance_to_side(middle, side));
    let distance = distances.fold(f64::INFINITY, f64::min);
    if distance > radius {
        return false;
    }
    if distance + size <= radius || size <= LEAST_PART * radius {
        return true;
    }
    // Halved across its longest side.
    let length = |k: usize| corners[k].distance_squared(corners[(k + 1) % 3]);
    let longest = (1..3).fold(0, |a, b| if length(b) > length(a) { b } else { a });
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let halfway = (a + b) * 0.5;
    is_near([a, halfway, c], rim, radius) && is_near([halfway, b, c], rim, radius)
}

fn distance_to_side(point: Vector, [a, b]: [Vector; 2]) -> f64 {
    let along = b - a;
    let share = along.dot(point - a) / along.length_squared();
    point.distance(a + along * share.clamp(0.0, 1.0))
}
