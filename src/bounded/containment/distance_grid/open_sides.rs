//! Sides in an open solid, of which a lazy grid knows many from few winding numbers.
//!
//! Where the surface is not crossed, the winding number changes only slowly, since only the
//! boundary changes it; across the surface it changes by whole turns. So one number for a block, and the turns
//! between its centre and a cell, which neighbours tell each other, bound the number at any point of the block.
//! The number of turns is exact. So what is found does not depend on which cell was asked first.

use std::sync::atomic::Ordering;

use super::blocks::{self, Block, BlockWinding, Cell, UNKNOWN};
use super::lazy::{LazyGrid, ROUNDING};
use super::vector_f32::{length, subtract};
use crate::bounded::containment::inside::{self, OPEN_INSIDE, Winding, winding_number};
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// A number of turns is known from a number that is less than half a turn away, with a margin for rounding and the
/// expansion's error.
const MOST_CHANGE: f64 = 0.45;

impl LazyGrid {
    pub(super) fn winding_of<'a>(
        &self,
        block: &'a Block,
        centre: [f32; 3],
        bvh: &Bvh,
    ) -> &'a BlockWinding {
        block.winding.get_or_init(|| {
            let centre = self.lattice.absolute(centre);
            BlockWinding {
                number: winding_number(bvh, &self.boundary, centre),
                slope: self.boundary.slope(centre, 0.0, f64::INFINITY),
            }
        })
    }

    /// Whether a cell's centre is inside.
    pub(super) fn is_inside_open(&self, cell: &Cell, place: [usize; 3], bvh: &Bvh) -> bool {
        let centre = self.lattice.absolute(self.lattice.centre(place));
        match self.winding(centre, bvh) {
            Some(winding) if winding.least > OPEN_INSIDE => true,
            Some(winding) if winding.most <= OPEN_INSIDE => false,
            _ => self.number(cell, centre, bvh) > OPEN_INSIDE,
        }
    }

    /// All points nearer than this to the centre of a cell that is inside are. With `needed`, less than that may be
    /// returned as 0.
    pub(super) fn reach_in_open(
        &self,
        cell: &Cell,
        place: [usize; 3],
        needed: f64,
        bvh: &Bvh,
    ) -> f64 {
        let centre = self.lattice.absolute(self.lattice.centre(place));
        let distance = f64::from(cell.distance());
        if let Some(reach) = self.winding(centre, bvh).and_then(|known| known.reach(distance))
            && reach >= needed
        {
            return reach;
        }
        let number = self.number(cell, centre, bvh);
        inside::reach(&self.boundary, number, centre, distance, needed).unwrap_or(0.0)
    }

    /// The winding number about a cell's centre, rounded down.
    fn number(&self, cell: &Cell, centre: Vector, bvh: &Bvh) -> f64 {
        let bits = match cell.number.load(Ordering::Relaxed) {
            UNKNOWN => {
                let number = winding_number(bvh, &self.boundary, centre) as f32;
                cell.number.store(number.to_bits(), Ordering::Relaxed);
                number.to_bits()
            }
            bits => bits,
        };
        f64::from(f32::from_bits(bits)) - ROUNDING
    }

    /// See [`inside::inside_reach`].
    pub(in crate::bounded::containment) fn inside_reach(
        &self,
        point: Vector,
        distance: f64,
        needed: f64,
        bvh: &Bvh,
    ) -> Option<f64> {
        if let Some(winding) = self.winding(point, bvh) {
            if winding.most <= OPEN_INSIDE {
                return None;
            }
            if let Some(reach) = winding.reach(distance)
                && reach >= needed
            {
                return Some(reach);
            }
        }
        inside::inside_reach(bvh, &self.boundary, point, distance, needed)
    }

    /// What the point's cell and its block know of the winding number.
    fn winding(&self, point: Vector, bvh: &Bvh) -> Option<Winding> {
        let (relative, place) = self.place(point);
        let cell = self.cell(place, bvh);
        let block = self.block_of(place);
        if length(subtract(relative, self.lattice.centre(place))) >= cell.distance() {
            return None;
        }
        let centre = self.block_centre(place);
        let known = self.winding_of(block, centre, bvh);
        let way = f64::from(length(subtract(relative, centre)));
        let change = known.slope.change(way);
        if change.is_infinite() {
            return None;
        }
        let turns = match cell.turns.load(Ordering::Relaxed) {
            UNKNOWN => self.compute_turns(cell, place, known, bvh)?,
            bits => bits.cast_signed(),
        };
        let number = known.number + f64::from(turns);
        Some(Winding {
            least: number - change,
            most: number + change,
            slope: known.slope.at_distance(way),
        })
    }

    /// See [`Cell::turns`].
    #[cold]
    fn compute_turns(
        &self,
        cell: &Cell,
        place: [usize; 3],
        known: &BlockWinding,
        bvh: &Bvh,
    ) -> Option<i32> {
        let centre = self.lattice.centre(place);
        let way = f64::from(length(subtract(centre, self.block_centre(place))));
        let change = known.slope.change(way);
        // Not only where no other cell tells: what is known may not depend on which was asked first.
        if change > MOST_CHANGE {
            return None;
        }
        let turns = self.turns_by_another(cell, place, (known, change), bvh).unwrap_or_else(|| {
            let number = winding_number(bvh, &self.boundary, self.lattice.absolute(centre));
            (number - known.number).round() as i32
        });
        cell.turns.store(turns.cast_unsigned(), Ordering::Relaxed);
        if let Some(block) = self.block(place) {
            block.sided.store(blocks::number(place) as u32, Ordering::Relaxed);
        }
        Some(turns)
    }

    /// The turns of a cell by those of another, if the surface does not pass between the two. `change` is that
    /// between the block's centre and the cell.
    fn turns_by_another(
        &self,
        cell: &Cell,
        place: [usize; 3],
        (known, change): (&BlockWinding, f64),
        bvh: &Bvh,
    ) -> Option<i32> {
        let own_centre = self.block_centre(place);
        self.others(place).find_map(|other| {
            let other_cell = self.known_cell(other)?;
            let turns = match other_cell.turns.load(Ordering::Relaxed) {
                UNKNOWN => return None,
                bits => bits.cast_signed(),
            };
            if !self.is_free(place, cell.distance(), other, other_cell) {
                return None;
            }
            let centre = self.block_centre(other);
            if centre == own_centre {
                return Some(turns);
            }
            let other_known = self.winding_of(self.block(other)?, centre, bvh);
            let way = f64::from(length(subtract(self.lattice.centre(place), centre)));
            let difference = other_known.number + f64::from(turns) - known.number;
            (other_known.slope.change(way) + change <= MOST_CHANGE)
                .then(|| difference.round() as i32)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::bounded::containment::boundary::Boundary;
    use crate::geometry::vector::{add, length, scale};
    use crate::mesh::shapes::{cuboid, join, turn};

    /// Two boxes without lids, one turned and through the wall of the other.
    fn open_boxes() -> (Vec<Vector>, Vec<[u32; 3]>) {
        let without_lid = |low, high| {
            let mut mesh = cuboid(low, high);
            mesh.triangles.drain(..2);
            mesh
        };
        let small = turn(without_lid([-0.3, -0.2, -0.1], [0.5, 0.2, 0.1]));
        let mesh = join(&[without_lid([-0.4, -0.3, -0.2], [0.4, 0.3, 0.2]), small]);
        (mesh.positions, mesh.triangles)
    }

    /// Evenly spread over the boxes and around them.
    fn spread(number: u32) -> Vector {
        [0.819_173, 0.671_044, 0.549_700]
            .map(|step: f64| 1.2 * (0.5 + step * f64::from(number)).fract() - 0.6)
    }

    fn reaches(numbers: impl Iterator<Item = u32>) -> Vec<(u32, Option<f64>)> {
        let (positions, triangles) = open_boxes();
        let bvh = Bvh::new(&positions, &triangles);
        let boundary = Arc::new(Boundary::new(&positions, &triangles));
        let grid = LazyGrid::new(&positions, 0.02, boundary, 0.018, 0.03);
        let mut reaches: Vec<(u32, Option<f64>)> = numbers
            .map(|number| {
                let point = spread(number);
                let distance = bvh.closest_point(point, f64::INFINITY).unwrap().distance;
                // Cells are asked for their sides as well, as by fit tests.
                grid.class_of(point, &bvh);
                (number, grid.inside_reach(point, distance, 0.0, &bvh))
            })
            .collect();
        reaches.sort_by_key(|&(number, _)| number);
        reaches
    }

    #[test]
    fn within_its_reach_by_a_block_every_point_is_inside() {
        let (positions, triangles) = open_boxes();
        let bvh = Bvh::new(&positions, &triangles);
        let boundary = Boundary::new(&positions, &triangles);
        let (mut inside, mut outside) = (0, 0);
        for (number, reach) in reaches(0..3000) {
            let point = spread(number);
            let Some(reach) = reach else {
                outside += 1;
                assert!(winding_number(&bvh, &boundary, point) < OPEN_INSIDE + 1e-5, "{point:?}");
                continue;
            };
            inside += 1;
            for k in 0..10 {
                let way = spread(17 * k + number);
                let there = add(point, scale(way, 0.999 * reach / length(way)));
                let number_there = winding_number(&bvh, &boundary, there);
                assert!(number_there > OPEN_INSIDE - 1e-5, "{point:?}: {number_there}");
            }
        }
        assert!(inside > 100 && outside > 100, "{inside} {outside}");
    }

    #[test]
    fn what_a_block_knows_does_not_depend_on_what_was_asked_first() {
        assert_eq!(reaches(0..3000), reaches((0..3000).rev()));
    }
}
