//! What the experiments are made of: single runs, and the lists of meshes.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright::surface::{self, SurfaceParameters};
use hullwright::{Control, Hull, Stage};

use crate::hacd::{self, HacdParameters};
use crate::runs::data_folder::{DataFolder, PaperRow};
use crate::runs::execute::{blank_row, execute};
use crate::runs::external_tools::ExternalTools;
use crate::runs::judge::{Judged, judge};
use crate::runs::limits::Limits;
use crate::runs::meshes::{self, Mesh};
use crate::runs::methods::Run;
use crate::runs::record::Worked;
use crate::statistics::median;

/// What every experiment may use.
pub struct Shared {
    pub folder: DataFolder,
    pub table1: Vec<PaperRow>,
    pub princeton: Vec<Mesh>,
    /// Some of them, for what takes long.
    pub some_of_princeton: Vec<Mesh>,
    pub tools: ExternalTools,
    pub scratch: PathBuf,
    pub limits: Limits,
}

/// What a run of the paper's method or of HACD gave.
pub struct Found {
    pub hulls: Vec<Hull>,
    pub pieces: usize,
    pub average_pieces: f64,
    pub cost: f64,
    pub planar_threshold: Option<f64>,
    pub resolution: usize,
    pub polygons: usize,
    pub initial_polygons: usize,
    /// Median of a few repeats.
    pub seconds: f64,
    /// Of those the search for groups.
    pub search_seconds: f64,
}

/// Short runs are repeated this often.
const REPEATS: usize = 3;
/// Runs longer than this are not repeated, in seconds.
const LONG: f64 = 2.0;

impl Shared {
    pub fn read(&self, mesh: &str) -> Result<MeshFile, String> {
        read_mesh(self.folder.mesh(mesh)).map_err(|error| error.to_string())
    }

    /// The ten meshes of Table 1.
    pub fn ten(&self) -> Result<Vec<(String, MeshFile)>, String> {
        self.table1.iter().map(|row| Ok((row.name(), self.read(&row.mesh)?))).collect()
    }

    /// A run in a process of its own.
    pub fn apart(&self, run: &Run, mesh: &str) -> Result<Option<(Worked, Judged)>, String> {
        let mut found = meshes::find(&[self.folder.mesh(mesh)])?;
        let Some(mut mesh_file) = found.pop() else { return Ok(None) };
        mesh_file.name = mesh.to_owned();
        let mut row = blank_row(&mesh_file, run, String::new());
        execute(run, &mesh_file, Some(&self.tools), self.limits, &self.scratch, &mut row)?;
        Ok(row.done().map(|(worked, judged)| (worked.clone(), judged.clone())))
    }

    /// HACD with a deadline; `None` where that passed.
    pub fn hacd(
        &self,
        mesh: &MeshFile,
        threshold: f64,
        surface: &SurfaceParameters,
    ) -> Result<Option<Found>, String> {
        let parameters =
            HacdParameters { concavity_threshold: threshold, surface: surface.clone() };
        let control =
            Control::new().with_parallel(false).with_deadline(Instant::now() + self.limits.time);
        let start = Instant::now();
        let found = hacd::decompose(mesh, &parameters, &control);
        let found = match found {
            Err(hullwright::Error::DeadlineExceeded) => return Ok(None),
            other => other.map_err(|error| error.to_string())?,
        };
        let search = found.times.iter().filter(|(stage, _)| *stage == Stage::Search);
        Ok(Some(Found {
            pieces: found.hulls.len(),
            average_pieces: found.average_pieces,
            cost: found.cost,
            planar_threshold: None,
            resolution: found.resolution,
            polygons: found.groups.len(),
            initial_polygons: found.initial_polygons,
            seconds: start.elapsed().as_secs_f64(),
            search_seconds: search.map(|(_, seconds)| seconds).sum(),
            hulls: found.hulls,
        }))
    }
}

/// The paper's method.
pub fn surface(mesh: &MeshFile, parameters: &SurfaceParameters) -> Result<Found, String> {
    let serial = Control::new().with_parallel(false);
    let (mut seconds, mut search) = (Vec::new(), Vec::new());
    loop {
        let start = Instant::now();
        let found =
            surface::decompose(mesh, parameters, &serial).map_err(|error| error.to_string())?;
        seconds.push(start.elapsed().as_secs_f64());
        let times = found.run.times.iter().filter(|time| time.stage == Stage::Search);
        search.push(times.map(|time| time.seconds).sum());
        if seconds.len() < REPEATS && seconds[0] < LONG {
            continue;
        }
        let report = found.report;
        return Ok(Found {
            hulls: found.hulls,
            pieces: report.pieces,
            average_pieces: report.average_pieces,
            cost: report.cost,
            planar_threshold: Some(report.planar_threshold),
            resolution: report.resolution,
            polygons: report.polygons,
            initial_polygons: report.initial_polygons,
            seconds: median(seconds),
            search_seconds: median(search),
        });
    }
}

/// Judges hulls as the benchmark does.
pub fn judge_default(mesh: &MeshFile, hulls: &[Hull]) -> Result<Judged, String> {
    judge(mesh.mesh.view(), hulls, &MeasureOptions::default()).map_err(|error| error.to_string())
}
