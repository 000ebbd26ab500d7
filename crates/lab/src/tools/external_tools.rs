//! Methods that are no part of this program: CoACD and V-HACD 4 through a script, and hull files
//! that CoACD wrote on another machine.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use super::data_folder::{DataFolder, ToolResult};
use super::methods::Run;
use crate::harness::limits::{self, Limits, Status};

/// Seconds and peak memory of a run of the script, or how it failed.
type Ran = Result<(f64, Option<u64>), (Status, String)>;

/// What there is of other tools.
pub struct ExternalTools {
    pub folder: DataFolder,
    python: String,
    /// The versions of [`PACKAGES`] that Python has; empty where it has none.
    pub versions: [String; 2],
    /// Seconds that CoACD took on another machine, by mesh.
    coacd_seconds: BTreeMap<String, f64>,
}

/// The packages that the script needs for CoACD and for V-HACD.
const PACKAGES: [&str; 2] = ["coacd", "vhacdx"];

impl ExternalTools {
    pub fn new(folder: DataFolder, python: &str) -> Self {
        let has_script = folder.script().is_file();
        let version_of = |package| if has_script { version(python, package) } else { None };
        let versions = PACKAGES.map(|package| version_of(package).unwrap_or_default());
        // Without the table, CoACD's files are left out, which `missing` says.
        let results = folder.tool_results().unwrap_or_default();
        Self {
            versions,
            python: python.to_owned(),
            coacd_seconds: seconds_of_coacd(results),
            folder,
        }
    }

    /// What is not there, in words.
    pub fn missing(&self) -> Vec<String> {
        let versions = PACKAGES.iter().zip(&self.versions);
        let mut missing: Vec<String> = versions
            .filter(|(_, version)| version.is_empty())
            .map(|(package, _)| format!("{} has no package {package}, or no script", self.python))
            .collect();
        if self.coacd_seconds.is_empty() {
            missing.push(format!("{}: no table of CoACD's runs", self.folder.0.display()));
        }
        missing
    }

    /// What can be run on a mesh: CoACD only on those that the table names, for it is slow.
    pub fn runs(&self, mesh: &str) -> Vec<Run> {
        let mut runs = Vec::new();
        let is_named = self.coacd_seconds.contains_key(mesh);
        if is_named && self.folder.coacd_hulls(mesh).is_file() {
            runs.push(Run::CoacdFiles);
        }
        if is_named && !self.versions[0].is_empty() {
            runs.extend(Run::coacd());
        }
        if !self.versions[1].is_empty() {
            runs.extend(Run::vhacd4());
        }
        runs
    }

    /// Seconds that CoACD took on another machine.
    pub fn coacd_seconds(&self, mesh: &str) -> Option<f64> {
        self.coacd_seconds.get(mesh).copied()
    }

    /// Runs the script. Hulls are in `out`.
    pub fn run(
        &self,
        run: &Run,
        name: &str,
        mesh: &Path,
        out: &Path,
        limits: Limits,
    ) -> Result<Ran, String> {
        let (kind, value) = match run {
            Run::Coacd { threshold } => ("coacd", threshold.to_string()),
            Run::Vhacd4 { hulls } => ("vhacd", hulls.to_string()),
            _ => return Err("not a method of the script".into()),
        };
        // The script reads OBJ best; glTF scenes have flattened copies.
        let flattened = self.folder.flat_mesh(name);
        let source = if flattened.is_file() { &flattened } else { mesh };
        let mut command = Command::new(&self.python);
        command.arg(self.folder.script()).arg(kind).arg(source).arg(out).arg(value);
        let ended = limits::run(command, limits)?;
        if ended.status != Status::Done {
            return Ok(Err((ended.status, ended.reason)));
        }
        let said = ended.lines.last().and_then(|line| serde_json::from_str(line).ok());
        let said: serde_json::Value = said.unwrap_or_default();
        let Some(seconds) = said["seconds"].as_f64() else {
            return Ok(Err((Status::Error, "the script told no time".into())));
        };
        Ok(Ok((seconds, ended.peak_memory)))
    }
}

fn version(python: &str, package: &str) -> Option<String> {
    let script = "import sys, importlib, importlib.metadata as m; \
                  importlib.import_module('trimesh'); importlib.import_module(sys.argv[1]); \
                  print(m.version(sys.argv[1]))";
    let output = Command::new(python).args(["-c", script, package]).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn seconds_of_coacd(results: Vec<ToolResult>) -> BTreeMap<String, f64> {
    let rows = results.into_iter().filter(|row| row.method.starts_with("coacd"));
    rows.map(|row| (row.mesh, row.seconds)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_said_and_not_run() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir(root.path().join("peers")).unwrap();
        let table = "mesh\tmethod\tseconds\thulls\n\
                     a/1.off\tcoacd-1.0\t9.5\t7\na/1.off\tvhacd-parry\t0.1\t7\n";
        std::fs::write(root.path().join("peers/results.tsv"), table).unwrap();
        let tools = ExternalTools::new(DataFolder(root.path().into()), "python3");
        assert_eq!(tools.coacd_seconds, BTreeMap::from([("a/1.off".into(), 9.5)]));
        // No script and no hull files.
        assert_eq!(tools.missing().len(), 2);
        assert_eq!(tools.runs("a/1.off"), []);
    }
}
