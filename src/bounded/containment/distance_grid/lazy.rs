//! A grid whose cells are filled by the tree when they are first asked. A hull's faces touch few of
//! them, so that a mesh of few triangles costs what its shape does, however small the bound.
//!
//! Distances are exact up to rounding. What a cell holds depends on the cell alone, so that threads
//! may fill it at the same time.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use super::lattice::Lattice;
use super::vector_f32::{dot, length, subtract};
use super::{CellClass, Clearance, HALF_DIAGONAL, Probe};
use crate::bounded::containment::boundary::Boundary;
use crate::bounded::containment::inside::{inside_reach, is_inside};
use crate::bounded::work;
use crate::bvh::Bvh;
use crate::geometry::vector::{Vector, bounds};

/// Cells of a block along each axis, as a power of two: blocks are allocated whole, and a face
/// passes through several cells of one.
const BLOCK_BITS: usize = 2;
const BLOCK: usize = 1 << BLOCK_BITS;

/// The distance of an empty cell, as bits. A cell on the surface has the smallest distance above.
const EMPTY: u32 = 0;

/// The reach of a cell whose side is unknown, and of one outside, as bits of single precision.
const UNKNOWN: u32 = u32::MAX;
const OUTSIDE: f32 = -1.0;

/// The surface does not pass between the centres of two cells if their distances from it add up to more than
/// the distance between them, times this: a margin for rounding.
const FREE: f32 = 1.01;

/// In an open surface, a reach below this share of the distance to it is not worth summing up.
const LEAST_REACH: f64 = 0.1;

/// What is known about a cell's centre. Single precision numbers as bits.
struct Cell {
    nearest: [AtomicU32; 3],
    triangle: AtomicU32,
    /// Written last.
    distance: AtomicU32,
    /// All points nearer than this to the centre are inside; [`OUTSIDE`] if the centre is not.
    reach: AtomicU32,
}

impl Cell {
    fn empty() -> Self {
        Self {
            nearest: [const { AtomicU32::new(0) }; 3],
            triangle: AtomicU32::new(u32::MAX),
            distance: AtomicU32::new(EMPTY),
            reach: AtomicU32::new(UNKNOWN),
        }
    }

    fn nearest(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| f32::from_bits(self.nearest[k].load(Ordering::Relaxed)))
    }

    fn distance(&self) -> f32 {
        f32::from_bits(self.distance.load(Ordering::Relaxed))
    }
}

/// A ball that is on one side as a whole. Single precision numbers as bits.
struct Ball {
    /// The distance of its centre from the surface, or [`EMPTY`].
    distance: AtomicU32,
    /// Its radius, negative if it is outside; or [`UNKNOWN`].
    radius: AtomicU32,
}

impl Ball {
    fn empty() -> Self {
        Self { distance: AtomicU32::new(EMPTY), radius: AtomicU32::new(UNKNOWN) }
    }
}

/// Cells that are near each other, and what the last of them to be filled tells the next.
struct Block {
    cells: [Cell; BLOCK * BLOCK * BLOCK],
    /// The ball around the block's centre.
    ball: Ball,
    /// A triangle that is near.
    triangle: AtomicU32,
    /// The number of a cell whose side is known.
    sided: AtomicU32,
}

impl Block {
    fn empty() -> Self {
        Self {
            cells: std::array::from_fn(|_| Cell::empty()),
            ball: Ball::empty(),
            triangle: AtomicU32::new(u32::MAX),
            sided: AtomicU32::new(u32::MAX),
        }
    }
}

/// The number of a cell in its block.
#[inline]
fn number([x, y, z]: [usize; 3]) -> usize {
    let [i, j, k] = [x, y, z].map(|place| place & (BLOCK - 1));
    (k << BLOCK_BITS | j) << BLOCK_BITS | i
}

/// The grid. See the file's head.
pub(in crate::bounded::containment) struct LazyGrid {
    lattice: Lattice,
    blocks: Vec<OnceLock<Box<Block>>>,
    /// Blocks along the first two axes.
    stride: [usize; 2],
    boundary: Arc<Boundary>,
    near: f64,
    far: f64,
}

