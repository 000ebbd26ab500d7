//! Sides of a closed surface: each connected region of cells that the surface does not touch is
//! flooded from one cell, whose winding number is computed. O(cells).

use std::sync::atomic::AtomicU8;

use super::distance_field::{CELLS_PER_CHECK, DistanceField, MAX_EXCESS};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, dot, length_squared, subtract};

/// Side of a cell.
pub(super) const UNKNOWN: u8 = 0;
pub(super) const INSIDE: u8 = 1;
pub(super) const OUTSIDE: u8 = 2;

/// The surface does not separate a cell farther than this from it, in cells, from its neighbours:
/// half a cell, and a margin for the usual excess of distances.
pub(super) const FREE: f32 = 0.8;

/// The same for the largest excess of distances.
const CERTAINLY_FREE: f32 = 0.5 + MAX_EXCESS as f32;

/// If the direction to a point makes an angle of at least this cosine with the normal of its
/// closest triangle, the point is on that side of the triangle, unless another one is closer.
const MIN_COSINE: f64 = 0.99;

/// Cells of a region that seem to be on the other side and are verified by a winding number. Where
/// triangles are oriented at random, every cell would be.
const MAX_DOUBTS: usize = 1000;

/// The side of each cell. Of cells near the surface it is unknown.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn sides(
    field: &DistanceField,
    bvh: &Bvh,
    mesh: (&[Vector], &[[u32; 3]]),
    control: &Control,
) -> Result<Vec<AtomicU8>, Error> {
    // Where distances are too large, a region may leak through the surface.
    let (mut sides, is_consistent) = sides_beyond(FREE, field, bvh, mesh, control)?;
    if !is_consistent {
        (sides, _) = sides_beyond(CERTAINLY_FREE, field, bvh, mesh, control)?;
    }
    Ok(sides.into_iter().map(AtomicU8::new).collect())
}

/// The same by flooding cells farther than `free` from the surface, and whether every region is on
/// one side. Stops at the first region that is not.
fn sides_beyond(
    free: f32,
    field: &DistanceField,
    bvh: &Bvh,
    mesh: (&[Vector], &[[u32; 3]]),
    control: &Control,
) -> Result<(Vec<u8>, bool), Error> {
    let size = field.lattice.size;
    let is_free = |index: usize| field.cells[index].distance > free * size;
    let mut sides = vec![UNKNOWN; field.cells.len()];
    let mut stack: Vec<u32> = Vec::new();
    let mut flooded = 0_usize;
    for start in 0..sides.len() {
        if sides[start] != UNKNOWN || !is_free(start) {
            continue;
        }
        bvh.expect_winding_numbers(control)?;
        let inside = bvh.is_inside(centre(field, start));
        let side = if inside { INSIDE } else { OUTSIDE };
        sides[start] = side;
        stack.push(start as u32);
        control.check()?;
        let mut doubts = 0;
        while let Some(index) = stack.pop() {
            let index = index as usize;
            flooded += 1;
            if flooded.is_multiple_of(CELLS_PER_CHECK) {
                control.check()?;
            }
            let is_close = field.cells[index].distance <= CERTAINLY_FREE * size;
            if is_close && doubts < MAX_DOUBTS && is_behind(field, index, mesh) == Some(!inside) {
                doubts += 1;
                if bvh.is_inside(centre(field, index)) != inside {
                    return Ok((sides, false));
                }
            }
            for neighbour in field.lattice.neighbours(index).into_iter().flatten() {
                if sides[neighbour] == UNKNOWN && is_free(neighbour) {
                    sides[neighbour] = side;
                    stack.push(neighbour as u32);
                }
            }
        }
    }
    Ok((sides, true))
}

fn centre(field: &DistanceField, index: usize) -> Vector {
    let lattice = &field.lattice;
    lattice.absolute(lattice.centre(lattice.cell(index)))
}

/// Whether the centre of a cell is behind its closest triangle; `None` where it is beside it.
fn is_behind(
    field: &DistanceField,
    index: usize,
    (positions, triangles): (&[Vector], &[[u32; 3]]),
) -> Option<bool> {
    let triangle = triangles.get(field.triangles[index] as usize)?;
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let nearest = field.lattice.absolute(field.cells[index].nearest);
    let away = subtract(centre(field, index), nearest);
    let normal = area_normal(a, b, c);
    let product = dot(normal, away);
    let least = MIN_COSINE * (length_squared(normal) * length_squared(away)).sqrt();
    (product.abs() > least).then_some(product < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::cuboid;

    /// A box tapered to an edge, rotated.
    fn knife(turn: f64) -> TriangleMesh {
        let mut mesh = cuboid([-0.4, -0.1, -0.25], [0.4, 0.1, 0.25]);
        for point in &mut mesh.positions {
            let [x, mut y, z] = *point;
            if x > 0.0 {
                y *= 0.05;
            }
            let (sin, cos) = turn.sin_cos();
            let [x, y] = [cos * x - sin * y, sin * x + cos * y];
            let (sin, cos) = (1.7 * turn).sin_cos();
            *point = [cos * x - sin * z, y, sin * x + cos * z];
        }
        mesh
    }

    #[test]
    fn no_region_leaks_through_the_surface() {
        for turn in 15..25 {
            let mesh = knife(0.1 * f64::from(turn));
            let control = Control::new();
            let (positions, triangles) = (&mesh.positions, &mesh.triangles);
            let bvh = Bvh::new(positions, triangles);
            for bound in [0.01, 0.02] {
                let field = DistanceField::new(positions, triangles, bound, &control).unwrap();
                let sides = sides(&field, &bvh, (positions, triangles), &control).unwrap();
                let mut wrong = 0;
                for (index, side) in sides.into_iter().map(AtomicU8::into_inner).enumerate() {
                    // Leaks begin near the surface.
                    if field.cells[index].distance > 2.0 * field.lattice.size {
                        continue;
                    }
                    let inside = bvh.is_inside(centre(&field, index));
                    wrong += usize::from(side != UNKNOWN && (side == INSIDE) != inside);
                }
                assert_eq!(wrong, 0, "turn {turn}, bound {bound}");
            }
        }
    }
}
