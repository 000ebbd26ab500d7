//! The tree's layout: nodes of four single-precision boxes over blocks of four triangles.
//!
//! A node stores the boxes of its four children side by side, so that one visit tests all four
//! with one vector instruction per operation (Dammertz, Hanika and Keller, "Shallow Bounding
//! Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays", 2008). Boxes are rounded
//! outward: a distance to a box is a lower bound for distances in double precision too.

use crate::geometry::vector::Vector;

/// Children of a node, and triangles of a block: as many `f32` as a 128-bit register holds.
pub(super) const WIDTH: usize = 4;

/// Marks a reference to a block of triangles; the other bits are the block's index.
pub(super) const LEAF: u32 = 1 << 31;

/// A child, or a triangle of a block, that does not exist.
pub(super) const EMPTY: u32 = u32::MAX;

/// Deepest level of the tree. Halving 2^32 triangles down to blocks of four takes 30 levels, and
/// the builder halves where the surface area heuristic would need more.
pub(super) const MAX_LEVELS: u32 = 30;

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
    Block(usize),
}

impl Node {
    pub(super) const NO_CHILDREN: Self = Self {
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
        Child::Block((reference & !LEAF) as usize)
    } else {
        Child::Node(reference as usize)
    }
}

/// Up to four triangles, relative to [`Tree::centre`]: by corner, by axis, then by triangle. Lanes
/// without a triangle repeat the first.
#[derive(Debug, Clone)]
#[repr(align(32))]
pub(super) struct Block {
    pub corners: [[[f32; WIDTH]; 3]; 3],
    /// Index of each triangle in the mesh, or [`EMPTY`].
    pub triangles: [u32; WIDTH],
}

/// The hierarchy. The root is the first node, and a node precedes its children.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub centre: Vector,
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
    /// Corners of the blocks' triangles in double precision, [`WIDTH`] triangles for each block.
    pub corners: Vec<[Vector; 3]>,
    /// How far rounding to single precision may move a corner, a plane or a point.
    pub margin: f32,
}

/// A single instruction, unlike `f32::min`, which handles NaN; no argument here is NaN.
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
