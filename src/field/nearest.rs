//! Which triangle of one mesh each triangle of another is nearest to.

use super::Field;
use crate::mesh::TriangleMesh;
use crate::vector::{add, scale};
use crate::{Control, Error};

/// Triangles between two looks at the control, and of a task.
const PER_TASK: usize = 2048;

/// For each triangle of a mesh the triangle of the field nearest to its centre; `u32::MAX` for an
/// empty field. O(n log m) for n triangles and m of the field.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn nearest_triangles(
    mesh: &TriangleMesh,
    field: &Field,
    control: &Control,
) -> Result<Vec<u32>, Error> {
    let task = |triangles: &[[u32; 3]]| {
        control.check()?;
        let mut guess = u32::MAX;
        let nearest = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
            let centre = scale(add(add(a, b), c), 1.0 / 3.0);
            guess = field.triangle_near(centre, guess).unwrap_or(u32::MAX);
            guess
        });
        Ok(nearest.collect::<Vec<u32>>())
    };
    let chunks: Vec<&[[u32; 3]]> = mesh.triangles.chunks(PER_TASK).collect();
    let parts = crate::parallel::map(&chunks, |chunk| task(chunk));
    Ok(parts.into_iter().collect::<Result<Vec<Vec<u32>>, Error>>()?.concat())
}
