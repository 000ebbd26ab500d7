//! Caps: what would close the loops of the boundary.
//!
//! A loop that is flat within a tolerance gets a polygon of its own vertices. Loops that lie in the
//! same plane inside of it and run the other way are its holes, as at the end of a lined pipe. A
//! loop without width is a crack, whose two sides are zipped. Polygons are triangulated by ear
//! clipping (crate `earcut`).

use earcut::Earcut;

use super::opening::{Loop, OpeningOutcome, sides};
use crate::bvh::Bvh;
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, area_normal, bounds};
use crate::mesh::weld::WELD_TOLERANCE;

/// A loop no wider than this is a crack: each of its sides lies within the weld distance of the
/// true edge.
const CRACK_WIDTH: f64 = 2.0 * WELD_TOLERANCE;

/// On polygons made to that end, ear clipping takes the square of the number of vertices.
const MOST_VERTICES: usize = 10_000;

/// Triangles of a polygon that does not cross itself add up to its area within this fraction.
const AREA_TOLERANCE: f64 = 1e-6;

/// Cosine of the angle between the normals of loops in one plane: 0.1 radians. Their distance is at
/// most the flatness.
const SAME_PLANE: f64 = 0.995;

/// Of more loops none is looked for in another: that takes seconds, and it is a surface in pieces,
/// which stays open.
const MOST_PAIRED: usize = 4096;

/// Corners nearer to the plane than this fraction of the diagonal lie in it: the rounding of single
/// precision and welding stay below.
const IN_PLANE: f64 = 1e-5;

/// Points that are tried along the line in which a triangle cuts the plane.
const POINTS: u32 = 5;

/// What fills a loop, or a loop with holes, or why nothing does.
pub(super) enum LoopFill {
    Crack { loop_index: usize, triangles: Vec<[u32; 3]> },
    Cap(Cap),
    Left { loop_index: usize, outcome: OpeningOutcome },
}

/// A flat polygon over one loop and its holes.
pub(super) struct Cap {
    /// Indices of its loops, the outer one first.
    pub loops: Vec<usize>,
    pub triangles: Vec<[u32; 3]>,
    pub plane: LoopPlane,
    pub area: f64,
    /// The loops in the axes of the plane.
    outlines: Vec<Vec<[f64; 2]>>,
}

/// The plane of a loop.
#[derive(Clone, Copy)]
pub(super) struct LoopPlane {
    /// Unit normal, outward if the surface around the loop is.
    pub normal: Vector,
    /// Two axes of the plane; with the normal they are right-handed.
    pub axes: [Vector; 2],
    point: Vector,
    area: f64,
    /// The farthest that a vertex is from it.
    deviation: f64,
}

/// What fills each loop. `flatness` is a fraction of the diagonal. O(l²) for l flat loops up to
/// [`MOST_PAIRED`], and their triangulation.
pub(super) fn fill_loops(positions: &[Vector], loops: &[Loop], flatness: f64) -> Vec<LoopFill> {
    let points_of = |found: &Loop| -> Vec<Vector> {
        found.vertices.iter().map(|&vertex| positions[vertex as usize]).collect()
    };
    let points: Vec<Vec<Vector>> = loops.iter().map(points_of).collect();
    let left = |loop_index, outcome| LoopFill::Left { loop_index, outcome };
    let mut found = Vec::new();
    let mut planes: Vec<Option<LoopPlane>> = Vec::new();
    for (loop_index, (points, own)) in points.iter().zip(loops).enumerate() {
        if is_crack(points) {
            let triangles = zip_crack(points, &own.vertices);
            found.push(LoopFill::Crack { loop_index, triangles });
            planes.push(None);
            continue;
        }
        let plane = LoopPlane::of(points);
        let is_flat = plane.deviation <= flatness && plane.area > 0.0;
        if !is_flat {
            found.push(left(loop_index, OpeningOutcome::NotFlat));
        }
        planes.push(is_flat.then_some(plane));
    }
    let outer = match loops.len() <= MOST_PAIRED {
        true => outer_loops(&points, &planes, flatness),
        false => vec![None; loops.len()],
    };
    let mut holes: Vec<Vec<usize>> = vec![Vec::new(); loops.len()];
    for (inner, outer) in outer.iter().enumerate() {
        if let Some(outer) = outer {
            holes[*outer].push(inner);
        }
    }
    for (loop_index, plane) in planes.iter().enumerate() {
        let Some(plane) = plane.as_ref().filter(|_| outer[loop_index].is_none()) else { continue };
        let mut own = vec![loop_index];
        own.append(&mut holes[loop_index]);
        let cap = triangulate(plane, own, loops, &points);
        found.push(cap.map_or(left(loop_index, OpeningOutcome::NotSimple), LoopFill::Cap));
    }
    found
}

