//! Rays: the winding number of a closed mesh, and the first triangle that is hit.
//!
//! Where triangles run along each edge as often one way as the other, the winding number is the
//! number of times that a ray leaves the mesh, less that of its entering. A ray meets few boxes,
//! and no solid angle is needed: a fraction of the work of the expansion, which open meshes need.
//!
//! A triangle counts by the winding number of its sides around the ray, in the plane across it.
//! What a side adds is, to the last bit, the opposite of what it adds to the triangle beyond it, so
//! that no ray slips through between the two. Typically O(log n).

use glam::Vec4;

use super::hierarchy::Bvh;
use super::tree::{Child, EMPTY, Leaf, Node, STACK, Tree, WIDTH, child};
use crate::geometry::vector::{Vector, larger, smaller};

/// Slopes of the ray, which runs along the first axis: oblique, since the sides of many shapes are
/// along axes. Not negative.
pub(crate) const SLOPES: [f64; 2] = [0.034_417, 0.021_913];

/// More than the rounding of boxes, corners and points to single precision.
const MARGIN: f32 = 1e-5;

/// Which children of a node the ray from a point may meet.
#[inline(always)]
fn meets(node: &Node, point: [f32; 3], slopes: [f32; 2]) -> [bool; WIDTH] {
    let mut meets = [true; WIDTH];
    for place in 0..WIDTH {
        let end = node.max[0][place] - point[0];
        let start = larger(node.min[0][place] - point[0], 0.0);
        meets[place] = end >= -MARGIN;
        for axis in 0..2 {
            let low = node.min[axis + 1][place] - point[axis + 1];
            let high = node.max[axis + 1][place] - point[axis + 1];
            meets[place] &= (slopes[axis] * start <= high + MARGIN)
                & (slopes[axis] * larger(end, 0.0) >= low - MARGIN);
        }
    }
    meets
}

/// Which triangles of a leaf the ray from a point may meet.
#[inline(always)]
fn near(leaf: &Leaf, point: [f32; 3], slopes: [f32; 2]) -> [bool; WIDTH] {
    let mut near = [true; WIDTH];
    for lane in 0..WIDTH {
        let x = [0, 1, 2].map(|corner| leaf.corners[corner][0][lane] - point[0]);
        near[lane] = larger(larger(x[0], x[1]), x[2]) >= -MARGIN;
        for axis in 0..2 {
            let across = [0, 1, 2].map(|corner| {
                leaf.corners[corner][axis + 1][lane] - point[axis + 1] - slopes[axis] * x[corner]
            });
            let least = smaller(smaller(across[0], across[1]), across[2]);
            let most = larger(larger(across[0], across[1]), across[2]);
            near[lane] &= (least <= MARGIN) & (most >= -MARGIN);
        }
    }
    near
}

/// How often a triangle leads the ray from a point outward, less how often inward.
fn crossing(corners: &[Vector; 3], point: Vector) -> i32 {
    // Along the ray, and across it.
    let relative = corners.map(|corner| {
        let [x, y, z] = (corner - point).to_array();
        [x, y - SLOPES[0] * x, z - SLOPES[1] * x]
    });
    let mut turns = 0;
    // The second over the first is how far along the ray the triangle's plane is.
    let (mut doubled_area, mut moment) = (0.0, 0.0);
    for k in 0..3 {
        let (a, b, opposite) = (relative[k], relative[(k + 1) % 3], relative[(k + 2) % 3]);
        let side = a[1] * b[2] - a[2] * b[1];
        turns += i32::from(a[2] <= 0.0 && b[2] > 0.0 && side > 0.0);
        turns -= i32::from(b[2] <= 0.0 && a[2] > 0.0 && side < 0.0);
        doubled_area += side;
        moment += side * opposite[0];
    }
    let is_ahead =
        relative.iter().all(|corner| corner[0] > 0.0) || (moment > 0.0) == (doubled_area > 0.0);
    if is_ahead { turns } else { 0 }
}

impl Bvh {
    /// Whether a point is inside a closed mesh: one along each edge of which triangles run as often
    /// one way as the other. For other meshes the answer means nothing. On the surface either may
    /// be the answer.
    #[inline]
    pub(crate) fn encloses(&self, point: Vector) -> bool {
        self.crossings(point) > 0
    }

