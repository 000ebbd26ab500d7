//! The way in, and the pipeline on one page. `docs/algorithm.md` explains its stages.
//!
//! ```text
//! repair -> close openings -> simplify -> solid -> patches -> merge -> cover -> finalize -> limit
//! ```

use crate::bounded::cover::cover;
use crate::bounded::deadline::Deadline;
use crate::bounded::finalize::final_hull::FinalHulls;
use crate::bounded::finalize::finalize;
use crate::bounded::limit::{BoundBracket, limit_hulls};
use crate::bounded::merge::merge;
use crate::bounded::output::BoundedResult;
use crate::bounded::patch::Patches;
use crate::bounded::patch_mesh::PatchMesh;
use crate::bounded::patches::divide_into_patches;
use crate::bounded::search::Search;
use crate::bounded::settings::Settings;
use crate::bounded::surfaces::{Solids, Surfaces, simplify, solids};
use crate::control::{Control, Stage};
use crate::decomposer::{Decomposer, Input, admit, run_to_end};
use crate::decomposition::{Decomposition, ProbeReport};
use crate::error::Error;
use crate::geometry::vector::cubed;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare as repair;
use crate::openings::OpeningSettings;
use crate::openings::prepare::close_prepared as close_openings;
use crate::parameters::Parameters;
use crate::solid::Solid;
use crate::stages::{FINISH, FINISHED, LIMIT, PREPARED, SEARCHED, Stages, nth};

/// Decomposes a triangle mesh into convex hulls.
///
/// `mesh` is in any unit; so are the hulls. Time is almost linear in the number of triangles, and
/// grows as the bound gets smaller. It never panics. For meshes from strangers, `control` limits
/// time and size.
///
/// # Errors
/// - [`Error::EmptyMesh`], [`Error::IndexOutOfRange`], [`Error::NothingUsable`],
///   [`Error::TooLarge`] and [`Error::SidednessCount`] for meshes that can't be used.
/// - [`Error::InvalidParameter`] for a parameter out of its range.
/// - [`Error::Cancelled`] and [`Error::DeadlineExceeded`] as `control` says.
/// - [`Error::Simplification`] where memory is short.
///
/// ```
/// use hullwright::{Control, Length, MeshView, Parameters, decompose};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let mesh = MeshView::new(&positions, &triangles);
/// let parameters = Parameters::default().with_max_error(Length::share(0.01)).with_max_hulls(32);
/// let result = decompose(mesh, &parameters, &Control::new())?;
/// assert_eq!(result.hulls.len(), 1);
/// # Ok(())
/// # }
/// ```
pub fn decompose<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &Parameters,
    control: &Control,
) -> Result<Decomposition, Error> {
    let mesh = mesh.into();
    parameters.validate()?;
    admit(mesh, control)?;
    run_to_end(pipeline(mesh, parameters, control))
}

impl Decomposer {
    /// Checks the input and the parameters and takes a copy of them. The control cannot be replaced
    /// later; [`Control::cancel`] works on every clone.
    ///
    /// # Errors
    /// [`Error::TooLarge`], [`Error::InvalidParameter`] and [`Error::EmptyMesh`]; the rest of the
    /// input is checked in the first [`step`](Self::step).
    pub fn new<'a>(
        mesh: impl Into<MeshView<'a>>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let mesh = mesh.into();
        parameters.validate()?;
        admit(mesh, control)?;
        let (mesh, parameters, control) = (mesh.to_owned(), parameters.clone(), control.clone());
        Ok(Self::of(async move { pipeline(mesh.view(), &parameters, &control).await }))
    }
}

