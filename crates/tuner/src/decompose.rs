//! Decomposition in the background: one job at a time, for the newest settings. The hulls that are
//! there stay until the new ones are.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use bevy::prelude::*;
use bevy::tasks::{Task, TaskPool, TaskPoolBuilder, block_on, poll_once};
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, MassProperties};
use bevy_rapier3d::rapier::geometry::{SharedShape, TriMeshFlags};
use hullwright::measure::{FilledSurface, MeasuredMesh};
use hullwright::{
    Control, Decomposition, Error, Hull, Length, Openings, Parameters, Preset, TriangleMesh,
    decompose, mass_properties_with,
};
use hullwright_demos::hulls::{Piece, pieces};

use crate::model::{Library, Model, SIZE};

/// Mass per cubed metre of the stage: light enough for balls to move things, heavy enough to move
/// balls.
const DENSITY: f64 = 60.0;

/// What the controls say.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct Settings {
    /// The bound, as percent of the mesh's diagonal.
    pub bound: f64,
    /// Most hulls, if they are capped.
    pub max_hulls: Option<usize>,
    /// Most vertices of a hull, if they are capped.
    pub max_vertices: Option<usize>,
    /// Work against hulls.
    pub preset: Preset,
    /// What becomes of flat openings.
    pub openings: Openings,
    /// Whether cavities stay empty that nothing can enter.
    pub keep_cavities: bool,
    /// The radius of what moves, as percent of the mesh's diagonal; 0 for no probe.
    pub probe: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let parameters = Parameters::default();
        Self {
            bound: parameters.max_error.of_diagonal(100.0),
            max_hulls: None,
            max_vertices: parameters.max_vertices,
            preset: parameters.preset,
            openings: parameters.openings,
            keep_cavities: parameters.keep_cavities,
            probe: 0.0,
        }
    }
}

impl Settings {
    /// As the library takes them.
    pub fn parameters(&self) -> Parameters {
        Parameters::default()
            .with_max_error(Length::share(self.bound / 100.0))
            .with_preset(self.preset)
            .with_openings(self.openings)
            .with_max_hulls(self.max_hulls)
            .with_keep_cavities(self.keep_cavities)
            .with_max_vertices(self.max_vertices)
            .with_probe_radius((self.probe > 0.0).then(|| Length::share(self.probe / 100.0)))
    }

    /// The probe's radius on the stage, in metres.
    pub fn ball(&self) -> f32 {
        (SIZE * self.probe / 100.0) as f32
    }
}

/// Hulls of a model, ready to be shown and thrown.
pub struct Fit {
    /// The model that they are of.
    pub model: Arc<Model>,
    /// What was asked for.
    pub settings: Settings,
    /// In the mesh's own units.
    pub decomposition: Decomposition,
    /// Wall-clock time of the decomposition alone.
    pub seconds: f64,
    /// On the stage, with the middle of the mesh at the origin.
    pub collider: Collider,
    /// Of the mesh, on the stage.
    pub mass: ColliderMassProperties,
    /// What the collider is made of.
    pub pieces: Vec<Piece>,
    /// With a probe: the mesh, which stops the ball at the pointer, and the surface of what no ball
    /// reaches. On the stage.
    pub probed: Option<(SharedShape, TriangleMesh)>,
}

impl Fit {
    fn new(model: Arc<Model>, settings: Settings, control: &Control) -> Result<Self, String> {
        let parameters = settings.parameters();
        let start = Instant::now();
        let decomposition =
            decompose(&model.mesh, &parameters, control).map_err(|error| match error {
                Error::Cancelled => String::new(),
                error => error.to_string(),
            })?;
        let seconds = start.elapsed().as_secs_f64();
        let hulls: Vec<Hull> =
            decomposition.hulls.iter().map(|hull| on_stage(&model, hull)).collect();
        let mesh = model.mesh_on_stage();
        let mass = mass_properties_with(&mesh, &hulls, DENSITY, &parameters)
            .map_err(|error| error.to_string())?;
        let shape =
            hullwright_rapier::shape(&hulls, [1.0; 3]).map_err(|error| error.to_string())?;
        let mass = hullwright_rapier::mass_properties(&mass, [1.0; 3])
            .map_err(|error| error.to_string())?;
        let pieces = pieces(&shape);
        let mass = ColliderMassProperties::MassProperties(MassProperties::from_rapier(mass));
        let collider = Collider::from(shape);
        let probed =
            if settings.probe > 0.0 { probed(&model, &mesh, &parameters, control)? } else { None };
        Ok(Self { model, settings, decomposition, seconds, collider, mass, pieces, probed })
    }

    /// Vertices of all hulls.
    pub fn vertices(&self) -> usize {
        self.decomposition.hulls.iter().map(|hull| hull.shape.points.len()).sum()
    }

