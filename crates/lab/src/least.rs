//! `cargo lab least`: how near each method is to the least number of hulls that its own errors
//! allow.

use std::path::PathBuf;

use hullwright::hulls_format::VerifiedErrors;
use hullwright::measure::{MeasureOptions, verify};
use hullwright::{Control, MeshView, Parameters, TriangleMesh, decompose, least_hulls};
use hullwright_formats::{read_hulls, read_mesh};
use rayon::prelude::*;

use crate::report::{NOTHING, Table, number};
use crate::statistics::median;
use crate::terminal::{Failure, print};
use crate::tools::data_folder::DataFolder;
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::{Run, Tool, bounded};
use crate::tools::vhacd;

/// Compare hulls with the least number that is possible with the same errors
///
/// For each mesh those of the default method, of V-HACD and of other tools' files. A result with
/// fewer hulls than possible is an error of the lower bound: the command fails.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(required = true, value_name = "DIR", help = meshes::folders_help())]
    folders: Vec<PathBuf>,

    /// Bounds of the default method, as fractions of the diagonal
    #[arg(long, value_delimiter = ',', value_name = "BOUNDS", default_values_t = [0.01, 0.02, 0.04])]
    bounds: Vec<f64>,

    /// A folder with peers/results.tsv and cuacd.tsv, and hulls in peers/coacd and cuacd
    #[arg(long, value_name = "DIR")]
    external_tools: Option<PathBuf>,
}

/// A result, and how few hulls are possible with its errors.
struct Compared {
    mesh: String,
    method: String,
    hulls: usize,
    least: usize,
}

