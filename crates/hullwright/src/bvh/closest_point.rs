//! Distance from a point to the nearest triangle, by branch and bound over the tree.
//!
//! Bounds are computed in single precision for four boxes or four triangles at once. Only a
//! triangle that may be the nearest is evaluated in double precision: the answer equals that of
//! evaluating every triangle, to the last bit. Typically O(log n). The closest point of a triangle
//! is found by Voronoi regions (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5).

use super::hierarchy::Bvh;
use super::tree::{BOUND_SLACK, Child, EMPTY, Leaf, Node, STACK, Tree, WIDTH, child};
use crate::geometry::vector::{Vector, larger, smaller};

/// The point of the mesh closest to a query point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosestPoint {
    pub distance: f64,
    /// The nearest triangle; of equally near ones the lowest index.
    pub triangle: u32,
    pub point: Vector,
}

/// The nearest triangle so far.
#[derive(Clone, Copy)]
struct Best {
    squared: f64,
    triangle: u32,
    /// Slot of its corners in the tree.
    slot: usize,
}

impl Best {
    fn none(limit: f64) -> Self {
        Self { squared: squared_or_none(limit), triangle: EMPTY, slot: 0 }
    }

    /// Whether a triangle is known whose squared distance is at most `enough`.
    #[inline(always)]
    fn is_within(&self, enough: f64) -> bool {
        self.squared <= enough && self.triangle != EMPTY
    }
}

/// A squared length; -1, which nothing is as near as, for one below 0.
fn squared_or_none(length: f64) -> f64 {
    if length < 0.0 { -1.0 } else { length * length }
}

/// Of [`closest_point_near`](Bvh::closest_point_near): only the closest triangle is near enough.
pub(crate) const EXACT: f64 = -1.0;

/// Squared length of each child's gap to the point, a lower bound up to [`BOUND_SLACK`]; infinite
/// without a child.
#[inline(always)]
pub(super) fn squared_gaps(node: &Node, point: [f32; 3]) -> [f32; WIDTH] {
    let mut squared = [0.0; WIDTH];
    for place in 0..WIDTH {
        let gap = |axis: usize| {
            let below = node.min[axis][place] - point[axis];
            let above = point[axis] - node.max[axis][place];
            larger(larger(below, above), 0.0)
        };
        let (x, y, z) = (gap(0), gap(1), gap(2));
        squared[place] = x * x + y * y + z * z;
    }
    squared
}

/// The same for the triangles of a leaf. Whatever point p of a triangle the weights give, the
/// triangle lies beyond the plane perpendicular to p through its lowest corner. So rounding of the
/// weights, even those of a sliver, loosens the bound but keeps it valid.
#[inline(always)]
fn squared_bounds(leaf: &Leaf, point: [f32; 3], margin: f32) -> [f32; WIDTH] {
    let mut squared = [0.0; WIDTH];
    for lane in 0..WIDTH {
        let arm = |corner: usize| {
            let [x, y, z] = &leaf.corners[corner];
            [x[lane] - point[0], y[lane] - point[1], z[lane] - point[2]]
        };
        let (a, b, c) = (arm(0), arm(1), arm(2));
        let ab = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let ac = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (v, w) = weights_in_single_precision(a, ab, ac);
        let p = [
            a[0] + v * ab[0] + w * ac[0],
            a[1] + v * ab[1] + w * ac[1],
            a[2] + v * ab[2] + w * ac[2],
        ];
        let height = smaller(smaller(dot(p, a), dot(p, b)), dot(p, c)) / dot(p, p).sqrt();
        // Also 0 for NaN.
        let height = if height > margin { height - margin } else { 0.0 };
        squared[lane] = height * height;
    }
    squared
}

/// The greatest squared gap of a box that may contain something as near as `squared`.
#[inline(always)]
fn largest_gap(squared: f64) -> f32 {
    (squared * BOUND_SLACK) as f32
}