impl LazyGrid {
    /// A grid over a surface. Cells are near as a whole if they are at most `near` from the solid,
    /// far if more than `far`.
    pub(in crate::bounded::containment) fn new(
        positions: &[Vector],
        bound: f64,
        boundary: Arc<Boundary>,
        near: f64,
        far: f64,
    ) -> Self {
        let lattice = Lattice::new(bounds(positions.iter().copied()), bound);
        let [x, y, z] = lattice.dimensions.map(|cells| cells.div_ceil(BLOCK));
        let mut blocks = Vec::new();
        blocks.resize_with(x * y * z, OnceLock::new);
        Self { lattice, blocks, stride: [x, y], boundary, near, far }
    }

    #[inline]
    fn block_of(&self, place: [usize; 3]) -> &Block {
        self.blocks[self.block_index(place)].get_or_init(|| Box::new(Block::empty()))
    }

    /// What the ball of a point's block tells about it: two queries serve many cells, where the surface is far
    /// enough. In an open solid the inside may end where no surface is.
    #[inline]
    pub(super) fn clearance(&self, point: Vector, bvh: &Bvh) -> Option<Clearance> {
        if !self.boundary.is_empty() {
            return None;
        }
        let (relative, place) = self.place(point);
        let block = self.block_of(place);
        let size = BLOCK as f32 * self.lattice.size;
        let centre = place.map(|place| ((place >> BLOCK_BITS) as f32 + 0.5) * size);
        let away = length(subtract(relative, centre));
        let distance = match block.ball.distance.load(Ordering::Relaxed) {
            EMPTY => self.measure(&block.ball, centre, &block.triangle, bvh),
            bits => f32::from_bits(bits),
        };
        if away >= distance {
            return None;
        }
        let radius = match block.ball.radius.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_radius(&block.ball, centre, distance, bvh),
            bits => f32::from_bits(bits),
        };
        let left = f64::from(radius.abs() - away) - ROUNDING;
        (left > 0.0).then_some(Clearance { radius: left, inside: radius > 0.0 })
    }

    /// The distance of a ball's centre. `hint` is a triangle that is near, and becomes the closest one.
    #[cold]
    fn measure(&self, ball: &Ball, centre: [f32; 3], hint: &AtomicU32, bvh: &Bvh) -> f32 {
        work::count(work::CELL);
        let guess = hint.load(Ordering::Relaxed);
        let absolute = self.lattice.absolute(centre);
        let closest = bvh.closest_point_near(absolute, f64::INFINITY, guess);
        let distance = closest.map_or(f32::INFINITY, |closest| {
            hint.store(closest.triangle, Ordering::Relaxed);
            closest.distance as f32
        });
        let distance = distance.max(f32::MIN_POSITIVE);
        ball.distance.store(distance.to_bits(), Ordering::Relaxed);
        distance
    }

    /// See [`Ball::radius`].
    #[cold]
    fn compute_radius(&self, ball: &Ball, centre: [f32; 3], distance: f32, bvh: &Bvh) -> f32 {
        let inside = is_inside(bvh, self.lattice.absolute(centre), true);
        let radius = if inside { distance } else { -distance };
        ball.radius.store(radius.to_bits(), Ordering::Relaxed);
        radius
    }

    /// A cell, filled.
    #[inline]
    fn cell(&self, place: [usize; 3], bvh: &Bvh) -> &Cell {
        let block = self.block_of(place);
        let cell = &block.cells[number(place)];
        if cell.distance.load(Ordering::Acquire) == EMPTY {
            self.fill(cell, place, &block.triangle, bvh);
        }
        cell
    }

    #[inline]
    fn block_index(&self, place: [usize; 3]) -> usize {
        let [width, depth] = self.stride;
        let [i, j, k] = place.map(|place| place >> BLOCK_BITS);
        (k * depth + j) * width + i
    }

    /// Fills a cell. `hint` is a triangle that is near, and becomes the closest one.
    #[cold]
    fn fill(&self, cell: &Cell, place: [usize; 3], hint: &AtomicU32, bvh: &Bvh) {
        work::count(work::CELL);
        let centre = self.lattice.centre(place);
        let (mut nearest, mut distance) = ([f32::NAN; 3], f32::INFINITY);
        let absolute = self.lattice.absolute(centre);
        let guess = hint.load(Ordering::Relaxed);
        if let Some(closest) = bvh.closest_point_near(absolute, f64::INFINITY, guess) {
            nearest = self.lattice.relative(closest.point);
            distance = length(subtract(centre, nearest));
            cell.triangle.store(closest.triangle, Ordering::Relaxed);
            hint.store(closest.triangle, Ordering::Relaxed);
        }
        for (place, x) in cell.nearest.iter().zip(nearest) {
            place.store(x.to_bits(), Ordering::Relaxed);
        }
        cell.distance.store(distance.max(f32::MIN_POSITIVE).to_bits(), Ordering::Release);
    }

    #[inline]
    fn place(&self, point: Vector) -> ([f32; 3], [usize; 3]) {
        let relative = self.lattice.relative(point);
        (relative, self.lattice.cell_at(relative))
    }

    #[inline]
    pub(super) fn probe(&self, point: Vector, bvh: &Bvh) -> Probe {
        let (relative, place) = self.place(point);
        let cell = self.cell(place, bvh);
        let away = length(subtract(relative, self.lattice.centre(place)));
        let upper = length(subtract(relative, cell.nearest()));
        Probe {
            upper: if upper.is_nan() { f64::INFINITY } else { f64::from(upper) },
            lower: f64::from(cell.distance() - away),
            index: 0,
            place,
        }
    }

    /// See [`super::DistanceGrid::distance_to_tangent`].
    pub(super) fn distance_to_tangent(&self, point: Vector, bvh: &Bvh) -> f64 {
        let (relative, place) = self.place(point);
        let nearest = self.cell(place, bvh).nearest();
        let normal = subtract(self.lattice.centre(place), nearest);
        let height = dot(subtract(relative, nearest), normal) / length(normal);
        if height.is_nan() { f64::INFINITY } else { f64::from(height) }
    }

    pub(super) fn nearest_point(&self, point: Vector, bvh: &Bvh) -> Option<Vector> {
        let nearest = self.cell(self.place(point).1, bvh).nearest();
        (!nearest[0].is_nan()).then(|| self.lattice.absolute(nearest))
    }

    pub(super) fn nearest_triangle(&self, point: Vector, bvh: &Bvh) -> u32 {
        self.cell(self.place(point).1, bvh).triangle.load(Ordering::Relaxed)
    }

    /// All points nearer than this to a cell's centre are inside; negative if the centre is not.
    #[inline]
    pub(super) fn reach(&self, place: [usize; 3], bvh: &Bvh) -> f32 {
        self.reach_of(self.cell(place, bvh), place, bvh)
    }

    #[inline]
    fn reach_of(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> f32 {
        match cell.reach.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_reach(cell, place, bvh),
            bits => f32::from_bits(bits),
        }
    }

    #[cold]
    fn compute_reach(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> f32 {
        let centre = self.lattice.absolute(self.lattice.centre(place));
        let distance = cell.distance();
        let reach = if self.boundary.is_empty() {
            let inside = self.side_of_another(place, distance);
            let inside = inside.unwrap_or_else(|| is_inside(bvh, centre, true));
            if inside { distance } else { OUTSIDE }
        } else {
            let away = f64::from(distance);
            let reach = inside_reach(bvh, &self.boundary, centre, away, LEAST_REACH * away);
            reach.map_or(OUTSIDE, |reach| reach as f32)
        };
        cell.reach.store(reach.to_bits(), Ordering::Relaxed);
        if let Some(block) = self.block(place) {
            block.sided.store(number(place) as u32, Ordering::Relaxed);
        }
        reach
    }

    /// Whether a cell is inside, if another cell knows that for itself and the surface does not pass
    /// between the two: one of their block, or a neighbour.
    fn side_of_another(&self, place: [usize; 3], distance: f32) -> Option<bool> {
        let mut others = (0..7).filter_map(|side| {
            let mut other = place;
            if side == 6 {
                let number = self.block(place)?.sided.load(Ordering::Relaxed) as usize;
                if number >= BLOCK * BLOCK * BLOCK {
                    return None;
                }
                let inner = [number, number >> BLOCK_BITS, number >> (2 * BLOCK_BITS)];
                for (axis, inner) in inner.into_iter().enumerate() {
                    other[axis] = place[axis] & !(BLOCK - 1) | inner & (BLOCK - 1);
                }
            } else {
                let axis = side / 2;
                other[axis] = match side % 2 {
                    0 => place[axis].checked_sub(1)?,
                    _ => place[axis] + 1,
                };
            }
            Some(other)
        });
        others.find_map(|other| {
            let cell = self.known_cell(other)?;
            let reach = f32::from_bits(match cell.reach.load(Ordering::Relaxed) {
                UNKNOWN => return None,
                bits => bits,
            });
            let apart = length(subtract(self.lattice.centre(place), self.lattice.centre(other)));
            // The surface crosses neither of the balls around the two that reach up to it.
            (distance + cell.distance() > FREE * apart).then_some(reach >= 0.0)
        })
    }

    /// A cell, if it exists and its block does.
    fn known_cell(&self, place: [usize; 3]) -> Option<&Cell> {
        self.block(place)?.cells.get(number(place))
    }

    /// The block of a cell, if both exist.
    fn block(&self, place: [usize; 3]) -> Option<&Block> {
        if (0..3).any(|axis| place[axis] >= self.lattice.dimensions[axis]) {
            return None;
        }
        self.blocks.get(self.block_index(place))?.get().map(Box::as_ref)
    }

    /// See [`super::DistanceGrid::depth`].
    #[inline]
    pub(super) fn depth(&self, point: Vector, bvh: &Bvh) -> Option<f64> {
        let (relative, place) = self.place(point);
        let reach = self.reach_of(self.cell(place, bvh), place, bvh);
        let away = length(subtract(relative, self.lattice.centre(place)));
        (reach >= 0.0).then_some(f64::from(reach - away) - ROUNDING)
    }

    /// See [`super::DistanceGrid::side`].
    #[inline]
    pub(super) fn side(&self, point: Vector, distance: f64, bvh: &Bvh) -> Option<bool> {
        let (relative, place) = self.place(point);
        let away = length(subtract(relative, self.lattice.centre(place)));
        if f64::from(away) >= distance || !self.boundary.is_empty() {
            return None;
        }
        Some(self.reach_of(self.cell(place, bvh), place, bvh) >= 0.0)
    }

    /// The class of a point's cell. In an open solid, a cell whose centre is outside is as far as
    /// its surface.
    #[inline]
    pub(super) fn class_of(&self, point: Vector, bvh: &Bvh) -> CellClass {
        let (_, place) = self.place(point);
        let cell = self.cell(place, bvh);
        let half = HALF_DIAGONAL * f64::from(self.lattice.size);
        let distance = f64::from(cell.distance());
        if distance + half <= self.near {
            return CellClass::Near;
        }
        if distance <= half && distance - half <= self.far && half > self.near {
            return CellClass::Mixed;
        }
        let reach = f64::from(self.reach_of(cell, place, bvh));
        if reach >= 0.0 && half - reach <= self.near {
            CellClass::Near
        } else if reach < 0.0 && distance - half > self.far {
            CellClass::Far
        } else {
            CellClass::Mixed
        }
    }
}

/// More than the rounding of distances to single precision, in diagonals.
const ROUNDING: f64 = 1e-6;
