//! `hullwright simplify`: a mesh with few triangles, within a bound of another.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::{Length, SimplifiedSurface, SimplifyParameters, TriangleMesh, simplify_surface};
use hullwright_cli::terminal::{Failure, count, print, print_json, time};
use hullwright_formats::{
    MeshFile, NamedMesh, check_mesh_output, is_mesh_output, mesh_suffix_list, read_mesh,
    write_meshes,
};
use serde_json::{Value, json};

use crate::arguments::{ThreadArguments, check_not_input, mesh_help};
use crate::notes;
use crate::progress::{LateBar, waiting};

/// Make a mesh with few triangles, within a bound of the mesh, for what never moves
#[derive(clap::Args)]
#[command(
    after_help = "No point of the result is farther from the mesh than the bound, and no point of the \
    mesh from the result; both are verified. Triangles wholly within the solid of another closed part \
    can't be touched, and go."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// The bound: 0.5% (default) of the bounding-box diagonal, or 0.02m in the mesh's unit
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = SimplifyParameters::default().max_error,
        hide_default_value = true,
        allow_hyphen_values = true
    )]
    max_error: Length,

    /// Keep triangles that nothing can touch
    #[arg(long)]
    keep_hidden: bool,

    #[arg(short, long, value_name = "OUT", help = output_help(), value_parser = parse_output)]
    output: Option<PathBuf>,

    /// Print one line of JSON instead of lines of text
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    threads: ThreadArguments,
}

fn output_help() -> String {
    format!("Write the result: {}", mesh_suffix_list())
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    match is_mesh_output(text) {
        true => Ok(PathBuf::from(text)),
        false => Err(format!("meshes are written as {}", mesh_suffix_list())),
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { mesh, max_error, keep_hidden, output, json, threads } = arguments;
    let parameters = SimplifyParameters::new(*max_error).with_keep_hidden(*keep_hidden);
    parameters.validate().map_err(|error| Failure::Usage(error.to_string()))?;
    if let Some(output) = output {
        check_mesh_output(output)?;
        check_not_input(output, mesh)?;
    }
    let file = waiting("reading", || read_mesh(mesh))?;
    let pool = threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(threads.is_parallel());
    let start = Instant::now();
    let result = pool.install(|| simplify_surface(&file, parameters, &control));
    let seconds = start.elapsed().as_secs_f64();
    bar.finish();
    let result = result.map_err(|error| format!("{}: {error}", mesh.display()))?;
    if let Some(output) = output {
        waiting("writing", || write_meshes(output, &objects(&file, &result)))?;
    }
    if *json {
        return print_json(&line(mesh, &result, seconds));
    }
    let mut lines = notes::lines(&file.notes);
    lines.extend(text(&result, seconds));
    lines.extend(output.as_deref().map(|output| wrote(output, &result)));
    print(&lines.join("\n"))
}

/// The result as the objects of the file: each triangle belongs to that of the triangle that it
/// remembers.
fn objects(file: &MeshFile, result: &SimplifiedSurface) -> Vec<NamedMesh> {
    let mut triangles: Vec<Vec<[u32; 3]>> = vec![Vec::new(); file.objects.len()];
    let ends = |source: u32| {
        let source = source as usize;
        file.objects.partition_point(|object| object.triangles.end <= source)
    };
    for (&triangle, &source) in result.mesh.triangles.iter().zip(&result.sources) {
        if let Some(own) = triangles.get_mut(ends(source)) {
            own.push(triangle);
        }
    }
    let all = file.objects.iter().zip(triangles).filter(|(_, own)| !own.is_empty());
    all.map(|(object, own)| NamedMesh { name: object.name.clone(), mesh: part(&result.mesh, own) })
        .collect()
}

/// Triangles with vertices of their own.
fn part(mesh: &TriangleMesh, mut triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    for vertex in triangles.as_flattened_mut() {
        *vertex = used.partition_point(|other| *other < *vertex) as u32;
    }
    let positions = used.iter().filter_map(|&vertex| mesh.positions.get(vertex as usize).copied());
    TriangleMesh::new(positions.collect(), triangles)
}

/// Lines of a name and a value.
fn text(result: &SimplifiedSurface, seconds: f64) -> Vec<String> {
    let report = &result.report;
    let share =
        |length: f64| format!("{length:.4} ({:.0} % of the bound)", 100.0 * length / report.bound);
    let rows = [
        ("triangles", format!("{} of {}", report.triangles, report.source_triangles)),
        ("vertices", format!("{} of {}", report.vertices, report.source_vertices)),
        ("hidden triangles", report.hidden_triangles.to_string()),
        ("bound", format!("{:.4}", report.bound)),
        ("result from mesh, at most", share(report.from_source)),
        ("mesh from result, at most", share(report.to_source)),
        ("time", time(seconds)),
    ];
    rows.map(|(name, value)| format!("{name:<25}  {value}")).to_vec()
}

/// Lengths are in the mesh's units, as in all lines of JSON.
fn line(mesh: &Path, result: &SimplifiedSurface, seconds: f64) -> Value {
    let report = &result.report;
    json!({
        "mesh": mesh.display().to_string(),
        "bound": report.bound,
        "from_source": report.from_source,
        "to_source": report.to_source,
        "source_triangles": report.source_triangles,
        "source_vertices": report.source_vertices,
        "triangles": report.triangles,
        "vertices": report.vertices,
        "hidden_triangles": report.hidden_triangles,
        "left_out": {
            "degenerate": report.repairs.degenerate_triangles,
            "duplicate": report.repairs.duplicate_triangles,
            "non_finite": report.repairs.non_finite_triangles,
        },
        "seconds": seconds,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// Says that the result was written to a file.
fn wrote(output: &Path, result: &SimplifiedSurface) -> String {
    let triangles = count(result.mesh.triangles.len(), "triangle", "triangles");
    format!("wrote {}: {triangles}", output.display())
}
