//! How near the centre of a ball can come to a point.
//!
//! Cells of the grid that may hold centres are divided in eight, and those parts again, where a
//! point is compared with them. A part with a half diagonal δ, whose middle m is D away from the
//! closest point q of the surface, holds no centre if D + δ < r. Otherwise its centres lie in the
//! part itself, and beyond a plane: they are r away from q at least, and off the line from q to m
//! by δ at most.
//!
//! ```text
//!         ┌───────┐
//!         │ · · · │   centres:   (y - q) · n ≥ √(r² - δ²),   n from q to m
//!     ────│───m───│────
//!         │   │   │
//!         └───│───┘
//!   ▓▓▓▓▓▓▓▓▓▓q▓▓▓▓▓▓▓▓▓▓
//! ```
//!
//! The same holds for any other point of the surface. Where a ball rests on several edges, each has
//! a plane, and what is left of a small part is a polytope. How far a point is from all such
//! polytopes bounds the distance from all centres from below. This bound depends on the point
//! alone, and changes no faster than it moves.

use std::sync::OnceLock;

use super::field::Field;
use super::reach::{Cell, ProbeSettings, Reach};
use crate::bvh::Bvh;
use crate::bvh::closest_point::EXACT;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, squared};

/// Half the side of a part that is not divided, as a fraction of the bound, at most: its planes are
/// off by its squared half diagonal over the diameter.
const LEAST_HALF: f64 = 0.1;

/// A ball that is entered farther than this, as a fraction of the radius, shows nothing: only the
/// distance from the mesh counts. Otherwise a ball smaller than the bound could vanish in hulls.
const MOST_ENTERED: f64 = 0.5;

/// More than the rounding of distances, as a fraction of the diagonal.
const ROUNDING: f64 = 1e-9;

/// Children of a part from the nearest to a point to the farthest, as differences from the nearest.
const NEAREST_FIRST: [usize; 8] = [0, 1, 2, 4, 3, 5, 6, 7];

/// Steps of the dual ascent, each over all planes: two planes at right angles take one. Any number
/// gives a valid bound.
const STEPS: usize = 12;

/// A part of a cell.
struct Part {
    /// The closest point of the surface to its middle, and how far that is.
    nearest: Vector,
    distance: f64,
    triangle: u32,
    within: OnceLock<Within>,
}

/// What is known about the inside of a part.
enum Within {
    Children(Box<[Part; 8]>),
    /// Of a small part: centres are beyond all of these.
    Planes(Vec<Plane>),
}

impl Part {
    fn new(tree: &Bvh, middle: Vector, guess: u32) -> Self {
        let within = OnceLock::new();
        match tree.closest_point_near(middle, EXACT, guess) {
            Some(found) => Self {
                nearest: found.point,
                distance: found.distance,
                triangle: found.triangle,
                within,
            },
            None => Self { nearest: middle, distance: f64::INFINITY, triangle: u32::MAX, within },
        }
    }
}

/// A cube by its middle and half its side.
#[derive(Clone, Copy)]
struct Cube {
    middle: Vector,
    half: f64,
}

impl Cube {
    fn radius(&self) -> f64 {
        self.half * 3f64.sqrt()
    }

    fn distance(&self, of: &Extent) -> f64 {
        let beyond = (of.centre - self.middle).abs() - Vector::splat(self.half);
        beyond.max(Vector::ZERO).length() - of.radius
    }

    /// The eighth, or the corner, on these sides.
    fn towards(&self, index: usize) -> Vector {
        let side = |axis: usize| if index >> axis & 1 == 1 { self.half } else { -self.half };
        Vector::new(side(0), side(1), side(2))
    }

    fn child(&self, index: usize) -> Self {
        Self { middle: self.middle + self.towards(index) * 0.5, half: 0.5 * self.half }
    }

    /// The plane that centres in the cube are beyond, since they stay `clear` away from a point of
    /// the surface.
    fn plane(&self, on_surface: Vector, clear: f64) -> Option<Plane> {
        let (along, radius) = (self.middle - on_surface, self.radius());
        let distance = along.length();
        if radius >= clear.min(distance) || !distance.is_finite() {
            return None;
        }
        let normal = along * (1.0 / distance);
        let height = (squared(clear) - squared(radius)).sqrt();
        Some(Plane { normal, offset: normal.dot(on_surface) + height })
    }

