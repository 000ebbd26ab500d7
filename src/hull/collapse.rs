//! Fewer vertices for as little volume as possible: edges collapse outward (progressive hulls, in
//! Sander, Gu, Gortler, Hoppe, Snyder, "Silhouette clipping", 2000).
//!
//! An edge makes way for a point near it that lies in front of all faces at its two ends. The hull
//! of the old one and that point has lost both ends, and holds all that it held.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::builder::HullBuilder;
use super::convex_hull::ConvexHull;
use super::face::{Face, after};
use super::simplex::Shape;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, cubed, dot, length, scale, subtract};

/// A new vertex lies this far in front of the faces that it replaces, in the builder's scaled space
/// (where a hull's extent is between 1 and 2): more than the tolerance, so that they vanish.
const CLEARANCE: f64 = 2e-6;

/// Sweeps of the projection onto the space in front of all faces. What they leave undone is made
/// up for by moving outward.
const SWEEPS: usize = 6;

/// The points of an edge that the new point should be near to, as shares of the way along it; the
/// one that leads to the least volume counts.
const STARTS: [f64; 3] = [0.5, 0.0, 1.0];

/// Fewest vertices of a hull.
const LEAST_VERTICES: usize = 4;

/// Collapsing takes time like the square of the number of vertices: nothing is done beyond this
/// many.
const MOST_VERTICES: usize = 4096;

/// What an edge may make way for, in the builder's scaled space.
#[derive(Debug, Clone, Copy)]
struct Collapse {
    pair: (u32, u32),
    /// Added volume; infinite if no direction leads out of all faces, or if it is no edge any more.
    volume: f64,
    point: Vector,
    /// The round that it was found in.
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
    /// The cheapest is the greatest, as a heap wants it.
    fn cmp(&self, other: &Self) -> Ordering {
        other.volume.total_cmp(&self.volume).then_with(|| other.pair.cmp(&self.pair))
    }
}

/// Collapses that may come next, cheapest first.
///
/// Where faces at the ends of an edge have changed, what is known of it is out of date. Mostly it has
/// become dearer, so that it is looked at again only when its turn comes.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Collapse>,
    /// For each vertex the last round in which its faces changed.
    changed: Vec<u32>,
    /// For each vertex what was refused at it. A change there gives it another chance, at its turn.
    refused: Vec<Vec<Collapse>>,
    round: u32,
}

impl Queue {
    fn is_out_of_date(&self, collapse: &Collapse) -> bool {
        let (a, b) = collapse.pair;
        [a, b].iter().any(|&vertex| self.changed[vertex as usize] > collapse.round)
    }

    fn add(&mut self, collapse: Collapse) {
        if collapse.volume.is_finite() {
            self.heap.push(collapse);
        } else {
            self.refuse(collapse);
        }
    }

    fn refuse(&mut self, collapse: Collapse) {
        let (a, b) = collapse.pair;
        self.refused[a as usize].push(collapse);
        self.refused[b as usize].push(collapse);
    }

