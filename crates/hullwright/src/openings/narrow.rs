//! Openings that no ball passes, in surfaces that are there both ways round.
//!
//! Where faces are there both ways round, nothing but its openings says whether a surface is a
//! sheet or the skin of a solid. An opening counts as closed if no ball passes whose radius is the
//! bound, and if a cap there closes a region: so a missing triangle changes nothing. What is wider
//! follows the rules of `decide`.
//!
//! Where all of a cap is within the radius of its rim, no ball crosses it: its centre would come
//! too near to the rim.

use super::cap::{LoopFill, fill_loops, zip_shortest};
use super::decide::{Closing, OpeningSettings, SHEET_ANGLE};
use super::opening::{Loop, Opening, OpeningOutcome, boundary_loops, sides};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{
    Vector, area_normal, centre, distance_to_segment, halves_of_triangle,
};
use crate::mesh::PreparedMesh;
use crate::mesh::regions::Regions;
use crate::sorting::sort_by_key;

/// A rim with more sides is not looked at, since each side is compared with each triangle of its
/// cap.
const MOST_SIDES: usize = 2000;

/// A part of a cap that is smaller than this, as a fraction of the radius, is as near to the rim as
/// its centre.
const LEAST_PART: f64 = 0.02;

/// Closes the openings that no ball passes; `None` where there are none. Linear time where nothing
/// is there both ways round.
pub(super) fn close_narrow(
    prepared: &PreparedMesh,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Option<Closing>, Error> {
    if !prepared.is_both_ways.contains(&true) {
        return Ok(None);
    }
    let mesh = &prepared.mesh;
    let radius = settings.flatness_in(prepared);
    let loops = boundary_loops(mesh.points(), &mesh.triangles);
    let mut caps = Vec::new();
    let mut closing = Closing { are_both_ways: true, ..Closing::default() };
    for fill in fill_loops(mesh.points(), &loops, radius) {
        control.check()?;
        let cap = match fill {
            LoopFill::Crack { triangles, .. } => {
                closing.triangles.extend(triangles);
                continue;
            }
            LoopFill::Cap(cap) => NarrowCap {
                rims: cap.loops.iter().map(|&index| &loops[index]).collect(),
                triangles: cap.triangles,
            },
            LoopFill::Left { loop_index, .. } => {
                let rim = &loops[loop_index];
                if rim.vertices.len() > MOST_SIDES {
                    continue;
                }
                let points =
                    Vec::from_iter(rim.vertices.iter().map(|&v| mesh.points()[v as usize]));
                let triangles = zip_shortest(&points, &rim.vertices);
                NarrowCap { rims: vec![rim], triangles }
            }
        };
        if cap.is_on_skin(prepared) && cap.is_narrow(mesh.points(), radius) {
            caps.push(cap);
        }
    }
    if caps.is_empty() {
        return Ok(None);
    }
    let mut all = [&mesh.triangles[..], &closing.triangles].concat();
    let mut start = all.len();
    all.extend(caps.iter().flat_map(|cap| &cap.triangles));
    let regions = Regions::new(mesh.points(), &all);
    for cap in &caps {
        let mut own = start..start + cap.triangles.len();
        start = own.end;
        if own.all(|triangle| regions.closes(triangle)) {
            closing.triangles.extend(&cap.triangles);
            closing.openings.push(cap.opening(prepared));
        }
    }
    Ok((!closing.openings.is_empty()).then_some(closing))
}

/// What would close an opening.
struct NarrowCap<'a> {
    rims: Vec<&'a Loop>,
    triangles: Vec<[u32; 3]>,
}

impl NarrowCap<'_> {
    /// Whether most of the surface at the rim, by length, is there both ways round and bends away
    /// from the cap: on a leaf, or on a blade of grass, the cap would lie on the sheet.
    fn is_on_skin(&self, prepared: &PreparedMesh) -> bool {
        let PreparedMesh { mesh, is_both_ways, .. } = prepared;
        let normal = |triangle: [u32; 3]| {
            let [a, b, c] = mesh.corners(triangle);
            area_normal(a, b, c).normalize_or_zero()
        };
        let half_edges =
            |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|edge| (edge, [a, b, c]));
        let mut of_edges: Vec<_> = self.triangles.iter().flat_map(half_edges).collect();
        sort_by_key(&mut of_edges, |of_edge| *of_edge);
        let most = libm::cos(SHEET_ANGLE);
        let (mut own, mut whole) = (0.0, 0.0);
        for rim in &self.rims {
            for ((&a, &b), (neighbour, length)) in
                sides(&rim.vertices).zip(rim.sides(mesh.points()))
            {
                whole += length;
                let Ok(place) = of_edges.binary_search_by_key(&[a, b], |edge| edge.0) else {
                    continue;
                };
                let [cap, surface] =
                    [of_edges[place].1, mesh.triangles[neighbour as usize]].map(normal);
                let is_bent = -surface.dot(cap) <= most;
                own += if is_bent && is_both_ways[neighbour as usize] { length } else { 0.0 };
            }
        }
        2.0 * own > whole
    }

    /// Whether all of the cap is within the radius of its rim.
    fn is_narrow(&self, positions: &[Vector], radius: f64) -> bool {
        let at = |vertex: u32| positions[vertex as usize];
        let sides = self.rims.iter().flat_map(|rim| sides(&rim.vertices));
        let rim: Vec<[Vector; 2]> = sides.map(|(&a, &b)| [at(a), at(b)]).collect();
        let mut corners = self.triangles.iter().map(|triangle| triangle.map(at));
        rim.len() <= MOST_SIDES && corners.all(|corners| is_near(corners, &rim, radius))
    }

    fn opening(&self, prepared: &PreparedMesh) -> Opening {
        let twice = self.triangles.iter().map(|&triangle| {
            let [a, b, c] = prepared.mesh.corners(triangle);
            area_normal(a, b, c).length()
        });
        let vertices = self.rims.iter().flat_map(|rim| rim.vertices.iter().copied());
        Opening::new(vertices, 0.5 * twice.sum::<f64>(), prepared, OpeningOutcome::Closed)
    }
}

/// Whether all points of a triangle are within the radius of the rim.
fn is_near(corners: [Vector; 3], rim: &[[Vector; 2]], radius: f64) -> bool {
    let middle = centre(corners);
    let size = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let distances = rim.iter().map(|&side| distance_to_segment(middle, side));
    let distance = distances.fold(f64::INFINITY, f64::min);
    if distance > radius {
        return false;
    }
    if distance + size <= radius || size <= LEAST_PART * radius {
        return true;
    }
    halves_of_triangle(corners).into_iter().all(|half| is_near(half, rim, radius))
}