impl LoopPlane {
    /// By the polygon's vector area (Newell), through the middle of its box.
    fn of(points: &[Vector]) -> Self {
        let (low, high) = bounds(points.iter().copied());
        let point = (low + high) * 0.5;
        let local = |index: usize| points[index % points.len()] - point;
        let twice = (0..points.len())
            .fold(Vector::ZERO, |sum, index| sum + local(index).cross(local(index + 1)));
        let normal = twice.normalize_or_zero();
        let heights = points.iter().map(|&p| normal.dot(p - point));
        let (lowest, highest) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        let middle = 0.5 * (lowest + highest);
        let least = Vector::AXES[normal.abs().min_position()];
        let first = normal.cross(least).normalize_or_zero();
        Self {
            normal,
            axes: [first, normal.cross(first)],
            point: point + normal * middle,
            area: 0.5 * twice.length(),
            deviation: 0.5 * (highest - lowest),
        }
    }

    /// Where a point is in the axes.
    pub fn flatten(&self, point: Vector) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(point - self.point))
    }
}

/// The farthest pair's line, found by going to the farthest vertex twice.
fn ends(points: &[Vector]) -> (usize, usize) {
    let farthest = |from: usize| {
        let far = |&index: &usize| points[index].distance(points[from]);
        (0..points.len()).max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a))).unwrap_or(from)
    };
    let first = farthest(0);
    (first, farthest(first))
}

fn is_crack(points: &[Vector]) -> bool {
    if points.len() < 3 {
        return true;
    }
    let (first, second) = ends(points);
    let along = (points[second] - points[first]).normalize_or_zero();
    points.iter().all(|&point| along.cross(point - points[first]).length() <= CRACK_WIDTH)
}

/// Triangles without area between the two sides of a crack: repair splits what is beyond them.
fn zip_crack(points: &[Vector], vertices: &[u32]) -> Vec<[u32; 3]> {
    let (first, second) = ends(points);
    let along = points[second] - points[first];
    let share = |index: usize| along.dot(points[index % points.len()]);
    zip(points, vertices, |left, right| share(left + 1) <= share(right - 1))
}

/// Triangles between the two sides of a loop that need not be flat, along the shorter diagonals.
pub(super) fn zip_shortest(points: &[Vector], vertices: &[u32]) -> Vec<[u32; 3]> {
    let at = |index: usize| points[index % points.len()];
    let length = |left, right| at(left).distance_squared(at(right));
    zip(points, vertices, |left, right| length(left + 1, right) <= length(left, right - 1))
}

/// Triangles between the two sides of a loop, from one of its ends to the other. `goes_left` says
/// from which side the next vertex is, where both have one.
fn zip(
    points: &[Vector],
    vertices: &[u32],
    goes_left: impl Fn(usize, usize) -> bool,
) -> Vec<[u32; 3]> {
    let count = vertices.len();
    let (first, second) = ends(points);
    // Both sides from the first end to the second.
    let (mut left, mut right) = (first, first + count);
    let end = if second > first { second } else { second + count };
    let mut triangles = Vec::new();
    while left < end || right > end {
        let goes_left = left < end && (right <= end || goes_left(left, right));
        let next = if goes_left { left + 1 } else { right - 1 };
        let corners = [left, next, right].map(|index| vertices[index % count]);
        if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
            triangles.push(corners);
        }
        if goes_left {
            left = next;
        } else {
            right = next;
        }
    }
    triangles
}

/// For each loop the least one that it is a hole of.
fn outer_loops(
    points: &[Vec<Vector>],
    planes: &[Option<LoopPlane>],
    flatness: f64,
) -> Vec<Option<usize>> {
    let is_hole = |inner: usize, outer: usize| {
        let (Some(own), Some(around)) = (&planes[inner], &planes[outer]) else { return false };
        own.area < around.area
            && own.normal.dot(around.normal) < -SAME_PLANE
            && around.normal.dot(own.point - around.point).abs() <= flatness
            && {
                let outline: Vec<[f64; 2]> =
                    points[outer].iter().map(|&point| around.flatten(point)).collect();
                points[inner].iter().all(|&point| is_in_outline(&outline, around.flatten(point)))
            }
    };
    (0..planes.len())
        .map(|inner| {
            let around = (0..planes.len()).filter(|&outer| is_hole(inner, outer));
            let area = |outer: &usize| planes[*outer].as_ref().map_or(0.0, |plane| plane.area);
            around.min_by(|a, b| area(a).total_cmp(&area(b)))
        })
        .collect()
}

fn triangulate(
    plane: &LoopPlane,
    own: Vec<usize>,
    loops: &[Loop],
    points: &[Vec<Vector>],
) -> Option<Cap> {
    let flat = |&index: &usize| points[index].iter().map(|&point| plane.flatten(point)).collect();
    let outlines: Vec<Vec<[f64; 2]>> = own.iter().map(flat).collect();
    let vertices: Vec<u32> =
        own.iter().flat_map(|&index| loops[index].vertices.iter().copied()).collect();
    if vertices.len() > MOST_VERTICES {
        return None;
    }
    let corners: Vec<[f64; 2]> = outlines.concat();
    let mut holes = Vec::new();
    let mut start = 0_u32;
    for outline in &outlines[..outlines.len() - 1] {
        start += outline.len() as u32;
        holes.push(start);
    }
    let mut found: Vec<u32> = Vec::new();
    Earcut::new().earcut(corners.iter().copied(), &holes, &mut found);
    let (found, _) = found.as_chunks::<3>();
    let expected: f64 = outlines.iter().map(|outline| signed_area(outline)).sum();
    let mut sum = 0.0;
    let mut triangles = Vec::with_capacity(found.len());
    for triangle in found {
        let outline = triangle.map(|corner| corners[corner as usize]);
        let area = signed_area(&outline);
        sum += area.abs();
        let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
        triangles.push(if area < 0.0 { [a, c, b] } else { [a, b, c] });
    }
    let is_whole = expected > 0.0 && (sum - expected).abs() <= AREA_TOLERANCE * expected;
    is_whole.then_some(Cap { loops: own, triangles, plane: *plane, area: expected, outlines })
}

