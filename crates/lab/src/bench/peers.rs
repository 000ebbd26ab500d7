//! Methods that are no part of this program: CoACD and V-HACD 4 through the script `peers.py`, and
//! hull files that somebody else computed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::caps::{self, Caps};
use super::methods::Run;
use super::record::{Status, Worked};

/// A folder with `tools/peers.py` and `peers/results.tsv`, and an interpreter for the first.
pub struct Peers {
    folder: PathBuf,
    python: String,
    /// What Python has of CoACD and V-HACD; empty where it has not.
    pub versions: [String; 2],
    /// Seconds of CoACD by mesh, from the table.
    elsewhere: BTreeMap<String, f64>,
}

/// The packages that `peers.py` needs for CoACD and for V-HACD.
const PACKAGES: [&str; 2] = ["coacd", "vhacdx"];

impl Peers {
    pub fn new(folder: &Path, python: &str) -> Self {
        let table = std::fs::read_to_string(folder.join("peers/results.tsv")).unwrap_or_default();
        let script = folder.join("tools/peers.py");
        let versions = PACKAGES.map(|package| {
            if script.is_file() {
                version(python, package).unwrap_or_default()
            } else {
                String::new()
            }
        });
        Self {
            folder: folder.to_owned(),
            python: python.to_owned(),
            versions,
            elsewhere: seconds_of_coacd(&table),
        }
    }

    /// What is not there, in words.
    pub fn missing(&self) -> Vec<String> {
        let versions = PACKAGES.iter().zip(&self.versions);
        let mut missing: Vec<String> = versions
            .filter(|(_, version)| version.is_empty())
            .map(|(package, _)| format!("{} has no package {package}, or no script", self.python))
            .collect();
        if self.elsewhere.is_empty() {
            missing.push(format!("{}: no table of CoACD's runs", self.folder.display()));
        }
        missing
    }

    /// What can be run on a mesh: CoACD only on those that the table names, for it is slow.
    pub fn runs(&self, mesh: &str) -> Vec<Run> {
        let mut runs = Vec::new();
        let is_named = self.elsewhere.contains_key(mesh);
        if is_named && self.hulls_of(mesh).is_file() {
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

    /// Seconds that CoACD took elsewhere.
    pub fn seconds_elsewhere(&self, mesh: &str) -> Option<f64> {
        self.elsewhere.get(mesh).copied()
    }

    /// CoACD's hulls from elsewhere.
    pub fn hulls_of(&self, mesh: &str) -> PathBuf {
        self.folder.join("peers/coacd").join(object(mesh))
    }

    /// Runs the script: what it did, or how it failed. Hulls are in `out`.
    pub fn run(
        &self,
        run: &Run,
        name: &str,
        mesh: &Path,
        out: &Path,
        caps: Caps,
    ) -> Result<Result<Worked, (Status, String)>, String> {
        let (kind, knob) = match run {
            Run::Coacd { threshold } => ("coacd", threshold.to_string()),
            Run::Vhacd4 { hulls } => ("vhacd", hulls.to_string()),
            _ => return Err("not a method of the script".into()),
        };
        // The script reads OBJ best; props come as flattened copies.
        let flattened = self.folder.join("peers/src").join(object(name));
        let source = if flattened.is_file() { &flattened } else { mesh };
        let mut command = Command::new(&self.python);
        command.arg(self.folder.join("tools/peers.py")).arg(kind).arg(source).arg(out).arg(knob);
        let ended = caps::run(command, caps)?;
        if ended.status != Status::Done {
            return Ok(Err((ended.status, ended.reason)));
        }
        let told = ended.lines.last().and_then(|line| serde_json::from_str(line).ok());
        let told: serde_json::Value = told.unwrap_or_default();
        let Some(seconds) = told["seconds"].as_f64() else {
            return Ok(Err((Status::Error, "the script told no time".into())));
        };
        Ok(Ok(Worked { seconds, repeats: 1, peak_memory: ended.peak_memory, ..Worked::default() }))
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

/// A mesh's file name in the folders of hulls: `/` is `_`, and the suffix `obj`.
fn object(mesh: &str) -> String {
    let name = mesh.replace('/', "_");
    format!("{}.obj", name.rsplit_once('.').map_or(&name[..], |(stem, _)| stem))
}

fn seconds_of_coacd(table: &str) -> BTreeMap<String, f64> {
    let rows = table.lines().skip(1).filter_map(|line| {
        let mut cells = line.split('\t');
        let (mesh, method, seconds) = (cells.next()?, cells.next()?, cells.next()?);
        method.starts_with("coacd").then_some((mesh.to_owned(), seconds.parse().ok()?))
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_the_seconds_of_coacd_alone() {
        let table = "mesh\tmethod\tseconds\na/1.off\tcoacd-1.0\t9.5\na/1.off\tvhacd-parry\t0.1\n";
        assert_eq!(seconds_of_coacd(table), BTreeMap::from([("a/1.off".into(), 9.5)]));
    }

    #[test]
    fn hulls_are_named_after_the_meshs_path() {
        assert_eq!(object("gltf/a__b.glb"), "gltf_a__b.obj");
    }
}
