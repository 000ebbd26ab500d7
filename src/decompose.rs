//! The way in, and the pipeline on one page. `docs/algorithm.md` explains its stages.
//!
//! ```text
//! repair -> close openings -> solid -> patches -> merge -> cover -> finalize -> limit
//! ```

use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::{Context, Poll, Waker};

use crate::bounded::containment::solid::Solid;
use crate::bounded::cover::cover;
use crate::bounded::deadline::Deadline;
use crate::bounded::finalize::final_hull::FinalHulls;
use crate::bounded::finalize::finalize;
use crate::bounded::limit::{BoundSearch, limit_hulls};
use crate::bounded::merge::merge;
use crate::bounded::output::BoundedResult;
use crate::bounded::patch::Patches;
use crate::bounded::patches::divide_into_patches;
use crate::bounded::search::{Search, solid_and_patch_mesh};
use crate::bounded::settings::Settings;
use crate::control::{Control, Stage};
use crate::decomposition::{
    ALGORITHM_VERSION, BoundedReport, Decomposition, GroupedMesh, Hull, Report, SurfaceReport,
};
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::PreparedMesh;
use crate::mesh::repair::prepare as repair;
use crate::openings::OpeningSettings;
use crate::openings::prepare::close_prepared as close_openings;
use crate::parameters::{Method, Openings, Parameters};
use crate::stages::{FINISH, FINISHED, HULL, LIMIT, PREPARED, SEARCHED, SURFACE, Stages, nth};
use crate::surface;

/// Decomposes a triangle mesh into convex hulls.
///
/// `mesh` is in any unit; so are the hulls. Time is almost linear in the number of triangles, and
/// grows as the bound gets smaller. It never panics. For meshes from strangers, `control` limits time and
/// size.
///
/// # Errors
/// - [`Error::EmptyMesh`], [`Error::IndexOutOfRange`], [`Error::NothingUsable`], [`Error::TooLarge`] and
///   [`Error::SidednessCount`] for meshes that can't be used.
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
/// let parameters = Parameters::default().max_error(Length::share(0.01)).max_hulls(32);
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
    admit(mesh, parameters, control)?;
    let mut work = pin!(pipeline(mesh, parameters, control));
    loop {
        if let Poll::Ready(result) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return result;
        }
    }
}

/// [`decompose`] in time slices, for platforms whose background tasks run on the main thread. A slice is a
/// stage, or one resolution or one threshold of the paper's method.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// use hullwright::{Control, Decomposer, Parameters};
///
/// let mut decomposer = Decomposer::new(&mesh, &Parameters::default(), &Control::new())?;
/// let decomposition = loop {
///     // Here a frame may be drawn.
///     if let Some(decomposition) = decomposer.step()? {
///         break decomposition;
///     }
/// };
/// assert_eq!(decomposition.hulls.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub struct Decomposer {
    /// `None` after the end.
    work: Option<Pin<Box<Work>>>,
}

type Work = dyn Future<Output = Result<Decomposition, Error>> + Send + Sync;

impl Decomposer {
    /// Checks the input and the parameters and takes a copy of them. The control cannot be replaced later;
    /// [`Control::cancel`] works on every clone.
    ///
    /// # Errors
    /// [`Error::TooLarge`], [`Error::InvalidParameter`] and [`Error::EmptyMesh`]; the rest of the input is
    /// checked in the first [`step`](Self::step).
    pub fn new<'a>(
        mesh: impl Into<MeshView<'a>>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let mesh = mesh.into();
        admit(mesh, parameters, control)?;
        let (mesh, parameters, control) = (mesh.to_owned(), parameters.clone(), control.clone());
        let work = async move { pipeline(mesh.view(), &parameters, &control).await };
        Ok(Self { work: Some(Box::pin(work)) })
    }

    /// Does the next slice of work. `None` while there is more to do.
    ///
    /// # Errors
    /// As [`decompose`], and [`Error::Finished`] after the result or an error.
    pub fn step(&mut self) -> Result<Option<Decomposition>, Error> {
        // Taken out first: what has panicked can't be polled again.
        let mut work = self.work.take().ok_or(Error::Finished)?;
        match work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(result) => result.map(Some),
            Poll::Pending => {
                self.work = Some(work);
                Ok(None)
            }
        }
    }
}

