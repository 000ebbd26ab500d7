//! The folder of meshes, of hulls that other tools made, and of the paper's own figures, which many
//! experiments take as their argument.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::methods::{Run, Tool};

/// A folder with any of:
/// - `meshes`;
/// - `paper/table1.tsv`, the paper's Table 1 with the names of its meshes;
/// - `peers/results.tsv` and `peers/cuacd.tsv`, what other tools returned, with their hulls in
///   `peers/coacd` and `peers/cuacd`, and the meshes of glTF scenes flattened in `peers/src`.
#[derive(Debug, Clone)]
pub struct DataFolder(pub PathBuf);

/// What another tool returned for a mesh, and what another evaluator measured. Lengths are
/// fractions of the diagonal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ToolResult {
    pub mesh: String,
    pub method: String,
    pub seconds: f64,
    pub hulls: usize,
    #[serde(rename = "haus")]
    pub hausdorff: Option<f64>,
    /// The largest distance of the mesh outside all hulls.
    #[serde(rename = "in_max")]
    pub uncovered: Option<f64>,
    pub iou: Option<f64>,
}

/// A row of the paper's Table 1.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PaperRow {
    pub model: String,
    pub mesh: String,
    pub pieces: usize,
    pub average_pieces: f64,
    pub seconds: f64,
    pub cost: f64,
    pub p: f64,
    pub r: usize,
    pub polygons: usize,
    pub initial_polygons: usize,
}

impl PaperRow {
    /// The model's number, and its mesh.
    pub fn name(&self) -> String {
        format!("{} ({})", self.model, self.mesh)
    }
}

impl DataFolder {
    /// A mesh by its name, such as `princeton/3.off`.
    pub fn mesh(&self, name: &str) -> PathBuf {
        self.0.join("meshes").join(name)
    }

    /// A mesh as the other tools got it: a glTF scene as its flattened copy.
    pub fn flat_mesh(&self, name: &str) -> PathBuf {
        let flattened = self.0.join("peers/src").join(object(name));
        if flattened.is_file() { flattened } else { self.mesh(name) }
    }

    /// The hulls of a mesh that a tool returned.
    pub fn hulls(&self, tool: Tool, mesh: &str) -> PathBuf {
        self.0.join("peers").join(tool.name()).join(object(mesh))
    }

    /// The hulls and times of each mesh that has a file of them, to judge.
    pub fn file_runs(&self) -> Result<BTreeMap<String, Vec<Run>>, String> {
        let mut runs: BTreeMap<String, Vec<Run>> = BTreeMap::new();
        for ToolResult { mesh, method, seconds, .. } in self.tool_results()? {
            let Some(tool) = Tool::ALL.into_iter().find(|tool| method.starts_with(tool.name()))
            else {
                continue;
            };
            let hulls = self.hulls(tool, &mesh);
            if hulls.is_file() {
                runs.entry(mesh).or_default().push(Run::Files { tool, hulls, seconds });
            }
        }
        Ok(runs)
    }

    /// What all tools returned.
    pub fn tool_results(&self) -> Result<Vec<ToolResult>, String> {
        let mut all: Vec<ToolResult> = read(&self.0.join("peers/results.tsv"))?;
        all.extend(self.beside_cuacd()?);
        Ok(all)
    }

    /// What CuACD returned, and the default method on the same machine, in the same run; nothing
    /// where there is no such table.
    pub fn beside_cuacd(&self) -> Result<Vec<ToolResult>, String> {
        let path = self.0.join("peers/cuacd.tsv");
        if path.is_file() { read(&path) } else { Ok(Vec::new()) }
    }

    pub fn table1(&self) -> Result<Vec<PaperRow>, String> {
        read(&self.0.join("paper/table1.tsv"))
    }
}

/// A mesh's file name in the folders of hulls: `/` is `_`, and the suffix `obj`.
fn object(mesh: &str) -> PathBuf {
    Path::new(&mesh.replace('/', "_")).with_extension("obj")
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, String> {
    let say = |error: csv::Error| format!("{}: {error}", path.display());
    let mut reader =
        csv::ReaderBuilder::new().delimiter(b'\t').quoting(false).from_path(path).map_err(say)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(say)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_are_named_after_the_path_of_the_mesh() {
        let folder = DataFolder("data".into());
        for (tool, expected) in [(Tool::Coacd, "coacd"), (Tool::Cuacd, "cuacd")] {
            let path = folder.hulls(tool, "gltf/a__b.glb");
            assert_eq!(path, Path::new("data/peers").join(expected).join("gltf_a__b.obj"));
        }
        assert_eq!(folder.flat_mesh("a/1.off"), Path::new("data/meshes/a/1.off"));
    }

    #[test]
    fn tables_are_read_by_the_names_of_their_columns() {
        let root = tempfile::tempdir().unwrap();
        let folder = DataFolder(root.path().into());
        assert!(folder.tool_results().unwrap_err().contains("results.tsv"));
        std::fs::create_dir(root.path().join("peers")).unwrap();
        let table = "mesh\tmethod\tseconds\thulls\thaus\tiou\textra\na/1.off\tcoacd-1.0\t9.5\t7\t0.02\t\t1\n";
        std::fs::write(root.path().join("peers/results.tsv"), table).unwrap();
        let rows = folder.tool_results().unwrap();
        assert_eq!((&rows[0].mesh[..], rows[0].seconds, rows[0].hulls), ("a/1.off", 9.5, 7));
        assert_eq!((rows[0].hausdorff, rows[0].iou), (Some(0.02), None));
        assert!(folder.file_runs().unwrap().is_empty(), "there are no hulls");
        for tool in ["coacd", "cuacd"] {
            std::fs::create_dir(root.path().join("peers").join(tool)).unwrap();
            std::fs::write(root.path().join("peers").join(tool).join("a_1.obj"), "").unwrap();
        }
        let other = table.replace("coacd-1.0", "cuacd-0.1").replace("9.5", "0.5");
        std::fs::write(root.path().join("peers/cuacd.tsv"), other).unwrap();
        let runs = folder.file_runs().unwrap();
        let found: Vec<_> = runs["a/1.off"]
            .iter()
            .map(|run| match run {
                Run::Files { tool, seconds, .. } => (*tool, *seconds),
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(found, [(Tool::Coacd, 9.5), (Tool::Cuacd, 0.5)]);
    }
}