    /// Verified protrusion and uncovered distance, in percent of the diagonal.
    pub fn errors(&self) -> [f64; 2] {
        let Decomposition { run, report, .. } = &self.decomposition;
        let percent = |length: f64| 100.0 * length / run.diagonal;
        [percent(report.protrusion_max), percent(report.uncovered_max)]
    }
}

/// See [`Fit::probed`].
fn probed(
    model: &Model,
    on_stage: &TriangleMesh,
    parameters: &Parameters,
    control: &Control,
) -> Result<Option<(SharedShape, TriangleMesh)>, String> {
    let filled = MeasuredMesh::new(&model.mesh, parameters, control)
        .and_then(|measured| measured.filled(control))
        .map_err(|error| error.to_string())?;
    let Some(FilledSurface { mesh: mut filled, .. }) = filled else { return Ok(None) };
    filled.positions.iter_mut().for_each(|point| *point = model.on_stage(*point));
    let whole = hullwright_rapier::triangle_mesh(on_stage, TriMeshFlags::empty());
    let whole = whole.map_err(|error| error.to_string())?;
    Ok(Some((SharedShape::new(whole), filled)))
}

fn on_stage(model: &Model, hull: &Hull) -> Hull {
    let mut hull = hull.clone();
    for point in &mut hull.shape.points {
        *point = model.on_stage(*point);
    }
    hull
}

/// A thread for jobs. Bevy's own pool for long work has one thread on a small machine: while a job
/// had it, no file was read and no picture written.
fn worker() -> &'static TaskPool {
    static WORKER: OnceLock<TaskPool> = OnceLock::new();
    WORKER.get_or_init(|| {
        TaskPoolBuilder::new().num_threads(1).thread_name("decompose".into()).build()
    })
}

/// What is being decomposed.
struct Job {
    model: Arc<Model>,
    settings: Settings,
    control: Control,
    /// Share that is done, as the bits of an `f32`.
    done: Arc<AtomicU32>,
    started: Instant,
    task: Task<Result<Fit, String>>,
}

/// The newest hulls, and the job for newer ones.
#[derive(Resource, Default)]
pub struct Tuning {
    /// What is shown.
    pub fit: Option<Arc<Fit>>,
    /// Why the last job made none.
    pub error: Option<String>,
    /// What the last job was asked for, whatever came of it.
    finished: Option<(Arc<Model>, Settings)>,
    job: Option<Job>,
}

impl Tuning {
    /// Share of the running job that is done, and the seconds since it began.
    pub fn progress(&self) -> Option<(f32, f32)> {
        let job = self.job.as_ref()?;
        let done = f32::from_bits(job.done.load(Ordering::Relaxed));
        Some((done, job.started.elapsed().as_secs_f32()))
    }

    /// Whether there is nothing newer to be had for these settings.
    pub fn is_current(&self, model: Option<&Arc<Model>>, settings: &Settings) -> bool {
        let is_same = |(of, with): &(Arc<Model>, Settings)| {
            model.is_some_and(|model| Arc::ptr_eq(of, model)) && with == settings
        };
        self.job.is_none() && self.finished.as_ref().is_some_and(is_same)
    }

    fn start(&mut self, model: Arc<Model>, settings: Settings) {
        let done = Arc::new(AtomicU32::new(0));
        let heard = done.clone();
        let control = Control::new().with_progress(move |progress| {
            heard.store(progress.fraction.to_bits(), Ordering::Relaxed);
        });
        let (of, with, by) = (model.clone(), settings.clone(), control.clone());
        let task = worker().spawn(async move { Fit::new(of, with, &by) });
        self.job = Some(Job { model, settings, control, done, started: Instant::now(), task });
    }
}

/// Starts, cancels and finishes jobs, so that the hulls follow the settings.
pub fn follow_settings(mut tuning: ResMut<Tuning>, library: Res<Library>, settings: Res<Settings>) {
    let Some(model) = &library.current else { return };
    if let Some(job) = &mut tuning.bypass_change_detection().job {
        let is_wanted = Arc::ptr_eq(&job.model, model) && job.settings == *settings;
        if !is_wanted {
            job.control.cancel();
        }
        let Some(result) = block_on(poll_once(&mut job.task)) else { return };
        let finished = (job.model.clone(), job.settings.clone());
        tuning.job = None;
        // A job that was overtaken may have finished all the same: newer hulls than those shown.
        match result {
            Ok(fit) => {
                tuning.error = None;
                tuning.fit = Some(Arc::new(fit));
                tuning.finished = Some(finished);
            }
            Err(error) if is_wanted => {
                tuning.error = Some(error);
                tuning.finished = Some(finished);
            }
            Err(_) => {}
        }
    }
    if !tuning.is_current(Some(model), &settings) {
        tuning.start(model.clone(), settings.clone());
    }
}
