//! Openings: the sides that a modeller leaves out since nobody sees them.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the flat
//! openings of the repaired mesh are found, and those are closed through which only the backs of
//! faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the boundary as simple loops |
//! | `cap` | flat polygons over loops, and zips for cracks |
//! | `crossing` | whether the surface goes through a cap |
//! | `look` | what is seen through an opening |
//! | `nested` | closed components that nothing can reach |
//! | `report` | what became of each opening |
//! | `prepare` | the repaired mesh with its caps |
//! | `closed_mesh` | the same as a public result |
//!
//! The decision, in this order:
//!
//! 1. Cracks and T-junctions within the weld distance are no openings: they are zipped.
//! 2. A loop that is not flat within the tolerance stays open.
//! 3. So does one whose cap would meet the surface around it at less than 30° in the median: a sheet;
//!    or whose cap the surface goes through.
//! 4. A loop around which most of the surface is drawn from both sides, or is there both ways round, stays
//!    open unless it lies in the lowest plane of the mesh.
//! 5. Rays go inward from the caps that are left, all of them closed. One from which more than 5 % of
//!    the rays see the front of a face, or a way out, stays open; so does one from which most see
//!    only another cap. This is repeated until no more caps fall.
//! 6. One beyond which is inside already stays open: parts of an open skin, as the planks of a chest without
//!    backs, enclose a solid together.
//! 7. The caps of a component most of whose boundary stays open are left, and all caps of a mesh nine tenths of
//!    whose boundary do.
//! 8. Where nothing else stays open, those of 6 are closed after all, as a leg's end within a table's top, but
//!    are no surface: the mesh is closed then, and nothing can touch them.
//!
//! A closed mesh whose normals all point inward is no opening's matter: repair turns it around, since
//! exporters that mirror are more common than rooms without a door.

mod boundary;
mod cap;
mod closed_mesh;
mod crossing;
mod look;
mod nested;
pub(crate) mod prepare;
mod report;

use boundary::{Loop, boundary_loops};
use cap::{Candidate, Cap, candidates};
use crossing::is_cut;
use look::{View, look};

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, distance, scale};
use crate::geometry::{MeshView, Sidedness};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::parameters::{BoundedParameters, Length, Method, Openings, Parameters, UpAxis};

pub use closed_mesh::{ClosedMesh, close_openings};
pub use report::{Opening, OpeningOutcome};

/// A cap that meets the surface around it at less than this, in radians (30°), closes a sheet onto itself.
const SHEET_ANGLE: f64 = std::f64::consts::PI / 6.0;

/// The same where all openings are to be closed: a sheet that is flat has no solid on it.
const FLAT_ANGLE: f64 = SHEET_ANGLE / 6.0;

/// Through the opening of a solid no more than this share of the rays sees anything.
const MOST_SEEN: f64 = 0.05;

/// Where more of the rays than this only see another cap, there is too little surface to tell: between the rim
/// of a cup and that of its liner a little below.
const MOST_CAPPED: f64 = 0.5;

/// Where caps close less than this share of what stays open, by length, there is little to win: a mesh of
/// fragments takes a few hulls more with a few caps.
const LEAST_CLOSED: f64 = 0.1;

/// What of [`Parameters`](crate::Parameters) openings depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpeningSettings {
    pub openings: Openings,
    /// How far a loop's vertices may be from its plane.
    pub flatness: Length,
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay.
    pub keep_cavities: bool,
    pub order: MeshOrder,
}

impl From<&Parameters> for OpeningSettings {
    /// The paper's method takes the mesh as it is.
    fn from(parameters: &Parameters) -> Self {
        let BoundedParameters { openings, up_axis, max_error: flatness, keep_cavities, .. } =
            parameters.bounded;
        match parameters.method {
            Method::Bounded => {
                Self { openings, flatness, up_axis, keep_cavities, order: MeshOrder::Place }
            }
            Method::Surface => Self {
                openings: Openings::Keep,
                flatness,
                up_axis,
                keep_cavities: true,
                order: MeshOrder::Input,
            },
        }
    }
}

/// Triangles that close openings, and what became of each.
struct Closing {
    triangles: Vec<[u32; 3]>,
    /// Those within the solid.
    hidden: Vec<[u32; 3]>,
    openings: Vec<Opening>,
}

