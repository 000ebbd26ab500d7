//! Which caps are closed, and why others are not.

use super::boundary::{Loop, boundary_loops};
use super::cap::{Candidate, Cap, candidates, is_cut};
use super::look::{is_seen_into, points};
use super::report::{Opening, OpeningOutcome};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, distance, scale};
use crate::geometry::{MeshView, Sidedness};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::parallel;
use crate::parameters::{BoundedParameters, Length, Method, Openings, Parameters, UpAxis};

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
    /// The paper's method takes the mesh as it is. For one hull this says what the mass is that of.
    fn from(parameters: &Parameters) -> Self {
        let BoundedParameters { openings, up_axis, max_error: flatness, keep_cavities, .. } =
            parameters.bounded;
        match parameters.method {
            Method::Bounded | Method::Hull => {
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
pub(super) struct Closing {
    pub triangles: Vec<[u32; 3]>,
    /// Those within the solid.
    pub hidden: Vec<[u32; 3]>,
    pub openings: Vec<Opening>,
}

/// Decides for each opening of a repaired mesh. `source` tells which sides of faces are drawn.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn close(
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
    } else {
        close_exposed(prepared, &mut caps, control)?;
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

fn flatness_in_diagonals(prepared: &PreparedMesh, settings: &OpeningSettings) -> f64 {
    let diagonal = prepared.normalization.diagonal;
    settings.flatness.of_diagonal(diagonal) / diagonal
}

// Which caps are closed, and why others are not.

/// A cap that meets the surface around it at less than this, in radians (30°), closes a sheet onto itself.
const SHEET_ANGLE: f64 = std::f64::consts::PI / 6.0;

/// The same where all openings are to be closed: a sheet that is flat has no solid on it.
const FLAT_ANGLE: f64 = SHEET_ANGLE / 6.0;

/// This far beyond a cap, in diagonals, a point is on one side of it: above rounding, below what matters.
const BEYOND: f64 = 1e-6;

/// The mesh with all caps, closed or not.
struct Capped<'a> {
    prepared: &'a PreparedMesh,
    /// The surface, then all caps: those that stay open are looked through.
    triangles: Vec<[u32; 3]>,
    /// For each triangle after the surface the number of its cap.
    cap_of: Vec<u32>,
    bvh: Bvh,
    /// The solid as it comes.
    open: Bvh,
    flatness: f64,
}

/// Says of each cap whether it is closed, or why not.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn decide(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    loops: &[Loop],
    caps: &mut [(Cap, OpeningOutcome)],
    settings: &OpeningSettings,
    control: &Control,
) -> Result<(), Error> {
    let flatness = flatness_in_diagonals(prepared, settings);
    let capped = Capped::new(prepared, caps, flatness, control)?;
    capped.judge_shapes(source, loops, caps, settings, control)?;
    if settings.openings != Openings::Auto {
        return Ok(());
    }
    while capped.leave_seen(caps, control)? {}
    capped.tell_within(caps, control)?;
    while capped.leave_emptied(caps, control)? || capped.leave_seen(caps, control)? {}
    Ok(())
}

impl<'a> Capped<'a> {
    fn new(
        prepared: &'a PreparedMesh,
        caps: &[(Cap, OpeningOutcome)],
        flatness: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let positions = &prepared.mesh.positions;
        let mut triangles = prepared.mesh.triangles.clone();
        let mut cap_of: Vec<u32> = Vec::new();
        for (number, (cap, _)) in (0_u32..).zip(caps) {
            triangles.extend_from_slice(&cap.triangles);
            cap_of.resize(triangles.len() - prepared.mesh.triangles.len(), number);
        }
        let (bvh, open) = parallel::join(
            || Bvh::with_control(positions, &triangles, control),
            || Bvh::with_control(positions, &prepared.triangles_of_solid(), control),
        );
        Ok(Self { prepared, triangles, cap_of, bvh: bvh?, open: open?, flatness })
    }

    /// The cap that a triangle belongs to, unless it is of the surface.
    fn cap_of(&self, triangle: u32) -> Option<usize> {
        let of_caps = (triangle as usize).checked_sub(self.prepared.mesh.triangles.len())?;
        Some(self.cap_of[of_caps] as usize)
    }

    /// Leaves caps by their shape and that of the surface around them.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn judge_shapes(
        &self,
        source: MeshView<'_>,
        loops: &[Loop],
        caps: &mut [(Cap, OpeningOutcome)],
        settings: &OpeningSettings,
        control: &Control,
    ) -> Result<(), Error> {
        let Self { prepared, bvh, flatness, .. } = self;
        let (positions, triangles) = (&prepared.mesh.positions, &prepared.mesh.triangles);
        let is_own_solid =
            |triangle: u32| prepared.closed[prepared.components[triangle as usize] as usize];
        let is_of_surface = |t: u32| self.cap_of(t).is_none() && !is_own_solid(t);
        let is_auto = settings.openings == Openings::Auto;
        let least_angle = if is_auto { SHEET_ANGLE } else { FLAT_ANGLE };
        let judged = parallel::map(caps, |(cap, _)| {
            control.check()?;
            Ok(if cap.rim_angle(positions, triangles, loops) < least_angle {
                OpeningOutcome::Sheet
            } else if is_cut(cap, (positions, triangles), bvh, *flatness, is_of_surface) {
                OpeningOutcome::Cut
            } else if is_auto
                && is_two_sided(cap, prepared, source, loops)
                && !is_lowest(cap, positions, loops, (settings.up_axis, *flatness))
            {
                OpeningOutcome::TwoSided
            } else {
                OpeningOutcome::Closed
            })
        });
        for ((_, outcome), judged) in caps.iter_mut().zip(judged) {
            *outcome = judged?;
        }
        Ok(())
    }

    /// Leaves caps through which something is seen with all others closed. Whether there were any.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn leave_seen(
        &self,
        caps: &mut [(Cap, OpeningOutcome)],
        control: &Control,
    ) -> Result<bool, Error> {
        let surface = self.prepared.mesh.triangles.len();
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        let positions = &self.prepared.mesh.positions;
        let are_seen = parallel::map_indices(caps.len(), |number| {
            control.check()?;
            let counts =
                |t: u32| self.cap_of(t).is_none_or(|owner| owner != number && is_closed[owner]);
            let cap = &caps[number].0;
            if !is_closed[number] {
                return Ok(false);
            }
            is_seen_into(cap, positions, &self.bvh, surface, counts, control)
        });
        let mut changed = false;
        for ((_, outcome), is_seen) in caps.iter_mut().zip(are_seen) {
            if is_seen? {
                *outcome = OpeningOutcome::SeenInto;
                changed = true;
            }
        }
        Ok(changed)
    }

    /// Tells caps within the solid from those on it.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn tell_within(
        &self,
        caps: &mut [(Cap, OpeningOutcome)],
        control: &Control,
    ) -> Result<(), Error> {
        let Self { open, flatness, .. } = self;
        let positions = &self.prepared.mesh.positions;
        let are_within = parallel::map(caps, |(cap, outcome)| {
            control.check()?;
            let is_within = || is_solid_beyond(cap, positions, [open, open], *flatness);
            Ok(outcome.is_closed().then(is_within))
        });
        for ((_, outcome), is_within) in caps.iter_mut().zip(are_within) {
            match is_within? {
                Some(true) => *outcome = OpeningOutcome::ClosedWithin,
                Some(false) => *outcome = OpeningOutcome::Closed,
                None => {}
            }
        }
        Ok(())
    }

    /// Leaves those of the caps within the solid that would empty it. Whether there were any.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn leave_emptied(
        &self,
        caps: &mut [(Cap, OpeningOutcome)],
        control: &Control,
    ) -> Result<bool, Error> {
        let Self { open, flatness, .. } = self;
        let positions = &self.prepared.mesh.positions;
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(false);
        }
        let is_there = |&(t, _): &(u32, &[u32; 3])| self.cap_of(t).is_none_or(|cap| is_closed[cap]);
        let kept: Vec<[u32; 3]> =
            (0_u32..).zip(&self.triangles).filter(is_there).map(|(_, &corners)| corners).collect();
        let closed = Bvh::with_control(positions, &kept, control)?;
        let mut changed = false;
        for (cap, outcome) in caps {
            control.check()?;
            if *outcome == OpeningOutcome::ClosedWithin
                && !is_solid_beyond(cap, positions, [open, &closed], *flatness)
            {
                *outcome = OpeningOutcome::SolidBeyond;
                changed = true;
            }
        }
        Ok(changed)
    }
}