    /// How often the ray from a point, along the first axis and by [`SLOPES`] along the others,
    /// leaves the mesh, less how often it enters.
    pub(crate) fn crossings(&self, point: Vector) -> i32 {
        let tree = &self.tree;
        let relative = (point - tree.centre).as_vec3().to_array();
        let slopes = SLOPES.map(|slope| slope as f32);
        let mut crossings = 0;
        tree.visit_leaves(
            |node| meets(&tree.nodes[node], relative, slopes),
            |leaf| {
                let near = near(&tree.leaves[leaf], relative, slopes);
                for lane in 0..WIDTH {
                    if near[lane] && tree.leaves[leaf].triangles[lane] != EMPTY {
                        crossings += crossing(&tree.corners[leaf * WIDTH + lane], point);
                    }
                }
                true
            },
        );
        crossings
    }
}

// First hit: boxes are tested by slabs (Kay and Kajiya, "Ray Tracing Complex Scenes", 1986),
// triangles in double precision (Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle
// Intersection", 1997). A ray through a common edge may hit both triangles or neither: shoot many.
// Typically O(log n).

/// Where a ray meets the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    /// In lengths of the ray's direction.
    pub distance: f64,
    pub triangle: u32,
    /// Whether the ray leaves through the triangle's back: runs along with its normal.
    pub is_back: bool,
}

/// Boxes are in single precision and rounded outward; the slabs' own rounding moves their planes by
/// far less than this.
const SLAB_SLACK: f32 = 1e-5;

/// In margins of the tree: rounding of a corner, of the origin, which is near the mesh, and of the
/// step along the ray times each slope, which is at most 1. With room to spare.
const ROUNDINGS: f32 = 8.0;

impl Bvh {
    /// The first triangle beyond `start` along a ray for which `counts` holds. `direction` should
    /// be of unit length.
    pub(crate) fn first_hit(
        &self,
        origin: Vector,
        direction: Vector,
        start: f64,
        counts: &dyn Fn(u32) -> bool,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let mut end = f64::INFINITY;
        self.visit_hits([origin, direction], start, &mut |hit| {
            let is_nearer = best
                .is_none_or(|best| (hit.distance, hit.triangle) < (best.distance, best.triangle));
            if is_nearer && counts(hit.triangle) {
                (best, end) = (Some(hit), hit.distance);
            }
            end
        });
        best
    }

    /// Calls `visit` for triangles beyond `start` along a ray, in no order, up to the distance that
    /// it last returned.
    pub(crate) fn visit_hits(
        &self,
        [origin, direction]: [Vector; 2],
        start: f64,
        visit: &mut dyn FnMut(Hit) -> f64,
    ) {
        let tree = &self.tree;
        let ray = Ray::new(tree, origin, direction, start);
        let mut end = f64::INFINITY;
        let mut stack = [(0.0_f32, EMPTY); STACK];
        let mut top = 1;
        stack[0] = (0.0, 0);
        while top > 0 {
            top -= 1;
            let (near, reference) = stack[top];
            if f64::from(near) > end {
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
                Child::Leaf(leaf) => {
                    let leaf_triangles = &tree.leaves[leaf];
                    let may_meet = ray.may_meet(leaf_triangles);
                    for (lane, &triangle) in leaf_triangles.triangles.iter().enumerate() {
                        if triangle == EMPTY || !may_meet[lane] {
                            continue;
                        }
                        let corners = tree.corners[leaf * WIDTH + lane];
                        if let Some((distance, is_back)) = intersect(origin, direction, corners)
                            && distance > start
                        {
                            end = visit(Hit { distance, triangle, is_back });
                        }
                    }
                }
            }
        }
    }
}

/// A ray in single precision. What it is tested against in lanes is in vectors by hand, since the
/// compiler leaves most of that in single steps.
struct Ray {
    /// Relative to the tree's centre.
    origin: [f32; 3],
    /// One over the direction's components. Finite, since 0 times infinity is not a number.
    inverse: [f32; 3],
    start: f32,
    /// The axis along which the ray runs most.
    most: usize,
    /// Along the two axes after it, for each step along it.
    slopes: [f32; 2],
    /// 1 or -1: which way the ray runs along it.
    way: f32,
    /// No component of the way from the origin to a corner, across the ray too, is farther than
    /// this from the true one.
    rounding: f32,
}

