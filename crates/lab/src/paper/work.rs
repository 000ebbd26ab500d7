//! What the experiments are made of: single runs, and the lists of meshes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::{HullShape, MeasureOptions, Measurement, measure};
use hullwright::{Control, Hull, Parameters, Stage, SurfaceParameters};

use crate::bench::caps::Caps;
use crate::bench::methods::Run;
use crate::bench::peers::Peers;
use crate::bench::plan::{self, Mesh};
use crate::bench::record::{Judged, Worked};
use crate::bench::worker::median;
use crate::bench::{blank_row, execute};
use crate::hacd::{self, HacdParameters};

/// What every experiment may use.
pub struct Shared {
    pub folder: PathBuf,
    pub table1: Vec<PaperRow>,
    pub princeton: Vec<Mesh>,
    /// Some of them, for what takes long.
    pub some_of_princeton: Vec<Mesh>,
    pub peers: Peers,
    pub scratch: PathBuf,
    pub caps: Caps,
}

/// A row of the paper's Table 1.
pub struct PaperRow {
    pub model: String,
    pub mesh: String,
    /// Pieces, average pieces, seconds, cost, p, r, polygons, initial polygons.
    pub figures: [String; 8],
}

impl PaperRow {
    pub fn name(&self) -> String {
        format!("{} ({})", self.model, self.mesh)
    }
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

/// The rows of Table 1, with the meshes that they must be.
pub fn table1(folder: &Path) -> Result<Vec<PaperRow>, String> {
    let path = folder.join("paper/table1.tsv");
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let row = |line: &str| {
        let cells: Vec<String> = line.split('\t').map(str::to_owned).collect();
        let figures = <[String; 8]>::try_from(cells.get(3..11)?.to_vec()).ok()?;
        Some(PaperRow { model: cells[0].clone(), mesh: cells[1].clone(), figures })
    };
    text.lines()
        .skip(1)
        .map(|line| row(line).ok_or_else(|| format!("{}: a broken row", path.display())))
        .collect()
}

impl Shared {
    pub fn read(&self, mesh: &str) -> Result<MeshFile, String> {
        read_mesh(self.folder.join("meshes").join(mesh)).map_err(|error| error.to_string())
    }

    /// The ten meshes of Table 1.
    pub fn ten(&self) -> Result<Vec<(String, MeshFile)>, String> {
        self.table1.iter().map(|row| Ok((row.name(), self.read(&row.mesh)?))).collect()
    }

    /// The meshes of a kind, by the list of sources.
    pub fn of_kind(&self, kind: &str) -> Result<Vec<String>, String> {
        let path = self.folder.join("meshes/SOURCES.tsv");
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let rows = text.lines().filter_map(|line| line.split_once('\t'));
        let rows = rows.filter(|(_, origin)| origin.split(';').next() == Some(kind));
        Ok(rows.map(|(mesh, _)| mesh.to_owned()).collect())
    }

    /// A run in a process of its own.
    pub fn apart(&self, run: &Run, mesh: &str) -> Result<Option<(Worked, Judged)>, String> {
        let path = self.folder.join("meshes").join(mesh);
        let mut mesh_list = plan::meshes(&[path])?;
        let Some(mut mesh_file) = mesh_list.pop() else { return Ok(None) };
        mesh_file.name = mesh.to_owned();
        let mut row = blank_row(&mesh_file, run, String::new());
        execute(run, &mesh_file, Some(&self.peers), self.caps, &self.scratch, &mut row)?;
        Ok(row.done().map(|(worked, judged)| (worked.clone(), judged.clone())))
    }

    /// HACD with a deadline; `None` where that passed.
    pub fn hacd(
        &self,
        mesh: &MeshFile,
        threshold: f64,
        surface: &SurfaceParameters,
    ) -> Result<Option<Found>, String> {
        let mut parameters = HacdParameters::default();
        parameters.concavity_threshold = threshold;
        parameters.surface = surface.clone();
        parameters.parallel = false;
        let control = Control::new().with_deadline(Instant::now() + self.caps.time);
        let start = Instant::now();
        let found = hacd::decompose(&mesh.positions, &mesh.triangles, &parameters, &control);
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
pub fn surface(mesh: &MeshFile, surface: &SurfaceParameters) -> Result<Found, String> {
    let mut parameters = Parameters::paper();
    parameters.method = hullwright::Method::Surface;
    parameters.surface = surface.clone();
    parameters.parallel = false;
    let (mut seconds, mut search) = (Vec::new(), Vec::new());
    loop {
        let start = Instant::now();
        let found =
            hullwright::decompose(&mesh.positions, &mesh.triangles, &parameters, &Control::new())
                .map_err(|error| error.to_string())?;
        seconds.push(start.elapsed().as_secs_f64());
        let times = found.report.times.iter().filter(|time| time.stage == Stage::Search);
        search.push(times.map(|time| time.seconds).sum());
        if seconds.len() < REPEATS && seconds[0] < LONG {
            continue;
        }
        let report = found.report.surface.ok_or("the report has no search")?;
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
pub fn judge(mesh: &MeshFile, hulls: &[Hull]) -> Result<Measurement, String> {
    let shapes: Vec<HullShape<'_>> = hulls.iter().map(HullShape::from).collect();
    measure(&mesh.positions, &mesh.triangles, &shapes, &MeasureOptions::default())
        .map_err(|error| error.to_string())
}
