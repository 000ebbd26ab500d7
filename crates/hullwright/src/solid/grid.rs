//! A grid in front of a surface. Its cells hold the closest point of the surface to their centre,
//! and their side: that answers most questions of a fit test without the tree.
//!
//! A cell is filled when it is first needed. The faces of hulls touch few cells, so that a mesh
//! costs what its shape does, however small the bound. Blocks of 64 cells hold the distance of
//! their centre from the surface: that settles most points far from it, and their cells stay empty.
//! What a cell holds depends on the cell alone, so that threads may fill it at the same time, and
//! no result depends on which was first. Distances are exact up to single precision.
//!
//! In an open solid the winding number changes only slowly where the surface is not crossed, and by
//! whole turns where it is. So one number for a block, and the turns between its centre and a cell,
//! bound the number at any point of the block. Neighbours share their turns, where no surface is
//! between them.

use glam::Vec3;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use super::boundary::Slope;
use super::surface::{OPEN_INSIDE, Side, Surface, Winding};
use crate::bvh::closest_point::EXACT;
use crate::geometry::blocks::{Blocks, size_for};
use crate::geometry::vector::{Vector, bounds, larger, smaller};
use crate::parallel;
use crate::work;

/// Maximum number of cells. At a bound of 2 % a hundred thousand are enough. At 0.5 % a grid of
/// 200,000 cells leaves so many queries to the tree that the search takes three times as long.
const MAX_CELLS: f64 = 1_500_000.0;

/// Minimum extent of the box along an axis, as a fraction of the diagonal: a flat mesh has none
/// along one.
const MIN_EXTENT: f64 = 1e-6;

/// Cells along each axis beyond those that cover the box: one on each side, so that the border is
/// outside the mesh, and one for rounding.
const BORDER: f64 = 3.0;

/// More than the rounding of distances to single precision, as a fraction of the diagonal, and of
/// winding numbers.
pub(super) const ROUNDING: f64 = 1e-6;

/// The surface does not pass between the centres of two cells if their distances from it add up to
/// more than the distance between them, times this: a margin for rounding.
const FREE: f32 = 1.01;

/// A cell whose centre is farther than this from the surface, as a multiple of its side, is crossed
/// by none of it on the way to a neighbour: half a side, and a margin.
const FREE_OF_SIDES: f32 = 0.8;

/// In an open surface, a depth below this fraction of the distance to it is not worth a sum over
/// the boundary.
const LEAST_DEPTH: f64 = 0.1;

/// A number of turns follows from a number that is less than half a turn away, with a margin for
/// rounding and the expansion's error.
const MOST_CHANGE: f64 = 0.45;

/// Cells of a block along each axis, as a power of two: a face passes through several cells of a
/// block.
const BLOCK_BITS: usize = 2;
const BLOCK: usize = 1 << BLOCK_BITS;
const CELLS: usize = Blocks::<(), BLOCK>::CELLS;

/// A value that is not computed yet, as bits of single precision or of a count of turns.
const UNKNOWN: u32 = u32::MAX;

/// The distance of an empty cell, as bits. A cell on the surface has the smallest distance above.
const EMPTY: u32 = 0;

/// The depth of a cell outside.
const OUTSIDE: f32 = -1.0;

/// The depth of a cell that is known to be inside, and no more.
const UNKNOWN_INSIDE: f32 = f32::INFINITY;

/// A point in single precision, relative to the corner of the first cell.
type Relative = glam::Vec3;

/// Column, row and layer of a cell.
type Place = [usize; 3];

/// Single precision numbers as bits, written by any thread.
fn load(bits: &AtomicU32) -> f32 {
    f32::from_bits(bits.load(Ordering::Relaxed))
}

fn store(bits: &AtomicU32, value: f32) {
    bits.store(value.to_bits(), Ordering::Relaxed);
}

/// What is known about a cell's centre.
struct Cell {
    nearest: [AtomicU32; 3],
    triangle: AtomicU32,
    /// Written last; [`EMPTY`] until then.
    distance: AtomicU32,
    /// The radius of a ball around the centre that is inside as a whole; [`OUTSIDE`] if the centre
    /// is not.
    depth: AtomicU32,
    /// In an open solid, by how many whole turns the winding number differs from that about the
    /// block's centre.
    turns: AtomicU32,
    /// In an open solid, the winding number, where it was computed.
    winding: AtomicU32,
}

