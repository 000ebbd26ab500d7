//! Which caps are closed, and why others are not: the rules of `docs/openings.md`, by the same
//! numbers. The first follows from `fill_loops`.
//!
//! What is seen through an opening decides most: the backs of faces, or their fronts. The back of a
//! face that is drawn from one side is invisible. So where only backs are seen from a cap, the
//! surface is the skin of a solid. Fronts, or a way out, mean that the inside is a room; except the
//! fronts of other solids that are stuck into this one, which the ray leaves again through their
//! backs.

use super::cap::{Cap, LoopFill, fill_loops, is_cut};
use super::opening::{Loop, Opening, OpeningOutcome, boundary_loops};
use crate::bvh::{Bvh, Hit};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::geometry::{MeshView, Sidedness};
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::parameters::{Length, Openings, Parameters, UpAxis};
use crate::sorting::{sort_by, sort_by_number};

/// A cap that meets the surface around it at less than this, in radians (30°), closes a sheet onto
/// itself.
pub(super) const SHEET_ANGLE: f64 = std::f64::consts::PI / 6.0;

/// The same where all openings are to be closed: a sheet that is flat has no solid on it.
const FLAT_ANGLE: f64 = SHEET_ANGLE / 6.0;

/// A point this far beyond a cap, as a fraction of the diagonal, is on one side of it: above
/// rounding, below visible sizes.
const BEYOND: f64 = 1e-6;

/// Where caps close less than this fraction of what stays open, by length, little is gained: a mesh
/// of fragments takes a few hulls more with a few caps.
const LEAST_CLOSED: f64 = 0.1;

/// Points that rays start from, spread over the cap by area.
const POINTS: usize = 32;

/// Rays from each point, spread over the half-space within as light from a matt surface is.
const RAYS_PER_POINT: usize = 4;

/// Through the opening of a solid no more than this fraction of the rays sees anything.
const MOST_SEEN: f64 = 0.05;

/// Where more of the rays than this only see another cap, there is too little surface to decide:
/// between the rim of a cup and that of its liner a little below.
const MOST_CAPPED: f64 = 0.5;

/// Points of every cap that rays start from before any cap has more of them. A surface that is no
/// solid shows that by its first rays, and the others are left out.
const POINTS_AT_ONCE: usize = 4;

/// A cap from so many of whose points nothing is seen, and few rays end on another cap, has no rays
/// from its other points.
const POINTS_OF_CLEAR: usize = POINTS / 2;

/// Where more of a cap's points than this are all within the solid, or all outside, the others are
/// as a rule.
const POINTS_THAT_AGREE: usize = POINTS / 4;

/// Caps with this share of all rims' length are looked through before the others: if they fall,
/// most of the others are fragments, without a ray.
const LONGEST: f64 = 0.5;

/// A ray through more faces than this decides nothing.
const MOST_HITS: usize = 32;

/// A hit nearer than this fraction of the diagonal is on the rim that the ray starts from.
const START: f64 = 1e-7;

/// Steps of the additive recurrences that spread points evenly: 1/φ, and 1/ρ, 1/ρ² for the plastic
/// number ρ (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// The part of [`Parameters`](crate::Parameters) that openings depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpeningSettings {
    pub openings: Openings,
    /// How far a loop's vertices may be from its plane.
    pub flatness: Length,
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay.
    pub keep_cavities: bool,
}

impl From<&Parameters> for OpeningSettings {
    fn from(parameters: &Parameters) -> Self {
        let &Parameters { openings, up_axis, max_error, keep_cavities, .. } = parameters;
        // A probe may start in a cavity.
        let keep_cavities = keep_cavities || !parameters.probe_from.is_empty();
        Self { openings, flatness: max_error, up_axis, keep_cavities }
    }
}

impl OpeningSettings {
    /// The flatness as a fraction of a mesh's diagonal.
    pub(super) fn flatness_in(&self, prepared: &PreparedMesh) -> f64 {
        let diagonal = prepared.normalization.diagonal;
        self.flatness.of_diagonal(diagonal) / diagonal
    }
}

