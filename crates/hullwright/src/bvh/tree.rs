//! The tree's layout: nodes of four single-precision boxes over leaves of four triangles.
//!
//! A node stores the boxes of its four children side by side, so that one visit tests all four
//! with one vector instruction per operation (Dammertz, Hanika and Keller, "Shallow Bounding
//! Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", 2008). Boxes are rounded
//! outward: a distance to a box is a lower bound for distances in double precision too.

use crate::geometry::vector::{Vector, larger, smaller};

/// Children of a node, and triangles of a leaf: as many `f32` as a 128-bit register holds.
pub(super) const WIDTH: usize = 4;

/// Marks a reference to a leaf of triangles; the other bits are the leaf's index.
const LEAF: u32 = 1 << 31;

/// A child, or a triangle of a leaf, that does not exist.
pub(super) const EMPTY: u32 = u32::MAX;

/// Deepest level of the tree. Halving 2^32 triangles down to leaves of four takes 30 levels, and
/// the builder halves where the surface area heuristic would need more.
const MAX_LEVELS: u32 = 30;

/// Entries of a traversal stack: each level leaves at most three siblings, the deepest pushes four.
pub(super) const STACK: usize = WIDTH + (WIDTH - 1) * MAX_LEVELS as usize;

/// A box's squared distance in single precision may exceed the true one by a few units in the
/// last place (2^-23 = 1.2e-7).
pub(super) const BOUND_SLACK: f64 = 1.0 + 1e-5;

/// The boxes of up to four children, relative to [`Tree::centre`].
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Node {
    /// By axis, then by child.
    pub min: [[f32; WIDTH]; 3],
    pub max: [[f32; WIDTH]; 3],
    pub children: [u32; WIDTH],
}

/// What a child refers to.
pub(super) enum Child {
    Empty,
    Node(usize),
    Leaf(usize),
}

impl Node {
    const NO_CHILDREN: Self = Self {
        min: [[f32::INFINITY; WIDTH]; 3],
        max: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [EMPTY; WIDTH],
    };
}

/// Reads a child's reference.
#[inline(always)]
pub(super) fn child(reference: u32) -> Child {
    if reference == EMPTY {
        Child::Empty
    } else if reference & LEAF != 0 {
        Child::Leaf((reference & !LEAF) as usize)
    } else {
        Child::Node(reference as usize)
    }
}

/// Up to four triangles, relative to [`Tree::centre`]: by corner, by axis, then by triangle. Lanes
/// without a triangle repeat the first.
#[derive(Debug, Clone)]
#[repr(align(32))]
pub(super) struct Leaf {
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// Index of each triangle in the mesh, or [`EMPTY`].
    pub triangles: [u32; WIDTH],
}

/// The hierarchy. The root is the first node, and a node precedes its children.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub centre: Vector,
    pub nodes: Vec<Node>,
    pub leaves: Vec<Leaf>,
    /// Corners of the leaves' triangles in double precision, [`WIDTH`] triangles for each leaf.
    pub corners: Vec<[Vector; 3]>,
    /// How far rounding to single precision may move a corner, a plane or a point.
    pub margin: f32,
}

