//! Which triangle of one mesh each triangle of another is nearest to, and which label.

use super::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, area_normal, dot, length_squared, scale};
use crate::mesh::TriangleMesh;

/// Triangles between two looks at the control, and of a task.
const PER_TASK: usize = 2048;

/// For each triangle of a mesh the triangle of the field nearest to its centre; `u32::MAX` for an
/// empty field. O(n log m) for n triangles and m of the field.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn nearest_triangles(
    mesh: &TriangleMesh,
    bvh: &Bvh,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    let task = |triangles: &[[u32; 3]]| {
        control.check()?;
        let mut guess = u32::MAX;
        let nearest = triangles.iter().map(|triangle| {
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
            guess = bvh.triangle_near(centre(corners), guess).unwrap_or(u32::MAX);
            guess
        });
        Ok(nearest.collect::<Vec<u32>>())
    };
    let chunks: Vec<&[[u32; 3]]> = mesh.triangles.chunks(PER_TASK).collect();
    let parts = crate::parallel::map(&chunks, |chunk| task(chunk));
    Ok(parts.into_iter().collect::<Result<Vec<Vec<u32>>, Error>>()?.concat())
}

/// Tasks that a large mesh is divided into, each with memory for all vertices. Any number will do, as long as
/// it does not depend on threads.
const TASKS: usize = 16;

/// What is known of the triangles around a vertex.
#[derive(Clone, Copy, PartialEq)]
struct Around {
    /// The normal of one that the field was asked about, and where that led.
    normal: Vector,
    nearest: u32,
    /// The label of all of them that the field was asked about, or `MIXED`.
    label: u32,
}

const MIXED: u32 = u32::MAX;

/// For each triangle of a mesh the label of the field's triangle that is nearest to its centre; `u32::MAX`
/// for an empty field. A triangle whose corners all belong to earlier ones of one and the same label, and of
/// about the same direction, has that label too, unasked: four of ten triangles of the Princeton meshes, and
/// 3 of 10,000 otherwise than if they had been asked. O(n log m) for n triangles and m of the field.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn nearest_labels(
    mesh: &TriangleMesh,
    bvh: &Bvh,
    labels: &[u32],
    control: &Control,
) -> Result<Vec<u32>, Error> {
    let label_of = |triangle: u32| labels.get(triangle as usize).copied().unwrap_or(MIXED);
    let task = |triangles: &[[u32; 3]]| {
        let mut around: Vec<Option<Around>> = vec![None; mesh.positions.len()];
        let mut result = Vec::with_capacity(triangles.len());
        let mut previous = u32::MAX;
        for (index, triangle) in triangles.iter().enumerate() {
            if index.is_multiple_of(PER_TASK) {
                control.check()?;
            }
            let known = triangle.map(|vertex| around[vertex as usize]);
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
            let [a, b, c] = corners;
            let normal = area_normal(a, b, c);
            if let [Some(a), Some(b), Some(c)] = known
                && a.label != MIXED
                && a.label == b.label
                && b.label == c.label
                && [a, b, c].iter().all(|known| is_same_way(known.normal, normal))
            {
                result.push(a.label);
                continue;
            }
            let guess = known.into_iter().flatten().next().map_or(previous, |known| known.nearest);
            let nearest = bvh.triangle_near(centre(corners), guess).unwrap_or(u32::MAX);
            previous = nearest;
            let label = label_of(nearest);
            for &vertex in triangle {
                let around = &mut around[vertex as usize];
                let is_same = around.is_none_or(|around| around.label == label);
                let label = if is_same { label } else { MIXED };
                *around = Some(Around { normal, nearest, label });
            }
            result.push(label);
        }
        Ok(result)
    };
    let chunks: Vec<&[[u32; 3]]> =
        mesh.triangles.chunks(mesh.triangles.len().div_ceil(TASKS).max(PER_TASK)).collect();
    let parts = crate::parallel::map(&chunks, |chunk| task(chunk));
    Ok(parts.into_iter().collect::<Result<Vec<Vec<u32>>, Error>>()?.concat())
}

/// Whether two normals are less than 60 degrees apart.
fn is_same_way(a: Vector, b: Vector) -> bool {
    let cosine = dot(a, b);
    cosine > 0.0 && 4.0 * cosine * cosine > length_squared(a) * length_squared(b)
}

fn centre([a, b, c]: [Vector; 3]) -> Vector {
    scale(add(add(a, b), c), 1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::torus;

    /// Eight sectors around the torus.
    fn sector(mesh: &TriangleMesh, triangle: [u32; 3]) -> u32 {
        let [x, y, _] = centre(triangle.map(|vertex| mesh.positions[vertex as usize]));
        u32::from(x > 0.0) + 2 * u32::from(y > 0.0) + 4 * u32::from(x.abs() > y.abs())
    }

    #[test]
    fn what_is_not_asked_hardly_ever_differs_from_what_the_field_would_say() {
        let (coarse, fine) = (torus(48, 16), torus(200, 70));
        let labels: Vec<u32> = coarse.triangles.iter().map(|&t| sector(&coarse, t)).collect();
        let bvh = Bvh::new(&coarse.positions, &coarse.triangles);
        let control = Control::new();
        let found = nearest_labels(&fine, &bvh, &labels, &control).unwrap();
        let asked = nearest_triangles(&fine, &bvh, &control).unwrap();
        let otherwise =
            found.iter().zip(asked).filter(|&(&label, t)| label != labels[t as usize]).count();
        assert_eq!(found.len(), fine.triangles.len());
        assert!(otherwise * 200 < found.len(), "{otherwise} of {}", found.len());
    }

    #[test]
    fn a_side_beyond_sharp_edges_is_asked_though_its_corners_are_known() {
        let mut cube = crate::mesh::shapes::cuboid([0.0; 3], [1.0; 3]);
        // The top comes last.
        let is_top = |triangle: &[u32; 3]| {
            triangle.iter().all(|&vertex| cube.positions[vertex as usize][2] == 1.0)
        };
        cube.triangles.sort_by_key(is_top);
        let labels: Vec<u32> = cube.triangles.iter().map(|t| u32::from(is_top(t))).collect();
        assert_eq!(labels.iter().sum::<u32>(), 2);
        let bvh = Bvh::new(&cube.positions, &cube.triangles);
        assert_eq!(nearest_labels(&cube, &bvh, &labels, &Control::new()).unwrap(), labels);
    }

    #[test]
    fn an_empty_field_has_no_labels() {
        let bvh = Bvh::new(&[], &[]);
        let found = nearest_labels(&torus(8, 4), &bvh, &[], &Control::new()).unwrap();
        assert!(found.iter().all(|&label| label == u32::MAX));
    }
}
