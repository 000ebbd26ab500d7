//! `cargo lab paper`: the experiments of section 4 of the paper, from today's version.

mod ablations;
mod comparisons;
mod pictures;
mod readings;
mod table1;
mod unity;

use std::path::PathBuf;
use std::time::Instant;

use hullwright::surface::{SurfaceParameters, SurfaceReport, decompose};
use hullwright::{Control, Decomposition, MeshView, TriangleMesh};
use hullwright_formats::read_mesh;

use crate::harness::describe;
use crate::report::{Report, Table, create_folder};
use crate::shapes::bounds;
use crate::terminal::{Failure, print};
use crate::tools::data_folder::{DataFolder, PaperRow};
use crate::tools::meshes;

/// Repeat the experiments of the paper's section 4: tables, plots, and its figures as pictures
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv, meshes/princeton and meshes/common/spot.obj
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// Only every tenth of the Princeton meshes where all are compared
    #[arg(long)]
    quick: bool,
}

/// Of Princeton's meshes these numbers are cups.
const CUPS: std::ops::RangeInclusive<u32> = 21..=40;

/// A mesh of the experiments.
#[derive(Clone)]
struct Model {
    name: String,
    mesh: TriangleMesh,
    diagonal: f64,
}

impl Model {
    fn new(name: &str, mesh: TriangleMesh) -> Self {
        let (low, high) = bounds(&mesh.positions);
        Self { name: name.to_owned(), diagonal: low.distance(high), mesh }
    }

    fn read(folder: &DataFolder, name: &str) -> Result<Self, Failure> {
        Ok(Self::new(name, read_mesh(folder.mesh(name))?.mesh))
    }

    fn is_cup(&self) -> bool {
        let number = self.name.rsplit('/').next().and_then(|file| file.split('.').next());
        number.and_then(|number| number.parse().ok()).is_some_and(|number| CUPS.contains(&number))
    }
}

/// A row of the paper's Table 1, and its mesh.
struct Paper {
    row: PaperRow,
    model: Model,
}

/// A decomposition on one thread, and its seconds.
struct Found {
    decomposition: Decomposition<SurfaceReport>,
    seconds: f64,
}

/// A figure of a decomposition, for tables.
type Figure = (&'static str, fn(&Found) -> f64);

fn decomposed<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &SurfaceParameters,
) -> Result<Found, Failure> {
    let (control, start) = (Control::new().with_parallel(false), Instant::now());
    let decomposition = decompose(mesh, parameters, &control)?;
    Ok(Found { decomposition, seconds: start.elapsed().as_secs_f64() })
}

fn all_of(models: &[Model], parameters: &SurfaceParameters) -> Result<Vec<Found>, Failure> {
    models.iter().map(|model| decomposed(&model.mesh, parameters)).collect()
}

/// The paper's parameters, with some changed.
fn paper_with(change: impl FnOnce(&mut SurfaceParameters)) -> SurfaceParameters {
    let mut parameters = SurfaceParameters::paper();
    change(&mut parameters);
    parameters
}

/// HACD in the paper's frame.
fn hacd_of(threshold: f64) -> SurfaceParameters {
    paper_with(|one| one.concavity_threshold = Some(threshold))
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let folder = DataFolder(arguments.folder.clone());
    create_folder(&arguments.output)?;
    let mut papers = Vec::new();
    for row in folder.table1()? {
        papers.push(Paper { model: Model::read(&folder, &row.mesh)?, row });
    }
    let mut princeton = Vec::new();
    for mesh in meshes::find(&[folder.mesh("princeton")])? {
        princeton.push(Model::new(&mesh.name, read_mesh(&mesh.path)?.mesh));
    }
    let cups: Vec<Model> = princeton.iter().filter(|model| model.is_cup()).cloned().collect();
    if arguments.quick {
        princeton = princeton.into_iter().step_by(10).collect();
    }
    let spot = Model::read(&folder, "common/spot.obj")?;
    let models: Vec<Model> = papers.iter().map(|paper| paper.model.clone()).collect();

    let done = |table: Table| -> Result<Table, Failure> {
        print(&format!("{:>6.1} s  {}", start.elapsed().as_secs_f64(), table.title))?;
        Ok(table)
    };
    let mut levels = readings::Levels::new();
    let mut tables = vec![done(table1::ten(&papers, &mut levels)?)?];
    tables.push(done(readings::table(&papers, &mut levels)?)?);
    let of_princeton = all_of(&princeton, &SurfaceParameters::paper())?;
    tables.push(done(table1::all(&of_princeton))?);
    tables.push(done(comparisons::hacd(&princeton, &of_princeton)?)?);
    tables.push(done(comparisons::hollow(&cups)?)?);
    tables.push(done(comparisons::more_pieces(&papers)?)?);
    let (of_p_and_r, plots) = ablations::thresholds_and_resolutions(&papers, &models)?;
    for table in of_p_and_r {
        tables.push(done(table)?);
    }
    tables.push(done(ablations::angular_threshold(&princeton)?)?);
    tables.push(done(ablations::parameters(&models)?)?);
    tables.push(done(ablations::exponents(&of_princeton))?);
    tables.push(done(ablations::spot(&spot)?)?);
    pictures::draw(&arguments.output, &models, &cups, &spot)?;
    let mut words = vec![
        "Section 4 of the paper, made by `cargo lab paper`. Times are of one thread, in seconds, without \
         reading files. Costs are averages of the paper's equation (3)."
            .to_owned(),
    ];
    let figures =
        pictures::FIGURES.iter().map(|(file, note)| format!("![{note}]({file})\n\n{note}."));
    words.extend(figures);
    let (title, name) = ("The paper's experiments", "paper-experiments");
    let report = Report { title, name, words, tables, plots, machine: describe() };
    Ok(report.write(&arguments.output)?)
}
