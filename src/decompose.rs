//! The way in: `decompose`, and `Decomposer` which does the same in slices.

use crate::bounded::Run;
use crate::bounded::output::BoundedResult;
use crate::clock::Instant;
use crate::control::{Control, Stage};
use crate::decomposition::{
    ALGORITHM_VERSION, BoundedReport, Decomposition, GroupedMesh, Report, StageTime, SurfaceReport,
};
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::PreparedMesh;
use crate::openings::prepare::{Closed, prepare_closed};
use crate::openings::{Opening, OpeningSettings};
use crate::parallel;
use crate::parameters::{Length, Method, Openings, Parameters};
use crate::surface::group_merging::merge_groups;
use crate::surface::grouping::Grouping;
use crate::surface::pieces::{assign_source_triangles, hulls};
use crate::surface::resolution_selection::{Levels, select};
use crate::surface::search::Search;

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
    // Before a copy is made.
    control.admit(mesh.triangles().len())?;
    let mut decomposer = Decomposer::new(mesh, parameters)?;
    loop {
        if let Some(decomposition) = decomposer.step(control)? {
            return Ok(decomposition);
        }
    }
}

/// The same work as [`decompose`], in slices, for where a background task is still the main
/// thread. A slice is a stage, or one resolution or one threshold of the paper's method.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// use hullwright::{Control, Decomposer, Parameters};
///
/// let control = Control::new();
/// let mut decomposer = Decomposer::new(&mesh, &Parameters::default())?;
/// let decomposition = loop {
///     // Here a frame may be drawn.
///     if let Some(decomposition) = decomposer.step(&control)? {
///         break decomposition;
///     }
/// };
/// assert_eq!(decomposition.hulls.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub struct Decomposer {
    source: TriangleMesh,
    parameters: Parameters,
    state: State,
    times: Vec<StageTime>,
    openings: Vec<Opening>,
    nested_components: usize,
    deadline_reached: bool,
}

enum State {
    Repair,
    Bounded(Box<Run>),
    Simplify(Box<(PreparedMesh, Levels)>),
    Search(Box<Search>),
    Pieces(Box<Search>),
    Done,
}

/// Shares of the whole work after which a stage begins, by their usual times.
const SIMPLIFY_AT: f32 = 0.1;
const SEARCH_AT: f32 = 0.4;
const PIECES_AT: f32 = 0.85;