/// What is checked before the mesh is copied or looked at.
fn admit(mesh: MeshView<'_>, parameters: &Parameters, control: &Control) -> Result<(), Error> {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles().len());
    control.admit(triangles)?;
    parameters.validate()?;
    if vertices == 0 || triangles == 0 {
        return Err(Error::EmptyMesh { vertices, triangles });
    }
    Ok(())
}

/// The whole of a decomposition. Each stage runs between two yields: see [`Stages::run`].
async fn pipeline(
    mesh: MeshView<'_>,
    parameters: &Parameters,
    control: &Control,
) -> Result<Decomposition, Error> {
    let mut stages = Stages::new(control);
    let settings = opening_settings(parameters);
    let repaired = stages.run(Stage::Repair, || repair(mesh, settings.order, control)).await?;
    let closed =
        stages.run(Stage::Openings, || close_openings(repaired, mesh, &settings, control)).await?;
    let mut prepared = closed.prepared;
    let Outcome { hulls, grouped, bounded, surface, deadline_reached } = match parameters.method {
        Method::Bounded => bounded(&mut prepared, parameters, &mut stages).await?,
        Method::Surface => surface(&prepared, parameters, &mut stages).await?,
        Method::Hull => one_hull(&prepared, parameters, &mut stages).await?,
    };
    let report = Report {
        algorithm_version: ALGORITHM_VERSION,
        method: parameters.method,
        source_vertices: mesh.vertex_count(),
        source_triangles: mesh.triangles().len(),
        triangles: prepared.mesh.triangles.len(),
        diagonal: prepared.normalization.diagonal,
        components: prepared.closed.len(),
        closed_components: prepared.closed.iter().filter(|&&closed| closed).count(),
        repairs: prepared.repairs,
        openings: closed.openings,
        nested_components: closed.nested_components,
        bounded,
        surface,
        deadline_reached,
        times: stages.finish(),
    };
    Ok(Decomposition { hulls, grouped, report })
}

/// What a method makes of a mesh without openings.
struct Outcome {
    hulls: Vec<Hull>,
    grouped: GroupedMesh,
    bounded: Option<BoundedReport>,
    surface: Option<SurfaceReport>,
    deadline_reached: bool,
}

