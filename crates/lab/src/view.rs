//! `cargo lab view`: a page with ours, V-HACD's and CoACD's hulls side by side.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::terminal::{Failure, print, time};
use crate::viewer::{HullSet, Page, hulls_of};
use hullwright::io::{MeshFile, NamedMesh, read_hulls, read_mesh};
use hullwright::{Control, Error, Hull, MergeTree, Parameters, decompose};

use crate::harness::Limits;
use crate::tools::data_folder::DataFolder;
use crate::tools::external_tools::ExternalTools;
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::Run;
use crate::tools::vhacd;

/// Write a page that shows ours, V-HACD's and CoACD's hulls of a mesh side by side
///
/// CoACD's hulls come from files, where the folder of external tools has them, or from its script.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::files_help())]
    mesh: PathBuf,

    /// The page
    #[arg(short, long, value_name = "PAGE")]
    output: PathBuf,

    /// A folder with tools/peers.py and peers/results.tsv, for CoACD
    #[arg(long, value_name = "DIR")]
    external_tools: Option<PathBuf>,

    /// The Python that has the packages coacd and trimesh
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
}

/// Longest time and most memory of CoACD's run.
const LIMITS: Limits = Limits { time: Duration::from_secs(300), memory: 4 << 30 };

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let found = meshes::find(std::slice::from_ref(&arguments.mesh))?;
    let Some(mesh) = found.first() else { return Err("there is no mesh".into()) };
    let tools = arguments.external_tools.clone();
    let tools = tools.map(|folder| ExternalTools::new(DataFolder(folder), &arguments.python));
    let control = Control::new();
    let file = read_mesh(&mesh.path)?;
    let mut page = ComparisonPage::new(&mesh.name, &file, &control)?;
    page.add_ours()?;
    page.add_vhacd()?;
    match &tools {
        Some(tools) => page.add_coacd(mesh, tools)?,
        None => print("without --external-tools there are no hulls of CoACD")?,
    }
    page.write(&arguments.output)
}

/// A page about one mesh with the hulls of several tools.
pub struct ComparisonPage<'a> {
    file: &'a MeshFile,
    page: Page<'a>,
    parameters: Parameters,
    control: &'a Control,
}

impl<'a> ComparisonPage<'a> {
    pub fn new(name: &str, file: &'a MeshFile, control: &'a Control) -> Result<Self, Error> {
        let parameters = Parameters::default();
        let page = Page::new(name, file, &parameters, control)?.objects(&file.objects);
        Ok(Self { file, page, parameters, control })
    }

    /// The default method with its defaults.
    pub fn add_ours(&mut self) -> Result<(), Error> {
        let start = Instant::now();
        let result = decompose(self.file, &self.parameters, self.control)?;
        let seconds = start.elapsed().as_secs_f64();
        let name = format!("Hullwright, {}", self.parameters.max_error);
        self.add(&name, &result.hulls, seconds)
    }

    /// Parry's V-HACD with its defaults.
    pub fn add_vhacd(&mut self) -> Result<(), Error> {
        let Some(parameters) = vhacd::parameters(&Run::VHACD_DEFAULT) else { return Ok(()) };
        let start = Instant::now();
        let hulls = vhacd::decompose(self.file.into(), &parameters);
        let seconds = start.elapsed().as_secs_f64();
        self.add("V-HACD in Parry", &hulls_of(&hulls), seconds)
    }

    fn add_coacd(&mut self, mesh: &Mesh, tools: &ExternalTools) -> Result<(), Failure> {
        match coacd(mesh, tools)? {
            Ok((hulls, seconds)) => Ok(self.add("CoACD", &hulls_of(&hulls), seconds)?),
            Err(reason) => print(&format!("without CoACD: {reason}")),
        }
    }

    fn add(&mut self, name: &str, hulls: &[Hull], seconds: f64) -> Result<(), Error> {
        if hulls.is_empty() {
            eprintln!("{name} returned no hulls");
            return Ok(());
        }
        let tree = MergeTree::from_hulls(self.file, hulls, &self.parameters, self.control)?;
        let set = HullSet::new(name, hulls).tree(&tree).fact("time", time(seconds));
        self.page.add(set, self.control)
    }

    pub fn write(&self, output: &Path) -> Result<(), Failure> {
        self.page.write(output)?;
        print(&format!("wrote {}", output.display()))
    }
}

/// CoACD's hulls and seconds: those of a file, or else of the script; or why there are none.
fn coacd(
    mesh: &Mesh,
    tools: &ExternalTools,
) -> Result<Result<(Vec<NamedMesh>, f64), String>, Failure> {
    let files = tools.folder.coacd_hulls(&mesh.name);
    if let (Some(seconds), true) = (tools.coacd_seconds(&mesh.name), files.is_file()) {
        return Ok(Ok((read_hulls(&files)?, seconds)));
    }
    if let Some(missing) = tools.missing().into_iter().next() {
        return Ok(Err(missing));
    }
    let scratch = tempfile::Builder::new().suffix(".obj").tempfile();
    let scratch = scratch.map_err(|error| format!("no temporary file: {error}"))?;
    let run = Run::Coacd { threshold: COACD_THRESHOLD };
    match tools.run(&run, &mesh.name, &mesh.path, scratch.path(), LIMITS)? {
        Ok((seconds, _)) => Ok(Ok((read_hulls(scratch.path())?, seconds))),
        Err((_, reason)) => Ok(Err(reason)),
    }
}

/// CoACD's default.
const COACD_THRESHOLD: f64 = 0.05;