/// Of the caps within the solid, makes those surface that reach out of it. All openings are closed.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn close_exposed(
    prepared: &PreparedMesh,
    caps: &mut [(Cap, OpeningOutcome)],
    control: &Control,
) -> Result<(), Error> {
    if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
        return Ok(());
    }
    let positions = &prepared.mesh.positions;
    let mut triangles = prepared.triangles_of_solid().into_owned();
    triangles.extend(caps.iter().flat_map(|(cap, _)| &cap.triangles));
    let solid = Bvh::with_control(positions, &triangles, control)?;
    for (cap, outcome) in caps {
        control.check()?;
        let beyond = scale(cap.normal, BEYOND);
        if *outcome == OpeningOutcome::ClosedWithin
            && !points(cap, positions).iter().all(|&point| solid.is_inside(add(point, beyond)))
        {
            *outcome = OpeningOutcome::Closed;
        }
    }
    Ok(())
}

/// Whether most of what is beyond a cap is inside as it is: the opening is within the solid, or the
/// parts of an open skin enclose it together. How far it is there is `open`'s to say, what is inside `solid`'s.
fn is_solid_beyond(
    cap: &Cap,
    positions: &[Vector],
    [open, solid]: [&Bvh; 2],
    flatness: f64,
) -> bool {
    let points = points(cap, positions);
    let is_inside = |point: Vector| {
        let outward = |distance: f64| add(point, scale(cap.normal, distance));
        // Near the backs of several parts the sum of what they enclose is unsure.
        let middle = || open.first_hit(point, cap.normal, flatness, |_, _| true);
        solid.is_inside(outward(flatness))
            || middle().is_some_and(|hit| solid.is_inside(outward(0.5 * hit.distance)))
    };
    let (mut inside, mut outside) = (0, 0);
    for &point in &points {
        *(if is_inside(point) { &mut inside } else { &mut outside }) += 1;
        if 2 * inside.max(outside) > points.len() {
            break;
        }
    }
    inside > outside
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

// Whether caps are worth it: on a mesh of fragments they are not.

/// Where caps close less than this share of what stays open, by length, there is little to win: a mesh of
/// fragments takes a few hulls more with a few caps.
const LEAST_CLOSED: f64 = 0.1;

/// Leaves the caps of components most of whose boundary, by length, stays open, and all of them where nearly
/// all of the mesh's boundary does: with a few caps such a mesh is no solid.
pub(super) fn leave_fragments(
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