    /// No point of the cube beyond all planes is nearer to any point of a part of a face than this.
    /// As much as `needed` is enough.
    fn distance_beyond(&self, planes: &[Plane], of: &Extent, needed: f64) -> f64 {
        let point = of.centre;
        // Of the cube, only its sides towards the point matter.
        let mut all = [(Vector::ZERO, 0.0); MAX_PLANES + 3];
        let mut count = 0;
        for plane in planes.iter().take(MAX_PLANES) {
            all[count] = (plane.normal, plane.offset - plane.normal.dot(point));
            count += 1;
        }
        let arm = point - self.middle;
        for axis in 0..3 {
            let height = arm[axis].abs() - self.half;
            if height > 0.0 {
                all[count].0[axis] = -arm[axis].signum();
                all[count].1 = height;
                count += 1;
            }
        }
        // The dual of the projection onto the planes, one after the other (Hildreth, "A quadratic
        // programming procedure", 1957).
        let all = &all[..count];
        let mut weights = [0.0_f64; MAX_PLANES + 3];
        let mut moved = Vector::ZERO;
        let mut squared_distance = 0.0;
        for _ in 0..STEPS {
            for (&(normal, height), weight) in all.iter().zip(&mut weights) {
                let more = (height - normal.dot(moved)).max(-*weight);
                *weight += more;
                moved += normal * more;
            }
            let raised: f64 =
                all.iter().zip(&weights).map(|(&(_, height), weight)| weight * height).sum();
            let before = squared_distance;
            squared_distance = 2.0 * raised - moved.length_squared();
            let gained = squared_distance - before;
            if squared_distance >= squared(needed + of.radius)
                || gained <= LEAST_GAIN * squared_distance
            {
                break;
            }
        }
        // All points that are beyond are so along what was moved.
        squared_distance.max(0.0).sqrt() - of.along(moved)
    }
}

/// The ascent ends with a step that gains less than this share.
const LEAST_GAIN: f64 = 1e-3;

/// Distance between samples along an axis, as a fraction of the bound: no point is farther than 0.7
/// of it from one.
const SPACING: f64 = 0.8;

/// What samples may be too large by, as a fraction of the distance between them.
const SLACK: f64 = 0.2;

/// Planes of a small part, at most: a ball rests on three points.
const MAX_PLANES: usize = 8;

/// A ball that moves from outside, and how far it is entered at a point. See the module.
pub(crate) struct Probe {
    pub radius: f64,
    /// The box of the mesh.
    pub bounds: (Vector, Vector),
    /// Centres are this far from the solid's own surface at least.
    clear: f64,
    /// Half the side of a part that is not divided.
    least_half: f64,
    bound: f64,
    reach: Reach,
    /// For each cell that may hold centres its place among `parts`.
    places: Vec<u32>,
    parts: Vec<OnceLock<Part>>,
    field: Field,
}

/// A point, or a part of a face around it.
pub(crate) struct Extent {
    centre: Vector,
    /// From the centre to the corners.
    arms: [Vector; 3],
    /// Their greatest length.
    radius: f64,
}

impl Extent {
    fn point(point: Vector) -> Self {
        Self { centre: point, arms: [Vector::ZERO; 3], radius: 0.0 }
    }

    /// A part whose size counts as `factor` times its own.
    pub fn of_part(centre: Vector, corners: [Vector; 3], factor: f64) -> Self {
        let arms = corners.map(|corner| (corner - centre) * factor);
        let radius = arms.iter().map(|arm| arm.length()).fold(0.0, f64::max);
        Self { centre, arms, radius }
    }

    /// How far it extends in a direction, which need not be of unit length.
    fn along(&self, direction: Vector) -> f64 {
        if self.radius == 0.0 {
            return 0.0;
        }
        let unit = direction.normalize_or_zero();
        self.arms.iter().map(|arm| arm.dot(unit)).fold(0.0, f64::max)
    }
}

/// The parts beside a part, those beside the one that it is a child of, and so on.
struct Above<'a> {
    parts: &'a [Part; 8],
    above: Option<&'a Above<'a>>,
}

/// A search for the centre that is nearest to a point or a part.
struct Search<'a> {
    tree: &'a Bvh,
    of: &'a Extent,
    /// The least bound so far; at first the largest that matters.
    nearest: f64,
    /// Once the bound is below this, it is near enough.
    enough: f64,
    /// The bound may be too large by this.
    slack: f64,
}

