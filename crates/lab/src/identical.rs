//! `cargo lab identical`: whether two builds of the command write the same hulls.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::terminal::{Failure, print};
use crate::tools::meshes;

/// Decompose every mesh below folders with two builds of the command, and compare what they write
///
/// Ends with exit code 1 where a byte differs, or where one build refuses a mesh that the other
/// takes.
#[derive(clap::Args)]
pub struct Arguments {
    /// A build of the command `hullwright`
    #[arg(value_name = "OLD")]
    old: PathBuf,

    /// Another build
    #[arg(value_name = "NEW")]
    new: PathBuf,

    #[arg(help = meshes::folders_help(), required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
}

/// Both methods: what they share is not all that they have.
const METHODS: [&str; 2] = ["bounded", "surface"];

/// What one build made of a mesh.
#[derive(PartialEq)]
enum Written {
    Hulls(Vec<u8>),
    /// The exit code; none where a signal ended it.
    Refused(Option<i32>),
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { old, new, folders } = arguments;
    let scratch = tempfile::tempdir().map_err(|error| format!("no scratch folder: {error}"))?;
    let (same, refused, different) = compare(old, new, folders, scratch.path())?;
    print(&format!("{same} the same, {refused} refused by both, {different} different"))?;
    match different {
        0 => Ok(()),
        _ => Err("the builds differ".into()),
    }
}

/// How many results are the same, refused by both, and different.
fn compare(
    old: &Path,
    new: &Path,
    folders: &[PathBuf],
    scratch: &Path,
) -> Result<(usize, usize, usize), Failure> {
    let (mut same, mut refused, mut different) = (0, 0, 0);
    for mesh in meshes::find(folders)? {
        for method in METHODS {
            let written = |program, name| write(program, &mesh.path, method, &scratch.join(name));
            match (written(old, "old.obj")?, written(new, "new.obj")?) {
                (Written::Refused(a), Written::Refused(b)) if a == b => refused += 1,
                (a, b) if a == b => same += 1,
                _ => {
                    different += 1;
                    print(&format!("{}, {method}: different", mesh.name))?;
                }
            }
        }
    }
    Ok((same, refused, different))
}

fn write(program: &Path, mesh: &Path, method: &str, output: &Path) -> Result<Written, String> {
    let mut command = Command::new(program);
    command.arg("decompose").arg(mesh).args(["--method", method, "--output"]).arg(output);
    let Output { status, .. } =
        command.output().map_err(|error| format!("{}: {error}", program.display()))?;
    if !status.success() {
        return Ok(Written::Refused(status.code()));
    }
    let hulls = std::fs::read(output).map_err(|error| format!("{}: {error}", output.display()))?;
    Ok(Written::Hulls(hulls))
}
