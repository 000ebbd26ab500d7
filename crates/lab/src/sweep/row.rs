//! What became of one mesh: a line of the journal, and of the table that is compared with the next.

use serde::{Deserialize, Serialize};

use crate::runs::journal::{Entry, Key};
use crate::runs::record::Status;

/// One mesh. Lengths are shares of its diagonal; what is empty was not reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub mesh: String,
    pub mesh_bytes: u64,
    /// Of the file's bytes.
    pub mesh_hash: String,
    pub version: String,
    pub status: Status,
    /// Why it was refused, or what ended it.
    pub reason: String,
    pub triangles: Option<usize>,
    pub hulls: Option<usize>,
    pub vertices: Option<usize>,
    /// Of decomposing alone, on one thread, in seconds.
    pub processor_seconds: Option<f64>,
    pub wall_seconds: Option<f64>,
    /// Highest resident memory while reading and decomposing, in bytes.
    pub peak_memory: Option<u64>,
    pub bound: Option<f64>,
    /// What the report says.
    pub protrusion_verified: Option<f64>,
    pub uncovered_verified: Option<f64>,
    /// What the sampling of this laboratory finds.
    pub protrusion_sampled: Option<f64>,
    pub uncovered_sampled: Option<f64>,
    pub samples: Option<usize>,
    pub undecided_samples: Option<usize>,
    /// What a promise is broken by; empty where all hold.
    pub broken: String,
    /// Hulls in single precision that are not closed, by exact tests.
    pub open_hulls: Option<usize>,
    pub non_convex_hulls: Option<usize>,
    pub hulls_without_volume: Option<usize>,
    /// Hulls that have no form in single precision.
    pub hulls_beyond_single: Option<usize>,
    pub uncovered_volume: Option<f64>,
    pub iou: Option<f64>,
}

impl Entry for Row {
    fn key(&self) -> Key {
        let Self { mesh, mesh_hash, version, .. } = self;
        [mesh, mesh_hash, version, "", ""].map(str::to_owned)
    }
}

impl Row {
    /// A mesh of which nothing is known yet.
    pub fn blank(mesh: &crate::runs::meshes::Mesh, version: &str) -> Self {
        Self {
            mesh: mesh.name.clone(),
            mesh_bytes: mesh.bytes,
            mesh_hash: mesh.hash.clone(),
            version: version.into(),
            status: Status::Done,
            reason: String::new(),
            triangles: None,
            hulls: None,
            vertices: None,
            processor_seconds: None,
            wall_seconds: None,
            peak_memory: None,
            bound: None,
            protrusion_verified: None,
            uncovered_verified: None,
            protrusion_sampled: None,
            uncovered_sampled: None,
            samples: None,
            undecided_samples: None,
            broken: String::new(),
            open_hulls: None,
            non_convex_hulls: None,
            hulls_without_volume: None,
            hulls_beyond_single: None,
            uncovered_volume: None,
            iou: None,
        }
    }

    /// Whether decomposing took more processor time than it may, though it was let go on.
    pub fn is_over(&self, seconds: f64) -> bool {
        self.status == Status::TimeOut || self.processor_seconds.is_some_and(|s| s > seconds)
    }

    /// The folder that the mesh is in.
    pub fn folder(&self) -> &str {
        crate::runs::meshes::folder(&self.mesh)
    }

    /// What is wrong with the hulls or the promise, in words; empty where nothing is.
    pub fn faults(&self) -> String {
        let counts = [
            (self.open_hulls, "open"),
            (self.non_convex_hulls, "not convex"),
            (self.hulls_without_volume, "without volume"),
            (self.hulls_beyond_single, "beyond single precision"),
        ];
        let faulty = counts.into_iter().filter_map(|(count, what)| Some((count?, what)));
        let mut words: Vec<String> = faulty
            .filter(|&(count, _)| count > 0)
            .map(|(count, what)| format!("{count} hulls {what}"))
            .collect();
        if !self.broken.is_empty() {
            words.push(self.broken.clone());
        }
        words.join("; ")
    }
}

/// All rows as CSV, with a line of names above.
pub fn to_csv(rows: &[Row]) -> Result<String, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|error| format!("a table: {error}"))?;
    }
    let bytes = writer.into_inner().map_err(|error| format!("a table: {error}"))?;
    String::from_utf8(bytes).map_err(|error| format!("a table: {error}"))
}

/// The reverse of [`to_csv`].
pub fn from_csv(path: &std::path::Path) -> Result<Vec<Row>, String> {
    let say = |error: csv::Error| format!("{}: {error}", path.display());
    let mut reader = csv::Reader::from_path(path).map_err(say)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(say)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn row(mesh: &str) -> Row {
        let mesh = crate::runs::meshes::Mesh {
            name: mesh.into(),
            path: Default::default(),
            bytes: 3,
            hash: "0f".into(),
        };
        Row::blank(&mesh, "1")
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.csv");
        let done = Row {
            processor_seconds: Some(0.1 + 0.2),
            hulls: Some(7),
            reason: "with, a \"comma\"".into(),
            ..row("a/b.obj")
        };
        let rows = [done, Row { status: Status::OutOfMemory, ..row("a/c.obj") }];
        std::fs::write(&path, to_csv(&rows).unwrap()).unwrap();
        assert_eq!(from_csv(&path).unwrap(), rows);
        assert!(from_csv(&folder.path().join("none.csv")).is_err());
    }

    #[test]
    fn faults_are_said_in_words() {
        assert_eq!(Row { open_hulls: Some(0), ..row("a") }.faults(), "");
        let faulty = Row { non_convex_hulls: Some(2), broken: "sampled".into(), ..row("a") };
        assert_eq!(faulty.faults(), "2 hulls not convex; sampled");
        assert!(Row { processor_seconds: Some(2.1), ..row("a") }.is_over(2.0));
    }
}