/// The whole of a decomposition: the passes of the preset, of which the one with the fewest hulls
/// is kept, then the limit on hulls. Each stage runs between two yields: see [`Stages::run`].
pub(crate) async fn pipeline(
    mesh: MeshView<'_>,
    parameters: &Parameters,
    control: &Control,
) -> Result<Decomposition, Error> {
    let mut stages = Stages::new(control);
    let openings = &OpeningSettings::from(parameters);
    let repaired = stages.run(Stage::Repair, || repair(mesh, MeshOrder::Place, control)).await?;
    let close = || close_openings(repaired, mesh, openings, control);
    let mut input = Input::closed(mesh, stages.run(Stage::Openings, close).await?);
    let prepared = &mut input.prepared;
    round(&mut prepared.mesh);
    let mut deadline = Deadline::new(control);
    let passes = Settings::of_preset(parameters, &prepared.normalization);
    let most = parameters.max_hulls.unwrap_or(usize::MAX);
    let searched = if most == usize::MAX { FINISHED } else { SEARCHED };
    let mut best: Option<Found> = None;
    for (index, settings) in passes.iter().enumerate() {
        if best.is_some() && !deadline.allows_another_pass() {
            break;
        }
        stages.begin_pass(nth(PREPARED..searched, index, passes.len()), best.is_some());
        let earlier = best.as_ref();
        let pass = run_pass(prepared, earlier, settings, &mut stages, &mut deadline).await;
        let Some(Some(found)) = deadline.end_pass(pass)? else { break };
        if best.as_ref().is_none_or(|best| found.count() < best.count()) {
            best = Some(found);
        }
    }
    // All passes have the same bound; searches for a limit divide as the last one does, the
    // coarsest. There is at least one pass, and the first ends with a result or an error.
    let (Some(mut best), Some(settings)) = (best, passes.last()) else {
        return Err(Error::Finished);
    };
    if best.count() > most {
        best = limit(prepared, best, settings, &mut stages, &mut deadline).await?;
    }
    let deadline_reached = deadline.is_cut_short() || stages.is_late();
    stages.begin(FINISH, FINISHED..1.0);
    let Found { surfaces, solids, patches, hulls } = &best;
    let bound = settings.bound.verified();
    let restore = || {
        let probe = probe_report(&solids.exact, prepared);
        Ok(BoundedResult::new((prepared, surfaces), patches, hulls, bound, probe))
    };
    let BoundedResult { hulls, grouped, report } = stages.run(Stage::Finalize, restore).await?;
    Ok(Decomposition { hulls, grouped, run: input.report(stages, deadline_reached), report })
}

/// What a pass has found: verified hulls of patches.
struct Found {
    surfaces: Surfaces,
    solids: Solids,
    patches: Patches,
    hulls: FinalHulls,
}

impl Found {
    fn count(&self) -> usize {
        self.hulls.hulls.len()
    }
}

/// What is reported of a probe.
fn probe_report(solid: &Solid, prepared: &PreparedMesh) -> Option<ProbeReport> {
    let probe = solid.probe.as_ref()?;
    let diagonal = prepared.normalization.diagonal;
    Some(ProbeReport {
        radius: probe.radius * diagonal,
        cell: probe.cell() * diagonal,
        unreachable_volume: solid.unreachable_volume() * cubed(diagonal),
    })
}

/// One pass, from the surfaces to verified hulls. `None` where a search for a limit is given up.
async fn run_pass(
    prepared: &PreparedMesh,
    earlier: Option<&Found>,
    settings: &Settings,
    stages: &mut Stages,
    deadline: &mut Deadline,
) -> Result<Option<Found>, Error> {
    let control = &stages.control();
    let known = earlier.map(|earlier| &earlier.surfaces);
    let simplify = || simplify(prepared, known, settings, control);
    let surfaces = stages.run(Stage::Simplify, simplify).await?;
    let settings = &settings.for_surface(surfaces.exact.mesh.triangles.len());
    let known = earlier.map(|earlier| &earlier.solids);
    let make = || solids(&surfaces, known, settings, control);
    let solids = stages.run(Stage::Solid, make).await?;
    let settings = &deadline.for_patches(settings, stages.taken())?;
    let divide = || {
        let mesh = PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control)?;
        divide_into_patches(mesh, &surfaces, &solids.coarse, settings, control)
    };
    let patches = stages.run(Stage::Patches, divide).await?;
    let search = Search::new(&surfaces, &solids, &patches, settings, control);
    let until_verifying = &deadline.for_search(control, stages.taken());
    let pieces = stages.run(Stage::Merge, || merge(&search)).await?;
    let hurried = &Search { control: until_verifying, ..search };
    let cover = stages.run(Stage::Cover, || cover(hurried, pieces)).await?;
    deadline.end_search(until_verifying);
    let hulls = stages.run(Stage::Finalize, || finalize(&search, cover)).await?;
    Ok(hulls.map(|hulls| Found { surfaces, solids, patches, hulls }))
}