impl Probe {
    /// The probe around a surface, under a bound on how far balls may be entered.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        tree: &Bvh,
        bounds: (Vector, Vector),
        &ProbeSettings { radius, ref from }: &ProbeSettings,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let clear = radius - ROUNDING;
        let reach = Reach::new(tree, bounds, [radius, clear], from, control)?;
        let least_half = LEAST_HALF * bound.min(radius);
        Ok(Self::within_reach(reach, bounds, [radius, clear, least_half, bound]))
    }

    /// The same with larger parts, whose half side is `least_half`: for fewer places, known less
    /// exactly.
    #[cfg(feature = "fill")]
    pub(super) fn coarser(&self, least_half: f64) -> Self {
        let sizes = [self.radius, self.clear, least_half, self.radius];
        Self::within_reach(self.reach.clone(), self.bounds, sizes)
    }

    fn within_reach(
        reach: Reach,
        bounds: (Vector, Vector),
        [radius, clear, least_half, bound]: [f64; 4],
    ) -> Self {
        let mut count = 0;
        let mut number = |cell: &Cell| {
            let place = count;
            count += u32::from(*cell == Cell::Partial);
            place
        };
        let places = reach.cells.iter().map(&mut number).collect();
        let mut parts = Vec::new();
        parts.resize_with(count as usize, OnceLock::new);
        let field = Field::new(bounds, SPACING * bound.min(radius));
        Self { radius, bounds, clear, least_half, bound, reach, places, parts, field }
    }

    /// Side of the cells that were flooded.
    pub fn cell(&self) -> f64 {
        self.reach.size
    }

    /// Balls that are entered farther than this show nothing.
    pub fn most_entered(&self) -> f64 {
        MOST_ENTERED * self.radius
    }

    /// Whether a ball may cover a point.
    pub fn reaches(&self, tree: &Bvh, point: Vector) -> bool {
        let of = &Extent::point(point);
        let search = Search { tree, of, nearest: self.radius, enough: self.radius, slack: 0.0 };
        self.clearance(search) < self.radius
    }

    /// How much farther a point is from all centres than the radius, within `limit` of zero, and no
    /// farther from it. Off by `tolerance` at most.
    #[cfg(feature = "fill")]
    pub(super) fn beyond_reach(
        &self,
        tree: &Bvh,
        point: Vector,
        limit: f64,
        tolerance: f64,
    ) -> f64 {
        let (most, enough) = (self.radius + limit, self.radius - limit);
        let of = Extent::point(point);
        let (nearest, slack) = (most + tolerance, 2.0 * tolerance);
        let clearance = self.clearance(Search { tree, of: &of, nearest, enough, slack });
        (clearance - tolerance).clamp(enough, most) - self.radius
    }

    /// Whether no ball is entered at a point by more than `bound`, and none by more than half its
    /// radius.
    pub fn allows(&self, tree: &Bvh, point: Vector, bound: f64) -> bool {
        self.allows_all(tree, &Extent::point(point), bound)
    }

    /// How far balls are entered at a point, at most. Exact where that is more than `known`. `None`
    /// if it may be more than `limit` or half their radius.
    pub fn entered(&self, tree: &Bvh, point: Vector, known: f64, limit: f64) -> Option<f64> {
        let needed = self.radius - known.min(self.most_entered());
        let (least, most) = self.clearance_by_sample(tree, point);
        if least >= needed {
            return Some(self.radius - least);
        }
        let least = self.radius - limit.min(self.most_entered());
        if most < least {
            return None;
        }
        let (of, nearest) = (&Extent::point(point), needed.min(most));
        let clearance = self.clearance(Search { tree, of, nearest, enough: least, slack: 0.0 });
        (clearance >= least).then_some(self.radius - clearance)
    }

    /// Whether no ball is entered by more than `bound` at any point of a part of a face. `false` if
    /// that is not known at once.
    pub fn allows_all(&self, tree: &Bvh, of: &Extent, bound: f64) -> bool {
        let needed = self.radius - bound.min(self.most_entered());
        let (least, most) = self.clearance_by_sample(tree, of.centre);
        if least - of.radius >= needed {
            return true;
        }
        let search = Search { tree, of, nearest: needed, enough: needed, slack: 0.0 };
        most >= needed && self.clearance(search) >= needed
    }

    /// How far balls are entered that can be entered farther by `more`; `None` as in
    /// [`entered`](Self::entered).
    pub fn entered_around(&self, entered: f64, more: f64) -> Option<f64> {
        let most = entered + more;
        (most <= self.most_entered()).then_some(most)
    }

    /// Bounds on [`clearance`](Self::clearance) by the nearest sample.
    fn clearance_by_sample(&self, tree: &Bvh, point: Vector) -> (f64, f64) {
        let field = &self.field;
        let Some(sample) = field.sample(point) else { return (0.0, f64::INFINITY) };
        let away = sample.point.distance(point) + ROUNDING;
        // Below that, no point for which this is the nearest sample is clear enough.
        let least = (self.radius - self.bound - field.spacing).max(0.0);
        let slack = SLACK * field.spacing;
        let known = sample.value(|| {
            let of = Extent::point(sample.point);
            let search = Search { tree, of: &of, nearest: self.radius, enough: least, slack };
            let clearance = self.clearance(search);
            if clearance < least { 0.0 } else { clearance }
        });
        let most = match known {
            0.0 => least + away,
            known if known + ROUNDING >= self.radius => f64::INFINITY,
            known => known + away,
        };
        (known - slack - away, most)
    }

    /// No centre is nearer to a point, or to any point of a part, than this less the slack. At most
    /// `nearest`; any value below `enough` if that is not reached.
    fn clearance(&self, mut search: Search<'_>) -> f64 {
        let Search { tree, of, nearest: most, enough, slack } = search;
        let (reach, point) = (&self.reach, of.centre);
        let half = 0.5 * reach.size;
        let own = reach.place(point);
        if reach.cells[reach.index(own)] == Cell::Open {
            return 0.0;
        }
        let way = Vector::splat(most + of.radius);
        let (low, high) = (reach.place(point - way), reach.place(point + way));
        let mut near: Vec<(f64, u32, Vector)> = Vec::new();
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    let index = reach.index([x, y, z]);
                    let cell = reach.cells[index];
                    if cell == Cell::Closed {
                        continue;
                    }
                    let middle = reach.centre([x, y, z]);
                    let distance = Cube { middle, half }.distance(of);
                    if distance >= search.nearest {
                        continue;
                    }
                    if cell == Cell::Partial {
                        near.push((distance, self.places[index], middle));
                        continue;
                    }
                    search.nearest = distance;
                    if search.nearest < enough {
                        return search.nearest;
                    }
                }
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (distance, place, middle) in near {
            if distance + slack >= search.nearest || search.nearest < enough {
                break;
            }
            let Some(part) = self.parts.get(place as usize) else { continue };
            let part = part.get_or_init(|| Part::new(tree, middle, u32::MAX));
            self.descend(part, Cube { middle, half }, 0.0, None, &mut search);
        }
        search.nearest
    }

    fn descend(
        &self,
        part: &Part,
        cube: Cube,
        bound: f64,
        above: Option<&Above<'_>>,
        search: &mut Search<'_>,
    ) {
        let of = search.of;
        if part.distance + cube.radius() < self.clear {
            return;
        }
        let mut bound = bound.max(cube.distance(of));
        if bound + search.slack >= search.nearest {
            return;
        }
        if let Some(plane) = cube.plane(part.nearest, self.clear) {
            bound = bound.max(cube.distance_beyond(&[plane], of, search.nearest));
        }
        if bound + search.slack >= search.nearest {
            return;
        }
        match part.within.get_or_init(|| self.within(search.tree, part, cube, above)) {
            Within::Planes(planes) => {
                let beyond = match planes.len() {
                    1 => 0.0,
                    _ => cube.distance_beyond(planes, of, search.nearest),
                };
                search.nearest = search.nearest.min(bound.max(beyond));
            }
            Within::Children(children) => {
                let side = |axis: usize| usize::from(of.centre[axis] > cube.middle[axis]) << axis;
                let nearest = side(0) | side(1) | side(2);
                for index in NEAREST_FIRST.map(|difference| nearest ^ difference) {
                    let above = Some(&Above { parts: children, above });
                    self.descend(&children[index], cube.child(index), bound, above, search);
                    if search.nearest < search.enough {
                        return;
                    }
                }
            }
        }
    }

    fn within(&self, tree: &Bvh, part: &Part, cube: Cube, above: Option<&Above<'_>>) -> Within {
        if cube.half > self.least_half {
            let child = |k| Part::new(tree, cube.child(k).middle, part.triangle);
            return Within::Children(Box::new(std::array::from_fn(child)));
        }
        // Those nearest first. Parts beside the same convex piece of the surface have points no
        // farther apart than the parts are, and planes that say about the same.
        let mut planes: Vec<Plane> = cube.plane(part.nearest, self.clear).into_iter().collect();
        let mut points = vec![part.nearest];
        let mut next = above;
        while let Some(Above { parts, above }) = next {
            for point in parts.iter().map(|part| part.nearest) {
                let is_new = || points.iter().all(|known| known.distance(point) > cube.radius());
                if planes.len() < MAX_PLANES && is_new() {
                    points.push(point);
                    planes.extend(cube.plane(point, self.clear));
                }
            }
            next = *above;
        }
        Within::Planes(planes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join};

    const BOUND: f64 = 0.02;

    /// Two blocks beside each other, `gap` apart, their tops at a height of 0.
    fn blocks(gap: f64) -> (Bvh, (Vector, Vector)) {
        let block = |x: f64| cuboid([x, -0.3, -0.2], [x + 0.2, 0.3, 0.0]);
        let mesh = join(&[block(-0.2 - 0.5 * gap), block(0.5 * gap)]);
        let bounds =
            (Vector::new(-0.2 - 0.5 * gap, -0.3, -0.2), Vector::new(0.2 + 0.5 * gap, 0.3, 0.0));
        (Bvh::new(mesh.points(), &mesh.triangles), bounds)
    }

    fn probe(tree: &Bvh, bounds: (Vector, Vector), radius: f64) -> Probe {
        let settings = ProbeSettings { radius, from: Vec::new() };
        Probe::new(tree, bounds, &settings, BOUND, &Control::new()).unwrap()
    }

    #[test]
    fn between_two_edges_a_ball_is_entered_as_far_as_it_sinks_in() {
        for radius in [0.06, 0.12] {
            for share in [0.3, 0.8, 1.2] {
                let gap = share * radius;
                let (tree, bounds) = blocks(gap);
                let probe = probe(&tree, bounds, radius);
                // Of the centre of a ball that rests on both edges.
                let height = (squared(radius) - squared(0.5 * gap)).sqrt();
                let sunk = radius - height;
                for depth in [0.0, 0.2 * sunk, 0.7 * sunk] {
                    let point = Vector::new(0.0, 0.013, -depth);
                    let (found, expected) =
                        (probe.entered(&tree, point, 0.0, radius), sunk - depth);
                    if expected > 0.5 * radius {
                        assert_eq!(found, None, "{radius}, {share}");
                        continue;
                    }
                    let found = found.unwrap();
                    let most = expected + 0.1 * BOUND;
                    assert!(
                        (expected - 1e-9..most).contains(&found),
                        "{radius}, {share}: {found} {expected}"
                    );
                    assert!(
                        probe.allows(&tree, point, found)
                            && !probe.allows(&tree, point, expected - 1e-3 * BOUND)
                    );
                }
                assert!(!probe.reaches(&tree, Vector::new(0.0, 0.0, -sunk - 0.1 * BOUND)));
                assert!(probe.reaches(&tree, Vector::new(0.0, 0.0, -0.9 * sunk)));
            }
        }
    }

    #[test]
    fn a_part_is_allowed_if_all_of_its_points_are() {
        let (radius, gap) = (0.06, 0.08);
        let (tree, bounds) = blocks(gap);
        let probe = probe(&tree, bounds, radius);
        let sunk = radius - (squared(radius) - squared(0.5 * gap)).sqrt();
        let part = |height: f64| {
            let corners = [[-0.01, -0.004, height], [0.01, -0.004, height], [0.0, 0.008, height]];
            Extent::of_part(Vector::new(0.0, 0.0, height), corners.map(Vector::from), 1.0)
        };
        assert!(probe.allows_all(&tree, &part(0.0), sunk + 0.1 * BOUND));
        assert!(!probe.allows_all(&tree, &part(0.0), sunk - 0.01 * BOUND));
        assert!(!probe.allows_all(&tree, &part(0.02), sunk + 0.1 * BOUND));
    }
}