impl Compared {
    fn ratio(&self) -> f64 {
        self.hulls as f64 / self.least as f64
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let meshes = meshes::find(&arguments.folders)?;
    let folder = arguments.external_tools.clone().map(DataFolder);
    let found = meshes.par_iter().map(|mesh| {
        let found = of_mesh(mesh, &arguments.bounds, folder.as_ref());
        let found = found.map_err(|error| Failure::Work(format!("{}: {error}", mesh.name)))?;
        for Compared { mesh, method, hulls, least } in &found {
            print(&format!("{mesh:<48} {method:<12} {hulls:>5} hulls, at least {least:>4}"))?;
        }
        Ok::<_, Failure>(found)
    });
    let found: Vec<Vec<Compared>> = found.collect::<Result<_, Failure>>()?;
    let found: Vec<Compared> = found.into_iter().flatten().collect();
    print(&format!("\n{}", table(&found).to_markdown()))?;
    let below: Vec<&str> =
        found.iter().filter(|row| row.hulls < row.least).map(|row| row.mesh.as_str()).collect();
    match below.is_empty() {
        true => Ok(()),
        false => Err(format!("fewer hulls than possible: {}", below.join(", ")).into()),
    }
}

/// The results of all methods on a mesh.
fn of_mesh(
    mesh: &Mesh,
    bounds: &[f64],
    folder: Option<&DataFolder>,
) -> Result<Vec<Compared>, hullwright::Error> {
    let control = Control::new();
    let file = read_mesh(&mesh.path)?.mesh;
    let mut found = Vec::new();
    let mut add = |method: String, hulls, errors, parameters: &Parameters| {
        let least = least_hulls(&file, errors, parameters, &control)?.hulls;
        found.push(Compared { mesh: mesh.name.clone(), method, hulls, least });
        Ok::<(), hullwright::Error>(())
    };
    for &bound in bounds {
        let parameters = bounded(bound);
        let made = decompose(&file, &parameters, &control)?;
        // No hull is farther than the bound, or than was verified where a limit forced more.
        let protrusion = made.report.protrusion_max.max(made.report.bound);
        let errors = VerifiedErrors::new(protrusion, made.report.uncovered_max);
        add(format!("{} %", 100.0 * bound), made.hulls.len(), errors, &parameters)?;
    }
    let mut other = |method: &str, hulls: &[TriangleMesh]| {
        let options = MeasureOptions::default();
        let views: Vec<MeshView<'_>> = hulls.iter().map(TriangleMesh::view).collect();
        let verified = verify(&file, &views, &options, &control)?;
        add(method.into(), hulls.len(), verified.in_units(), &Parameters::default())
    };
    if let Some(parameters) = vhacd::parameters(&Run::VHACD_DEFAULT) {
        let hulls = vhacd::decompose(file.view(), &parameters);
        other("vhacd", &hulls.into_iter().map(|hull| hull.mesh).collect::<Vec<_>>())?;
    }
    for tool in Tool::ALL {
        let path = folder.map(|folder| folder.hulls(tool, &mesh.name));
        if let Some(path) = path.filter(|path| path.is_file()) {
            let hulls = read_hulls(path)?;
            other(tool.name(), &hulls.into_iter().map(|hull| hull.mesh).collect::<Vec<_>>())?;
        }
    }
    Ok(found)
}

/// A row for each folder and method, and one for all folders.
fn table(found: &[Compared]) -> Table {
    let header = [
        "folder",
        "method",
        "meshes",
        "hulls",
        "at least",
        "over it, in sum",
        "in the median",
        "equal",
        "below",
    ];
    let note = "The least number of hulls that is possible with the errors of each result: for the default method \
                its bound and the uncovered distance that it verified, for others both verified errors.";
    let mut table = Table::new("Hulls over the least number possible", note, &header);
    let mut methods: Vec<&str> = Vec::new();
    let mut folders: Vec<&str> = Vec::new();
    for row in found {
        for (list, name) in
            [(&mut methods, row.method.as_str()), (&mut folders, meshes::folder(&row.mesh))]
        {
            if !list.contains(&name) {
                list.push(name);
            }
        }
    }
    let groups = folders.into_iter().map(Some).chain([None]);
    for folder in groups {
        for &method in &methods {
            let is_own = |row: &&Compared| {
                row.method == method
                    && folder.is_none_or(|folder| meshes::folder(&row.mesh) == folder)
            };
            let rows: Vec<&Compared> = found.iter().filter(is_own).collect();
            if rows.is_empty() {
                continue;
            }
            let sum = |of: fn(&Compared) -> usize| rows.iter().map(|row| of(row)).sum::<usize>();
            let (hulls, least) = (sum(|row| row.hulls), sum(|row| row.least));
            let count = |is: fn(&Compared) -> bool| rows.iter().filter(|row| is(row)).count();
            table.rows.push(vec![
                folder.unwrap_or("all").into(),
                method.into(),
                rows.len().to_string(),
                hulls.to_string(),
                least.to_string(),
                if least > 0 { number(hulls as f64 / least as f64) } else { NOTHING.into() },
                number(median(rows.iter().map(|row| row.ratio()).collect())),
                count(|row| row.hulls == row.least).to_string(),
                count(|row| row.hulls < row.least).to_string(),
            ]);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_a_row_for_each_folder_and_method_and_counts_what_is_below() {
        let row = |mesh: &str, method: &str, hulls, least| Compared {
            mesh: mesh.into(),
            method: method.into(),
            hulls,
            least,
        };
        let found = [
            row("a/1.off", "2 %", 6, 3),
            row("a/2.off", "2 %", 4, 4),
            row("b/1.off", "2 %", 2, 3),
            row("b/1.off", "vhacd", 9, 3),
        ];
        let table = table(&found);
        let rows: Vec<String> = table.rows.iter().map(|row| row.join(" ")).collect();
        assert_eq!(rows[0], "a 2 % 2 10 7 1.43 1.50 1 0");
        assert_eq!(rows[1], "b 2 % 1 2 3 0.667 0.667 0 1");
        assert_eq!(rows[3], "all 2 % 3 12 10 1.20 1.00 1 1");
        assert_eq!(rows.len(), 5);
    }
}