/// Weights of the second and the third corner in the triangle's point closest to the origin, for
/// a triangle `a, a + ab, a + ac`: Ericson's regions without branches. Inaccurate for slivers.
macro_rules! weights {
    ($name:ident, $real:ty) => {
        #[inline(always)]
        fn $name(a: [$real; 3], ab: [$real; 3], ac: [$real; 3]) -> ($real, $real) {
            let dot = |a: [$real; 3], b: [$real; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let (abab, abac, acac) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
            let (d1, d2) = (-dot(ab, a), -dot(ac, a));
            let (d3, d4) = (d1 - abab, d2 - abac);
            let (d5, d6) = (d1 - abac, d2 - acac);
            let va = d3 * d6 - d5 * d4;
            let vb = d5 * d2 - d1 * d6;
            let vc = d1 * d4 - d3 * d2;
            let (bc1, bc2) = (d4 - d3, d5 - d6);

            let (mut v, mut w, mut sum) = (vb, vc, va + vb + vc);
            let mut region = |inside: bool, new_v: $real, new_w: $real, new_sum: $real| {
                v = if inside { new_v } else { v };
                w = if inside { new_w } else { w };
                sum = if inside { new_sum } else { sum };
            };
            // Where regions touch, the later line wins, and both are correct.
            region((va <= 0.0) & (bc1 >= 0.0) & (bc2 >= 0.0), bc2, bc1, bc1 + bc2);
            region((vb <= 0.0) & (d2 >= 0.0) & (d6 <= 0.0), 0.0, d2, d2 - d6);
            region((d6 >= 0.0) & (d5 <= d6), 0.0, 1.0, 1.0);
            region((vc <= 0.0) & (d1 >= 0.0) & (d3 <= 0.0), d1, 0.0, d1 - d3);
            region((d3 >= 0.0) & (d4 <= d3), 1.0, 0.0, 1.0);
            region((d1 <= 0.0) & (d2 <= 0.0), 0.0, 0.0, 1.0);
            let inverse = 1.0 / sum;
            (v * inverse, w * inverse)
        }
    };
}

weights!(weights, f64);
weights!(weights_in_single_precision, f32);

/// A triangle whose squared sine at the first corner is below this is a sliver: its weights would
/// be off by more than 1e-8.
const SLIVER: f64 = 1e-8;

/// The point of a sliver closest to the origin: on an edge, or inside if its normal is accurate.
#[cold]
fn closest_point_on_sliver(a: Vector, ab: Vector, ac: Vector) -> Vector {
    /// Below this squared sine rounding destroys the normal; the triangle's width is negligible.
    const NEEDLE: f64 = 1e-20;

    let (b, c) = (a + ab, a + ac);
    let mut nearest = a;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let along = to - from;
        let squared = along.length_squared();
        let share = (-from.dot(along) / squared).clamp(0.0, 1.0);
        // Of an edge without length the share is NaN, and another edge has the same end.
        let point = from + along * share;
        if point.length_squared() < nearest.length_squared() {
            nearest = point;
        }
    }
    let normal = ab.cross(ac);
    let squared = normal.length_squared();
    if squared > NEEDLE * ab.length_squared() * ac.length_squared() {
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(from, to)| normal.cross(to - from).dot(from) <= 0.0);
        let foot = normal * (normal.dot(a) / squared);
        if inside && foot.length_squared() < nearest.length_squared() {
            nearest = foot;
        }
    }
    nearest
}

/// The point of a triangle closest to the origin.
pub(crate) fn closest_point_on_triangle(a: Vector, b: Vector, c: Vector) -> Vector {
    let (ab, ac) = (b - a, c - a);
    let sides = ab.length_squared() * ac.length_squared();
    let cosine = ab.dot(ac);
    if sides - cosine * cosine <= SLIVER * sides {
        closest_point_on_sliver(a, ab, ac)
    } else {
        let (v, w) = weights(a.to_array(), ab.to_array(), ac.to_array());
        a + (ab * v + ac * w)
    }
}

#[inline(always)]
fn sort_descending(entries: &mut [u64; WIDTH]) {
    let mut order = |low: usize, high: usize| {
        let (a, b) = (entries[low], entries[high]);
        entries[low] = a.max(b);
        entries[high] = a.min(b);
    };
    order(0, 2);
    order(1, 3);
    order(0, 1);
    order(2, 3);
    order(1, 2);
}

impl Tree {
    #[inline(always)]
    fn relative(&self, point: Vector) -> [f32; 3] {
        (point - self.centre).as_vec3().to_array()
    }

    /// The point of the triangle in a slot that is closest to `point`, relative to it.
    #[inline(always)]
    fn closest_on(&self, slot: usize, point: Vector) -> Vector {
        let [a, b, c] = self.corners[slot];
        closest_point_on_triangle(a - point, b - point, c - point)
    }

    #[inline(always)]
    fn improve(&self, leaf: usize, point: Vector, bounds: &[f32; WIDTH], best: &mut Best) {
        let triangles = &self.leaves[leaf];
        for lane in 0..WIDTH {
            let triangle = triangles.triangles[lane];
            if bounds[lane] > largest_gap(best.squared) || triangle == EMPTY {
                continue;
            }
            let slot = leaf * WIDTH + lane;
            // The best so far is often met again, above all a correct guess.
            if triangle == best.triangle {
                continue;
            }
            let squared = self.closest_on(slot, point).length_squared();
            if squared < best.squared || (squared == best.squared && triangle < best.triangle) {
                *best = Best { squared, triangle, slot };
            }
        }
    }

