//! A grid whose cells are all filled in advance: what dense meshes ask so often that it pays.
//!
//! Distances may be too large by a fraction of a cell, never too small. Cells beyond a band around
//! the surface only know that they are. Where the mesh is open, sides are computed on demand, by
//! one winding number per cell.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use super::distance_field::{Cell, DistanceField, MAX_EXCESS};
use super::flood::{self, FREE, INSIDE, OUTSIDE, UNKNOWN};
use super::vector_f32::{dot, length, subtract};
use super::{CellClass, HALF_DIAGONAL, Probe};
use crate::bounded::containment::boundary::Boundary;
use crate::bounded::containment::inside::{inside_reach, is_inside};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;

/// The grid. See the file's head.
pub(in crate::bounded::containment) struct FilledGrid {
    field: DistanceField,
    sides: Vec<AtomicU8>,
    classes: Vec<CellClass>,
    boundary: Arc<Boundary>,
}

impl FilledGrid {
    /// # Errors
    /// [`Error::Cancelled`].
    pub(in crate::bounded::containment) fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        boundary: Arc<Boundary>,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let field = DistanceField::new(positions, triangles, bound, control)?;
        let mut sides = Vec::new();
        sides.resize_with(field.cells.len(), || AtomicU8::new(UNKNOWN));
        Ok(Self { field, sides, classes: Vec::new(), boundary })
    }

    /// Determines the sides of a closed surface.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(in crate::bounded::containment) fn flood(
        &mut self,
        bvh: &Bvh,
        mesh: (&[Vector], &[[u32; 3]]),
        control: &Control,
    ) -> Result<(), Error> {
        self.sides = flood::sides(&self.field, bvh, mesh, control)?;
        Ok(())
    }

    /// Classifies cells: near as a whole, at most `near` from the solid, or far, more than `far`.
    /// Call it after flooding.
    pub(in crate::bounded::containment) fn classify_cells(&mut self, near: f64, far: f64) {
        let half = HALF_DIAGONAL * f64::from(self.field.lattice.size);
        let is_flooded = self.boundary.is_empty();
        let class = |(cell, side): (&Cell, &mut AtomicU8)| {
            let distance = f64::from(cell.distance);
            match *side.get_mut() {
                _ if distance + half <= near => CellClass::Near,
                INSIDE if is_flooded && distance > half => CellClass::Near,
                OUTSIDE if is_flooded && distance - half > far => CellClass::Far,
                _ => CellClass::Mixed,
            }
        };
        self.classes = self.field.cells.iter().zip(&mut self.sides).map(class).collect();
    }

    #[inline]
    fn index_at(&self, point: Vector) -> usize {
        let lattice = &self.field.lattice;
        lattice.index(lattice.cell_at(lattice.relative(point)))
    }

    /// The class of a point's cell.
    #[inline]
    pub(in crate::bounded::containment) fn class_of(&self, point: Vector) -> CellClass {
        self.classes[self.index_at(point)]
    }

    /// The number of cells.
    pub(in crate::bounded::containment) fn count(&self) -> usize {
        self.field.cells.len()
    }

    pub(in crate::bounded::containment) fn centre(&self, index: usize) -> Vector {
        let lattice = &self.field.lattice;
        lattice.absolute(lattice.centre(lattice.cell(index)))
    }

    /// The distance from a cell's centre to the surface, at most the band's width.
    pub(in crate::bounded::containment) fn distance(&self, index: usize) -> f32 {
        self.field.cells[index].distance
    }

    /// Whether a cell is so far from the surface that paths through such cells do not cross it.
    pub(in crate::bounded::containment) fn is_free(&self, index: usize, bound: f64) -> bool {
        self.field.cells[index].distance > (bound as f32).max(FREE * self.field.lattice.size)
    }

    /// The cells that share a side with a cell; `None` beyond the border.
    pub(in crate::bounded::containment) fn neighbours(&self, index: usize) -> [Option<usize>; 6] {
        self.field.lattice.neighbours(index)
    }

    /// What the grid knows about a point.
    #[inline]
    pub(in crate::bounded::containment) fn probe(&self, point: Vector) -> Probe {
        let lattice = &self.field.lattice;
        let relative = lattice.relative(point);
        let cell = lattice.cell_at(relative);
        let index = lattice.index(cell);
        let content = &self.field.cells[index];
        let away = length(subtract(relative, lattice.centre(cell)));
        let upper = length(subtract(relative, content.nearest));
        Probe {
            upper: if upper.is_nan() { f64::INFINITY } else { f64::from(upper) },
            lower: f64::from(content.distance - away),
            index,
            place: cell,
        }
    }

    /// The distance to the plane through the closest point of a point's cell, normal to the
    /// direction from there to the cell's centre: the distance to a surface that is flat there.
    /// Infinite beyond the band.
    #[inline]
    pub(in crate::bounded::containment) fn distance_to_tangent(&self, point: Vector) -> f64 {
        let lattice = &self.field.lattice;
        let relative = lattice.relative(point);
        let cell = lattice.cell_at(relative);
        let nearest = self.field.cells[lattice.index(cell)].nearest;
        let normal = subtract(lattice.centre(cell), nearest);
        let height = dot(subtract(relative, nearest), normal) / length(normal);
        if height.is_nan() { f64::INFINITY } else { f64::from(height) }
    }

    /// The point of the surface closest to the centre of a point's cell; `None` beyond the band.
    #[inline]
    pub(in crate::bounded::containment) fn nearest_point(&self, point: Vector) -> Option<Vector> {
        let nearest = self.field.cells[self.index_at(point)].nearest;
        (!nearest[0].is_nan()).then(|| self.field.lattice.absolute(nearest))
    }

    /// The triangle closest to the centre of a point's cell; `u32::MAX` beyond the band.
    #[inline]
    pub(in crate::bounded::containment) fn nearest_triangle(&self, point: Vector) -> u32 {
        self.field.triangles[self.index_at(point)]
    }

    /// Whether the probe's point is inside; `None` if it may be on another side than its cell's
    /// centre.
    #[inline]
    pub(in crate::bounded::containment) fn is_inside(
        &self,
        probe: &Probe,
        bvh: &Bvh,
    ) -> Option<bool> {
        if probe.lower <= 0.0 {
            return None;
        }
        match self.sides[probe.index].load(Ordering::Relaxed) {
            INSIDE => Some(true),
            OUTSIDE => Some(false),
            _ => Some(self.compute_side(probe.index, bvh)),
        }
    }

    /// A lower bound on the depth of a point inside a closed surface; `None` if it may be outside.
    #[inline]
    pub(in crate::bounded::containment) fn depth(&self, point: Vector) -> Option<f64> {
        let probe = self.probe(point);
        let depth = probe.lower - MAX_EXCESS * f64::from(self.field.lattice.size);
        let is_inside = depth > 0.0
            && self.boundary.is_empty()
            && self.sides[probe.index].load(Ordering::Relaxed) == INSIDE;
        is_inside.then_some(depth)
    }

    /// Whether a point at `distance` from a closed surface is inside, if its cell tells. Where a
    /// surface is open, the inside may end without crossing it.
    #[inline]
    pub(in crate::bounded::containment) fn side(
        &self,
        point: Vector,
        distance: f64,
    ) -> Option<bool> {
        let lattice = &self.field.lattice;
        let relative = lattice.relative(point);
        let cell = lattice.cell_at(relative);
        let away = length(subtract(relative, lattice.centre(cell)));
        if f64::from(away) >= distance || !self.boundary.is_empty() {
            return None;
        }
        match self.sides[lattice.index(cell)].load(Ordering::Relaxed) {
            INSIDE => Some(true),
            OUTSIDE => Some(false),
            _ => None,
        }
    }

    /// See [`inside_reach`].
    pub(in crate::bounded::containment) fn inside_reach(
        &self,
        point: Vector,
        distance: f64,
        needed: f64,
        bvh: &Bvh,
    ) -> Option<f64> {
        inside_reach(bvh, &self.boundary, point, distance, needed)
    }

    #[cold]
    fn compute_side(&self, index: usize, bvh: &Bvh) -> bool {
        let inside = is_inside(bvh, &self.boundary, self.centre(index));
        self.sides[index].store(if inside { INSIDE } else { OUTSIDE }, Ordering::Relaxed);
        inside
    }
}
