//! The first triangle that a ray hits.
//!
//! Boxes are tested by slabs (Kay and Kajiya, "Ray Tracing Complex Scenes", 1986), triangles in double
//! precision (Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997). A ray
//! through a common edge may hit both triangles or neither: ask many rays. Typically O(log n).

use super::Bvh;
use super::tree::{Child, EMPTY, Node, STACK, Tree, WIDTH, child, larger, smaller};
use crate::geometry::vector::{Vector, cross, dot, subtract};

/// Where a ray meets the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// In lengths of the ray's direction.
    pub distance: f64,
    pub triangle: u32,
    /// Whether the ray leaves through the triangle's back: runs along with its normal.
    pub is_back: bool,
}

/// Boxes are in single precision and rounded outward; the slabs' own rounding moves their planes by far less than
/// this.
const SLAB_SLACK: f32 = 1e-5;

impl Bvh {
    /// The first triangle beyond `start` along a ray for which `counts` holds. `direction` should be of
    /// unit length.
    pub(crate) fn first_hit(
        &self,
        origin: Vector,
        direction: Vector,
        start: f64,
        mut counts: impl FnMut(u32, bool) -> bool,
    ) -> Option<Hit> {
        let tree = &self.tree;
        let ray = Ray::new(tree, origin, direction, start);
        let mut best: Option<Hit> = None;
        let mut stack = [(0.0_f32, EMPTY); STACK];
        let mut top = 1;
        stack[0] = (0.0, 0);
        while top > 0 {
            top -= 1;
            let (near, reference) = stack[top];
            if best.is_some_and(|best| f64::from(near) > best.distance) {
                continue;
            }
            match child(reference) {
                Child::Empty => {}
                Child::Node(node) => {
                    let Some(node) = tree.nodes.get(node) else { continue };
                    let (near, far) = ray.slabs(node);
                    let first = top;
                    for place in 0..WIDTH {
                        if node.children[place] != EMPTY && near[place] <= far[place] {
                            // The nearest comes last, and is looked at first.
                            let mut at = top;
                            while at > first && stack[at - 1].0 < near[place] {
                                stack[at] = stack[at - 1];
                                at -= 1;
                            }
                            stack[at] = (near[place], node.children[place]);
                            top += 1;
                        }
                    }
                }
                Child::Block(block) => {
                    for (lane, &triangle) in tree.blocks[block].triangles.iter().enumerate() {
                        if triangle == EMPTY {
                            continue;
                        }
                        let corners = tree.corners[block * WIDTH + lane];
                        let Some((distance, is_back)) = intersect(origin, direction, corners)
                        else {
                            continue;
                        };
                        let is_nearer = best.is_none_or(|best| {
                            (distance, triangle) < (best.distance, best.triangle)
                        });
                        if distance > start && is_nearer && counts(triangle, is_back) {
                            best = Some(Hit { distance, triangle, is_back });
                        }
                    }
                }
            }
        }
        best
    }

    /// The triangles whose boxes, as far as the tree knows them, come within `margin` of a box.
    pub(crate) fn triangles_near_box(&self, low: Vector, high: Vector, margin: f64) -> Vec<u32> {
        let tree = &self.tree;
        let low = subtract(low, tree.centre).map(|x| x - margin - f64::from(tree.margin));
        let high = subtract(high, tree.centre).map(|x| x + margin + f64::from(tree.margin));
        let mut found = Vec::new();
        let mut open = vec![0_u32];
        while let Some(reference) = open.pop() {
            match child(reference) {
                Child::Empty => {}
                Child::Node(node) => {
                    let Some(node) = tree.nodes.get(node) else { continue };
                    for place in 0..WIDTH {
                        let overlaps = (0..3).all(|axis| {
                            f64::from(node.min[axis][place]) <= high[axis]
                                && f64::from(node.max[axis][place]) >= low[axis]
                        });
                        if node.children[place] != EMPTY && overlaps {
                            open.push(node.children[place]);
                        }
                    }
                }
                Child::Block(block) => {
                    let triangles = tree.blocks[block].triangles.iter();
                    found.extend(triangles.filter(|&&triangle| triangle != EMPTY));
                }
            }
        }
        found.sort_unstable();
        found
    }
}

struct Ray {
    /// Relative to the tree's centre.
    origin: [f32; 3],
    inverse: [f32; 3],
    start: f32,
}