    /// Improves on `best`; stops at the first triangle whose squared distance is at most `enough`.
    #[inline(always)]
    fn traverse(&self, point: Vector, best: &mut Best, enough: f64) -> bool {
        let relative = self.relative(point);
        // Entries hold a squared gap's bits above a child's reference. Gaps are not negative, so
        // that entries compare like gaps.
        let mut stack = [0_u64; STACK + WIDTH];
        let mut height = 1;
        let mut largest_gap = largest_gap(best.squared);
        while height > 0 {
            height -= 1;
            let entry = stack[height];
            if f32::from_bits((entry >> 32) as u32) > largest_gap {
                continue;
            }
            match child(entry as u32) {
                Child::Empty => {}
                Child::Leaf(leaf) => {
                    let bounds = squared_bounds(&self.leaves[leaf], relative, self.margin);
                    let least =
                        smaller(smaller(bounds[0], bounds[1]), smaller(bounds[2], bounds[3]));
                    if least <= largest_gap {
                        self.improve(leaf, point, &bounds, best);
                        if best.is_within(enough) {
                            return true;
                        }
                        largest_gap = self::largest_gap(best.squared);
                    }
                }
                Child::Node(node) => {
                    let node = &self.nodes[node];
                    let gaps = squared_gaps(node, relative);
                    let mut entries = [0; WIDTH];
                    for (place, &reference) in node.children.iter().enumerate() {
                        let hit = (gaps[place] <= largest_gap) & (reference != EMPTY);
                        let entry = u64::from(gaps[place].to_bits()) << 32 | u64::from(reference);
                        // The root is no child, so no hit is 0.
                        entries[place] = if hit { entry } else { 0 };
                        height += usize::from(hit);
                    }
                    // Hits end up below `height` with the nearest on top; the zeros lie above.
                    let hits = entries.iter().filter(|&&entry| entry != 0).count();
                    sort_descending(&mut entries);
                    stack[height - hits..][..WIDTH].copy_from_slice(&entries);
                }
            }
        }
        best.triangle != EMPTY
    }
}

impl Bvh {
    /// The point of the mesh closest to `point`, at most `limit` away (`f64::INFINITY` for no
    /// limit). The smaller the limit, the faster.
    pub(crate) fn closest_point(&self, point: Vector, limit: f64) -> Option<ClosestPoint> {
        self.improved(point, Best::none(limit), EXACT)
    }

    /// The point of the mesh closest to `point`, or that of the first triangle that is found at
    /// most `enough` away (less than 0 for none). Faster if the triangle `guess` is near.
    pub(crate) fn closest_point_near(
        &self,
        point: Vector,
        enough: f64,
        guess: u32,
    ) -> Option<ClosestPoint> {
        let best = self.guessed(point, guess);
        self.improved(point, best, squared_or_none(enough))
    }

    fn improved(&self, point: Vector, mut best: Best, enough: f64) -> Option<ClosestPoint> {
        (best.is_within(enough) || self.tree.traverse(point, &mut best, enough)).then(|| {
            ClosestPoint {
                distance: best.squared.sqrt(),
                triangle: best.triangle,
                point: point + self.tree.closest_on(best.slot, point),
            }
        })
    }

    /// The closest triangle. Faster if the triangle `guess` is near.
    pub(super) fn closest_triangle_near(&self, point: Vector, guess: u32) -> Option<u32> {
        let mut best = self.guessed(point, guess);
        self.tree.traverse(point, &mut best, EXACT).then_some(best.triangle)
    }

    fn guessed(&self, point: Vector, guess: u32) -> Best {
        let Some(slot) = self.slot(guess) else { return Best::none(f64::INFINITY) };
        let squared = self.tree.closest_on(slot, point).length_squared();
        Best { squared, triangle: guess, slot }
    }

    /// The distance to one triangle; infinite if it does not exist.
    pub(crate) fn distance_to_triangle(&self, point: Vector, triangle: u32) -> f64 {
        let slot = self.slot(triangle);
        slot.map_or(f64::INFINITY, |slot| self.tree.closest_on(slot, point).length())
    }

    /// Whether the mesh comes within `limit` of `point`. Faster than the distance.
    pub(crate) fn is_within(&self, point: Vector, limit: f64) -> bool {
        self.tree.traverse(point, &mut Best::none(limit), f64::INFINITY)
    }
}
