//! `cargo lab paper`: the paper's own experiments (its section 4), on the meshes that can be told.
//!
//! The paper numbers its models within a set of its own; only those of its Table 1 can be told by
//! their triangle counts. Figures that show other models are done on the meshes of their kind.

mod ablation;
mod comparison;
mod figures;
mod work;

use hullwright_cli::terminal::{Failure, print};
use std::path::PathBuf;
use std::time::Duration;

use work::Shared;

use crate::report::html_report::{Report, create_folder};
use crate::report::table::Table;
use crate::runs::data_folder::DataFolder;
use crate::runs::external_tools::ExternalTools;
use crate::runs::limits::Limits;
use crate::runs::{machine, meshes};

/// Repeat the experiments of the paper that the surface method comes from
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv, meshes/princeton, meshes/SOURCES.tsv and
    /// meshes/common/spot.obj
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// The Python that has the packages vhacdx and trimesh
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,

    /// Run HACD only on every so manyth of the Princeton meshes
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: usize,

    /// Longest time of one run of HACD or V-HACD, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    time_limit: u64,
}

type Experiment = fn(&Shared) -> Result<Vec<Table>, String>;

/// Most memory of a run of V-HACD, in bytes: as in the benchmark.
const MEMORY_LIMIT: u64 = 4 << 30;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let output = &arguments.output;
    create_folder(output)?;
    let limits = Limits { time: Duration::from_secs(arguments.time_limit), memory: MEMORY_LIMIT };
    let folder = DataFolder(arguments.folder.clone());
    let meshes = meshes::find(&[folder.mesh("princeton")])?;
    let count = meshes.len() / arguments.every.max(1);
    let shared = Shared {
        table1: folder.table1()?,
        some_of_princeton: meshes::spread(meshes.clone(), count.max(1)),
        princeton: meshes,
        tools: ExternalTools::new(folder.clone(), &arguments.python),
        folder,
        scratch: output.join("external-hulls.obj"),
        limits,
    };
    let experiments: [(&str, Experiment); 10] = [
        ("Table 1", figures::table1),
        ("comparison with HACD", comparison::hacd),
        ("comparison with V-HACD", comparison::vhacd),
        ("hollow shapes", comparison::hollow_shapes),
        ("ablation of p", ablation::planar_threshold),
        ("ablation of r", ablation::resolution),
        ("a", ablation::angular_threshold),
        ("O(N / k)", ablation::complexity),
        ("Q, epsilon and mu", ablation::sensitivity),
        ("Figure 5", figures::spot),
    ];
    let mut tables = Vec::new();
    for (name, experiment) in experiments {
        print(name)?;
        tables.extend(experiment(&shared)?);
    }
    let words = vec![
        "Times are of one thread, in seconds, without reading files. Costs are averages of the \
         paper's equation (3)."
            .into(),
    ];
    let machine = machine::describe(limits);
    let title = "The paper's experiments";
    let report =
        Report { title, words, machine: &machine, plots: &[], tables: &tables, pages: &[] };
    Ok(report.write(output, "paper-experiments")?)
}