/// Decides for each opening of a repaired mesh. `source` tells which sides of faces are drawn.
///
/// # Errors
/// [`Error::Cancelled`].
fn close(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closing, Error> {
    let (positions, triangles) = (&prepared.mesh.positions, &prepared.mesh.triangles);
    let loops = boundary_loops(positions, triangles);
    control.check()?;
    let flatness = flatness_in_diagonals(prepared, settings);
    let mut closing = Closing { triangles: Vec::new(), hidden: Vec::new(), openings: Vec::new() };
    let mut caps: Vec<(Cap, OpeningOutcome)> = Vec::new();
    let mut is_crack = vec![false; loops.len()];
    for candidate in candidates(positions, &loops, flatness) {
        let left =
            |loop_index: usize, outcome| Opening::left(&loops[loop_index], prepared, outcome);
        match candidate {
            Candidate::Crack { loop_index, triangles } => {
                is_crack[loop_index] = true;
                closing.triangles.extend(triangles);
            }
            Candidate::NotFlat { loop_index } => {
                closing.openings.push(left(loop_index, OpeningOutcome::NotFlat));
            }
            Candidate::NotSimple { loop_index } => {
                closing.openings.push(left(loop_index, OpeningOutcome::NotSimple));
            }
            Candidate::Cap(cap) => caps.push((cap, OpeningOutcome::Closed)),
        }
    }
    control.check()?;
    if !caps.is_empty() {
        decide(prepared, source, &loops, &mut caps, settings, control)?;
    }
    leave_fragments(prepared, &loops, &is_crack, &mut caps);
    let is_left = |outcome: &OpeningOutcome| !outcome.is_closed();
    if closing.openings.iter().any(|opening| is_left(&opening.outcome))
        || caps.iter().any(|(_, outcome)| is_left(outcome))
    {
        for (_, outcome) in &mut caps {
            if *outcome == OpeningOutcome::ClosedWithin {
                *outcome = OpeningOutcome::SolidBeyond;
            }
        }
    }
    for (cap, outcome) in &caps {
        match outcome {
            OpeningOutcome::Closed => closing.triangles.extend_from_slice(&cap.triangles),
            OpeningOutcome::ClosedWithin => closing.hidden.extend_from_slice(&cap.triangles),
            _ => {}
        }
        closing.openings.push(Opening::of_cap(cap, &loops, prepared, *outcome));
    }
    Ok(closing)
}

/// Leaves the caps of components most of whose boundary, by length, stays open, and all of them where nearly
/// all of the mesh's boundary does: with a few caps such a mesh is no solid.
fn leave_fragments(
    prepared: &PreparedMesh,
    loops: &[Loop],
    is_crack: &[bool],
    caps: &mut [(Cap, OpeningOutcome)],
) {
    let mut outcomes = vec![OpeningOutcome::NotFlat; loops.len()];
    for (cap, outcome) in caps.iter() {
        cap.loops.iter().for_each(|&index| outcomes[index] = *outcome);
    }
    let component_of = |own: &Loop| {
        let neighbour = own.neighbours.first().copied().unwrap_or_default();
        prepared.components[neighbour as usize] as usize
    };
    let components = prepared.closed.len();
    let (mut closed, mut left) = (vec![0.0; components], vec![0.0; components]);
    let mut within = 0.0;
    for ((own, outcome), _) in loops.iter().zip(outcomes).zip(is_crack).filter(|own| !own.1) {
        let length = own.length(&prepared.mesh.positions);
        match outcome {
            OpeningOutcome::SolidBeyond | OpeningOutcome::ClosedWithin => within += length,
            OpeningOutcome::Closed => closed[component_of(own)] += length,
            _ => left[component_of(own)] += length,
        }
    }
    let sum = |lengths: &[f64]| lengths.iter().sum::<f64>();
    let all_left = sum(&left) + if sum(&left) > 0.0 { within } else { 0.0 };
    let is_little = sum(&closed) < LEAST_CLOSED * all_left;
    for (cap, outcome) in caps.iter_mut() {
        let is_fragment = cap.loops.iter().any(|&index| {
            let component = component_of(&loops[index]);
            left[component] > closed[component]
        });
        if outcome.is_closed() && (is_fragment || is_little) {
            *outcome = OpeningOutcome::Fragment;
        }
    }
}

fn flatness_in_diagonals(prepared: &PreparedMesh, settings: &OpeningSettings) -> f64 {
    let diagonal = prepared.normalization.diagonal;
    settings.flatness.of_diagonal(diagonal) / diagonal
}

/// Says of each cap whether it is closed, or why not.
fn decide(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    loops: &[Loop],
    caps: &mut [(Cap, OpeningOutcome)],
    settings: &OpeningSettings,
    control: &Control,
) -> Result<(), Error> {
    let (positions, triangles) = (&prepared.mesh.positions, &prepared.mesh.triangles);
    // All caps are in the tree; those that stay open are looked through.
    let mut all = triangles.clone();
    let mut cap_of: Vec<u32> = Vec::new();
    for (number, (cap, _)) in (0_u32..).zip(caps.iter()) {
        all.extend_from_slice(&cap.triangles);
        cap_of.resize(all.len() - triangles.len(), number);
    }
    let bvh = Bvh::with_control(positions, &all, control)?;
    let is_own_solid =
        |triangle: u32| prepared.closed[prepared.components[triangle as usize] as usize];
    let flatness = flatness_in_diagonals(prepared, settings);
    let is_auto = settings.openings == Openings::Auto;
    let least_angle = if is_auto { SHEET_ANGLE } else { FLAT_ANGLE };
    for (cap, outcome) in caps.iter_mut() {
        let is_of_surface = |t: u32| (t as usize) < triangles.len() && !is_own_solid(t);
        *outcome = if cap.rim_angle(positions, triangles, loops) < least_angle {
            OpeningOutcome::Sheet
        } else if is_cut(cap, (positions, triangles), &bvh, flatness, is_of_surface) {
            OpeningOutcome::Cut
        } else if is_auto
            && is_two_sided(cap, prepared, source, loops)
            && !is_lowest(cap, positions, loops, (settings.up_axis, flatness))
        {
            OpeningOutcome::TwoSided
        } else {
            OpeningOutcome::Closed
        };
    }
    control.check()?;
    if !is_auto {
        return Ok(());
    }
    let open = Bvh::with_control(positions, &prepared.triangles_of_solid(), control)?;
    loop {
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        let is_there = |triangle: u32| match (triangle as usize).checked_sub(triangles.len()) {
            None => true,
            Some(of_caps) => is_closed[cap_of[of_caps] as usize],
        };
        let is_seen = |number: usize, cap: &Cap| {
            let is_own = |t: u32| {
                (t as usize)
                    .checked_sub(triangles.len())
                    .is_some_and(|t| cap_of[t] == number as u32)
            };
            let counts = |t: u32| is_there(t) && !is_own(t);
            let View { seen, capped } = look(cap, positions, &bvh, triangles.len(), counts);
            seen > MOST_SEEN || capped > MOST_CAPPED
        };
        let mut changed = false;
        for (number, (cap, outcome)) in caps.iter_mut().enumerate() {
            if outcome.is_closed() && is_seen(number, cap) {
                *outcome = OpeningOutcome::SeenInto;
                changed = true;
            }
            control.check()?;
        }
        if changed {
            continue;
        }
        for (cap, outcome) in caps.iter_mut() {
            if outcome.is_closed() {
                let is_within = is_solid_beyond(cap, positions, [&open, &open], flatness);
                *outcome = match is_within {
                    true => OpeningOutcome::ClosedWithin,
                    false => OpeningOutcome::Closed,
                };
            }
        }
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(());
        }
        let kept = (0_u32..).zip(&all).filter(|&(t, _)| is_there(t)).map(|(_, &corners)| corners);
        let closed = Bvh::with_control(positions, &kept.collect::<Vec<_>>(), control)?;
        for (cap, outcome) in caps.iter_mut() {
            if *outcome == OpeningOutcome::ClosedWithin
                && !is_solid_beyond(cap, positions, [&open, &closed], flatness)
            {
                *outcome = OpeningOutcome::SolidBeyond;
                changed = true;
            }
        }
        if !changed {
            return Ok(());
        }
    }
}