impl Cell {
    fn empty() -> Self {
        let unknown = || AtomicU32::new(UNKNOWN);
        Self {
            nearest: [const { AtomicU32::new(0) }; 3],
            triangle: unknown(),
            distance: AtomicU32::new(EMPTY),
            depth: unknown(),
            turns: unknown(),
            winding: unknown(),
        }
    }

    fn nearest(&self) -> Relative {
        Vec3::from_array([0, 1, 2].map(|k| load(&self.nearest[k])))
    }
}

/// Cells that are near each other.
struct Block {
    cells: [Cell; CELLS],
    /// The distance of the centre from the surface, or [`EMPTY`].
    distance: AtomicU32,
    /// The radius of a ball around the centre that is on one side as a whole, negative if that is
    /// outside.
    ball: AtomicU32,
    /// A triangle that is near: the closest one of the cell that was filled last.
    triangle: AtomicU32,
    /// The index of a cell whose side is known.
    sided: AtomicU32,
    /// In an open solid, the winding number about the centre.
    winding: OnceLock<BlockWinding>,
}

struct BlockWinding {
    number: f64,
    slope: Slope,
}

impl Block {
    fn empty() -> Self {
        let unknown = || AtomicU32::new(UNKNOWN);
        Self {
            cells: std::array::from_fn(|_| Cell::empty()),
            distance: AtomicU32::new(EMPTY),
            ball: unknown(),
            triangle: unknown(),
            sided: unknown(),
            winding: OnceLock::new(),
        }
    }
}

/// The grid. See the module.
pub(super) struct Grid {
    pub surface: Arc<Surface>,
    /// Corner of the first cell.
    origin: Vector,
    /// Side of a cell.
    size: f32,
    inverse_size: f32,
    blocks: Blocks<Block, BLOCK>,
}

/// A ball around a point: all of it is on the same side, and no surface is in it.
pub(super) struct Ball {
    pub radius: f64,
    pub side: Side,
}