/// Triangles that close openings, and what became of each.
#[derive(Default)]
pub(super) struct Closing {
    pub triangles: Vec<[u32; 3]>,
    /// Those within the solid.
    pub hidden: Vec<[u32; 3]>,
    pub openings: Vec<Opening>,
    /// Whether they are there both ways round, as what is around them.
    pub are_both_ways: bool,
}

/// A cap, and whether it is closed or why not.
type JudgedCap = (Cap, OpeningOutcome);

/// Judges each opening of a repaired mesh. The materials of `source` say which sides of faces are
/// drawn. `is_on_seen_rim` says of each vertex of the source whether a cap around it was left by a
/// pass before this one since something is seen through it, and then of this pass too: what is
/// there is looked through first, since nearly all of it falls again.
pub(super) fn judge(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    is_on_seen_rim: &mut [bool],
    control: &Control,
) -> Result<Closing, Error> {
    let loops = boundary_loops(prepared.mesh.points(), &prepared.mesh.triangles);
    control.check()?;
    let flatness = settings.flatness_in(prepared);
    Judge { prepared, source, settings, control, loops, flatness }.closing(is_on_seen_rim)
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

    fn closing(&self, is_on_seen_rim: &mut [bool]) -> Result<Closing, Error> {
        let mut closing = Closing::default();
        let mut caps: Vec<JudgedCap> = Vec::new();
        let mut is_crack = vec![false; self.loops.len()];
        for fill in fill_loops(self.positions(), &self.loops, self.flatness) {
            match fill {
                LoopFill::Crack { loop_index, triangles } => {
                    is_crack[loop_index] = true;
                    closing.triangles.extend(triangles);
                }
                LoopFill::Left { loop_index, outcome } => {
                    let own = &self.loops[loop_index];
                    closing.openings.push(Opening::left(own, self.prepared, outcome));
                }
                LoopFill::Cap(cap) => caps.push((cap, OpeningOutcome::Closed)),
            }
        }
        self.control.check()?;
        if !caps.is_empty() {
            self.judge_caps(&mut caps, &is_crack, is_on_seen_rim)?;
        }
        self.leave_fragments(&is_crack, &mut caps);
        let mut outcomes =
            caps.iter().map(|cap| cap.1).chain(closing.openings.iter().map(|o| o.outcome));
        if outcomes.all(OpeningOutcome::is_closed) {
            self.close_exposed(&mut caps)?;
        } else {
            let within = caps.iter_mut().filter(|cap| cap.1 == OpeningOutcome::ClosedWithin);
            within.for_each(|cap| cap.1 = OpeningOutcome::SolidBeyond);
        }
        for (cap, outcome) in &caps {
            match outcome {
                OpeningOutcome::Closed => closing.triangles.extend_from_slice(&cap.triangles),
                OpeningOutcome::ClosedWithin => closing.hidden.extend_from_slice(&cap.triangles),
                _ => {}
            }
            let vertices = cap.loops.iter().flat_map(|&index| &self.loops[index].vertices);
            let opening = Opening::new(vertices.copied(), cap.area, self.prepared, *outcome);
            closing.openings.push(opening);
        }
        Ok(closing)
    }

    /// Judges caps anew. `outcome` gives the new one, or `None` where it stays. Whether any has
    /// changed.
    fn update(
        &self,
        caps: &mut [JudgedCap],
        outcome: impl Fn(usize, &JudgedCap) -> Option<OpeningOutcome> + Sync + Send,
    ) -> Result<bool, Error> {
        let found = parallel::map_indices(caps.len(), |index| {
            self.control.check()?;
            Ok(outcome(index, &caps[index]))
        });
        let mut has_changed = false;
        for ((_, before), found) in caps.iter_mut().zip(found) {
            let after = found?.unwrap_or(*before);
            has_changed |= after != *before;
            *before = after;
        }
        Ok(has_changed)
    }

    /// Rules 2 to 6. The checks of rule 5 are repeated until no more caps fall.
    fn judge_caps(
        &self,
        caps: &mut [JudgedCap],
        is_crack: &[bool],
        is_on_seen_rim: &mut [bool],
    ) -> Result<(), Error> {
        let capped = Capped::new(self, caps)?;
        capped.judge_shapes(caps)?;
        if self.settings.openings != Openings::Auto {
            return Ok(());
        }
        self.leave_fragments(is_crack, caps);
        let (order, longest) = self.longest_first(caps);
        let is_seen =
            |&index: &usize| self.rim(&caps[index].0).any(|vertex| is_on_seen_rim[vertex]);
        let seen_before: Vec<usize> = order.iter().copied().filter(is_seen).collect();
        let mut views = vec![View::default(); caps.len()];
        for some in [&seen_before, &order[..longest], &order] {
            while capped.leave_seen(caps, some, is_crack, &mut views)? {}
        }
        capped.mark_within(caps)?;
        while capped.leave_emptied(caps)?
            || capped.leave_seen(caps, &order, is_crack, &mut views)?
        {}
        for (cap, _) in caps.iter().filter(|cap| cap.1 == OpeningOutcome::SeenInto) {
            self.rim(cap).for_each(|vertex| is_on_seen_rim[vertex] = true);
        }
        Ok(())
    }

    /// The vertices of the source around a cap.
    fn rim(&self, cap: &Cap) -> impl Iterator<Item = usize> {
        let vertices = cap.loops.iter().flat_map(|&index| &self.loops[index].vertices);
        vertices.map(|&vertex| self.prepared.source_vertices[vertex as usize] as usize)
    }

    /// The caps that are closed so far, those with the longest rims first, and how many of them
    /// have [`LONGEST`] of the length.
    fn longest_first(&self, caps: &[JudgedCap]) -> (Vec<usize>, usize) {
        let length = |cap: &Cap| -> f64 {
            let rims = cap.loops.iter().map(|&index| &self.loops[index]);
            rims.flat_map(|rim| rim.sides(self.positions())).map(|side| side.1).sum()
        };
        let closed = caps.iter().enumerate().filter(|(_, (_, outcome))| outcome.is_closed());
        let mut all: Vec<(f64, usize)> =
            closed.map(|(index, (cap, _))| (-length(cap), index)).collect();
        sort_by_number(&mut all);
        let mut left = LONGEST * all.iter().map(|cap| cap.0).sum::<f64>();
        let is_longest = |cap: &&(f64, usize)| {
            let is_longest = left < 0.0;
            left -= cap.0;
            is_longest
        };
        let longest = all.iter().take_while(is_longest).count();
        (all.into_iter().map(|cap| cap.1).collect(), longest)
    }

    /// Rule 7: leaves the caps of components most of whose boundary, by length, stays open, and all
    /// of them where nearly all of the mesh's boundary does: with a few caps such a mesh is no
    /// solid. What is left only grows, so that a fragment stays one.
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
            let length: f64 = own.sides(prepared.mesh.points()).map(|side| side.1).sum();
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

    /// The end of rule 6: of the caps within the solid, those that reach out of it become surface.
    /// All openings are closed.
    fn close_exposed(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(());
        }
        let positions = self.positions();
        let mut triangles = self.prepared.triangles_of_solid().into_owned();
        triangles.extend(caps.iter().flat_map(|(cap, _)| &cap.triangles));
        let solid = Bvh::with_control(positions, &triangles, self.control)?;
        self.update(caps, |_, (cap, outcome)| {
            let beyond = cap.plane.normal * BEYOND;
            let is_hidden =
                || points(cap, positions).iter().all(|&point| solid.is_inside(point + beyond));
            let is_exposed = *outcome == OpeningOutcome::ClosedWithin && !is_hidden();
            is_exposed.then_some(OpeningOutcome::Closed)
        })?;
        Ok(())
    }

    /// Whether most of the surface around a cap, by the length of its rim, is drawn from both
    /// sides.
    fn is_two_sided(&self, cap: &Cap) -> bool {
        let Self { prepared, source, .. } = self;
        let (mut two, mut whole) = (0.0, 0.0);
        for own in cap.loops.iter().map(|&index| &self.loops[index]) {
            for (neighbour, length) in own.sides(self.positions()) {
                let source_triangle = prepared.source_triangles[neighbour as usize];
                whole += length;
                if prepared.is_both_ways[neighbour as usize]
                    || source.sidedness(source_triangle) == Some(Sidedness::Two)
                {
                    two += length;
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

/// What rays from a cap inward have seen.
#[derive(Clone, Default)]
struct View {
    /// The points of the cap that rays have started from.
    points: Vec<PointView>,
    /// Each of these points with another cap that a ray from there has met.
    met: Vec<[usize; 2]>,
}

/// What the rays from a point have seen.
#[derive(Clone, Copy)]
struct PointView {
    /// By [`scattered`].
    point: usize,
    /// Rays that see a front, or a way out.
    seen: usize,
    /// Rays that leave the solid through another cap.
    capped: usize,
}

impl View {
    fn has(&self, point: usize) -> bool {
        self.points.iter().any(|own| own.point == point)
    }

    /// How many rays see something, and how many only another cap.
    fn counts(&self) -> [usize; 2] {
        let counts = self.points.iter().map(|point| [point.seen, point.capped]);
        counts.fold([0, 0], |a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Whether further rays are not worth their time.
    fn is_complete(&self) -> bool {
        let [seen, capped] = self.counts();
        let rays = self.points.len() * RAYS_PER_POINT;
        let is_clear = seen == 0 && capped as f64 <= 0.5 * MOST_CAPPED * rays as f64;
        self.points.len() >= if is_clear { POINTS_OF_CLEAR } else { POINTS }
    }

    /// Whether more than `MOST_SEEN` of all rays see something, or more than `MOST_CAPPED` only
    /// another cap.
    fn is_seen_into(&self) -> bool {
        let is_more =
            |count: usize, share: f64| count as f64 > share * (POINTS * RAYS_PER_POINT) as f64;
        let [seen, capped] = self.counts();
        is_more(seen, MOST_SEEN) || is_more(capped, MOST_CAPPED)
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
        let &Judge { prepared, settings, ref loops, flatness, .. } = self.judge;
        let mesh = &prepared.mesh;
        let is_own_solid =
            |triangle: u32| prepared.closed[prepared.components[triangle as usize] as usize];
        let is_of_surface = |t: u32| self.cap_of(t).is_none() && !is_own_solid(t);
        let is_auto = settings.openings == Openings::Auto;
        let least_angle = if is_auto { SHEET_ANGLE } else { FLAT_ANGLE };
        self.judge.update(caps, |_, (cap, _)| {
            Some(if cap.rim_angle(mesh, loops) < least_angle {
                OpeningOutcome::Sheet
            } else if is_cut(cap, mesh, &self.bvh, flatness, is_of_surface) {
                OpeningOutcome::Cut
            } else if is_auto && self.judge.is_two_sided(cap) && !self.judge.is_lowest(cap) {
                OpeningOutcome::TwoSided
            } else {
                OpeningOutcome::Closed
            })
        })?;
        Ok(())
    }

    /// Leaves those of some caps through which something is seen with all others closed, and the
    /// fragments that this makes of components. Whether there were any. `views` keeps what was seen
    /// from each cap from call to call: rays that met only caps which are still closed see what
    /// they saw, and with thousands of openings most of the time would be theirs.
    fn leave_seen(
        &self,
        caps: &mut [JudgedCap],
        some: &[usize],
        is_crack: &[bool],
        views: &mut [View],
    ) -> Result<bool, Error> {
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        for View { points, met } in &mut *views {
            let fallen = met.iter().filter(|&&[_, cap]| !is_closed[cap]);
            let fallen: Vec<usize> = fallen.map(|&[point, _]| point).collect();
            points.retain(|own| !fallen.contains(&own.point));
            met.retain(|[point, _]| !fallen.contains(point));
        }
        let mut has_changed = false;
        for _ in 0..POINTS / POINTS_AT_ONCE {
            let found = parallel::map_indices(some.len(), |place| {
                self.judge.control.check()?;
                let index = some[place];
                let (cap, outcome) = &caps[index];
                let is_open = outcome.is_closed() && !views[index].is_complete();
                Ok(is_open.then(|| self.seen_further(index, cap, &is_closed, &views[index])))
            });
            let mut has_fallen = false;
            for (&index, found) in some.iter().zip(found) {
                let Some(found) = found? else { continue };
                if found.is_seen_into() {
                    (caps[index].1, has_fallen) = (OpeningOutcome::SeenInto, true);
                }
                views[index] = found;
            }
            if has_fallen {
                self.judge.leave_fragments(is_crack, caps);
                has_changed = true;
            }
        }
        Ok(has_changed)
    }

    /// What is seen from a cap inward, by rays from some more of its points.
    fn seen_further(&self, index: usize, cap: &Cap, is_closed: &[bool], before: &View) -> View {
        let is_there =
            |t: u32| self.cap_of(t).is_none_or(|owner| owner != index && is_closed[owner]);
        let mut view = before.clone();
        let points = points(cap, self.judge.positions());
        for order in 0..POINTS {
            if view.has(order) {
                continue;
            }
            let number = scattered(order);
            let Some(&point) = points.get(number) else { continue };
            let mut own = PointView { point: order, seen: 0, capped: 0 };
            for ray in 0..RAYS_PER_POINT {
                let direction = direction(cap, number * RAYS_PER_POINT + ray);
                let meets = |t: u32| view.met.extend(self.cap_of(t).map(|cap| [order, cap]));
                match leaves_through(&self.bvh, [point, direction], is_there, meets) {
                    None => own.seen += 1,
                    Some(triangle) => own.capped += usize::from(self.cap_of(triangle).is_some()),
                }
            }
            view.points.push(own);
            if view.points.len() >= before.points.len() + POINTS_AT_ONCE || view.is_seen_into() {
                break;
            }
        }
        view
    }

    /// Separates caps within the solid from those on it.
    fn mark_within(&self, caps: &mut [JudgedCap]) -> Result<(), Error> {
        let Self { judge, open, .. } = self;
        judge.update(caps, |_, (cap, outcome)| {
            let is_within =
                || is_solid_beyond(cap, judge.positions(), [open, open], judge.flatness);
            outcome.is_closed().then(|| match is_within() {
                true => OpeningOutcome::ClosedWithin,
                false => OpeningOutcome::Closed,
            })
        })?;
        Ok(())
    }

    /// Leaves those of the caps within the solid that would empty it. Whether there were any.
    fn leave_emptied(&self, caps: &mut [JudgedCap]) -> Result<bool, Error> {
        let Self { judge, open, .. } = self;
        let positions = judge.positions();
        let is_closed: Vec<bool> = caps.iter().map(|(_, outcome)| outcome.is_closed()).collect();
        if caps.iter().all(|(_, outcome)| *outcome != OpeningOutcome::ClosedWithin) {
            return Ok(false);
        }
        let is_there = |&(t, _): &(u32, &[u32; 3])| self.cap_of(t).is_none_or(|cap| is_closed[cap]);
        let kept: Vec<[u32; 3]> =
            (0_u32..).zip(&self.triangles).filter(is_there).map(|(_, &corners)| corners).collect();
        let closed = Bvh::with_control(positions, &kept, judge.control)?;
        judge.update(caps, |_, (cap, outcome)| {
            let is_emptied = *outcome == OpeningOutcome::ClosedWithin
                && !is_solid_beyond(cap, positions, [open, &closed], judge.flatness);
            is_emptied.then_some(OpeningOutcome::SolidBeyond)
        })
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
    let is_inside = |&point: &Vector| {
        let outward = |distance: f64| point + cap.plane.normal * distance;
        // Near the backs of several parts the winding number is ambiguous.
        let middle = || open.first_hit(point, cap.plane.normal, flatness, &|_| true);
        solid.is_inside(outward(flatness))
            || middle().is_some_and(|hit| solid.is_inside(outward(0.5 * hit.distance)))
    };
    let (mut inside, mut outside) = (0, 0);
    for point in (0..POINTS).filter_map(|order| points.get(scattered(order))) {
        *(if is_inside(point) { &mut inside } else { &mut outside }) += 1;
        let enough = if inside.min(outside) == 0 { POINTS_THAT_AGREE } else { POINTS / 2 };
        if inside.max(outside) > enough {
            break;
        }
    }
    inside > outside
}

/// Through which triangle a ray that starts in the solid leaves it, if it does: through one back
/// more than fronts. A part of another solid that is stuck into this one shows its front, and then
/// its own back. `counts` says which triangles are there, and `meets` is called for those on the
/// way.
fn leaves_through(
    bvh: &Bvh,
    [origin, direction]: [Vector; 2],
    counts: impl Fn(u32) -> bool,
    mut meets: impl FnMut(u32),
) -> Option<u32> {
    let mut solids = 1;
    let mut leaves = |hit: Hit| {
        meets(hit.triangle);
        solids += if hit.is_back { -1 } else { 1 };
        (solids == 0).then_some(hit.triangle)
    };
    let first = bvh.first_hit(origin, direction, START, &counts)?;
    if let Some(triangle) = leaves(first) {
        return Some(triangle);
    }
    // Most rays end there. One that does not goes through many faces.
    let mut others = Vec::new();
    bvh.visit_hits([origin, direction], first.distance, &mut |hit| {
        if counts(hit.triangle) {
            others.push(hit);
        }
        f64::INFINITY
    });
    sort_by(&mut others, |a, b| {
        a.distance.total_cmp(&b.distance).then(a.triangle.cmp(&b.triangle))
    });
    let (mut distance, mut count) = (first.distance, 1);
    for hit in others {
        // Of faces at the same distance, as those on both sides of an edge, one counts.
        if hit.distance == distance {
            continue;
        }
        if count == MOST_HITS {
            break;
        }
        (distance, count) = (hit.distance, count + 1);
        if let Some(triangle) = leaves(hit) {
            return Some(triangle);
        }
    }
    None
}

/// By its bits the other way round: the first few of all points are spread over the cap.
fn scattered(order: usize) -> usize {
    order.reverse_bits() >> (POINTS.leading_zeros() + 1)
}

/// An element of an additive recurrence.
fn spread(step: f64, index: usize) -> f64 {
    (0.5 + step * (index + 1) as f64).fract()
}

/// Points of a cap, spread evenly by area.
fn points(cap: &Cap, positions: &[Vector]) -> Vec<Vector> {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| positions[vertex as usize]);
    let areas: Vec<f64> = cap
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle).map(|corner| cap.plane.flatten(corner));
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
        })
        .collect();
    let whole: f64 = areas.iter().sum();
    let (mut triangle, mut before) = (0, 0.0);
    (0..POINTS)
        .filter_map(|index| {
            let target = whole * (index as f64 + 0.5) / POINTS as f64;
            while triangle + 1 < areas.len() && before + areas[triangle] < target {
                before += areas[triangle];
                triangle += 1;
            }
            let [a, b, c] = corners(cap.triangles.get(triangle)?);
            let [mut v, mut w] = PLASTIC.map(|step| spread(step, index));
            if v + w > 1.0 {
                (v, w) = (1.0 - v, 1.0 - w);
            }
            Some(a + ((b - a) * v + (c - a) * w))
        })
        .collect()
}

/// A direction inward, with a density that is proportional to the cosine with the normal.
fn direction(cap: &Cap, index: usize) -> Vector {
    let height_squared = spread(GOLDEN, index);
    let turn = std::f64::consts::TAU * (index as f64 + 0.5) / (POINTS * RAYS_PER_POINT) as f64;
    let radius = (1.0 - height_squared).sqrt();
    let across = cap.plane.axes[0] * (radius * libm::cos(turn))
        + cap.plane.axes[1] * (radius * libm::sin(turn));
    -cap.plane.normal * height_squared.sqrt() + across
}
