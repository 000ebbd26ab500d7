//! The paper's figure of merit for any grouped mesh: the average concavity cost [3.4.2, 3.4.3].

use hullwright::GroupedMesh;
use hullwright::internals::{CostScratch, TriangleMesh, cost, members};

/// Groups of at most this many polygons are left out of the average [3.4.2].
const TOO_SMALL_TO_COUNT: usize = 2;

/// Average of equation (3) over the groups of more than two triangles; 0 if there are none.
///
/// This is what the paper's Table 1 calls cost. O(vertices · hull faces) per group.
pub fn average_cost(grouped: &GroupedMesh) -> f64 {
    let count = grouped.groups.iter().max().map_or(0, |&label| label as usize + 1);
    let mesh = TriangleMesh::new(grouped.positions.clone(), grouped.triangles.clone());
    average(&mesh, &grouped.groups, count)
}

/// The same for a mesh of the pipeline.
pub(super) fn average(mesh: &TriangleMesh, labels: &[u32], count: usize) -> f64 {
    let groups = members(labels, count);
    let mut scratch = CostScratch::default();
    let counted: Vec<f64> = groups
        .iter()
        .filter(|group| group.len() > TOO_SMALL_TO_COUNT)
        .map(|group| cost(mesh, group, &mut scratch))
        .collect();
    if counted.is_empty() { 0.0 } else { counted.iter().sum::<f64>() / counted.len() as f64 }
}
