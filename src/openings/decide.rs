//! Which caps are closed, and why others are not: the rules of `docs/openings.md`, by the same numbers. The first
//! follows from `fill_loops`.

use super::boundary::{Loop, boundary_loops};
use super::cap::{Cap, LoopFill, fill_loops, is_cut};
use super::look::{is_seen_into, points};
use super::report::{Opening, OpeningOutcome};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::geometry::{MeshView, Sidedness};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::parallel;
use crate::parameters::{Length, Openings, Parameters, UpAxis};

/// A cap that meets the surface around it at less than this, in radians (30°), closes a sheet onto itself.
const SHEET_ANGLE: f64 = std::f64::consts::PI / 6.0;

/// The same where all openings are to be closed: a sheet that is flat has no solid on it.
const FLAT_ANGLE: f64 = SHEET_ANGLE / 6.0;

/// A point this far beyond a cap, as a fraction of the diagonal, is on one side of it: above rounding, below
/// visible sizes.
const BEYOND: f64 = 1e-6;

/// Where caps close less than this share of what stays open, by length, there is little to win: a mesh of
/// fragments takes a few hulls more with a few caps.
const LEAST_CLOSED: f64 = 0.1;

/// The part of [`Parameters`](crate::Parameters) that openings depend on.
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
    fn from(parameters: &Parameters) -> Self {
        let &Parameters { openings, up_axis, max_error, keep_cavities, .. } = parameters;
        Self { openings, flatness: max_error, up_axis, keep_cavities, order: MeshOrder::Place }
    }
}

/// Triangles that close openings, and what became of each.
pub(super) struct Closing {
    pub triangles: Vec<[u32; 3]>,
    /// Those within the solid.
    pub hidden: Vec<[u32; 3]>,
    pub openings: Vec<Opening>,
}

/// A cap, and whether it is closed or why not.
type JudgedCap = (Cap, OpeningOutcome);

/// Judges each opening of a repaired mesh. The materials of `source` say which sides of faces are drawn.
pub(super) fn judge(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closing, Error> {
    let loops = boundary_loops(prepared.mesh.points(), &prepared.mesh.triangles);
    control.check()?;
    let diagonal = prepared.normalization.diagonal;
    let flatness = settings.flatness.of_diagonal(diagonal) / diagonal;
    Judge { prepared, source, settings, control, loops, flatness }.closing()
}

/// A repaired mesh and the loops of its boundary.
struct Judge<'a> {
    prepared: &'a PreparedMesh,
    source: MeshView<'a>,
    settings: &'a OpeningSettings,
    control: &'a Control,
    loops: Vec<Loop>,
    /// As a fraction of the diagonal.
    flatness: f64,
}