impl Ray {
    fn new(tree: &Tree, origin: Vector, direction: Vector, start: f64) -> Self {
        let origin = subtract(origin, tree.centre).map(|x| x as f32);
        let start = start as f32 - SLAB_SLACK;
        Self { origin, inverse: direction.map(|x| (1.0 / x) as f32), start }
    }

    /// Where the ray, from its start on, enters and leaves the children's boxes: the other way round where it
    /// misses them.
    #[inline(always)]
    fn slabs(&self, node: &Node) -> ([f32; WIDTH], [f32; WIDTH]) {
        let (mut near, mut far) = ([self.start; WIDTH], [f32::INFINITY; WIDTH]);
        for axis in 0..3 {
            let (origin, inverse) = (self.origin[axis], self.inverse[axis]);
            for place in 0..WIDTH {
                let first = (node.min[axis][place] - SLAB_SLACK - origin) * inverse;
                let second = (node.max[axis][place] + SLAB_SLACK - origin) * inverse;
                // Where a ray runs within a plane, that is not a number, and says nothing.
                near[place] = larger(smaller(first, second), near[place]);
                far[place] = smaller(larger(first, second), far[place]);
            }
        }
        (near, far)
    }
}

/// How far along a ray a triangle is, and whether the ray leaves through its back.
fn intersect(origin: Vector, direction: Vector, [a, b, c]: [Vector; 3]) -> Option<(f64, bool)> {
    let (ab, ac) = (subtract(b, a), subtract(c, a));
    let across = cross(direction, ac);
    let determinant = dot(ab, across);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let arm = subtract(origin, a);
    let v = dot(arm, across) * inverse;
    let turned = cross(arm, ab);
    let w = dot(direction, turned) * inverse;
    let is_inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    let distance = dot(ac, turned) * inverse;
    // The determinant is positive where the ray runs against the normal.
    (is_inside && distance >= 0.0).then_some((distance, determinant < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::normalize;
    use crate::mesh::shapes::uv_sphere;

    /// A direction for each number, all over the sphere.
    fn direction(number: u32) -> Vector {
        let x = f64::from(number);
        normalize([(x * 0.7).sin(), (x * 1.3).cos(), (x * 2.1).sin()])
    }

    #[test]
    fn the_first_hit_is_that_of_trying_all_triangles() {
        let mesh = uv_sphere(16, [0.1, 0.2, 0.3], 0.5);
        let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
        let mut hits = 0;
        for number in 0..500 {
            let origin = direction(1000 + number).map(|x| 0.7 * x);
            let along = direction(number);
            let corners = |t: &[u32; 3]| t.map(|v| mesh.positions[v as usize]);
            let all = mesh.triangles.iter().filter_map(|t| intersect(origin, along, corners(t)));
            let nearest = all.map(|(distance, _)| distance).fold(f64::INFINITY, f64::min);
            let found = bvh.first_hit(origin, along, 0.0, |_, _| true);
            assert_eq!(found.map_or(f64::INFINITY, |hit| hit.distance), nearest);
            hits += usize::from(found.is_some());
        }
        assert!(hits > 100 && hits < 500, "{hits}");
    }

    #[test]
    fn from_within_the_back_is_hit_and_from_outside_the_front() {
        let mesh = uv_sphere(16, [0.0; 3], 1.0);
        let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
        let along = direction(3);
        let within = bvh.first_hit([0.0; 3], along, 0.0, |_, _| true).unwrap();
        assert!(within.is_back && (within.distance - 1.0).abs() < 0.05);
        let outside = bvh.first_hit(along.map(|x| -3.0 * x), along, 0.0, |_, _| true).unwrap();
        assert!(!outside.is_back && (outside.distance - 2.0).abs() < 0.05);
        let second = bvh.first_hit(along.map(|x| -3.0 * x), along, 3.0, |_, _| true).unwrap();
        assert!(second.is_back);
    }

    #[test]
    fn triangles_near_a_box_are_among_those_found() {
        let mesh = uv_sphere(16, [0.0; 3], 1.0);
        let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
        let (low, high) = ([0.5, -0.2, -0.2], [1.5, 0.2, 0.2]);
        let found = bvh.triangles_near_box(low, high, 0.0);
        for (t, triangle) in (0_u32..).zip(&mesh.triangles) {
            let is_in = triangle.iter().any(|&v| {
                let point = mesh.positions[v as usize];
                (0..3).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
            });
            assert!(!is_in || found.contains(&t));
        }
        assert!(found.len() < mesh.triangles.len() / 2);
    }
}