/// Whether most of what is beyond a cap is inside as it is: the opening is within the solid, or the
/// parts of an open skin enclose it together. How far it is there is `open`'s to say, what is inside `solid`'s.
fn is_solid_beyond(
    cap: &Cap,
    positions: &[Vector],
    [open, solid]: [&Bvh; 2],
    flatness: f64,
) -> bool {
    let points = look::points(cap, positions);
    let inside = points.iter().filter(|&&point| {
        let outward = |distance: f64| add(point, scale(cap.normal, distance));
        // Near the backs of several parts the sum of what they enclose is unsure.
        let middle = open.first_hit(point, cap.normal, flatness, |_, _| true);
        solid.is_inside(outward(flatness))
            || middle.is_some_and(|hit| solid.is_inside(outward(0.5 * hit.distance)))
    });
    2 * inside.count() > points.len()
}

/// Whether most of the surface around a cap, by the length of its rim, is drawn from both sides.
fn is_two_sided(cap: &Cap, prepared: &PreparedMesh, source: MeshView<'_>, loops: &[Loop]) -> bool {
    let positions = &prepared.mesh.positions;
    let (mut two, mut whole) = (0.0, 0.0);
    for own in cap.loops.iter().map(|&index| &loops[index]) {
        let next = own.vertices.iter().cycle().skip(1);
        for ((&from, &to), &neighbour) in own.vertices.iter().zip(next).zip(&own.neighbours) {
            let side = distance(positions[from as usize], positions[to as usize]);
            let source_triangle = prepared.source_triangles[neighbour as usize];
            whole += side;
            if prepared.is_both_ways[neighbour as usize]
                || source.sidedness(source_triangle) == Some(Sidedness::Two)
            {
                two += side;
            }
        }
    }
    2.0 * two > whole
}

/// Whether all of a cap's rim lies in the lowest plane of the mesh.
fn is_lowest(
    cap: &Cap,
    positions: &[Vector],
    loops: &[Loop],
    (up_axis, flatness): (UpAxis, f64),
) -> bool {
    let axis = up_axis.index();
    let lowest = positions.iter().map(|point| point[axis]).fold(f64::INFINITY, f64::min);
    let mut rim = cap.loops.iter().flat_map(|&index| &loops[index].vertices);
    rim.all(|&vertex| positions[vertex as usize][axis] <= lowest + flatness)
}

#[cfg(test)]
mod tests;
