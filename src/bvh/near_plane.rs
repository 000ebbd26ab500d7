//! The triangles near a face: in its box and in the slab around its plane.

use super::Bvh;
use super::tree::{Child, EMPTY, STACK, WIDTH, child};
use crate::geometry::vector::{Vector, dot};

/// A box cut to a slab: points between `min` and `max`, at most `half_width` from a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slab {
    pub min: Vector,
    pub max: Vector,
    /// Unit normal of the plane.
    pub normal: Vector,
    /// Points p of the plane have normal · p = offset.
    pub offset: f64,
    pub half_width: f64,
}

/// Boxes of nodes are rounded outward by more than a query's box is rounded. Their heights over a
/// plane are computed in double precision.
impl Slab {
    /// Whether a box, given by its centre and half its extents, may reach into the slab's plane.
    fn meets_plane(&self, centre: Vector, half: Vector) -> bool {
        let reach: f64 = (0..3).map(|k| self.normal[k].abs() * half[k]).sum();
        (dot(self.normal, centre) - self.offset).abs() <= reach + self.half_width
    }

    /// Whether a triangle may reach into the slab.
    fn meets(&self, corners: &[Vector; 3]) -> bool {
        let is_apart = (0..3).any(|k| {
            corners.iter().all(|corner| corner[k] < self.min[k])
                || corners.iter().all(|corner| corner[k] > self.max[k])
        });
        let heights = corners.map(|corner| dot(self.normal, corner) - self.offset);
        !is_apart
            && heights.iter().any(|&height| height <= self.half_width)
            && heights.iter().any(|&height| height >= -self.half_width)
    }
}

impl Bvh {
    /// Collects the corners of the triangles that may reach into a slab. Returns whether there are
    /// at most `most`; otherwise some are missing. Typically O(log n + found).
    pub(crate) fn triangles_in_slab(
        &self,
        slab: &Slab,
        most: usize,
        found: &mut Vec<[Vector; 3]>,
    ) -> bool {
        found.clear();
        let tree = &self.tree;
        let relative = |point: Vector, k: usize| point[k] - tree.centre[k];
        let mut stack = [0_u32; STACK];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            match child(stack[height]) {
                Child::Empty => {}
                Child::Block(block) => {
                    for lane in 0..WIDTH {
                        let corners = &tree.corners[block * WIDTH + lane];
                        if tree.blocks[block].triangles[lane] != EMPTY && slab.meets(corners) {
                            found.push(*corners);
                        }
                    }
                    if found.len() > most {
                        return false;
                    }
                }
                Child::Node(index) => {
                    let node = &tree.nodes[index];
                    for (place, reference) in node.children.into_iter().enumerate() {
                        let is_apart = (0..3).any(|k| {
                            f64::from(node.min[k][place]) > relative(slab.max, k)
                                || f64::from(node.max[k][place]) < relative(slab.min, k)
                        });
                        if reference == EMPTY || is_apart {
                            continue;
                        }
                        let ends = |k: usize| {
                            (f64::from(node.min[k][place]), f64::from(node.max[k][place]))
                        };
                        let centre = [0, 1, 2].map(|k| {
                            let (low, high) = ends(k);
                            0.5 * (low + high) + tree.centre[k]
                        });
                        let half = [0, 1, 2].map(|k| {
                            let (low, high) = ends(k);
                            0.5 * (high - low)
                        });
                        if slab.meets_plane(centre, half) {
                            stack[height] = reference;
                            height += 1;
                        }
                    }
                }
            }
        }
        true
    }
}
