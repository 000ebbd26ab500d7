//! Fewer vertices, by three ways.
//!
//! - [`collapse_edges`] lets edges collapse outward, for as little volume as possible (progressive
//!   hulls, in Sander, Gu, Gortler, Hoppe, Snyder, "Silhouette clipping", 2000). An edge makes way
//!   for a point near it that lies in front of all faces at its two ends: the hull of the old one
//!   and that point has lost both ends, and holds all that it held.
//! - [`prominent`] leaves out vertices that hardly stand out, [`most_prominent`] all except those
//!   that stand out most: their hulls are smaller.
//! - [`limit_vertices`] tries all of them for a given number of vertices, lets their hulls grow
//!   about their centres until they hold the old hull, and takes the one that grew least.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::convex_hull::ConvexHull;
use super::face::{Face, after};
use super::growing_hull::HullBuilder;
use super::quickhull::{HullState, Shape, first_simplex};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, as_arrays, cubed, larger};

/// A new vertex lies this far in front of the faces that it replaces, in the builder's frame (where
/// a hull's extent is between 1 and 2): more than the tolerance, so that they vanish.
const CLEARANCE: f64 = 2e-6;

/// Sweeps of the projection onto the space in front of all faces. Moving outward makes up for what
/// they leave undone.
const SWEEPS: usize = 6;

/// The points of an edge that the new point should be near to, as fractions of the way along it;
/// the one that adds the least volume counts.
const STARTS: [f64; 3] = [0.5, 0.0, 1.0];

/// Fewest vertices of a hull.
const MIN_VERTICES: usize = 4;

/// Collapsing takes time like the square of the number of vertices: larger hulls don't collapse.
const MAX_COLLAPSIBLE: usize = 4096;

/// More vertices than this are thinned out before edges collapse.
const MANY_VERTICES: usize = 512;

/// The first tolerance of thinning out, as a fraction of the hull's extent; it doubles as long as
/// it is too fine.
const THINNING: f64 = 1e-4;

/// When a hull has grown over another one, rounding must not leave a vertex outside.
const ROUNDING: f64 = 1e-12;

/// What an edge may make way for, in the builder's frame.
#[derive(Debug, Clone, Copy)]
struct Collapse {
    /// The edge's vertices, the lower index first.
    edge: (u32, u32),
    /// Added volume; infinite if no direction leads out of all faces, or if it is no edge any more.
    volume: f64,
    point: Vector,
    /// The round in which it was found.
    round: u32,
}

impl PartialEq for Collapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Collapse {}
impl PartialOrd for Collapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Collapse {
    /// The cheapest is the greatest, since a heap pops that first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.volume.total_cmp(&self.volume).then_with(|| other.edge.cmp(&self.edge))
    }
}

/// Collapses that may come next, cheapest first.
///
/// Where faces at the ends of an edge have changed, its collapse is out of date. Mostly it has
/// become dearer, so that it is computed again only when its turn comes.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Collapse>,
    /// For each vertex the last round in which its faces changed.
    changed: Vec<u32>,
    /// For each vertex the collapses that were refused at it. They return when its faces change.
    refused: Vec<Vec<Collapse>>,
    round: u32,
}

impl Queue {
    fn add(&mut self, collapse: Collapse) {
        if collapse.volume.is_finite() {
            self.heap.push(collapse);
        } else {
            self.refuse(collapse);
        }
    }

    fn refuse(&mut self, collapse: Collapse) {
        let (a, b) = collapse.edge;
        self.refused[a as usize].push(collapse);
        self.refused[b as usize].push(collapse);
    }

    /// Starts a round in which the faces at these vertices have changed.
    fn change(&mut self, vertices: impl Iterator<Item = u32>) {
        self.round += 1;
        for vertex in vertices {
            self.changed[vertex as usize] = self.round;
            for collapse in std::mem::take(&mut self.refused[vertex as usize]) {
                let (a, b) = collapse.edge;
                let other = &mut self.refused[(if a == vertex { b } else { a }) as usize];
                other.retain(|known| known.edge != collapse.edge);
                self.heap.push(collapse);
            }
        }
    }
}

/// A face at an end of an edge.
struct Constraint {
    normal: Vector,
    offset: f64,
    area: f64,
    /// How far it has moved the new point.
    push: f64,
}

