//! The triangles near a face (in its box and in the slab around its plane), or near a box.

use super::hierarchy::Bvh;
use super::tree::{EMPTY, Node, WIDTH};
use crate::geometry::vector::Vector;

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
        let offset = self.offset - self.normal.dot(origin);
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
        let heights = corners.map(|corner| self.normal.dot(corner) - self.offset);
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
        tree.visit_blocks(
            |node| slab.meets_children(&tree.nodes[node], tree.centre),
            |block| {
                for lane in 0..WIDTH {
                    let corners = &tree.corners[block * WIDTH + lane];
                    if tree.blocks[block].triangles[lane] != EMPTY && slab.meets(corners) {
                        found.push(*corners);
                    }
                }
                found.len() <= most
            },
        )
    }

    /// The triangles whose boxes come within `margin` of a box, and others near it.
    pub(crate) fn triangles_near_box(&self, low: Vector, high: Vector, margin: f64) -> Vec<u32> {
        let tree = &self.tree;
        let low = (low - tree.centre).map(|x| x - margin - f64::from(tree.margin));
        let high = (high - tree.centre).map(|x| x + margin + f64::from(tree.margin));
        let mut found = Vec::new();
        let overlaps = |node: &Node, place: usize| {
            (0..3).all(|axis| {
                f64::from(node.min[axis][place]) <= high[axis]
                    && f64::from(node.max[axis][place]) >= low[axis]
            })
        };
        tree.visit_blocks(
            |node| [0, 1, 2, 3].map(|place| overlaps(&tree.nodes[node], place)),
            |block| {
                let triangles = tree.blocks[block].triangles.iter();
                found.extend(triangles.filter(|&&triangle| triangle != EMPTY));
                true
            },
        );
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::uv_sphere;

    #[test]
    fn triangles_near_a_box_are_among_those_found() {
        let mesh = uv_sphere(16, [0.0; 3], 1.0);
        let bvh = Bvh::new(mesh.points(), &mesh.triangles);
        let (low, high) = (Vector::new(0.5, -0.2, -0.2), Vector::new(1.5, 0.2, 0.2));
        let found = bvh.triangles_near_box(low, high, 0.0);
        for (t, triangle) in (0_u32..).zip(&mesh.triangles) {
            let is_in = triangle.iter().any(|&v| {
                let point = mesh.points()[v as usize];
                (0..3).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
            });
            assert!(!is_in || found.contains(&t));
        }
        assert!(found.len() < mesh.triangles.len() / 2);
    }
}