impl Ray {
    fn new(tree: &Tree, origin: Vector, direction: Vector, start: f64) -> Self {
        let origin = (origin - tree.centre).as_vec3().to_array();
        let direction = direction.to_array();
        let inverse = direction.map(|x| ((1.0 / x) as f32).clamp(f32::MIN, f32::MAX));
        let [x, y, z] = direction.map(f64::abs);
        let most = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
        let slopes = [1, 2].map(|k| (direction[(most + k) % 3] / direction[most]) as f32);
        let way = direction[most].signum() as f32;
        let rounding = ROUNDINGS * tree.margin;
        Self { origin, inverse, start: start as f32 - SLAB_SLACK, most, slopes, way, rounding }
    }

    /// Where the ray, from its start on, enters and leaves the children's boxes: the other way
    /// round where it misses them.
    #[inline(always)]
    fn slabs(&self, node: &Node) -> ([f32; WIDTH], [f32; WIDTH]) {
        let (mut near, mut far) = (Vec4::splat(self.start), Vec4::INFINITY);
        let slack = Vec4::splat(SLAB_SLACK);
        for axis in 0..3 {
            let (origin, inverse) = (Vec4::splat(self.origin[axis]), self.inverse[axis]);
            let first = (Vec4::from_array(node.min[axis]) - slack - origin) * inverse;
            let second = (Vec4::from_array(node.max[axis]) + slack - origin) * inverse;
            near = near.max(first.min(second));
            far = far.min(first.max(second));
        }
        (near.to_array(), far.to_array())
    }

    /// Which triangles of a leaf the ray may meet: those that are not behind its origin, and whose
    /// sides it passes all on the same side (Woop, Benthin and Wald, "Watertight Ray/Triangle
    /// Intersection", 2013). A ray meets the boxes of hundreds of long thin triangles.
    #[inline(always)]
    fn may_meet(&self, leaf: &Leaf) -> [bool; WIDTH] {
        let origin = self.origin.map(Vec4::splat);
        // Across the ray, and along it.
        let corner = |[x, y, z]: &[[f32; WIDTH]; 3]| {
            let x = Vec4::from_array(*x) - origin[0];
            let y = Vec4::from_array(*y) - origin[1];
            let z = Vec4::from_array(*z) - origin[2];
            let (x, y, z) = match self.most {
                0 => (y, z, x),
                1 => (z, x, y),
                _ => (x, y, z),
            };
            [x - z * self.slopes[0], y - z * self.slopes[1], z * self.way]
        };
        let [a, b, c] = &leaf.corners;
        let (a, b, c) = (corner(a), corner(b), corner(c));
        let side = |a: [Vec4; 3], b: [Vec4; 3]| a[0] * b[1] - a[1] * b[0];
        let (ab, bc, ca) = (side(a, b), side(b, c), side(c, a));
        let longest = |a: [Vec4; 3]| a[0].abs().max(a[1].abs());
        let rounding = Vec4::splat(self.rounding);
        let longest = longest(a).max(longest(b)).max(longest(c)).max(rounding);
        let error = longest * (4.0 * self.rounding);
        let is_around = ab.min(bc).min(ca).cmpge(-error) | ab.max(bc).max(ca).cmple(error);
        (is_around & a[2].max(b[2]).max(c[2]).cmpge(-rounding)).into()
    }
}