fn signed_area(outline: &[[f64; 2]]) -> f64 {
    0.5 * sides(outline).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// By the crossings of a ray along the first axis.
fn is_in_outline(outline: &[[f64; 2]], point: [f64; 2]) -> bool {
    let crossings = sides(outline).filter(|(a, b)| {
        (a[1] > point[1]) != (b[1] > point[1]) && {
            let share = (point[1] - a[1]) / (b[1] - a[1]);
            point[0] < a[0] + share * (b[0] - a[0])
        }
    });
    crossings.count() % 2 == 1
}

impl Cap {
    /// Whether a point of the plane is on the cap, farther than `margin` from its rim.
    fn holds(&self, point: [f64; 2], margin: f64) -> bool {
        let is_in_odd =
            self.outlines.iter().filter(|outline| is_in_outline(outline, point)).count() % 2;
        is_in_odd == 1
            && self.outlines.iter().all(|outline| {
                sides(outline).all(|(&a, &b)| distance_to_side(point, a, b) > margin)
            })
    }

    /// The median over the rim, by length, of the angle inside of the solid between the cap and the
    /// surface, in radians: 0 where the surface folds back onto the cap, π where it goes straight
    /// on.
    pub(super) fn rim_angle(&self, mesh: &TriangleMesh, loops: &[Loop]) -> f64 {
        let rim = self.loops.iter().flat_map(|&index| loops[index].sides(mesh.points()));
        let angle = |(neighbour, length): (u32, f64)| {
            let [a, b, c] = mesh.corners(mesh.triangles[neighbour as usize]);
            let normal = area_normal(a, b, c).normalize_or_zero();
            (libm::acos((-normal.dot(self.plane.normal)).clamp(-1.0, 1.0)), length)
        };
        let mut angles: Vec<(f64, f64)> = rim.map(angle).collect();
        angles.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = angles.iter().map(|angle| angle.1).sum();
        let mut sum = 0.0;
        let median = angles.iter().find(|angle| {
            sum += angle.1;
            2.0 * sum >= whole
        });
        median.map_or(0.0, |angle| angle.0)
    }
}

fn distance_to_side(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let arm = [point[0] - a[0], point[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = ((arm[0] * along[0] + arm[1] * along[1]) / squared).clamp(0.0, 1.0);
    let share = if share.is_nan() { 0.0 } else { share };
    libm::hypot(arm[0] - share * along[0], arm[1] - share * along[1])
}

/// Whether a triangle of a mesh for which `counts` holds goes through the cap, farther than
/// `margin` from its rim.
pub(super) fn is_cut(
    cap: &Cap,
    mesh: &TriangleMesh,
    bvh: &Bvh,
    margin: f64,
    counts: impl Fn(u32) -> bool,
) -> bool {
    let corners = cap.triangles.iter().flat_map(|&triangle| mesh.corners(triangle));
    let (low, high) = bounds(corners);
    let near = bvh.triangles_near_box(low, high, IN_PLANE);
    near.into_iter().filter(|&triangle| counts(triangle)).any(|triangle| {
        // The tree may hold caps too, which are not in the mesh.
        let Some(&triangle) = mesh.triangles.get(triangle as usize) else { return false };
        let Some([from, to]) = line_in_plane(cap, mesh.corners(triangle)) else { return false };
        (0..POINTS).any(|index| {
            let share = (f64::from(index) + 0.5) / f64::from(POINTS);
            let point = from + (to - from) * share;
            cap.holds(cap.plane.flatten(point), margin)
        })
    })
}

/// Where a triangle that has corners on both sides of the plane cuts it.
fn line_in_plane(cap: &Cap, corners: [Vector; 3]) -> Option<[Vector; 2]> {
    let heights = corners.map(|corner| cap.plane.normal.dot(corner - cap.plane.point));
    let is_above = heights.iter().any(|&height| height > IN_PLANE);
    let is_below = heights.iter().any(|&height| height < -IN_PLANE);
    if !is_above || !is_below {
        return None;
    }
    let mut points = (0..3).filter_map(|side| {
        let (a, b) = (side, (side + 1) % 3);
        let crosses = (heights[a] > 0.0) != (heights[b] > 0.0);
        let share = heights[a] / (heights[a] - heights[b]);
        crosses.then(|| corners[a] + (corners[b] - corners[a]) * share)
    });
    Some([points.next()?, points.next()?])
}