/// A hull of fewer vertices that holds `hull`, and how far it grew: no point of it is farther than
/// that from the old one, in the points' units. `None` if no vertex was saved, as for a hull of
/// very many.
///
/// Cheapest edges go first, each only if `fits` accepts all new faces: as long as one adds at most
/// `most_volume`, in cubed units, and beyond that while there are more than `max_vertices`
/// vertices. O(n²) for n vertices, with a small constant.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::DeadlineExceeded`], and those of `fits`.
pub(crate) fn collapse_edges(
    hull: &ConvexHull,
    most_volume: f64,
    max_vertices: usize,
    control: &Control,
    fits: &mut impl FnMut([Vector; 3]) -> Result<bool, Error>,
) -> Result<Option<(ConvexHull, f64)>, Error> {
    let mut builder = HullBuilder::new();
    if hull.points.len() > MAX_COLLAPSIBLE || builder.build(&hull.points) != Shape::Solid {
        return Ok(None);
    }
    let frame = builder.hull.frame;
    let most_volume = if most_volume > 0.0 { most_volume * cubed(frame.factor) } else { 0.0 };
    let mut trial = HullBuilder::new();
    let mut fans = Vec::new();
    let mut constraints = Vec::new();
    let mut queue = Queue::default();
    let mut new: Vec<(u32, u32)> = edges(builder.hull.faces.iter()).collect();
    loop {
        let vertices = find_fans(&builder.hull, &mut fans);
        if vertices <= MIN_VERTICES {
            break;
        }
        queue.changed.resize(fans.len(), 0);
        queue.refused.resize_with(fans.len(), Vec::new);
        for edge in new.drain(..) {
            control.check()?;
            queue.add(collapse(&builder.hull, &fans, edge, queue.round, &mut constraints));
        }
        let mut is_taken = false;
        while let Some(cheapest) = queue.heap.pop() {
            let (a, b) = cheapest.edge;
            if [a, b].iter().any(|&vertex| fans[vertex as usize].is_empty()) {
                continue;
            }
            if cheapest.volume > most_volume && vertices <= max_vertices {
                break;
            }
            if [a, b].iter().any(|&vertex| queue.changed[vertex as usize] > cheapest.round) {
                queue.add(collapse(&builder.hull, &fans, (a, b), queue.round, &mut constraints));
                continue;
            }
            trial.clone_from(&builder);
            trial.insert(&[frame.outward(cheapest.point).to_array()]);
            // Each collapse saves a vertex, unless rounding comes in between.
            if trial.triangle_count() < builder.triangle_count() {
                let mut misfits =
                    trial.new_faces().map(&mut *fits).filter(|fits| *fits != Ok(true));
                if misfits.next().unwrap_or(Ok(true))? {
                    is_taken = true;
                    break;
                }
            }
            queue.refuse(cheapest);
        }
        if !is_taken {
            break;
        }
        std::mem::swap(&mut builder, &mut trial);
        let changed = builder.hull.newest().flat_map(|face| face.vertices);
        queue.change(changed.filter(|&vertex| (vertex as usize) < fans.len()));
        // The new vertex, and points that were within the tolerance of the old faces.
        let is_new = |vertex: u32| fans.get(vertex as usize).is_none_or(Vec::is_empty);
        new.extend(edges(builder.hull.newest()).filter(|&(a, b)| is_new(a) || is_new(b)));
    }
    let fewer = ConvexHull::from(builder.extract());
    if fewer.points.len() >= hull.points.len() {
        return Ok(None);
    }
    let growth = growth(&fewer, hull);
    Ok(Some((fewer, growth)))
}

/// How far the farthest point of a hull is from another one. O(vertices · triangles).
fn growth(hull: &ConvexHull, old: &ConvexHull) -> f64 {
    let planes = old.face_planes();
    // The distance to a convex set is a convex function, and so largest at a vertex.
    let distances = hull.points().iter().map(|&point| old.distance_outside(&planes, point));
    distances.fold(0.0, f64::max)
}

/// The edges of some faces, the vertex of the lower index first.
fn edges<'a>(faces: impl Iterator<Item = &'a Face>) -> impl Iterator<Item = (u32, u32)> {
    faces
        .flat_map(|face| [0, 1, 2].map(|edge| (face.vertices[edge], face.vertices[after(edge)])))
        // Each is met from both its faces.
        .filter(|(a, b)| a < b)
}

/// Lists the faces at each point. Returns how many points have some.
fn find_fans(hull: &HullState, fans: &mut Vec<Vec<u32>>) -> usize {
    fans.iter_mut().for_each(Vec::clear);
    fans.resize(hull.points.len(), Vec::new());
    for (index, face) in (0..).zip(&hull.faces) {
        for vertex in face.vertices {
            fans[vertex as usize].push(index);
        }
    }
    fans.iter().filter(|fan| !fan.is_empty()).count()
}