/// How far along a ray a triangle is, and whether the ray leaves through its back.
fn intersect(origin: Vector, direction: Vector, [a, b, c]: [Vector; 3]) -> Option<(f64, bool)> {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let arm = origin - a;
    let v = arm.dot(across) * inverse;
    let turned = arm.cross(ab);
    let w = direction.dot(turned) * inverse;
    let is_inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    let distance = ac.dot(turned) * inverse;
    // The determinant is positive where the ray runs against the normal.
    (is_inside && distance >= 0.0).then_some((distance, determinant < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join, torus, turn, uv_sphere};

    #[test]
    fn what_is_enclosed_is_where_the_winding_number_is_above_one_half() {
        let boxes = || {
            join(&[
                cuboid([-0.5, -0.4, -0.3], [0.5, 0.4, 0.3]),
                turn(cuboid([-0.3, -0.2, -0.1], [0.3, 0.2, 0.1])),
                cuboid([0.0, 0.0, 0.0], [0.6, 0.6, 0.6]),
            ])
        };
        let mut oblique = boxes();
        for [x, y, z] in &mut oblique.positions {
            (*x, *y, *z) = (0.6 * *x - 0.8 * *y, 0.48 * *x + 0.36 * *y - 0.8 * *z, *x + *z);
        }
        let meshes = [boxes(), oblique, torus(24, 12), uv_sphere(16, [0.1, 0.0, 0.2], 0.5)];
        for mesh in meshes {
            let bvh = Bvh::new(mesh.points(), &mesh.triangles);
            let mut inside = 0;
            for index in 0..4000_u32 {
                // Every other point is of a lattice, as corners and sides are.
                let point = Vector::new(0.819_173, 0.671_044, 0.549_700).map(|step| {
                    let share = 2.0 * (step * f64::from(index)).fract() - 1.0;
                    if index % 2 == 0 { (share * 10.0).round() / 10.0 } else { share }
                });
                let distance = bvh.closest_point(point, f64::INFINITY).unwrap().distance;
                if distance > 1e-4 {
                    assert_eq!(bvh.encloses(point), bvh.is_inside(point), "{point:?}");
                    inside += usize::from(bvh.encloses(point));
                }
            }
            assert!(inside > 20, "{inside}");
        }
    }

    /// A direction for each number, all over the sphere.
    fn direction(number: u32) -> Vector {
        let x = f64::from(number);
        Vector::new((x * 0.7).sin(), (x * 1.3).cos(), (x * 2.1).sin()).normalize_or_zero()
    }

    /// Whether a ray hits anything. The first hit is asserted to be that of trying all triangles.
    #[track_caller]
    fn hits_nearest(
        bvh: &Bvh,
        [origin, along]: [Vector; 2],
        points: &[Vector],
        triangles: &[[u32; 3]],
    ) -> bool {
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let all = triangles.iter().filter_map(|t| intersect(origin, along, corners(t)));
        let nearest = all.map(|(distance, _)| distance).fold(f64::INFINITY, f64::min);
        let found = bvh.first_hit(origin, along, 0.0, &|_| true);
        assert_eq!(found.map_or(f64::INFINITY, |hit| hit.distance), nearest);
        found.is_some()
    }

    #[test]
    fn the_first_hit_is_that_of_trying_all_triangles() {
        let mesh = uv_sphere(16, [0.1, 0.2, 0.3], 0.5);
        let bvh = Bvh::new(mesh.points(), &mesh.triangles);
        let mut hits = 0;
        for number in 0..500 {
            let origin = direction(1000 + number).map(|x| 0.7 * x);
            let ray = [origin, direction(number)];
            hits += usize::from(hits_nearest(&bvh, ray, mesh.points(), &mesh.triangles));
        }
        assert!(hits > 100 && hits < 500, "{hits}");
    }

    /// Rounding to single precision must not lose the side on which the ray passes.
    #[test]
    fn long_thin_triangles_are_hit_where_each_is_hit_alone() {
        const COUNT: usize = 400;
        let axis = Vector::new(0.6, 0.7, 0.39);
        let points: Vec<Vector> = (0..COUNT)
            .flat_map(|index| {
                let rim = |index: usize| {
                    let angle = std::f64::consts::TAU * index as f64 / COUNT as f64;
                    Vector::new(angle.cos(), 0.0, angle.sin()) * 3e-4
                };
                [rim(index), rim(index + 1), rim(index) + axis]
            })
            .collect();
        let triangles: Vec<[u32; 3]> =
            (0..COUNT as u32).map(|index| [0, 1, 2].map(|k| 3 * index + k)).collect();
        let bvh = Bvh::new(&points, &triangles);
        let mut hits = 0;
        for ray in 0..2000 {
            let origin = axis * (0.1 + 3e-4 * f64::from(ray));
            let ray = [origin, direction(ray)];
            hits += usize::from(hits_nearest(&bvh, ray, &points, &triangles));
        }
        assert!(hits > 500, "{hits}");
    }

    #[test]
    fn from_within_the_back_is_hit_and_from_outside_the_front() {
        let mesh = uv_sphere(16, [0.0; 3], 1.0);
        let bvh = Bvh::new(mesh.points(), &mesh.triangles);
        let along = direction(3);
        let within = bvh.first_hit(Vector::ZERO, along, 0.0, &|_| true).unwrap();
        assert!(within.is_back && (within.distance - 1.0).abs() < 0.05);
        let outside = bvh.first_hit(along.map(|x| -3.0 * x), along, 0.0, &|_| true).unwrap();
        assert!(!outside.is_back && (outside.distance - 2.0).abs() < 0.05);
        let second = bvh.first_hit(along.map(|x| -3.0 * x), along, 3.0, &|_| true).unwrap();
        assert!(second.is_back);
    }
}