impl Decomposer {
    /// Checks the input and the parameters and takes a copy of them.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] and [`Error::EmptyMesh`]; the rest of the input is judged in
    /// the first [`step`](Self::step).
    ///
    /// ```
    /// use hullwright::{Decomposer, Error, Parameters, TriangleMesh};
    ///
    /// let empty = Decomposer::new(&TriangleMesh::default(), &Parameters::default());
    /// assert!(matches!(empty, Err(Error::EmptyMesh { .. })));
    /// ```
    pub fn new<'a>(mesh: impl Into<MeshView<'a>>, parameters: &Parameters) -> Result<Self, Error> {
        parameters.validate()?;
        let mesh = mesh.into();
        let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles().len());
        if vertices == 0 || triangles == 0 {
            return Err(Error::EmptyMesh { vertices, triangles });
        }
        Ok(Self {
            source: mesh.to_owned(),
            parameters: parameters.clone(),
            state: State::Repair,
            times: Vec::new(),
            openings: Vec::new(),
            nested_components: 0,
            deadline_reached: false,
        })
    }

    /// Does the next slice of work. `None` while there is more to do.
    ///
    /// # Errors
    /// As [`decompose`], and [`Error::Finished`] after the result or an error.
    ///
    /// ```
    /// # let mesh = hullwright::TriangleMesh::new(
    /// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    /// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// # );
    /// use hullwright::{Control, Decomposer, Parameters};
    ///
    /// let mut decomposer = Decomposer::new(&mesh, &Parameters::default())?;
    /// let result = loop {
    ///     // A frame of the game goes between two steps.
    ///     if let Some(result) = decomposer.step(&Control::new())? {
    ///         break result;
    ///     }
    /// };
    /// assert_eq!(result.hulls.len(), 1);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn step(&mut self, control: &Control) -> Result<Option<Decomposition>, Error> {
        control.check()?;
        control.admit(self.source.triangles.len())?;
        let start = Instant::now();
        let (stage, fraction) = self.stage().ok_or(Error::Finished)?;
        control.report(stage, fraction);
        let surface = &self.parameters.surface;
        self.state = match std::mem::replace(&mut self.state, State::Done) {
            State::Repair => {
                let settings = self.opening_settings();
                let Closed { prepared, openings, nested_components, .. } =
                    parallel::with(control.is_parallel(), || {
                        prepare_closed(self.source.view(), &settings, control)
                    })?;
                (self.openings, self.nested_components) = (openings, nested_components);
                match self.parameters.method {
                    Method::Hull => return self.one_hull(&prepared, control, start).map(Some),
                    Method::Bounded => {
                        State::Bounded(Box::new(Run::new(prepared, &self.parameters)))
                    }
                    Method::Surface => State::Simplify(Box::new((prepared, Levels::new(surface)))),
                }
            }
            State::Bounded(mut run) => {
                let result = run.step(control)?;
                // The last step is done whole, however late it is.
                self.deadline_reached |=
                    run.is_cut_short() || result.is_none() && control.is_past_deadline();
                if let Some(result) = result {
                    add_time(&mut self.times, stage, start);
                    let BoundedResult { prepared, hulls, grouped, report } = result;
                    let report = self.report(&prepared, Some(report), None);
                    control.report(stage, 1.0);
                    return Ok(Some(Decomposition { hulls, grouped, report }));
                }
                State::Bounded(run)
            }
            State::Simplify(mut state) => {
                state.1.make_next(&state.0, surface, control)?;
                if state.1.is_complete() {
                    let (prepared, levels) = *state;
                    let unit = match surface.unit {
                        Length::Share(unit) => unit,
                        Length::Units(unit) => unit / prepared.normalization.diagonal,
                    };
                    let levels = levels.finish();
                    State::Search(Box::new(Search { prepared, levels, unit }))
                } else {
                    State::Simplify(state)
                }
            }
            State::Search(mut search) => {
                let is_done = search.advance(surface, control)?;
                self.deadline_reached = control.is_past_deadline() && !is_done;
                if is_done || (self.deadline_reached && search.has_candidate()) {
                    State::Pieces(search)
                } else if self.deadline_reached {
                    return Err(Error::DeadlineExceeded);
                } else {
                    State::Search(search)
                }
            }
            State::Pieces(search) => {
                let decomposition = self.pieces(*search, control, start)?;
                control.report(Stage::Assign, 1.0);
                return Ok(Some(decomposition));
            }
            State::Done => State::Done,
        };
        add_time(&mut self.times, stage, start);
        Ok(None)
    }

    /// What is done next, and the share of the whole that is done; `None` after the end.
    fn stage(&self) -> Option<(Stage, f32)> {
        Some(match &self.state {
            State::Repair => (Stage::Repair, 0.0),
            State::Bounded(run) => run.stage(),
            State::Simplify(state) => {
                let share = state.1.share_done();
                (Stage::Simplify, SIMPLIFY_AT + (SEARCH_AT - SIMPLIFY_AT) * share)
            }
            State::Search(search) => {
                let share = search.share_done(&self.parameters.surface);
                (Stage::Search, SEARCH_AT + (PIECES_AT - SEARCH_AT) * share)
            }
            State::Pieces(_) => (Stage::Hulls, PIECES_AT),
            State::Done => return None,
        })
    }

    fn opening_settings(&self) -> OpeningSettings {
        let mut settings = OpeningSettings::from(&self.parameters);
        if self.parameters.method == Method::Hull {
            // Neither a cap nor what lies inside changes the hull of all points.
            (settings.openings, settings.keep_cavities) = (Openings::Keep, true);
        }
        settings
    }

    /// Selection, group merging, hulls, and what each hull stands for.
    fn pieces(
        &mut self,
        search: Search,
        control: &Control,
        start: Instant,
    ) -> Result<Decomposition, Error> {
        let Search { prepared, levels, unit } = search;
        let surface = &self.parameters.surface;
        let cut_off = surface.resolution_cut_off;
        let selection = select(&levels, cut_off).ok_or(Error::DeadlineExceeded)?;
        let Some(level) = levels.get(selection.level) else {
            return Err(Error::DeadlineExceeded);
        };
        let significant = surface.significant_diagonal;
        let found = &selection.candidate;
        let grouping = merge_groups(&level.mesh, &level.adjacency, &found.grouping, significant);
        add_time(&mut self.times, Stage::Merge, start);

        let start = Instant::now();
        let normalization = &prepared.normalization;
        let mut hulls = hulls(
            &level.mesh,
            &level.components,
            &grouping,
            normalization,
            self.parameters.max_vertices,
            control,
        )?;
        add_time(&mut self.times, Stage::Hulls, start);

        let start = Instant::now();
        crate::parallel::with(control.is_parallel(), || {
            assign_source_triangles(&prepared, &level.mesh, &grouping, &mut hulls, control)
        })?;
        add_time(&mut self.times, Stage::Assign, start);

        let surface = SurfaceReport {
            pieces: grouping.count,
            pieces_before_merging: found.grouping.count,
            average_pieces: selection.average_pieces,
            cost: found.cost,
            planar_threshold: found.planar_threshold,
            resolution: level.resolution,
            polygons: level.mesh.triangles.len(),
            initial_polygons: prepared.mesh.triangles.len(),
            unit: unit * normalization.diagonal,
            resolutions: selection.reports,
        };
        let positions = level.mesh.positions.iter();
        Ok(Decomposition {
            hulls,
            grouped: GroupedMesh {
                positions: positions.map(|&point| normalization.restore(point)).collect(),
                triangles: level.mesh.triangles.clone(),
                groups: grouping.labels,
            },
            report: self.report(&prepared, None, Some(surface)),
        })
    }

    /// The hull of all points, whatever the bound. O(n log n).
    fn one_hull(
        &mut self,
        prepared: &PreparedMesh,
        control: &Control,
        start: Instant,
    ) -> Result<Decomposition, Error> {
        add_time(&mut self.times, Stage::Repair, start);
        let start = Instant::now();
        let PreparedMesh { mesh, components, normalization, .. } = prepared;
        let grouping = Grouping { labels: vec![0; mesh.triangles.len()], count: 1 };
        let cap = self.parameters.max_vertices;
        let mut hulls = hulls(mesh, components, &grouping, normalization, cap, control)?;
        crate::parallel::with(control.is_parallel(), || {
            assign_source_triangles(prepared, mesh, &grouping, &mut hulls, control)
        })?;
        add_time(&mut self.times, Stage::Hulls, start);
        let positions = mesh.positions.iter().map(|&point| normalization.restore(point)).collect();
        let triangles = mesh.triangles.clone();
        let grouped = GroupedMesh { positions, triangles, groups: grouping.labels };
        control.report(Stage::Hulls, 1.0);
        Ok(Decomposition { hulls, grouped, report: self.report(prepared, None, None) })
    }

    fn report(
        &mut self,
        prepared: &PreparedMesh,
        bounded: Option<BoundedReport>,
        surface: Option<SurfaceReport>,
    ) -> Report {
        Report {
            algorithm_version: ALGORITHM_VERSION,
            method: self.parameters.method,
            source_vertices: self.source.positions.len(),
            source_triangles: self.source.triangles.len(),
            triangles: prepared.mesh.triangles.len(),
            diagonal: prepared.normalization.diagonal,
            components: prepared.closed.len(),
            closed_components: prepared.closed.iter().filter(|&&closed| closed).count(),
            repairs: prepared.repairs,
            openings: std::mem::take(&mut self.openings),
            nested_components: self.nested_components,
            bounded,
            surface,
            deadline_reached: self.deadline_reached,
            times: std::mem::take(&mut self.times),
        }
    }
}

fn add_time(times: &mut Vec<StageTime>, stage: Stage, start: Instant) {
    let seconds = start.elapsed().as_secs_f64();
    match times.iter_mut().find(|time| time.stage == stage) {
        Some(time) => time.seconds += seconds,
        None => times.push(StageTime { stage, seconds }),
    }
}