/// What an edge may make way for, if it is still one. `constraints` is memory.
fn collapse(
    hull: &HullState,
    fans: &[Vec<u32>],
    edge: (u32, u32),
    round: u32,
    constraints: &mut Vec<Constraint>,
) -> Collapse {
    let (a, b) = edge;
    let [fan, other_fan] = [a, b].map(|vertex| fans[vertex as usize].as_slice());
    let face = |&index: &u32| &hull.faces[index as usize];
    constraints.clear();
    let mut outward = Vector::ZERO;
    let others = other_fan.iter().map(face).filter(|face| !face.vertices.contains(&a));
    for face in fan.iter().map(face).chain(others).filter(|face| face.inverse > 0.0) {
        let normal = face.plane.normal * face.inverse;
        outward += normal;
        constraints.push(Constraint {
            normal,
            offset: face.plane.offset * face.inverse + CLEARANCE,
            area: 0.5 / face.inverse,
            push: 0.0,
        });
    }
    let is_edge = fan.iter().map(face).any(|face| face.vertices.contains(&b));
    let [a, b] = [a, b].map(|vertex| hull.points[vertex as usize]);
    let nowhere = Collapse { edge, volume: f64::INFINITY, point: a, round };
    if !is_edge {
        return nowhere;
    }
    let ways = STARTS.iter().filter_map(|&share| {
        let start = a * (1.0 - share) + b * share;
        let point = projected(start, constraints, outward)?;
        let volumes = constraints
            .iter()
            .map(|constraint| constraint.area * (constraint.normal.dot(point) - constraint.offset));
        Some(Collapse { edge, volume: volumes.sum::<f64>() / 3.0, point, round })
    });
    ways.min_by(|a, b| a.volume.total_cmp(&b.volume)).unwrap_or(nowhere)
}

/// The point nearest to another one in front of all faces (Hildreth, "A quadratic programming
/// procedure", 1957), moved outward as far as is missing in the end.
fn projected(from: Vector, constraints: &mut [Constraint], outward: Vector) -> Option<Vector> {
    let mut point = from;
    constraints.iter_mut().for_each(|constraint| constraint.push = 0.0);
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for constraint in &mut *constraints {
            let missing = constraint.offset - constraint.normal.dot(point);
            let push = larger(constraint.push + missing, 0.0);
            let more = push - constraint.push;
            if more != 0.0 {
                is_done &= more.abs() < CLEARANCE;
                point += constraint.normal * more;
                constraint.push = push;
            }
        }
        if is_done {
            break;
        }
    }
    let by = constraints.iter().map(|constraint| {
        let missing = constraint.offset - constraint.normal.dot(point);
        if missing > 0.0 { missing / constraint.normal.dot(outward) } else { 0.0 }
    });
    let by = by.fold(0.0, larger);
    let point = point + outward * by;
    // Moving outward does not lead in front of faces that look away from the others.
    let is_in_front = |constraint: &Constraint| {
        constraint.normal.dot(point) >= constraint.offset - 0.5 * CLEARANCE
    };
    constraints.iter().all(is_in_front).then_some(point)
}

/// A hull of at most `max_vertices` vertices that holds all of `hull`, and how far it grew: no
/// point of it is farther than that from the old one, in the points' units. A hull of few enough
/// vertices stays as it is, and any hull if `max_vertices` is below 4.
///
/// O(n log n + m² n) for n vertices, of which m are left.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn limit_vertices(
    builder: &mut HullBuilder,
    hull: ConvexHull,
    max_vertices: usize,
    control: &Control,
) -> Result<(ConvexHull, f64), Error> {
    if hull.points.len() <= max_vertices {
        return Ok((hull, 0.0));
    }
    let thin = match hull.points.len() {
        ..=MANY_VERTICES => None,
        _ => thinned(builder, &hull, control)?,
    };
    let mut fits = |_| control.check().map(|()| true);
    let collapsible = thin.as_ref().unwrap_or(&hull);
    let collapsed = collapse_edges(collapsible, 0.0, max_vertices, control, &mut fits)?;
    let collapsed = collapsed.map(|(collapsed, _)| collapsed);
    // For very few vertices the cheapest collapses, one by one, don't lead to the best hull.
    let prominent = most_prominent(builder, hull.points(), max_vertices, control)?;
    let fewer = [thin, collapsed, prominent].into_iter().flatten();
    let fewer = fewer.filter(|fewer| fewer.points.len() <= max_vertices).filter_map(|fewer| {
        let grown = grown_over(fewer, &hull)?;
        let growth = growth(&grown, &hull);
        Some((grown, growth))
    });
    Ok(fewer.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((hull, 0.0)))
}