impl Grid {
    /// A grid over a surface: cells whose half diagonal is half the bound, or larger ones where
    /// those were too many.
    pub fn new(surface: Arc<Surface>, positions: &[Vector], bound: f64) -> Self {
        let (min, max) = bounds(positions.iter().copied());
        let extent = [0, 1, 2].map(|k| (max[k] - min[k]).max(MIN_EXTENT));
        let count = |size: f64| Vector::from(extent.map(|e| (e / size).ceil() + BORDER));
        let size = size_for(bound / 3f64.sqrt(), MAX_CELLS, count);
        let dimensions = extent.map(|e| (e / size).ceil() as usize + BORDER as usize);
        let origin = Vector::from_array(
            [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]) - 0.5 * size * dimensions[k] as f64),
        );
        let (size, inverse_size) = (size as f32, (1.0 / size) as f32);
        Self { surface, origin, size, inverse_size, blocks: Blocks::new(dimensions) }
    }

    /// The corners of a box around the surface.
    pub fn bounds(&self) -> (Vector, Vector) {
        let dimensions = Vector::from_array(self.blocks.dimensions.map(|count| count as f64));
        (self.origin, self.origin + dimensions * f64::from(self.size))
    }

    /// A point in its cell, or in the nearest one, with bounds on its distance from the surface.
    #[inline]
    pub fn locate(&self, point: Vector) -> Location<'_> {
        let (relative, place) = self.place(point);
        let cell = self.cell(place);
        let away = relative.distance(self.centre(place));
        let upper = relative.distance(cell.nearest());
        let upper = if upper.is_nan() { f64::INFINITY } else { f64::from(upper) };
        let lower = f64::from(load(&cell.distance) - away);
        Location { grid: self, cell, place, relative, away, lower, upper }
    }

    /// The ball around a point that follows from its block. In an open solid the inside may end
    /// where no surface is.
    #[inline]
    pub fn ball(&self, point: Vector) -> Option<Ball> {
        let (relative, place) = self.place(point);
        let block = self.block_of(place);
        let centre = self.block_centre(place);
        let away = relative.distance(centre);
        let distance = self.block_distance(block, centre);
        if away >= distance {
            return None;
        }
        let ball = match block.ball.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_ball(block, centre, distance),
            bits => f32::from_bits(bits),
        };
        let radius = f64::from(ball.abs() - away) - ROUNDING;
        let side = if ball > 0.0 { Side::Inside } else { Side::Outside };
        (radius > 0.0).then_some(Ball { radius, side })
    }

    /// For each cell whether the surface is farther from its centre than `bound` and than the sides
    /// of the cell. Fills few more cells than those near the limit. O(cells).
    pub fn free_cells(&self, bound: f64) -> Vec<bool> {
        let [width, height, depth] = self.blocks.dimensions;
        let limit = (bound as f32).max(FREE_OF_SIDES * self.size);
        let layers = parallel::map_indices(depth, |z| {
            let cells = (0..height).flat_map(|y| (0..width).map(move |x| [x, y, z]));
            let is_free = cells.map(|place| {
                let (block, centre) = (self.block_of(place), self.block_centre(place));
                let away = FREE * self.centre(place).distance(centre);
                match self.block_distance(block, centre) {
                    far if far - away > limit => true,
                    near if near + away <= limit => false,
                    _ => load(&self.cell(place).distance) > limit,
                }
            });
            is_free.collect::<Vec<bool>>()
        });
        layers.concat()
    }

    /// The greatest distance from any point of a face to a triangle of the surface.
    #[inline]
    pub fn upper_to_triangle(&self, face: [Vector; 3], triangle: u32) -> f64 {
        let [a, b, c] = face.map(|corner| self.surface.tree.distance_to_triangle(corner, triangle));
        larger(larger(a, b), c)
    }

    /// The cells that share a side with a cell, by their indices; `None` beyond the border.
    pub fn neighbours(&self, index: usize) -> [Option<usize>; 6] {
        let [width, height, depth] = self.blocks.dimensions;
        let [x, y, z] = self.place_of(index);
        let layer = width * height;
        [
            (x > 0).then(|| index - 1),
            (x + 1 < width).then_some(index + 1),
            (y > 0).then(|| index - width),
            (y + 1 < height).then_some(index + width),
            (z > 0).then(|| index - layer),
            (z + 1 < depth).then_some(index + layer),
        ]
    }

    /// The centre of a cell by its index.
    pub fn centre_of(&self, index: usize) -> Vector {
        self.absolute(self.centre(self.place_of(index)))
    }

    fn place_of(&self, index: usize) -> Place {
        let [x, y, _] = self.blocks.dimensions;
        [index % x, index / x % y, index / (x * y)]
    }

    #[inline]
    fn place(&self, point: Vector) -> (Relative, Place) {
        let relative = (point - self.origin).as_vec3();
        let place = (relative * self.inverse_size).to_array().map(|x| x as usize);
        let place = [0, 1, 2].map(|k| place[k].min(self.blocks.dimensions[k] - 1));
        (relative, place)
    }

    #[inline]
    fn absolute(&self, relative: Relative) -> Vector {
        self.origin + relative.as_dvec3()
    }

    #[inline]
    fn centre(&self, place: Place) -> Relative {
        Vec3::from(place.map(|x| (x as f32 + 0.5) * self.size))
    }

    /// The centre of a cell's block.
    #[inline]
    fn block_centre(&self, place: Place) -> Relative {
        let size = BLOCK as f32 * self.size;
        Vec3::from(place.map(|place| ((place >> BLOCK_BITS) as f32 + 0.5) * size))
    }

    #[inline]
    fn block_of(&self, place: Place) -> &Block {
        self.blocks.block(place, Block::empty)
    }

    /// A cell, filled.
    #[inline]
    fn cell(&self, place: Place) -> &Cell {
        let block = self.block_of(place);
        let cell = &block.cells[Blocks::<Block, BLOCK>::index_in_block(place)];
        if cell.distance.load(Ordering::Acquire) == EMPTY {
            self.fill(cell, place, &block.triangle);
        }
        cell
    }

    /// Fills a cell. `hint` is a triangle that is near, and becomes the closest one.
    #[cold]
    fn fill(&self, cell: &Cell, place: Place, hint: &AtomicU32) {
        work::count(work::CELL);
        let centre = self.centre(place);
        let (mut nearest, mut distance) = (Vec3::NAN, f32::INFINITY);
        let (absolute, guess) = (self.absolute(centre), hint.load(Ordering::Relaxed));
        let tree = &self.surface.tree;
        if let Some(closest) = tree.closest_point_near(absolute, EXACT, guess) {
            nearest = self.place(closest.point).0;
            distance = centre.distance(nearest);
            cell.triangle.store(closest.triangle, Ordering::Relaxed);
            hint.store(closest.triangle, Ordering::Relaxed);
        }
        cell.nearest.iter().zip(nearest.to_array()).for_each(|(bits, x)| store(bits, x));
        cell.distance.store(distance.max(f32::MIN_POSITIVE).to_bits(), Ordering::Release);
    }

    /// The distance of a block's centre from the surface.
    #[inline]
    fn block_distance(&self, block: &Block, centre: Relative) -> f32 {
        match block.distance.load(Ordering::Relaxed) {
            EMPTY => self.fill_block(block, centre),
            bits => f32::from_bits(bits),
        }
    }

    #[cold]
    fn fill_block(&self, block: &Block, centre: Relative) -> f32 {
        work::count(work::CELL);
        let guess = block.triangle.load(Ordering::Relaxed);
        let tree = &self.surface.tree;
        let closest = tree.closest_point_near(self.absolute(centre), EXACT, guess);
        let distance = closest.map_or(f32::INFINITY, |closest| {
            block.triangle.store(closest.triangle, Ordering::Relaxed);
            closest.distance as f32
        });
        let distance = distance.max(f32::MIN_POSITIVE);
        store(&block.distance, distance);
        distance
    }

    /// See [`Block::ball`].
    #[cold]
    fn compute_ball(&self, block: &Block, centre: Relative, distance: f32) -> f32 {
        let (is_inside, radius) = if self.surface.is_closed() {
            (self.surface.side(self.absolute(centre)) == Side::Inside, distance)
        } else {
            let BlockWinding { number, slope } = self.winding_of(block, centre);
            let excess = number - OPEN_INSIDE;
            (excess > 0.0, (slope.way_within(excess.abs()) as f32).min(distance))
        };
        let ball = if is_inside { radius } else { -radius };
        store(&block.ball, ball);
        ball
    }

    /// Whether a cell's centre is inside.
    #[inline]
    fn is_inside(&self, cell: &Cell, place: Place) -> bool {
        match cell.depth.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_side(cell, place),
            bits => f32::from_bits(bits) >= 0.0,
        }
    }

    #[cold]
    fn compute_side(&self, cell: &Cell, place: Place) -> bool {
        if self.surface.is_closed() {
            return self.compute_depth(cell, place) >= 0.0;
        }
        let centre = self.absolute(self.centre(place));
        let known = self.locate(centre).winding().and_then(|winding| winding.side());
        let is_inside = known.map_or_else(
            || self.winding_at(cell, centre) > OPEN_INSIDE,
            |side| side == Side::Inside,
        );
        store(&cell.depth, if is_inside { UNKNOWN_INSIDE } else { OUTSIDE });
        is_inside
    }

    /// See [`Cell::depth`].
    #[inline]
    fn depth_of(&self, cell: &Cell, place: Place) -> f32 {
        let depth = load(&cell.depth);
        if depth.is_nan() || depth == UNKNOWN_INSIDE {
            self.compute_depth(cell, place)
        } else {
            depth
        }
    }

    #[cold]
    fn compute_depth(&self, cell: &Cell, place: Place) -> f32 {
        let distance = load(&cell.distance);
        let depth = if self.surface.is_closed() {
            let centre = self.absolute(self.centre(place));
            let is_inside = self.side_of_another(place, distance);
            let is_inside = is_inside.unwrap_or_else(|| self.surface.side(centre) == Side::Inside);
            if let Some(block) = self.blocks.known(place) {
                block
                    .sided
                    .store(Blocks::<Block, BLOCK>::index_in_block(place) as u32, Ordering::Relaxed);
            }
            if is_inside { distance } else { OUTSIDE }
        } else if self.is_inside(cell, place) {
            self.depth_in_open(cell, place) as f32
        } else {
            OUTSIDE
        };
        store(&cell.depth, depth);
        depth
    }

    /// Whether a cell is inside, if that is known for another cell and the surface does not pass
    /// between the two.
    fn side_of_another(&self, place: Place, distance: f32) -> Option<bool> {
        self.others(place).find_map(|other| {
            let cell = self.known_cell(other)?;
            let depth = load(&cell.depth);
            (!depth.is_nan() && self.is_free(place, distance, other, cell)).then_some(depth >= 0.0)
        })
    }

    /// Whether the surface crosses neither of the balls around two cells' centres that extend up to
    /// it.
    fn is_free(&self, place: Place, distance: f32, other: Place, cell: &Cell) -> bool {
        let apart = self.centre(place).distance(self.centre(other));
        distance + load(&cell.distance) > FREE * apart
    }

    /// Cells whose side may be known: the neighbours of a cell, and one of its block.
    fn others(&self, place: Place) -> impl Iterator<Item = Place> + '_ {
        (0..7).filter_map(move |side| {
            let mut other = place;
            if side == 6 {
                let index = self.blocks.known(place)?.sided.load(Ordering::Relaxed) as usize;
                if index >= CELLS {
                    return None;
                }
                let inner = [index, index >> BLOCK_BITS, index >> (2 * BLOCK_BITS)];
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

    /// A cell, if it exists and its block does.
    fn known_cell(&self, place: Place) -> Option<&Cell> {
        self.blocks.known(place)?.cells.get(Blocks::<Block, BLOCK>::index_in_block(place))
    }

    fn winding_of<'a>(&self, block: &'a Block, centre: Relative) -> &'a BlockWinding {
        block.winding.get_or_init(|| {
            let centre = self.absolute(centre);
            BlockWinding {
                number: self.surface.winding_number(centre),
                slope: self.surface.boundary.slope(centre, 0.0, f64::INFINITY),
            }
        })
    }

    /// The depth of a cell that is inside an open solid.
    fn depth_in_open(&self, cell: &Cell, place: Place) -> f64 {
        let centre = self.absolute(self.centre(place));
        let distance = f64::from(load(&cell.distance));
        let needed = LEAST_DEPTH * distance;
        if let Some(depth) = self.locate(centre).winding().and_then(|known| known.depth(distance))
            && depth >= needed
        {
            return depth;
        }
        let winding = self.winding_at(cell, centre);
        self.surface.depth_by(winding, centre, distance, needed).unwrap_or(0.0)
    }

    /// The winding number about a cell's centre, rounded down.
    fn winding_at(&self, cell: &Cell, centre: Vector) -> f64 {
        let mut winding = load(&cell.winding);
        if winding.is_nan() {
            winding = self.surface.winding_number(centre) as f32;
            store(&cell.winding, winding);
        }
        f64::from(winding) - ROUNDING
    }

    /// See [`Cell::turns`].
    #[cold]
    fn compute_turns(&self, cell: &Cell, place: Place, known: &BlockWinding) -> Option<i32> {
        let centre = self.centre(place);
        let way = f64::from(centre.distance(self.block_centre(place)));
        let change = known.slope.change(way);
        // Also where another cell has the answer: what is known must not depend on which was first.
        if change > MOST_CHANGE {
            return None;
        }
        let turns = self.turns_of_another(cell, place, known, change).unwrap_or_else(|| {
            let number = self.surface.winding_number(self.absolute(centre));
            (number - known.number).round() as i32
        });
        cell.turns.store(turns.cast_unsigned(), Ordering::Relaxed);
        if let Some(block) = self.blocks.known(place) {
            block
                .sided
                .store(Blocks::<Block, BLOCK>::index_in_block(place) as u32, Ordering::Relaxed);
        }
        Some(turns)
    }

    /// The turns of a cell by those of another, if the surface does not pass between the two.
    /// `change` is that between the block's centre and the cell.
    fn turns_of_another(
        &self,
        cell: &Cell,
        place: Place,
        known: &BlockWinding,
        change: f64,
    ) -> Option<i32> {
        let own_centre = self.block_centre(place);
        self.others(place).find_map(|other| {
            let other_cell = self.known_cell(other)?;
            let turns = match other_cell.turns.load(Ordering::Relaxed) {
                UNKNOWN => return None,
                bits => bits.cast_signed(),
            };
            if !self.is_free(place, load(&cell.distance), other, other_cell) {
                return None;
            }
            let centre = self.block_centre(other);
            if centre == own_centre {
                return Some(turns);
            }
            let other_known = self.winding_of(self.blocks.known(other)?, centre);
            let way = f64::from(self.centre(place).distance(centre));
            let difference = other_known.number + f64::from(turns) - known.number;
            (other_known.slope.change(way) + change <= MOST_CHANGE)
                .then(|| difference.round() as i32)
        })
    }
}

