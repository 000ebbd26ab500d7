//! The surface of what no ball reaches, where it is off the mesh: for display, and no part of what
//! is promised.
//!
//! Points are filled that are at least the radius away from all centres. Samples of that distance
//! on a grid become triangles by surface nets (Gibson, "Constrained elastic surface nets", 1998;
//! `fast-surface-nets`). On the mesh the surface of what is filled is the mesh's own, and is left
//! out. O(samples), each with some queries of the tree.

use fast_surface_nets::ndshape::RuntimeShape;
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

use super::clearance::Probe;
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::TriangleMesh;
use crate::geometry::blocks::size_for;
use crate::geometry::vector::Vector;
use crate::parallel;

/// Cells along the radius: what balls roll over is round to the eye.
const CELLS_PER_RADIUS: f64 = 6.0;

/// The side of a cell as a fraction of the diagonal, at most: a ball of any size shows the mesh's
/// shape.
const LARGEST_CELL: f64 = 0.0125;

/// Samples at most. Where they are not enough, cells are larger. They take a second or two on one
/// thread.
const MAX_SAMPLES: f64 = 200_000.0;

/// Cells beyond the mesh's box on each side: nothing outside it is filled.
const MARGIN: f64 = 2.0;

/// What is nearer to the mesh than this many cells is on it: more than a net over a flat face is
/// off.
const ON_MESH: f64 = 0.5;

/// Half the side of the smallest parts of space that are resolved, in cells: their planes
/// are off by 0.02 cells.
const LEAST_HALF: f64 = 0.25;

/// What samples may be off, in cells.
const TOLERANCE: f64 = 0.1;

/// The surface of what a probe does not reach outside a solid: see
/// [`MeasuredMesh::filled`](crate::measure::MeasuredMesh::filled).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct FilledSurface {
    /// Its triangles, counter-clockwise seen from where balls are. Open where it meets the mesh;
    /// empty where nothing is filled.
    pub mesh: TriangleMesh,
    /// The side of a cell of the grid. The surface is off by about a quarter of that. What is
    /// filled less than half a cell high, or is narrower than a cell, is missing.
    pub cell: f64,
}

/// What no ball reaches around the surface in `tree`. Lengths are fractions of the diagonal.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn filled(probe: &Probe, tree: &Bvh, control: &Control) -> Result<FilledSurface, Error> {
    let (min, max) = probe.bounds;
    let count = |cell: f64| ((max - min) / cell).ceil() + Vector::splat(2.0 * MARGIN + 1.0);
    let finest = LARGEST_CELL.min(probe.radius / CELLS_PER_RADIUS);
    let cell = size_for(finest, MAX_SAMPLES, count);
    let origin = (min + max - (count(cell) - 1.0) * cell) * 0.5;
    let [width, height, depth] = count(cell).to_array().map(|count| count as u32);
    let probe = probe.coarser(LEAST_HALF * cell);
    let rows = parallel::map_indices((height * depth) as usize, |row| {
        control.check()?;
        let (y, z) = (row as u32 % height, row as u32 / height);
        let sample = |x: u32| {
            let place = Vector::new(f64::from(x), f64::from(y), f64::from(z));
            // Surface nets cross zero from inside, where values are negative.
            -probe.beyond_reach(tree, origin + place * cell, cell, TOLERANCE * cell) as f32
        };
        Ok((0..width).map(sample).collect::<Vec<f32>>())
    });
    let samples = rows.into_iter().collect::<Result<Vec<_>, Error>>()?.concat();
    let mut net = SurfaceNetsBuffer::default();
    let shape = RuntimeShape::<u32, 3>::new([width, height, depth]);
    surface_nets(&samples, &shape, [0; 3], [width, height, depth].map(|count| count - 1), &mut net);
    control.check()?;
    Ok(FilledSurface { mesh: off_the_mesh(&net, tree, origin, cell), cell })
}