impl Tree {
    /// Visits the leaves below all children that `enters` picks by a node's index, until `visit`
    /// returns false. Whether it never did.
    #[inline(always)]
    pub(super) fn visit_leaves(
        &self,
        mut enters: impl FnMut(usize) -> [bool; WIDTH],
        mut visit: impl FnMut(usize) -> bool,
    ) -> bool {
        let mut stack = [0_u32; STACK];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            match child(stack[height]) {
                Child::Empty => {}
                Child::Leaf(leaf) => {
                    if !visit(leaf) {
                        return false;
                    }
                }
                Child::Node(node) => {
                    let entered = enters(node);
                    for (place, reference) in self.nodes[node].children.into_iter().enumerate() {
                        if entered[place] && reference != EMPTY {
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

// Construction, top down, by the surface area heuristic with bins (Wald, "On Fast Construction of
// SAH-based Bounding Volume Hierarchies", 2007). A node splits its largest range until it has four
// children. Small ranges are split between full leaves, so that few lanes stay empty. O(n log n).

/// Nodes over more triangles than this check for cancellation: building a smaller part takes less
/// than a millisecond.
const CANCELLABLE: usize = 4096;

/// Bins of the surface area heuristic; more hardly improve a tree (Wald 2007, section 4).
const BINS: usize = 16;

/// Ranges up to this size are sorted and split between full leaves: they end as one node.
const SORTED: usize = WIDTH * WIDTH;

/// Margin of boxes and of planes across triangles, as a fraction of the mesh's radius (the greatest
/// distance of a corner from the centre). It exceeds what rounding to single precision does to a
/// point within three times the radius (at most 5 × 3 × 2^-24). For points farther away the error
/// is relative to the distance, and [`BOUND_SLACK`](super::tree::BOUND_SLACK) covers it.
const MARGIN: f64 = 1.0 / (1 << 19) as f64;

/// Estimates for memory that is reserved: triangles per node, and full lanes per leaf on average.
const TRIANGLES_PER_NODE: usize = 6;
const TRIANGLES_PER_TWO_LEAVES: usize = 7;

/// A triangle and its box.
#[derive(Debug, Clone, Copy)]
struct Primitive {
    bounds: Box3,
    triangle: u32,
}

#[derive(Debug, Clone, Copy)]
struct Box3 {
    min: [f32; LANES],
    max: [f32; LANES],
}

/// Three axes and an unused lane, so that a corner fills a register.
const LANES: usize = 4;

impl Box3 {
    const NOTHING: Self = Self { min: [f32::INFINITY; LANES], max: [f32::NEG_INFINITY; LANES] };

    #[inline(always)]
    fn join(&mut self, other: &Self) {
        for axis in 0..LANES {
            self.min[axis] = smaller(self.min[axis], other.min[axis]);
            self.max[axis] = larger(self.max[axis], other.max[axis]);
        }
    }

    /// Half the surface area.
    fn area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.extent(axis));
        x * y + y * z + z * x
    }

    fn extent(&self, axis: usize) -> f32 {
        self.max[axis] - self.min[axis]
    }

    /// Twice the middle along an axis.
    #[inline(always)]
    fn middle(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }
}

impl Tree {
    /// Leaves out triangles with a corner that does not exist or is not finite, and, once
    /// `is_cancelled`, large parts of the mesh.
    pub(super) fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        is_cancelled: &dyn Fn() -> bool,
    ) -> Self {
        let corners = |index: usize| corners_of(positions, triangles, index);
        let mut min = Vector::INFINITY;
        let mut max = Vector::NEG_INFINITY;
        for index in 0..triangles.len() {
            if let Some([a, b, c]) = corners(index) {
                min = min.min(a).min(b.min(c));
                max = max.max(a).max(b.max(c));
            }
        }
        let mut tree = Self {
            centre: Vector::ZERO,
            nodes: Vec::new(),
            leaves: Vec::new(),
            corners: Vec::new(),
            margin: 0.0,
        };
        if min[0] > max[0] {
            tree.nodes.push(Node::NO_CHILDREN);
            return tree;
        }
        tree.centre = (min + max) * 0.5;
        let margin = max.distance(tree.centre) * MARGIN;
        tree.margin = margin as f32;

        let mut primitives = Vec::with_capacity(triangles.len());
        let mut bounds = Box3::NOTHING;
        for index in 0..triangles.len() {
            if let Some([a, b, c]) = corners(index) {
                let min = a.min(b).min(c) - tree.centre;
                let max = a.max(b).max(c) - tree.centre;
                let primitive = Primitive {
                    bounds: Box3 { min: single(min, -margin), max: single(max, margin) },
                    triangle: index as u32,
                };
                bounds.join(&primitive.bounds);
                primitives.push(primitive);
            }
        }
        tree.nodes.reserve(primitives.len() / TRIANGLES_PER_NODE + 1);
        let leaves = primitives.len() * 2 / TRIANGLES_PER_TWO_LEAVES + 1;
        tree.leaves.reserve(leaves);
        tree.corners.reserve(WIDTH * leaves);
        let mut builder = Builder { tree, corners, is_cancelled };
        builder.build(&mut primitives, bounds, MAX_LEVELS);
        builder.tree
    }
}

/// A tree under construction.
struct Builder<'a, C> {
    tree: Tree,
    /// A triangle's corners, if it can be used.
    corners: C,
    is_cancelled: &'a dyn Fn() -> bool,
}

impl<C: Fn(usize) -> Option<[Vector; 3]>> Builder<'_, C> {
    /// Appends a node over the primitives and returns its index.
    fn build(&mut self, primitives: &mut [Primitive], bounds: Box3, levels: u32) -> u32 {
        let index = self.tree.nodes.len() as u32;
        self.tree.nodes.push(Node::NO_CHILDREN);
        if primitives.len() > CANCELLABLE && (self.is_cancelled)() {
            return index;
        }
        let mut ranges = [(0, primitives.len(), bounds); WIDTH];
        let mut count = 1;
        // The heuristic alone could build a chain deeper than the stack.
        let halve = primitives.len() as u64 > 2 << levels;
        while count < WIDTH {
            let weight = |&(start, end, bounds): &(usize, usize, Box3)| match end - start {
                ..=WIDTH => -1.0,
                size if halve => size as f32,
                _ => bounds.area(),
            };
            let mut largest = 0;
            for other in 1..count {
                if weight(&ranges[other]) > weight(&ranges[largest]) {
                    largest = other;
                }
            }
            let (start, end, _) = ranges[largest];
            if end - start <= WIDTH {
                break;
            }
            let (size, low, high) = split(&mut primitives[start..end], halve);
            ranges[largest] = (start, start + size, low);
            ranges[count] = (start + size, end, high);
            count += 1;
        }
        for (place, &(start, end, bounds)) in ranges[..count].iter().enumerate() {
            let part = &mut primitives[start..end];
            let reference = if part.len() <= WIDTH {
                self.append_leaf(part)
            } else {
                self.build(part, bounds, levels.saturating_sub(1))
            };
            let node = &mut self.tree.nodes[index as usize];
            node.children[place] = reference;
            for axis in 0..3 {
                node.min[axis][place] = bounds.min[axis];
                node.max[axis][place] = bounds.max[axis];
            }
        }
        index
    }

    fn append_leaf(&mut self, primitives: &mut [Primitive]) -> u32 {
        primitives.sort_unstable_by_key(|primitive| primitive.triangle);
        let mut leaf = Leaf { corners: [[[0.0; WIDTH]; 3]; 3], triangles: [EMPTY; WIDTH] };
        for lane in 0..WIDTH {
            let index = primitives[if lane < primitives.len() { lane } else { 0 }].triangle;
            let Some([a, b, c]) = (self.corners)(index as usize) else {
                continue;
            };
            if lane < primitives.len() {
                leaf.triangles[lane] = index;
            }
            self.tree.corners.push([a, b, c]);
            let relative = [a - self.tree.centre, b - self.tree.centre, c - self.tree.centre];
            for axis in 0..3 {
                for corner in 0..3 {
                    leaf.corners[corner][axis][lane] = relative[corner][axis] as f32;
                }
            }
        }
        self.tree.leaves.push(leaf);
        LEAF | (self.tree.leaves.len() - 1) as u32
    }
}

/// A triangle's corners, if all exist and are finite.
#[inline(always)]
fn corners_of(positions: &[Vector], triangles: &[[u32; 3]], index: usize) -> Option<[Vector; 3]> {
    let &[a, b, c] = triangles.get(index)?;
    let a = *positions.get(a as usize)?;
    let b = *positions.get(b as usize)?;
    let c = *positions.get(c as usize)?;
    // The sum of absolute values is finite only if all are; one that overflows is unusable too.
    let size = |x: Vector| x[0].abs() + x[1].abs() + x[2].abs();
    (size(a) + size(b) + size(c)).is_finite().then_some([a, b, c])
}

#[inline(always)]
fn single(a: Vector, margin: f64) -> [f32; LANES] {
    let [x, y, z] = a.to_array();
    [(x + margin) as f32, (y + margin) as f32, (z + margin) as f32, 0.0]
}

fn bounds_of(primitives: &[Primitive]) -> Box3 {
    let mut bounds = Box3::NOTHING;
    for primitive in primitives {
        bounds.join(&primitive.bounds);
    }
    bounds
}

/// Partitions the primitives in two; returns the size of the first part and both boxes.
fn split(primitives: &mut [Primitive], halve: bool) -> (usize, Box3, Box3) {
    let mut middles = Box3::NOTHING;
    for primitive in primitives.iter() {
        for axis in 0..LANES {
            let middle = primitive.bounds.middle(axis);
            middles.min[axis] = smaller(middles.min[axis], middle);
            middles.max[axis] = larger(middles.max[axis], middle);
        }
    }
    let mut axis = 0;
    for other in 1..3 {
        if middles.extent(other) > middles.extent(axis) {
            axis = other;
        }
    }
    let low = middles.min[axis];
    let bins_per_length = BINS as f32 / middles.extent(axis);
    if !halve && primitives.len() > SORTED && bins_per_length.is_finite() {
        let bin = |primitive: &Primitive| {
            let bin = (primitive.bounds.middle(axis) - low) * bins_per_length;
            (bin as usize).min(BINS - 1)
        };
        if let Some(parts) = split_binned(primitives, bin) {
            return parts;
        }
    }
    split_sorted(primitives, axis, halve)
}

/// Splits between full leaves, where the surface area heuristic is least; or, if `halve`, in the
/// middle.
fn split_sorted(primitives: &mut [Primitive], axis: usize, halve: bool) -> (usize, Box3, Box3) {
    let order = |a: &Primitive, b: &Primitive| {
        let (at_a, at_b) = (a.bounds.middle(axis), b.bounds.middle(axis));
        at_a.total_cmp(&at_b).then(a.triangle.cmp(&b.triangle))
    };
    let half = primitives.len().div_ceil(2);
    if halve || primitives.len() > SORTED {
        primitives.select_nth_unstable_by(half, order);
        let (low, high) = primitives.split_at(half);
        return (half, bounds_of(low), bounds_of(high));
    }
    primitives.sort_unstable_by(order);
    let mut best = (half, Box3::NOTHING, Box3::NOTHING);
    let mut least = f32::INFINITY;
    for size in (WIDTH..primitives.len()).step_by(WIDTH) {
        let (low, high) = primitives.split_at(size);
        let (low, high) = (bounds_of(low), bounds_of(high));
        let leaves = |count: usize| count.div_ceil(WIDTH) as f32;
        let cost = low.area() * leaves(size) + high.area() * leaves(primitives.len() - size);
        if cost < least {
            least = cost;
            best = (size, low, high);
        }
    }
    if least == f32::INFINITY {
        let (low, high) = primitives.split_at(half);
        best = (half, bounds_of(low), bounds_of(high));
    }
    best
}

/// Splits between bins, where the surface area heuristic is least. `None` if one part is empty.
fn split_binned(
    primitives: &mut [Primitive],
    bin: impl Fn(&Primitive) -> usize,
) -> Option<(usize, Box3, Box3)> {
    let mut boxes = [Box3::NOTHING; BINS];
    let mut counts = [0_usize; BINS];
    for primitive in primitives.iter() {
        let bin = bin(primitive);
        counts[bin] += 1;
        boxes[bin].join(&primitive.bounds);
    }
    let mut upper = [Box3::NOTHING; BINS];
    let mut above = Box3::NOTHING;
    for bin in (1..BINS).rev() {
        above.join(&boxes[bin]);
        upper[bin] = above;
    }
    let mut below = Box3::NOTHING;
    let mut size = 0;
    let mut best = (0, 0, Box3::NOTHING);
    let mut least = f32::INFINITY;
    for bin in 1..BINS {
        below.join(&boxes[bin - 1]);
        size += counts[bin - 1];
        let cost =
            below.area() * size as f32 + upper[bin].area() * (primitives.len() - size) as f32;
        if cost < least {
            least = cost;
            best = (bin, size, below);
        }
    }
    let (first_bin_above, size, low) = best;
    if size == 0 || size == primitives.len() {
        return None;
    }
    // Branch-free: the branch would be unpredictable.
    let mut end_of_low = 0;
    for index in 0..primitives.len() {
        let is_low = bin(&primitives[index]) < first_bin_above;
        primitives.swap(end_of_low, index);
        end_of_low += usize::from(is_low);
    }
    Some((size, low, upper[first_bin_above]))
}