    /// Faces at these vertices have changed.
    fn change(&mut self, vertices: impl Iterator<Item = u32>) {
        self.round += 1;
        for vertex in vertices {
            self.changed[vertex as usize] = self.round;
            let refused = std::mem::take(&mut self.refused[vertex as usize]);
            for collapse in refused {
                let (a, b) = collapse.pair;
                let other = &mut self.refused[(if a == vertex { b } else { a }) as usize];
                other.retain(|known| known.pair != collapse.pair);
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
    /// How far it has moved the point that is looked for.
    push: f64,
}

/// A hull of fewer vertices that holds `hull`, and how far it grew: no point of it is farther than
/// that from the old one, in the points' units. `None` if no vertex was saved, as for a hull of very
/// many.
///
/// Cheapest edges go first, each only if all new faces are as `fits` wants them: as long as one
/// adds at most `most_volume`, in cubed units, and beyond that while there are more than `cap`
/// vertices. O(n²) for n vertices, with a small constant.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::DeadlineExceeded`], and those of `fits`.
pub(crate) fn collapse_edges(
    hull: &ConvexHull,
    most_volume: f64,
    cap: usize,
    control: &Control,
    fits: &mut impl FnMut([Vector; 3]) -> Result<bool, Error>,
) -> Result<Option<(ConvexHull, f64)>, Error> {
    let mut builder = HullBuilder::new();
    if hull.points.len() > MOST_VERTICES || builder.build(&hull.points) != Shape::Solid {
        return Ok(None);
    }
    let most_volume = if most_volume > 0.0 { most_volume * cubed(builder.factor) } else { 0.0 };
    let mut trial = HullBuilder::new();
    let mut faces: Vec<Vec<u32>> = Vec::new();
    let mut constraints = Vec::new();
    let mut queue = Queue::default();
    let mut new: Vec<(u32, u32)> = edges(builder.faces.iter()).collect();
    loop {
        let vertices = faces_of_vertices(&builder, &mut faces);
        if vertices <= LEAST_VERTICES {
            break;
        }
        queue.changed.resize(builder.points.len(), 0);
        queue.refused.resize_with(builder.points.len(), Vec::new);
        for pair in new.drain(..) {
            control.check()?;
            queue.add(collapse(&builder, &faces, pair, queue.round, &mut constraints));
        }
        let mut is_taken = false;
        while let Some(cheapest) = queue.heap.pop() {
            let (a, b) = cheapest.pair;
            if [a, b].iter().any(|&vertex| faces[vertex as usize].is_empty()) {
                continue;
            }
            if cheapest.volume > most_volume && vertices <= cap {
                break;
            }
            if queue.is_out_of_date(&cheapest) {
                queue.add(collapse(&builder, &faces, (a, b), queue.round, &mut constraints));
                continue;
            }
            trial.clone_from(&builder);
            trial.insert(&[builder.outward(cheapest.point)]);
            // Each collapse saves a vertex, unless rounding comes in between.
            let is_smaller = trial.triangle_count() < builder.triangle_count();
            if is_smaller && all_fit(&trial, fits)? {
                is_taken = true;
                break;
            }
            queue.refuse(cheapest);
        }
        if !is_taken {
            break;
        }
        let before = builder.points.len() as u32;
        std::mem::swap(&mut builder, &mut trial);
        queue.change(builder.newest_vertices().filter(|&vertex| vertex < before));
        // The new vertex, and what waited within the tolerance of the old faces.
        let is_new = |vertex: u32| faces.get(vertex as usize).is_none_or(Vec::is_empty);
        new.extend(edges(builder.newest()).filter(|&(a, b)| is_new(a) || is_new(b)));
    }
    let fewer = ConvexHull::from(builder.extract());
    if fewer.points.len() >= hull.points.len() {
        return Ok(None);
    }
    let growth = growth(&fewer, hull);
    Ok(Some((fewer, growth)))
}

fn all_fit(
    builder: &HullBuilder,
    fits: &mut impl FnMut([Vector; 3]) -> Result<bool, Error>,
) -> Result<bool, Error> {
    for face in builder.new_faces() {
        if !fits(face)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// How far the farthest point of a hull is from another one. O(vertices · triangles).
pub(super) fn growth(hull: &ConvexHull, old: &ConvexHull) -> f64 {
    let planes = old.planes();
    // The distance to a convex set is a convex function, and so largest at a vertex. What is
    // nearest to a point outside is on a face that it is in front of.
    let away = |&point: &Vector| {
        let in_front =
            old.corners().zip(&planes).filter(|(_, plane)| dot(plane.0, point) > plane.1).map(
                |(corners, _)| {
                    let [a, b, c] = corners.map(|corner| subtract(corner, point));
                    length(closest_point_on_triangle(a, b, c))
                },
            );
        in_front.min_by(f64::total_cmp).unwrap_or(0.0)
    };
    hull.points.iter().map(away).fold(0.0, f64::max)
}

/// The edges of some faces, the vertex of the lower number first.
fn edges<'a>(faces: impl Iterator<Item = &'a Face>) -> impl Iterator<Item = (u32, u32)> {
    faces
        .flat_map(|face| [0, 1, 2].map(|edge| (face.vertices[edge], face.vertices[after(edge)])))
        // Each is met from both its faces.
        .filter(|(a, b)| a < b)
}

/// Lists the faces at each point. Returns how many points have some.
fn faces_of_vertices(builder: &HullBuilder, faces: &mut Vec<Vec<u32>>) -> usize {
    faces.iter_mut().for_each(Vec::clear);
    faces.resize(builder.points.len(), Vec::new());
    for (index, face) in (0..).zip(&builder.faces) {
        for vertex in face.vertices {
            faces[vertex as usize].push(index);
        }
    }
    faces.iter().filter(|faces| !faces.is_empty()).count()
}

/// What an edge may make way for, if it is still one.
fn collapse(
    builder: &HullBuilder,
    faces: &[Vec<u32>],
    pair: (u32, u32),
    round: u32,
    constraints: &mut Vec<Constraint>,
) -> Collapse {
    let (a, b) = pair;
    constraints.clear();
    let mut outward = [0.0; 3];
    let of_both = faces[a as usize].iter().chain(&faces[b as usize]);
    for (place, &face) in of_both.enumerate() {
        let face = &builder.faces[face as usize];
        let is_known = place >= faces[a as usize].len() && face.vertices.contains(&a);
        if is_known || face.inverse <= 0.0 {
            continue;
        }
        let normal = scale(face.plane.normal, face.inverse);
        outward = add(outward, normal);
        constraints.push(Constraint {
            normal,
            offset: face.plane.offset * face.inverse + CLEARANCE,
            area: 0.5 / face.inverse,
            push: 0.0,
        });
    }
    let is_edge =
        faces[a as usize].iter().any(|&face| builder.faces[face as usize].vertices.contains(&b));
    let [a, b] = [a, b].map(|vertex| builder.points[vertex as usize]);
    let nowhere = Collapse { pair, volume: f64::INFINITY, point: a, round };
    if !is_edge {
        return nowhere;
    }
    let ways = STARTS.iter().filter_map(|&share| {
        let start = add(scale(a, 1.0 - share), scale(b, share));
        let point = projected(start, constraints, outward)?;
        let volume = added_volume(point, constraints);
        Some(Collapse { pair, volume, point, round })
    });
    ways.min_by(|a, b| a.volume.total_cmp(&b.volume)).unwrap_or(nowhere)
}

/// Volume between faces and a point in front of all of them.
fn added_volume(point: Vector, constraints: &[Constraint]) -> f64 {
    let volumes = constraints
        .iter()
        .map(|constraint| constraint.area * (dot(constraint.normal, point) - constraint.offset));
    volumes.sum::<f64>() / 3.0
}

/// The point nearest to another one in front of all faces (Hildreth, "A quadratic programming
/// procedure", 1957), moved outward as far as is missing in the end.
fn projected(from: Vector, constraints: &mut [Constraint], outward: Vector) -> Option<Vector> {
    let mut point = from;
    constraints.iter_mut().for_each(|constraint| constraint.push = 0.0);
    for _ in 0..SWEEPS {
        let mut is_done = true;
        for constraint in &mut *constraints {
            let missing = constraint.offset - dot(constraint.normal, point);
            let push = (constraint.push + missing).max(0.0);
            let more = push - constraint.push;
            if more != 0.0 {
                is_done &= more.abs() < CLEARANCE;
                point = add(point, scale(constraint.normal, more));
                constraint.push = push;
            }
        }
        if is_done {
            break;
        }
    }
    let by = constraints.iter().map(|constraint| {
        let missing = constraint.offset - dot(constraint.normal, point);
        if missing > 0.0 { missing / dot(constraint.normal, outward) } else { 0.0 }
    });
    let by = by.fold(0.0, f64::max);
    let point = add(point, scale(outward, by));
    // Faces that look away from the others are not reached that way, or left behind.
    let is_in_front = |constraint: &Constraint| {
        dot(constraint.normal, point) >= constraint.offset - 0.5 * CLEARANCE
    };
    constraints.iter().all(is_in_front).then_some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    /// A prism over a regular polygon.
    fn prism(corners: u32) -> ConvexHull {
        let points = (0..corners).flat_map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
            [-0.5, 0.5].map(|z| [angle.cos(), angle.sin(), z])
        });
        convex_hull(&points.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_prism_with_fewer_sides_holds_the_old_one_and_little_more() {
        let full = prism(40);
        let (fewer, growth) =
            collapse_edges(&full, 1e-3, usize::MAX, &Control::new(), &mut |_| Ok(true))
                .unwrap()
                .unwrap();
        assert!(fewer.holds(&full));
        assert!(fewer.points.len() <= 48, "{}", fewer.points.len());
        assert!(fewer.volume() < 1.1 * full.volume());
        assert!(growth > 0.0 && growth < 0.2, "{growth}");
    }

    #[test]
    fn nothing_is_saved_at_no_cost_in_volume() {
        assert!(
            collapse_edges(&prism(40), 0.0, usize::MAX, &Control::new(), &mut |_| Ok(true))
                .unwrap()
                .is_none()
        );
    }

    #[test]
    fn faces_that_do_not_fit_stay_away() {
        let full = prism(40);
        let is_old = |&[x, y, _]: &Vector| x < 0.0 || x.hypot(y) < 1.0 + 1e-5;
        let mut on_the_left = |face: [Vector; 3]| Ok(face.iter().all(is_old));
        let (fewer, _) = collapse_edges(&full, 1e-3, usize::MAX, &Control::new(), &mut on_the_left)
            .unwrap()
            .unwrap();
        assert!(fewer.points.len() < full.points.len());
        assert!(fewer.points.iter().all(is_old));
    }

    #[test]
    fn growth_is_the_distance_of_the_farthest_corner() {
        let cube: Vec<Vector> =
            (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1))).collect();
        let mut grown = cube.clone();
        grown.push([1.3, 1.4, 0.5]);
        let [cube, grown] = [cube, grown].map(|points| convex_hull(&points).unwrap());
        // From the middle of an edge by 0.3 and 0.4.
        assert!((growth(&grown, &cube) - 0.5).abs() < 1e-12);
        assert_eq!(growth(&cube, &grown), 0.0);
    }

    #[test]
    fn an_error_ends_it() {
        let mut cancelled = |_| Err(Error::Cancelled);
        let result = collapse_edges(&prism(40), 1e-3, usize::MAX, &Control::new(), &mut cancelled);
        assert!(matches!(result, Err(Error::Cancelled)));
    }
}
