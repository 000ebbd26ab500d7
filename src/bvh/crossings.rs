//! What a closed mesh encloses, by the triangles that a ray from a point crosses.
//!
//! Where triangles run along each edge as often one way as the other, the winding number is the number of times
//! that a ray leaves the mesh, less that of its entering. A ray meets few boxes, and no solid angle is needed: a fraction of
//! the work of the expansion, which open meshes need.
//!
//! A triangle counts by the winding number of its sides around the ray, in the plane across it. What a side
//! adds is, to the last bit, the opposite of what it adds to the triangle beyond it, so that no ray slips through
//! between the two. Typically O(log n).

use super::Bvh;
use super::tree::{Block, Child, EMPTY, Node, STACK, WIDTH, child, larger, smaller};
use crate::geometry::vector::{Vector, subtract};

/// Slopes of the ray, which runs along the first axis: oblique, since the sides of many shapes are along axes. Not
/// negative.
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

/// Which triangles of a block the ray from a point may meet.
#[inline(always)]
fn near(block: &Block, point: [f32; 3], slopes: [f32; 2]) -> [bool; WIDTH] {
    let mut near = [true; WIDTH];
    for lane in 0..WIDTH {
        let x = [0, 1, 2].map(|corner| block.corners[corner][0][lane] - point[0]);
        near[lane] = larger(larger(x[0], x[1]), x[2]) >= -MARGIN;
        for axis in 0..2 {
            let across = [0, 1, 2].map(|corner| {
                block.corners[corner][axis + 1][lane] - point[axis + 1] - slopes[axis] * x[corner]
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
        let [x, y, z] = subtract(corner, point);
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
    /// Whether a point is inside a closed mesh: one along each edge of which triangles run as often one way as the
    /// other. Of other meshes it says nothing. On the surface either may be the answer.
    #[inline]
    pub(crate) fn encloses(&self, point: Vector) -> bool {
        self.crossings(point) > 0
    }

    /// How often the ray from a point, along the first axis and by [`SLOPES`] along the others, leaves the mesh,
    /// less how often it enters.
    pub(crate) fn crossings(&self, point: Vector) -> i32 {
        let tree = &self.tree;
        let relative = subtract(point, tree.centre).map(|x| x as f32);
        let slopes = SLOPES.map(|slope| slope as f32);
        let mut stack = [0_u32; STACK];
        let mut height = 1;
        let mut crossings = 0;
        while height > 0 {
            height -= 1;
            match child(stack[height]) {
                Child::Empty => {}
                Child::Block(block) => {
                    let near = near(&tree.blocks[block], relative, slopes);
                    for lane in 0..WIDTH {
                        if near[lane] && tree.blocks[block].triangles[lane] != EMPTY {
                            crossings += crossing(&tree.corners[block * WIDTH + lane], point);
                        }
                    }
                }
                Child::Node(node) => {
                    let node = &tree.nodes[node];
                    let meets = meets(node, relative, slopes);
                    for (place, reference) in node.children.into_iter().enumerate() {
                        if meets[place] && reference != EMPTY {
                            stack[height] = reference;
                            height += 1;
                        }
                    }
                }
            }
        }
        crossings
    }
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
            let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
            let mut inside = 0;
            for index in 0..4000_u32 {
                // Every other point is of a lattice, as corners and sides are.
                let point = [0.819_173, 0.671_044, 0.549_700].map(|step| {
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
}
