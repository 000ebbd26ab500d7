//! A grid whose cells are filled by the tree when they are first asked. A hull's faces touch few of
//! them, so that a mesh of few triangles costs what its shape does, however small the bound.
//!
//! Distances are exact up to rounding. What a cell holds depends on the cell alone, so that threads
//! may fill it at the same time.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use super::blocks::{
    BLOCK, BLOCK_BITS, Ball, Block, Cell, EMPTY, OUTSIDE, UNKNOWN, UNKNOWN_INSIDE, number,
};
use super::lattice::Lattice;
use super::vector_f32::{dot, length, subtract};
use super::{CellClass, Clearance, HALF_DIAGONAL, Probe};
use crate::bounded::containment::boundary::Boundary;
use crate::bounded::containment::inside::is_inside;
use crate::bounded::work;
use crate::bvh::Bvh;
use crate::geometry::vector::{Vector, bounds};

/// The surface does not pass between the centres of two cells if their distances from it add up to more than
/// the distance between them, times this: a margin for rounding.
const FREE: f32 = 1.01;

/// In an open surface, a reach below this share of the distance to it is not worth summing up.
const LEAST_REACH: f64 = 0.1;

/// The grid. See the file's head.
pub(in crate::bounded::containment) struct LazyGrid {
    pub(super) lattice: Lattice,
    blocks: Vec<OnceLock<Box<Block>>>,
    /// Blocks along the first two axes.
    stride: [usize; 2],
    pub(super) boundary: Arc<Boundary>,
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
    pub(super) fn block_of(&self, place: [usize; 3]) -> &Block {
        self.blocks[self.block_index(place)].get_or_init(|| Box::new(Block::empty()))
    }

    /// What the ball of a point's block tells about it: two queries serve many cells, where the surface is far
    /// enough. In an open solid the inside may end where no surface is.
    #[inline]
    pub(super) fn clearance(&self, point: Vector, bvh: &Bvh) -> Option<Clearance> {
        let (relative, place) = self.place(point);
        let block = self.block_of(place);
        let centre = self.block_centre(place);
        let away = length(subtract(relative, centre));
        let distance = match block.ball.distance.load(Ordering::Relaxed) {
            EMPTY => self.measure(&block.ball, centre, &block.triangle, bvh),
            bits => f32::from_bits(bits),
        };
        if away >= distance {
            return None;
        }
        let radius = match block.ball.radius.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_radius(block, centre, distance, bvh),
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
    fn compute_radius(&self, block: &Block, centre: [f32; 3], distance: f32, bvh: &Bvh) -> f32 {
        let radius = if self.boundary.is_empty() {
            let inside = is_inside(bvh, &self.boundary, self.lattice.absolute(centre));
            if inside { distance } else { -distance }
        } else {
            self.winding_of(block, centre, bvh).radius(distance)
        };
        block.ball.radius.store(radius.to_bits(), Ordering::Relaxed);
        radius
    }

    /// A cell, filled.
    #[inline]
    pub(super) fn cell(&self, place: [usize; 3], bvh: &Bvh) -> &Cell {
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
    pub(super) fn place(&self, point: Vector) -> ([f32; 3], [usize; 3]) {
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
    fn reach_of(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> f32 {
        let bits = cell.reach.load(Ordering::Relaxed);
        if bits == UNKNOWN || bits == UNKNOWN_INSIDE.to_bits() {
            return self.compute_reach(cell, place, bvh);
        }
        f32::from_bits(bits)
    }

    /// Whether a cell's centre is inside.
    #[inline]
    pub(super) fn is_inside(&self, place: [usize; 3], bvh: &Bvh) -> bool {
        self.is_cell_inside(self.cell(place, bvh), place, bvh)
    }

    #[inline]
    fn is_cell_inside(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> bool {
        match cell.reach.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_side(cell, place, bvh),
            bits => f32::from_bits(bits) >= 0.0,
        }
    }

    #[cold]
    fn compute_side(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> bool {
        if self.boundary.is_empty() {
            return self.compute_reach(cell, place, bvh) >= 0.0;
        }
        let inside = self.is_inside_open(cell, place, bvh);
        let reach = if inside { UNKNOWN_INSIDE } else { OUTSIDE };
        cell.reach.store(reach.to_bits(), Ordering::Relaxed);
        inside
    }

    #[cold]
    fn compute_reach(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> f32 {
        let distance = cell.distance();
        let reach = if self.boundary.is_empty() {
            let centre = self.lattice.absolute(self.lattice.centre(place));
            let inside = self.side_of_another(place, distance);
            let inside = inside.unwrap_or_else(|| is_inside(bvh, &self.boundary, centre));
            if inside { distance } else { OUTSIDE }
        } else if self.is_cell_inside(cell, place, bvh) {
            self.reach_in_open(cell, place, LEAST_REACH * f64::from(distance), bvh) as f32
        } else {
            OUTSIDE
        };
        cell.reach.store(reach.to_bits(), Ordering::Relaxed);
        if self.boundary.is_empty()
            && let Some(block) = self.block(place)
        {
            block.sided.store(number(place) as u32, Ordering::Relaxed);
        }
        reach
    }

    /// Whether a cell is inside, if another cell knows that for itself and the surface does not pass
    /// between the two: one of their block, or a neighbour.
    fn side_of_another(&self, place: [usize; 3], distance: f32) -> Option<bool> {
        self.others(place).find_map(|other| {
            let cell = self.known_cell(other)?;
            let reach = f32::from_bits(match cell.reach.load(Ordering::Relaxed) {
                UNKNOWN => return None,
                bits => bits,
            });
            self.is_free(place, distance, other, cell).then_some(reach >= 0.0)
        })
    }

    /// Whether the surface crosses neither of the balls around two cells' centres that reach up to it.
    pub(super) fn is_free(
        &self,
        place: [usize; 3],
        distance: f32,
        other: [usize; 3],
        cell: &Cell,
    ) -> bool {
        let apart = length(subtract(self.lattice.centre(place), self.lattice.centre(other)));
        distance + cell.distance() > FREE * apart
    }

    /// Cells that may know a cell's side: its neighbours, and one of its block.
    pub(super) fn others(&self, place: [usize; 3]) -> impl Iterator<Item = [usize; 3]> + '_ {
        (0..7).filter_map(move |side| {
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
        })
    }

    /// The centre of a cell's block.
    pub(super) fn block_centre(&self, place: [usize; 3]) -> [f32; 3] {
        let size = BLOCK as f32 * self.lattice.size;
        place.map(|place| ((place >> BLOCK_BITS) as f32 + 0.5) * size)
    }

    /// A cell, if it exists and its block does.
    pub(super) fn known_cell(&self, place: [usize; 3]) -> Option<&Cell> {
        self.block(place)?.cells.get(number(place))
    }

    /// The block of a cell, if both exist.
    pub(super) fn block(&self, place: [usize; 3]) -> Option<&Block> {
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
        Some(self.is_inside(place, bvh))
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
        let inside = self.is_cell_inside(cell, place, bvh);
        let is_near = || half - f64::from(self.reach_of(cell, place, bvh)) <= self.near;
        if inside && (half <= self.near || is_near()) {
            CellClass::Near
        } else if !inside && distance - half > self.far {
            CellClass::Far
        } else {
            CellClass::Mixed
        }
    }
}

/// More than the rounding of distances to single precision, in diagonals, and of winding numbers.
pub(super) const ROUNDING: f64 = 1e-6;