/// The default method: the passes of the preset, of which the one with the fewest hulls is kept, then the cap
/// on hulls.
async fn bounded(
    prepared: &mut PreparedMesh,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<Outcome, Error> {
    round(&mut prepared.mesh);
    let mut deadline = Deadline::new(&stages.control());
    let passes = Settings::of_preset(parameters, prepared.normalization.diagonal);
    let most = parameters.bounded.max_hulls.unwrap_or(usize::MAX);
    let searched = if most == usize::MAX { FINISHED } else { SEARCHED };
    let mut best: Option<Found> = None;
    for (index, settings) in passes.iter().enumerate() {
        if best.is_some() && !deadline.allows_another_pass() {
            break;
        }
        stages.begin_pass(nth(PREPARED..searched, index, passes.len()), best.is_some());
        let solid = best.as_ref().map(|best| Arc::clone(&best.solid));
        let pass = search(prepared, solid, settings, stages, &mut deadline).await;
        let Some(found) = deadline.end_pass(pass)? else { break };
        if best.as_ref().is_none_or(|best| found.count() < best.count()) {
            best = Some(found);
        }
    }
    let (Some(mut best), Some(settings)) = (best, passes.last()) else {
        return Err(Error::Finished);
    };
    if best.count() > most {
        best = limit(prepared, best, settings, stages, &mut deadline).await?;
    }
    stages.begin(FINISH, FINISHED..1.0);
    let Found { patches, hulls, .. } = &best;
    let asked = settings.bound.protrusion();
    let restore = || Ok(BoundedResult::new(prepared, patches, hulls, asked));
    let BoundedResult { hulls, grouped, report } = stages.run(Stage::Finalize, restore).await?;
    Ok(Outcome {
        hulls,
        grouped,
        bounded: Some(report),
        surface: None,
        deadline_reached: deadline.is_cut_short() || stages.is_late(),
    })
}

/// What a pass has found: verified hulls of patches.
struct Found {
    solid: Arc<Solid>,
    patches: Patches,
    hulls: FinalHulls,
}

impl Found {
    fn count(&self) -> usize {
        self.hulls.hulls.len()
    }
}

/// One pass, from the solid, unless an earlier pass has built it, to verified hulls.
async fn search(
    prepared: &PreparedMesh,
    solid: Option<Arc<Solid>>,
    settings: &Settings,
    stages: &mut Stages,
    deadline: &mut Deadline,
) -> Result<Found, Error> {
    let control = &stages.control();
    let (solid, patch_mesh) = stages
        .run(Stage::Solid, || solid_and_patch_mesh(prepared, solid, settings, control))
        .await?;
    let settings = &deadline.for_patches(settings, stages.taken())?;
    let patches = stages
        .run(Stage::Patches, || divide_into_patches(patch_mesh, &solid, settings, control))
        .await?;
    let search = Search { solid: &solid, patches: &patches, settings, control };
    let control = &deadline.for_search(control, stages.taken());
    let pieces = stages.run(Stage::Merge, || merge(&search)).await?;
    let cover = stages.run(Stage::Cover, || cover(&Search { control, ..search }, pieces)).await?;
    deadline.end_search(control);
    let hulls = stages.run(Stage::Finalize, || finalize(&search, cover)).await?;
    Ok(Found { solid, patches, hulls })
}

/// The cap on hulls: hulls join, and the search is repeated under larger bounds as long as that may end with
/// less error.
async fn limit(
    prepared: &PreparedMesh,
    found: Found,
    settings: &Settings,
    stages: &mut Stages,
    deadline: &mut Deadline,
) -> Result<Found, Error> {
    let mut bounds = BoundSearch::new(settings.bound.protrusion());
    stages.begin(LIMIT, SEARCHED..SEARCHED);
    let mut best = joined(found, settings, stages).await?;
    while let Some(bound) = bounds.next_bound(best.hulls.error()) {
        if !deadline.allows_another_pass() {
            break;
        }
        let settings = settings.with_bound(bound);
        let share = |share| SEARCHED + (FINISHED - SEARCHED) * bounds.progress(share);
        let (begin, middle, end) = (share(0.0), share(0.9), share(1.0));
        stages.begin_pass(begin..middle, true);
        let pass = search(prepared, None, &settings, stages, deadline).await;
        let Some(mut found) = deadline.end_pass(pass)? else { break };
        if settings.max_hulls.is_some_and(|most| found.count() > most) {
            bounds.refuse(bound);
            stages.begin(LIMIT, middle..end);
            found = joined(found, &settings, stages).await?;
        }
        if found.hulls.error() < best.hulls.error() {
            best = found;
        }
    }
    Ok(best)
}

/// The hulls, joined until there are no more than the cap.
async fn joined(found: Found, settings: &Settings, stages: &mut Stages) -> Result<Found, Error> {
    let Found { solid, patches, hulls: FinalHulls { hulls, uncovered } } = found;
    let most = settings.max_hulls.unwrap_or(usize::MAX);
    let control = &stages.control();
    let search = Search { solid: &solid, patches: &patches, settings, control };
    let hulls = stages.run(Stage::Limit, || limit_hulls(&search, &hulls, most)).await?;
    Ok(Found { solid, patches, hulls: FinalHulls { hulls, uncovered } })
}

/// The paper's method.
async fn surface(
    prepared: &PreparedMesh,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<Outcome, Error> {
    stages.begin(SURFACE, PREPARED..1.0);
    let result = surface::decompose::decompose(prepared, parameters, stages).await?;
    Ok(Outcome {
        hulls: result.hulls,
        grouped: result.grouped,
        bounded: None,
        surface: Some(result.report),
        deadline_reached: result.is_cut_short,
    })
}

/// The hull of all points, whatever the bound.
async fn one_hull(
    prepared: &PreparedMesh,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<Outcome, Error> {
    stages.begin(HULL, PREPARED..1.0);
    let (hulls, grouped) = surface::decompose::one_hull(prepared, parameters, stages).await?;
    Ok(Outcome { hulls, grouped, bounded: None, surface: None, deadline_reached: false })
}

fn opening_settings(parameters: &Parameters) -> OpeningSettings {
    let mut settings = OpeningSettings::from(parameters);
    if parameters.method == Method::Hull {
        // Neither a cap nor what lies inside changes the hull of all points.
        (settings.openings, settings.keep_cavities) = (Openings::Keep, true);
    }
    settings
}

/// Coordinates are rounded to 2^-38 diagonals. A mesh in other units, which differs in the last
/// bits, then breaks ties of symmetric shapes the same way.
const ROUNDING: f64 = (1_u64 << 38) as f64;

fn round(mesh: &mut TriangleMesh) {
    for coordinate in mesh.positions.as_flattened_mut() {
        *coordinate = (*coordinate * ROUNDING).round() / ROUNDING;
    }
}