/// A hull of the vertices that stand out of the rest by more than a tolerance: about the least that
/// leaves few enough to collapse.
fn thinned(
    builder: &mut HullBuilder,
    hull: &ConvexHull,
    control: &Control,
) -> Result<Option<ConvexHull>, Error> {
    let mut tolerance = THINNING;
    while tolerance < 1.0 {
        let mut coarse = HullBuilder::new().with_tolerance(tolerance);
        if coarse.build(&hull.points) != Shape::Solid {
            break;
        }
        let (points, triangles) = coarse.extract();
        if points.len() <= MANY_VERTICES {
            return Ok(Some((points, triangles).into()));
        }
        control.check()?;
        tolerance *= 2.0;
    }
    most_prominent(builder, hull.points(), MANY_VERTICES, control)
}

/// The hull of the vertices that stand out of each other by more than `tolerance`, in the points'
/// units: the others are at most that far in front of a face. `None` if none is left.
pub(crate) fn prominent(hull: &ConvexHull, tolerance: f64) -> Option<ConvexHull> {
    let mut builder = HullBuilder::new().with_least_tolerance(tolerance);
    (builder.build(&hull.points) == Shape::Solid).then(|| builder.extract().into())
}

/// The hull of up to `max_vertices` points, each the farthest outside the hull of those before.
pub(crate) fn most_prominent(
    builder: &mut HullBuilder,
    points: &[Vector],
    max_vertices: usize,
    control: &Control,
) -> Result<Option<ConvexHull>, Error> {
    let (_, simplex) = first_simplex(points, 0.0);
    let corners = simplex.iter().filter_map(|&index| points.get(index as usize).copied());
    let first: Vec<Vector> = corners.collect();
    if builder.build(as_arrays(&first)) != Shape::Solid || first.len() > max_vertices {
        return Ok(None);
    }
    for _ in first.len()..max_vertices {
        control.check()?;
        let planes = ConvexHull::from(builder.extract()).face_planes();
        let height = |point: Vector| {
            let heights = planes.iter().map(|plane| plane.height(point));
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        let heights = points.iter().map(|&point| (height(point), point));
        let Some((_, farthest)) = heights.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        builder.insert(&[farthest.to_array()]);
        if builder.new_faces().next().is_none() {
            // It is in the hull up to the tolerance, and so are all others.
            break;
        }
    }
    Ok(Some(builder.extract().into()))
}

/// Lets a hull grow about its centre until it holds another one. The factor is exact: the largest,
/// over the planes, of the other hull's extent in front of the centre over its own.
fn grown_over(mut kept: ConvexHull, hull: &ConvexHull) -> Option<ConvexHull> {
    let sum = kept.points().iter().fold(Vector::ZERO, |sum, &point| sum + point);
    let centre = sum * (1.0 / kept.points.len() as f64);
    let mut factor: f64 = 1.0;
    for Plane { normal, offset } in kept.face_planes() {
        let own = offset - normal.dot(centre);
        let extents = hull.points().iter().map(|&point| normal.dot(point - centre));
        let wanted = extents.fold(f64::NEG_INFINITY, f64::max);
        if own > 0.0 {
            factor = factor.max(wanted / own);
        } else if normal != Vector::ZERO {
            return None;
        }
    }
    if factor > 1.0 {
        let factor = factor * (1.0 + ROUNDING);
        for point in &mut kept.points {
            *point = (centre + (Vector::from(*point) - centre) * factor).to_array();
        }
    }
    Some(kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull::convex_hull;
    use crate::mesh::shapes::cuboid;

    /// A prism over a regular polygon.
    fn prism(corners: u32, height: f64) -> ConvexHull {
        let points = (0..corners).flat_map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
            [0.0, height].map(|z| [angle.cos(), angle.sin(), z])
        });
        convex_hull(&points.collect::<Vec<_>>()).unwrap()
    }

    fn collapsed(
        hull: &ConvexHull,
        most_volume: f64,
        mut fits: impl FnMut([Vector; 3]) -> Result<bool, Error>,
    ) -> Result<Option<(ConvexHull, f64)>, Error> {
        collapse_edges(hull, most_volume, usize::MAX, &Control::new(), &mut fits)
    }

    #[test]
    fn a_prism_with_fewer_sides_holds_the_old_one_and_little_more() {
        let full = prism(40, 1.0);
        let (fewer, growth) = collapsed(&full, 1e-3, |_| Ok(true)).unwrap().unwrap();
        assert!(fewer.holds(&full));
        assert!(fewer.points.len() <= 48, "{}", fewer.points.len());
        assert!(fewer.volume() < 1.1 * full.volume());
        assert!(growth > 0.0 && growth < 0.2, "{growth}");
        assert_eq!(collapsed(&full, 0.0, |_| Ok(true)), Ok(None), "nothing is saved for no volume");
    }

    #[test]
    fn no_face_that_does_not_fit_is_made_and_errors_end_it() {
        let full = prism(40, 1.0);
        let is_old = |&Vector { x, y, .. }: &Vector| x < 0.0 || x.hypot(y) < 1.0 + 1e-5;
        let on_the_left = |face: [Vector; 3]| Ok(face.iter().all(is_old));
        let (fewer, _) = collapsed(&full, 1e-3, on_the_left).unwrap().unwrap();
        assert!(fewer.points.len() < full.points.len());
        assert!(fewer.points().iter().all(is_old));
        assert_eq!(collapsed(&full, 1e-3, |_| Err(Error::Cancelled)), Err(Error::Cancelled));
    }

    #[test]
    fn growth_is_the_distance_of_the_farthest_corner() {
        let cube = cuboid([0.0; 3], [1.0; 3]).positions;
        let grown = [cube.clone(), vec![[1.3, 1.4, 0.5]]].concat();
        let [cube, grown] = [cube, grown].map(|points| convex_hull(&points).unwrap());
        // From the middle of an edge by 0.3 and 0.4.
        assert!((growth(&grown, &cube) - 0.5).abs() < 1e-12);
        assert_eq!(growth(&cube, &grown), 0.0);
    }

    /// Over points of the unit sphere, evenly (Fibonacci's lattice).
    fn ball(count: u32) -> ConvexHull {
        let point = |i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let angle = f64::from(i) * std::f64::consts::PI * (3.0 - 5f64.sqrt());
            let ring = (1.0 - z * z).sqrt();
            [ring * angle.cos(), ring * angle.sin(), z]
        };
        convex_hull(&(0..count).map(point).collect::<Vec<_>>()).unwrap()
    }

    fn limited(hull: &ConvexHull, max_vertices: usize) -> (ConvexHull, f64) {
        let control = Control::new();
        limit_vertices(&mut HullBuilder::new(), hull.clone(), max_vertices, &control).unwrap()
    }

    #[test]
    fn limiting_can_be_cancelled() {
        let control = Control::new();
        control.cancel();
        let result = limit_vertices(&mut HullBuilder::new(), ball(300), 64, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }

    #[test]
    fn the_most_prominent_points_are_as_many_as_allowed() {
        let full = ball(300);
        for count in [6, 7, 20, 64] {
            let mut builder = HullBuilder::new();
            let found = most_prominent(&mut builder, full.points(), count, &Control::new());
            let found = found.unwrap().unwrap();
            assert_eq!(found.points.len(), count);
            assert!(full.holds(&found));
        }
    }

    #[test]
    fn a_limited_hull_holds_the_old_one_and_says_how_far_it_grew() {
        let full = ball(300);
        for (most, most_growth) in [(64, 0.12), (32, 0.25), (8, 1.5)] {
            let (limited, growth) = limited(&full, most);
            assert!(limited.points.len() <= most);
            assert!(limited.holds(&full), "{most}");
            assert!(limited.holds(&limited), "{most} is convex");
            let farthest = limited.points().iter().map(|&p| p.length()).fold(0.0, f64::max);
            assert!(farthest - 1.0 <= growth + 1e-9);
            assert!(growth < most_growth, "{most}: {growth}");
        }
        assert_eq!(limited(&full, 300), (full, 0.0), "few enough vertices stay as they are");
    }

    #[test]
    fn very_many_vertices_and_very_large_units_are_limited_too() {
        let full = ball(1500);
        for factor in [1e200, 1e-170] {
            let mut full = full.clone();
            full.points
                .iter_mut()
                .for_each(|point| *point = (Vector::from(*point) * factor).to_array());
            for most in [64, 600] {
                assert!(limited(&full, most).0.points.len() <= most, "{factor:e}");
            }
        }
        for (most, most_growth) in [(64, f64::INFINITY), (600, 0.02)] {
            let (limited, growth) = limited(&full, most);
            assert!(limited.points.len() <= most && limited.holds(&full));
            assert!(growth < most_growth, "{growth}");
        }
    }

    #[test]
    fn a_thin_plate_stays_thin() {
        let plate = prism(100, 0.02);
        let (limited, _) = limited(&plate, 64);
        let bounds = limited.bounds().unwrap();
        assert!(limited.holds(&plate));
        assert!(bounds.max[2] - bounds.min[2] < 0.03, "{bounds:?}");
    }
}