/// The triangles that are somewhere off the surface. Their corners on it are moved there exactly.
fn off_the_mesh(net: &SurfaceNetsBuffer, tree: &Bvh, origin: Vector, cell: f64) -> TriangleMesh {
    let points = parallel::map(&net.positions, |&position| {
        let point = origin + Vector::from(position.map(f64::from)) * cell;
        // At edges and corners the net runs through the solid.
        let is_on = |distance: f64| distance < ON_MESH * cell || tree.is_inside(point);
        match tree.closest_point(point, f64::INFINITY) {
            Some(closest) if is_on(closest.distance) => (closest.point, false),
            _ => (point, true),
        }
    });
    let mut numbers = vec![None; points.len()];
    let mut mesh = TriangleMesh::default();
    let (triangles, _) = net.indices.as_chunks::<3>();
    for triangle in triangles {
        let corners = triangle.map(|corner| points.get(corner as usize).copied());
        if !corners.iter().flatten().any(|&(_, is_off)| is_off) {
            continue;
        }
        let mut number = |k: usize| {
            let (point, _) = corners[k]?;
            let number = numbers.get_mut(triangle[k] as usize)?;
            Some(*number.get_or_insert_with(|| {
                mesh.positions.push(point.to_array());
                mesh.positions.len() as u32 - 1
            }))
        };
        if let (Some(a), Some(b), Some(c)) = (number(0), number(1), number(2)) {
            mesh.triangles.push([a, b, c]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::MeshView;
    use crate::measure::MeasuredMesh;
    use crate::mesh::shapes::{cuboid, join};
    use crate::parameters::{Length, Parameters};

    fn filled_at(mesh: &TriangleMesh, radius: Option<f64>) -> Option<FilledSurface> {
        let parameters = Parameters::default().with_probe_radius(radius.map(Length::units));
        let control = Control::new();
        let mesh = MeasuredMesh::new(MeshView::from(mesh), &parameters, &control).unwrap();
        mesh.filled(&control).unwrap()
    }

    /// A floor and four walls around a shaft of 0.4 by 0.4 that is 0.6 deep; its rim is at a height
    /// of 0.
    fn cup() -> TriangleMesh {
        join(&[
            cuboid([-0.3, -0.3, -0.7], [0.3, 0.3, -0.6]),
            cuboid([-0.3, -0.3, -0.65], [-0.2, 0.3, 0.0]),
            cuboid([0.2, -0.3, -0.65], [0.3, 0.3, 0.0]),
            cuboid([-0.25, -0.3, -0.65], [0.25, -0.2, 0.0]),
            cuboid([-0.25, 0.2, -0.65], [0.25, 0.3, 0.0]),
        ])
    }

    #[test]
    fn a_cup_whose_mouth_is_thinner_than_the_ball_has_a_lid_where_the_ball_rests_on_its_rim() {
        let radius = 0.3;
        let found = filled_at(&cup(), Some(radius)).unwrap();
        // Over the walls the ball rests on the edges of the shaft, 0.2 away from its axis.
        let sunk = radius - (radius * radius - 0.2 * 0.2_f64).sqrt();
        let lowest = found.mesh.positions.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        assert!((lowest + sunk).abs() < 0.5 * found.cell, "{lowest}, {sunk}, {}", found.cell);
        for &[x, y, z] in &found.mesh.positions {
            assert!(x.abs().max(y.abs()) < 0.2 + 2.0 * found.cell, "{x}, {y}, {z}");
            assert!(z < 0.5 * found.cell, "{z}");
        }
        // It hides the shaft, and is little larger.
        let lid = found.mesh.area();
        assert!((0.9 * 0.16..1.5 * 0.16).contains(&lid), "{lid}");
        // Towards the ball.
        for triangle in &found.mesh.triangles {
            let [a, b, c] =
                triangle.map(|vertex| Vector::from(found.mesh.positions[vertex as usize]));
            assert!((b - a).cross(c - a).z > -1e-6);
        }
    }

    #[test]
    fn in_a_cup_with_a_wider_mouth_only_its_corners_are_rounded() {
        let radius = 0.12;
        let found = filled_at(&cup(), Some(radius)).unwrap();
        let centre = |p: &[f64; 3]| p[0].abs().max(p[1].abs()) < 0.2 - radius;
        assert!(!found.mesh.triangles.is_empty());
        assert!(!found.mesh.positions.iter().any(|p| centre(p) && p[2] > -0.6 + found.cell));
    }

    #[test]
    fn a_convex_box_has_nothing() {
        for radius in [0.05, 0.2, 20.0] {
            let found = filled_at(&cuboid([0.0; 3], [1.0, 2.0, 0.5]), Some(radius)).unwrap();
            assert_eq!((found.mesh.triangles.len(), found.mesh.positions.len()), (0, 0));
        }
    }

    #[test]
    fn the_gaps_of_a_comb_are_covered_as_deep_as_a_ball_sinks_in() {
        let tooth = |k: f64| cuboid([0.2 * k, 0.0, 0.0], [0.2 * k + 0.1, 0.3, 0.8]);
        let teeth: Vec<_> = (0..5).map(|k| tooth(f64::from(k))).collect();
        let mesh = join(&[&teeth[..], &[cuboid([0.0, 0.0, -0.1], [0.9, 0.3, 0.05])]].concat());
        let found = filled_at(&mesh, Some(0.1)).unwrap();
        let sunk = 0.1 - (0.01 - 0.05 * 0.05_f64).sqrt();
        for k in 0..4 {
            let middle = 0.2 * f64::from(k) + 0.15;
            let tops = found.mesh.positions.iter().filter(|p| {
                (p[0] - middle).abs() < found.cell && (p[1] - 0.15).abs() < 0.05 && p[2] > 0.4
            });
            let heights: Vec<f64> = tops.map(|p| p[2]).collect();
            assert!(!heights.is_empty(), "gap {k}");
            let is_covered = |z: &f64| (z - (0.8 - sunk)).abs() < found.cell;
            assert!(heights.iter().all(is_covered), "gap {k}: {heights:?}");
        }
    }

    #[test]
    fn without_a_probe_there_is_no_surface() {
        assert_eq!(filled_at(&cup(), None), None);
    }

    #[test]
    fn a_small_ball_in_a_large_mesh_gets_a_coarser_grid_and_any_scale_the_same_surface() {
        let found = filled_at(&cup(), Some(0.001)).unwrap();
        assert!(found.cell > 0.002 && found.cell < 0.02, "{}", found.cell);
        let mut large = cup();
        large.positions.iter_mut().flatten().for_each(|x| *x *= 1024.0);
        let [small, large] = [(cup(), 0.3), (large, 0.3 * 1024.0)]
            .map(|(mesh, radius)| filled_at(&mesh, Some(radius)).unwrap());
        assert_eq!(small.mesh.triangles, large.mesh.triangles);
        assert!((large.cell / small.cell - 1024.0).abs() < 1e-6);
    }
}