/// A point in its cell. See [`Grid::locate`].
pub(super) struct Location<'a> {
    grid: &'a Grid,
    cell: &'a Cell,
    place: Place,
    relative: Relative,
    /// The distance from the cell's centre.
    away: f32,
    /// At most the distance from the surface, except for [`ROUNDING`]; negative if nothing is
    /// known.
    pub lower: f64,
    /// At least that distance, except for [`ROUNDING`].
    pub upper: f64,
}

impl Location<'_> {
    /// The side of the point; `None` if it may be on another side than the cell's centre. In an
    /// open solid the side of the centre.
    #[inline]
    pub fn side(&self) -> Option<Side> {
        (self.lower > 0.0).then(|| self.side_of_cell())
    }

    #[inline]
    fn side_of_cell(&self) -> Side {
        let is_inside = self.grid.is_inside(self.cell, self.place);
        if is_inside { Side::Inside } else { Side::Outside }
    }

    /// The side of a point of a closed surface, which is `distance` away.
    #[inline]
    pub fn side_at_distance(&self, distance: f64) -> Option<Side> {
        let is_known = f64::from(self.away) < distance && self.grid.surface.is_closed();
        is_known.then(|| self.side_of_cell())
    }

    /// The side of the point in an open solid.
    pub fn side_in_open(&self, point: Vector) -> Side {
        let known = self.winding().and_then(|winding| winding.side());
        known.unwrap_or_else(|| self.grid.surface.side(point))
    }

    /// The radius of a ball around the point that is inside as a whole; `None` if the cell's centre
    /// is outside. If it is negative, the inside begins that far away at most.
    #[inline]
    pub fn depth(&self) -> Option<f64> {
        let depth = self.grid.depth_of(self.cell, self.place);
        (depth >= 0.0).then_some(f64::from(depth - self.away) - ROUNDING)
    }

    /// The same, of a point that is `distance` away from an open surface; `None` if the point is
    /// outside. Less than `needed` may be returned as 0.
    pub fn depth_at_distance(&self, point: Vector, distance: f64, needed: f64) -> Option<f64> {
        if let Some(winding) = self.winding() {
            if winding.side() == Some(Side::Outside) {
                return None;
            }
            if let Some(depth) = winding.depth(distance)
                && depth >= needed
            {
                return Some(depth);
            }
        }
        self.grid.surface.depth(point, distance, needed)
    }

    /// The distance to the plane through the closest point of the cell, normal to the
    /// direction from there to the cell's centre: the distance to a surface that is flat there.
    #[inline]
    pub fn distance_to_tangent(&self) -> f64 {
        let nearest = self.cell.nearest();
        let normal = self.grid.centre(self.place) - nearest;
        let height = (self.relative - nearest).dot(normal) / normal.length();
        if height.is_nan() { f64::INFINITY } else { f64::from(height) }
    }

    /// The triangle closest to the cell's centre; `u32::MAX` without any.
    #[inline]
    pub fn triangle(&self) -> u32 {
        self.cell.triangle.load(Ordering::Relaxed)
    }

    /// No point of a face around this one is farther than this from the surface. Once it is known
    /// to be at most `enough`, it is not refined.
    ///
    /// The distance to a point of the surface, or to one of its triangles, is a convex function:
    /// its maximum over the face is at a corner. Point and triangle are those of the cell.
    #[inline]
    pub fn upper_of_face(&self, face: [Vector; 3], enough: f64) -> f64 {
        let nearest = self.cell.nearest();
        if nearest[0].is_nan() {
            return f64::INFINITY;
        }
        let nearest = self.grid.absolute(nearest);
        let [a, b, c] = face.map(|corner| corner.distance_squared(nearest));
        let to_point = larger(larger(a, b), c).sqrt() + ROUNDING;
        if to_point <= enough {
            return to_point;
        }
        smaller(self.grid.upper_to_triangle(face, self.triangle()), to_point)
    }

    /// Bounds on the winding number of an open surface, by the cell and its block.
    fn winding(&self) -> Option<Winding> {
        let Self { grid, cell, place, relative, .. } = *self;
        if self.away >= load(&cell.distance) {
            return None;
        }
        let centre = grid.block_centre(place);
        let known = grid.winding_of(grid.block_of(place), centre);
        let way = f64::from(relative.distance(centre));
        let change = known.slope.change(way);
        if change.is_infinite() {
            return None;
        }
        let turns = match cell.turns.load(Ordering::Relaxed) {
            UNKNOWN => grid.compute_turns(cell, place, known)?,
            bits => bits.cast_signed(),
        };
        let number = known.number + f64::from(turns);
        let slope = known.slope.at_distance(way);
        Some(Winding { least: number - change, most: number + change, slope })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Bvh;
    use crate::geometry::vector::into_vectors;
    use crate::mesh::shapes::{cuboid, join, turn};
    use crate::solid::Boundary;

    /// Two boxes without lids, one turned and through the wall of the other.
    fn open_boxes() -> (Vec<Vector>, Vec<[u32; 3]>) {
        let without_lid = |low, high| {
            let mut mesh = cuboid(low, high);
            mesh.triangles.drain(..2);
            mesh
        };
        let small = turn(without_lid([-0.3, -0.2, -0.1], [0.5, 0.2, 0.1]));
        let mesh = join(&[without_lid([-0.4, -0.3, -0.2], [0.4, 0.3, 0.2]), small]);
        (into_vectors(mesh.positions), mesh.triangles)
    }

    /// Evenly spread over the boxes and around them.
    fn spread(number: u32) -> Vector {
        Vector::from_array(
            [0.819_173, 0.671_044, 0.549_700]
                .map(|step: f64| 1.2 * (0.5 + step * f64::from(number)).fract() - 0.6),
        )
    }

    fn surface() -> (Vec<Vector>, Surface) {
        let (positions, triangles) = open_boxes();
        let boundary = Boundary::new(&positions, &triangles);
        let surface = Surface { tree: Bvh::new(&positions, &triangles), boundary };
        (positions, surface)
    }

    fn depths(numbers: impl Iterator<Item = u32>) -> Vec<(u32, Option<f64>)> {
        let (positions, surface) = surface();
        let grid = Grid::new(surface.into(), &positions, 0.02);
        let mut depths: Vec<(u32, Option<f64>)> = numbers
            .map(|number| {
                let point = spread(number);
                let closest = grid.surface.tree.closest_point(point, f64::INFINITY).unwrap();
                // Fit tests need the sides of cells as well.
                let _ = grid.locate(point).side();
                (number, grid.locate(point).depth_at_distance(point, closest.distance, 0.0))
            })
            .collect();
        depths.sort_by_key(|&(number, _)| number);
        depths
    }

    #[test]
    fn within_its_depth_by_a_block_every_point_is_inside() {
        let (_, surface) = surface();
        let (mut inside, mut outside) = (0, 0);
        for (number, depth) in depths(0..3000) {
            let point = spread(number);
            let Some(depth) = depth else {
                outside += 1;
                assert!(surface.winding_number(point) < OPEN_INSIDE + 1e-5, "{point:?}");
                continue;
            };
            inside += 1;
            for k in 0..10 {
                let way = spread(17 * k + number);
                let there = point + way * (0.999 * depth / way.length());
                let number_there = surface.winding_number(there);
                assert!(number_there > OPEN_INSIDE - 1e-5, "{point:?}: {number_there}");
            }
        }
        assert!(inside > 100 && outside > 100, "{inside} {outside}");
    }

    #[test]
    fn what_is_known_of_a_block_does_not_depend_on_which_cell_was_first() {
        assert_eq!(depths(0..3000), depths((0..3000).rev()));
    }
}