/// The limit on hulls: hulls join, and the search is repeated under larger bounds as long as that
/// may end with less error.
async fn limit(
    prepared: &PreparedMesh,
    found: Found,
    settings: &Settings,
    stages: &mut Stages,
    deadline: &mut Deadline,
) -> Result<Found, Error> {
    let mut bounds = BoundBracket::new(settings.bound.verified());
    stages.begin(LIMIT, SEARCHED..SEARCHED);
    let mut best = within_limit(found, settings, stages).await?;
    while let Some(bound) = bounds.next_bound(best.hulls.error()) {
        if !deadline.allows_another_pass() {
            break;
        }
        let settings = settings.with_bound(bound);
        let progress = |done| SEARCHED + (FINISHED - SEARCHED) * bounds.progress(done);
        stages.begin_pass(progress(0.0)..progress(1.0), true);
        let pass = run_pass(prepared, Some(&best), &settings, stages, deadline).await;
        let Some(found) = deadline.end_pass(pass)? else { break };
        let Some(found) = found else {
            bounds.refuse(bound);
            continue;
        };
        if found.hulls.error() < best.hulls.error() {
            best = found;
        }
    }
    Ok(best)
}

/// The hulls, joined until they keep the limit.
async fn within_limit(
    found: Found,
    settings: &Settings,
    stages: &mut Stages,
) -> Result<Found, Error> {
    let Found { surfaces, solids, patches, hulls } = found;
    let FinalHulls { hulls, uncovered, without_vertex_limit } = hulls;
    let most = settings.max_hulls.unwrap_or(usize::MAX);
    let control = &stages.control();
    let search = Search::new(&surfaces, &solids, &patches, settings, control);
    let hulls = stages.run(Stage::Limit, || limit_hulls(&search, &hulls, most)).await?;
    let without_vertex_limit = without_vertex_limit.min(hulls.len());
    let hulls = FinalHulls { hulls, uncovered, without_vertex_limit };
    Ok(Found { surfaces, solids, patches, hulls })
}

/// Once openings are closed, coordinates are rounded to 2^-38 of the diagonal. A mesh in other
/// units, which differs in the last bits, then breaks ties of symmetric shapes the same way.
const ROUNDING: f64 = (1_u64 << 38) as f64;

fn round(mesh: &mut TriangleMesh) {
    for coordinate in mesh.positions.as_flattened_mut() {
        *coordinate = (*coordinate * ROUNDING).round() / ROUNDING;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::openings::prepare::prepare_closed;

    /// Patches, pieces after merging, pieces of the cover, and hulls: the first of them that
    /// differs names the stage that a change has changed.
    fn counts(mesh: MeshView<'_>) -> [usize; 4] {
        let (parameters, control) = (&Parameters::default(), &Control::new());
        let mut prepared = prepare_closed(mesh, &parameters.into(), control).unwrap().prepared;
        round(&mut prepared.mesh);
        let settings = &Settings::of_preset(parameters, &prepared.normalization)[0];
        let surfaces = simplify(&prepared, None, settings, control).unwrap();
        let settings = &settings.for_surface(surfaces.exact.mesh.triangles.len());
        let solids = solids(&surfaces, None, settings, control).unwrap();
        let divided = PatchMesh::new(&surfaces.coarse, &solids.coarse, settings, control).unwrap();
        let solid = &solids.coarse;
        let patches = &divide_into_patches(divided, &surfaces, solid, settings, control).unwrap();
        let search = &Search::new(&surfaces, &solids, patches, settings, control);
        let pieces = merge(search).unwrap();
        let merged = pieces.len();
        let covering = cover(search, pieces).unwrap();
        let covered = covering.pieces.len();
        let hulls = finalize(search, covering).unwrap().unwrap().hulls.len();
        assert_eq!(hulls, decompose(mesh, parameters, control).unwrap().hulls.len());
        [patches.count(), merged, covered, hulls]
    }

    /// After a change of the method, `UPDATE_STAGES=1 cargo test --package hullwright --lib
    /// decompose` writes the file anew.
    #[test]
    fn each_stage_ends_with_as_many_parts_of_the_bundled_models_as_on_record() {
        use std::fmt::Write;
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let (assets, record) = (root.join("../../assets"), root.join("tests/data/stages.txt"));
        let mut found = String::from("model patches merge cover hulls\n");
        for name in ["chair", "dog", "gear", "lamp", "mug", "table", "teapot", "torus"] {
            let path = assets.join(format!("{name}.glb"));
            let hullwright_formats::MeshFile { mesh, .. } =
                hullwright_formats::read_mesh(path).unwrap();
            let mesh = MeshView::new(&mesh.positions, &mesh.triangles);
            let [patches, merged, covered, hulls] = counts(mesh);
            assert!(patches >= merged && merged >= covered, "{name}");
            writeln!(found, "{name} {patches} {merged} {covered} {hulls}").unwrap();
        }
        if std::env::var_os("UPDATE_STAGES").is_some() {
            std::fs::write(&record, &found).unwrap();
        }
        assert_eq!(found, std::fs::read_to_string(&record).unwrap());
    }
}
