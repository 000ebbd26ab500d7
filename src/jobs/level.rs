//! Few triangles within a bound, of what never moves.

use hullwright::{Control, Error, simplify_surface};

use super::request::MeshData;
use crate::tag::outcomes::DecompositionError;
use crate::tag::parameters::metres;

/// The same surface with few triangles, in the order of its parts. O(n log n) for n triangles.
pub(super) fn simplified(
    data: MeshData,
    bound: f32,
    control: &Control,
) -> Result<MeshData, DecompositionError> {
    let made = match simplify_surface(data.view(), metres(bound), control) {
        // The engine takes what has no area.
        Err(Error::NothingUsable { .. }) => return Ok(data),
        // By the name that it has here.
        Err(Error::InvalidParameter { reason, .. }) => {
            return Err(Error::InvalidParameter { name: "level_bound", reason }.into());
        }
        made => made?,
    };
    let all = made.mesh.triangles.iter().zip(&made.sources);
    let mut triangles: Vec<(usize, [u32; 3])> =
        all.map(|(triangle, source)| (data.part_of(*source), *triangle)).collect();
    triangles.sort_by_key(|(part, _)| *part);
    let part_ends = (0..data.part_ends.len())
        .map(|part| triangles.partition_point(|(other, _)| *other <= part) as u32)
        .collect();
    let triangles = triangles.into_iter().map(|(_, triangle)| triangle).collect();
    // Each vertex has the place of one of the mesh, which is in single precision.
    let positions = made.mesh.positions.iter().map(|point| point.map(|x| x as f32)).collect();
    Ok(MeshData { positions, triangles, part_ends })
}
