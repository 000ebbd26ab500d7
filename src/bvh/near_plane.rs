//! The triangles near a face: in its box and in the slab around its plane.

use super::hierarchy::Bvh;
use super::tree::{Child, EMPTY, Node, STACK, WIDTH, child};
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
    /// Which children of a node may reach into the slab.
    #[inline]
    fn meets_children(&self, node: &Node, origin: Vector) -> [bool; WIDTH] {
        let offset = self.offset - dot(self.normal, origin);
        let mut meets = [true; WIDTH];
        let (mut height, mut reach) = ([0.0; WIDTH], [0.0; WIDTH]);
        for k in 0..3 {
            let (min, max) = (self.min[k] - origin[k], self.max[k] - origin[k]);
            for place in 0..WIDTH {
                let low = f64::from(node.min[k][place]);
                let high = f64::from(node.max[k][place]);
                meets[place] &= (low <= max) & (high >= min);
                height[place] += 0.5 * self.normal[k] * (low + high);
                reach[place] += 0.5 * self.normal[k].abs() * (high - low);
            }
        }
        for place in 0..WIDTH {
            meets[place] &= (height[place] - offset).abs() <= reach[place] + self.half_width;
        }
        meets
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
                    let meets = slab.meets_children(node, tree.centre);
                    for (place, reference) in node.children.into_iter().enumerate() {
                        if meets[place] && reference != EMPTY {
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