impl Judge<'_> {
    fn positions(&self) -> &[Vector] {
        self.prepared.mesh.points()
    }

    fn closing(&self) -> Result<Closing, Error> {
        let mut closing =
            Closing { triangles: Vec::new(), hidden: Vec::new(), openings: Vec::new() };
        let mut caps: Vec<JudgedCap> = Vec::new();
        let mut is_crack = vec![false; self.loops.len()];
        for fill in fill_loops(self.positions(), &self.loops, self.flatness) {
            let left = |loop_index: usize, outcome| {
                Opening::left(&self.loops[loop_index], self.prepared, outcome)
            };
            match fill {
                LoopFill::Crack { loop_index, triangles } => {
                    is_crack[loop_index] = true;
                    closing.triangles.extend(triangles);
                }
                LoopFill::NotFlat { loop_index } => {
                    closing.openings.push(left(loop_index, OpeningOutcome::NotFlat));
                }
                LoopFill::NotSimple { loop_index } => {
                    closing.openings.push(left(loop_index, OpeningOutcome::NotSimple));
                }
                LoopFill::Cap(cap) => caps.push((cap, OpeningOutcome::Closed)),
            }
        }
        self.control.check()?;
        if !caps.is_empty() {
            self.judge_caps(&mut caps)?;
        }
        self.leave_fragments(&is_crack, &mut caps);
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
            self.close_exposed(&mut caps)?;
        }
        for (cap, outcome) in &caps {
            match outcome {
                OpeningOutcome::Closed => closing.triangles.extend_from_slice(&cap.triangles),
                OpeningOutcome::ClosedWithin => closing.hidden.extend_from_slice(&cap.triangles),
                _ => {}
            }
            closing.openings.push(Opening::of_cap(cap, &self.loops, self.prepared, *outcome));
        }
        Ok(closing)
    }

    /// Rules 2 to 6. The checks of rule 5 are repeated until no more caps fall.
    fn judge_caps(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        let capped = Capped::new(self, caps)?;
        capped.judge_shapes(caps)?;
        if self.settings.openings != Openings::Auto {
            return Ok(());
        }
        while capped.leave_seen(caps)? {}
        capped.mark_within(caps)?;
        while capped.leave_emptied(caps)? || capped.leave_seen(caps)? {}
        Ok(())
    }

    /// Rule 7: leaves the caps of components most of whose boundary, by length, stays open, and all of them where nearly
    /// all of the mesh's boundary does: with a few caps such a mesh is no solid.
    fn leave_fragments(&self, is_crack: &[bool], caps: &mut [JudgedCap]) {
        let Self { prepared, loops, .. } = self;
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
            let length = own.length(prepared.mesh.points());
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

    /// The end of rule 6: of the caps within the solid, those that reach out of it become surface. All openings are closed.
    fn close_exposed(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(());
        }
        let positions = self.positions();
        let mut triangles = self.prepared.triangles_of_solid().into_owned();
        triangles.extend(caps.iter().flat_map(|(cap, _)| &cap.triangles));
        let solid = Bvh::with_control(positions, &triangles, self.control)?;
        for (cap, outcome) in caps {
            self.control.check()?;
            let beyond = cap.normal * BEYOND;
            if *outcome == OpeningOutcome::ClosedWithin
                && !points(cap, positions).iter().all(|&point| solid.is_inside(point + beyond))
            {
                *outcome = OpeningOutcome::Closed;
            }
        }
        Ok(())
    }

    /// Whether most of the surface around a cap, by the length of its rim, is drawn from both sides.
    fn is_two_sided(&self, cap: &Cap) -> bool {
        let Self { prepared, source, loops, .. } = self;
        let positions = self.positions();
        let (mut two, mut whole) = (0.0, 0.0);
        for own in cap.loops.iter().map(|&index| &loops[index]) {
            let next = own.vertices.iter().cycle().skip(1);
            for ((&from, &to), &neighbour) in own.vertices.iter().zip(next).zip(&own.neighbours) {
                let side = positions[from as usize].distance(positions[to as usize]);
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
    fn is_lowest(&self, cap: &Cap) -> bool {
        let positions = self.positions();
        let axis = self.settings.up_axis.index();
        let lowest = positions.iter().map(|point| point[axis]).fold(f64::INFINITY, f64::min);
        let mut rim = cap.loops.iter().flat_map(|&index| &self.loops[index].vertices);
        rim.all(|&vertex| positions[vertex as usize][axis] <= lowest + self.flatness)
    }
}

/// The mesh with all caps, closed or not.
struct Capped<'a> {
    judge: &'a Judge<'a>,
    /// The surface, then all caps: those that stay open are looked through.
    triangles: Vec<[u32; 3]>,
    /// For each triangle after the surface the index of its cap.
    cap_of: Vec<u32>,
    bvh: Bvh,
    /// The solid as it comes.
    open: Bvh,
}

impl<'a> Capped<'a> {
    fn new(judge: &'a Judge<'a>, caps: &[JudgedCap]) -> Result<Self, Error> {
        let &Judge { prepared, control, .. } = judge;
        let positions = judge.positions();
        let mut triangles = prepared.mesh.triangles.clone();
        let mut cap_of: Vec<u32> = Vec::new();
        for (index, (cap, _)) in (0_u32..).zip(caps) {
            triangles.extend_from_slice(&cap.triangles);
            cap_of.resize(triangles.len() - prepared.mesh.triangles.len(), index);
        }
        let (bvh, open) = parallel::join(
            || Bvh::with_control(positions, &triangles, control),
            || Bvh::with_control(positions, &prepared.triangles_of_solid(), control),
        );
        Ok(Self { judge, triangles, cap_of, bvh: bvh?, open: open? })
    }

    /// How many triangles are surface.
    fn surface(&self) -> usize {
        self.judge.prepared.mesh.triangles.len()
    }

    /// The cap that a triangle belongs to, unless it is of the surface.
    fn cap_of(&self, triangle: u32) -> Option<usize> {
        let of_caps = (triangle as usize).checked_sub(self.surface())?;
        Some(self.cap_of[of_caps] as usize)
    }

    /// Leaves caps by their shape and that of the surface around them.
    fn judge_shapes(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        let &Judge { prepared, settings, control, ref loops, flatness, .. } = self.judge;
        let (positions, triangles) = (prepared.mesh.points(), &prepared.mesh.triangles);
        let is_own_solid =
            |triangle: u32| prepared.closed[prepared.components[triangle as usize] as usize];
        let is_of_surface = |t: u32| self.cap_of(t).is_none() && !is_own_solid(t);
        let is_auto = settings.openings == Openings::Auto;
        let least_angle = if is_auto { SHEET_ANGLE } else { FLAT_ANGLE };
        let judged = parallel::map(caps, |(cap, _)| {
            control.check()?;
            Ok(if cap.rim_angle(positions, triangles, loops) < least_angle {
                OpeningOutcome::Sheet
            } else if is_cut(cap, (positions, triangles), &self.bvh, flatness, is_of_surface) {
                OpeningOutcome::Cut
            } else if is_auto && self.judge.is_two_sided(cap) && !self.judge.is_lowest(cap) {
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
    fn leave_seen(&self, caps: &mut [JudgedCap]) -> Result<bool, Error> {
        let surface = self.surface();
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        let positions = self.judge.positions();
        let are_seen = parallel::map_indices(caps.len(), |index| {
            self.judge.control.check()?;
            let counts =
                |t: u32| self.cap_of(t).is_none_or(|owner| owner != index && is_closed[owner]);
            let cap = &caps[index].0;
            if !is_closed[index] {
                return Ok(false);
            }
            Ok(is_seen_into(cap, positions, &self.bvh, surface, counts))
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

    /// Separates caps within the solid from those on it.
    fn mark_within(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        let Self { judge, open, .. } = self;
        let positions = judge.positions();
        let are_within = parallel::map(caps, |(cap, outcome)| {
            self.judge.control.check()?;
            let is_within = || is_solid_beyond(cap, positions, [open, open], judge.flatness);
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
    fn leave_emptied(&self, caps: &mut [JudgedCap]) -> Result<bool, Error> {
        let Self { judge, open, .. } = self;
        let positions = self.judge.positions();
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(false);
        }
        let is_there = |&(t, _): &(u32, &[u32; 3])| self.cap_of(t).is_none_or(|cap| is_closed[cap]);
        let kept: Vec<[u32; 3]> =
            (0_u32..).zip(&self.triangles).filter(is_there).map(|(_, &corners)| corners).collect();
        let closed = Bvh::with_control(positions, &kept, self.judge.control)?;
        let mut changed = false;
        for (cap, outcome) in caps {
            self.judge.control.check()?;
            if *outcome == OpeningOutcome::ClosedWithin
                && !is_solid_beyond(cap, positions, [open, &closed], judge.flatness)
            {
                *outcome = OpeningOutcome::SolidBeyond;
                changed = true;
            }
        }
        Ok(changed)
    }
}

/// Whether most of what is beyond a cap is inside as it is: the opening is within the solid, or the
/// parts of an open skin enclose it together. `open` gives the thickness there, `solid` the inside.
fn is_solid_beyond(
    cap: &Cap,
    positions: &[Vector],
    [open, solid]: [&Bvh; 2],
    flatness: f64,
) -> bool {
    let points = points(cap, positions);
    let is_inside = |point: Vector| {
        let outward = |distance: f64| point + cap.normal * distance;
        // Near the backs of several parts the winding number is ambiguous.
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
