//! The one hull of all points, for what is convex enough.

use crate::control::{Control, Stage};
use crate::decomposer::run_to_end;
use crate::decomposition::Decomposition;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::input::{Input, admit};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::grouping::Grouping;
use crate::mesh::repair::prepare as repair;
use crate::parameters::check_max_vertices;
use crate::stages::{HULL, PREPARED, Stages};
use crate::surface::pieces::Pieces;

/// The hull of all points that triangles use, with at most `max_vertices` vertices, whatever the error: nothing
/// is verified. O(n log n).
///
/// # Errors
/// As [`decompose`](crate::decompose()).
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let result = hullwright::single_hull(&mesh, Some(64), &hullwright::Control::new())?;
/// assert_eq!(result.hulls.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn single_hull<'a>(
    mesh: impl Into<MeshView<'a>>,
    max_vertices: Option<usize>,
    control: &Control,
) -> Result<Decomposition<()>, Error> {
    let mesh = mesh.into();
    check_max_vertices(max_vertices)?;
    admit(mesh, control)?;
    run_to_end(pipeline(mesh, max_vertices, control))
}

/// The whole of it, with a yield between stages.
pub(crate) async fn pipeline(
    mesh: MeshView<'_>,
    max_vertices: Option<usize>,
    control: &Control,
) -> Result<Decomposition<()>, Error> {
    let mut stages = Stages::new(control);
    // Neither a cap nor what lies inside changes the hull of all points.
    let repaired = stages.run(Stage::Repair, || repair(mesh, MeshOrder::Place, control)).await?;
    let input = Input::as_it_is(mesh, repaired);
    stages.begin(HULL, PREPARED..1.0);
    let PreparedMesh { mesh, components, normalization, .. } = &input.prepared;
    let grouping = Grouping { labels: vec![0; mesh.triangles.len()], count: 1 };
    let whole = Pieces { mesh, components, grouping: &grouping };
    let hulls = whole.finish(&input.prepared, max_vertices, &mut stages).await?;
    let grouped = whole.grouped_mesh(normalization);
    Ok(Decomposition { hulls, grouped, run: input.report(stages, false), report: () })
}
