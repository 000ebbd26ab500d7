//! `hullwright decompose`: a mesh into convex hulls.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::hulls_format::HullsFile;
use hullwright::{Decomposition, Error, Hull, MeshView, MethodReport, Parameters};
use hullwright_cli::terminal::{Failure, count, print, print_json};
use hullwright_formats::{
    HullFormat, check_output, is_hulls_file, read_mesh, write_file, write_hulls,
};

use crate::arguments::{
    ParameterArguments, SURFACE_HEADING, ThreadArguments, Uses, check_is_surface, check_not_input,
    mesh_help,
};
use crate::progress::{LateBar, waiting};
use crate::report;

/// Decompose a mesh into convex hulls
#[derive(clap::Args)]
#[command(
    after_help = "Protrusion is how far hulls reach outside the solid, uncovered how far the \
    surface reaches outside all hulls; both are verified."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// Write hulls: .obj, .glb (coloured) or .hulls (see `bake`)
    #[arg(short, long, value_name = "OUT", value_parser = parse_output)]
    output: Option<PathBuf>,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,

    /// Show each resolution and threshold
    #[arg(long, help_heading = SURFACE_HEADING)]
    search: bool,
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    if HullFormat::from_path(text).is_some() || is_hulls_file(text) {
        Ok(PathBuf::from(text))
    } else {
        Err(format!("hulls are written as {}, or as .hulls", HullFormat::suffix_list()))
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { mesh, output, json, threads, parameters, search } = arguments;
    let method = parameters.checked(&Uses::default())?.method;
    if *search {
        check_is_surface(&method)?;
    }
    if let Some(output) = output {
        check_output(output)?;
        check_not_input(output, mesh)?;
    }
    let file = waiting("reading", || read_mesh(mesh))?;
    let pool = threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(threads.is_parallel());
    let start = Instant::now();
    let result = pool.install(|| method.decompose(&file, &control));
    let seconds = start.elapsed().as_secs_f64();
    bar.finish();
    let decomposition = result.map_err(|error| format!("{}: {error}", mesh.display()))?;
    match output {
        Some(output) if is_hulls_file(output) => {
            let name = mesh.file_stem().unwrap_or_default().to_string_lossy();
            let view = (&file).into();
            let hulls = hulls_file(name, view, &decomposition, &method.solid(), DEFAULT_DENSITY)?;
            let shares = file.parts.shares(view, &decomposition.hulls)?;
            let hulls = hulls.with_parts(file.parts.list.clone(), shares);
            write_file(output, &hulls.to_bytes()?)?;
        }
        Some(output) => waiting("writing", || write_hulls(output, &decomposition.hulls))?,
        None => {}
    }
    if *json {
        return print_json(&report::json(mesh, &file, &decomposition, seconds, *search)?);
    }
    if let (true, Some(surface)) = (*search, decomposition.report.surface()) {
        print(&report::search(surface))?;
    }
    print(&report::summary(&file.notes, &decomposition, seconds))?;
    match output {
        Some(output) => print(&wrote(output, &decomposition.hulls)),
        None => Ok(()),
    }
}

/// Mass per cubed unit. With 1 the mass is the volume, which any density can be multiplied with.
pub const DEFAULT_DENSITY: f64 = 1.0;

/// What a `.hulls` file holds of a mesh. `solid` describes what its mass is computed from.
pub fn hulls_file(
    name: impl Into<String>,
    mesh: MeshView<'_>,
    decomposition: &Decomposition<MethodReport>,
    solid: &Parameters,
    density: f64,
) -> Result<HullsFile, Error> {
    let hulls = &decomposition.hulls;
    let properties = hullwright::mass_properties_with(mesh, hulls, density, solid)?;
    Ok(HullsFile::new(name, decomposition).with_mass_properties(properties))
}

/// Says that hulls were written to a file.
pub fn wrote(output: &Path, hulls: &[Hull]) -> String {
    let vertices = count(report::vertices(hulls), "vertex", "vertices");
    format!("wrote {}: {}, {vertices}", output.display(), count(hulls.len(), "hull", "hulls"))
}
