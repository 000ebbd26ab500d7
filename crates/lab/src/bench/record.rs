//! What became of a run: one row, one line of JSON in a file that only grows.

use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::Path;

use hullwright::measure::Measurement;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Hulls, and measured.
    Done,
    /// It said what is wrong.
    Error,
    /// It panicked, or was ended by a signal that it caused itself.
    Crash,
    /// Over the cap on time.
    TimeOut,
    /// Over the cap on memory.
    OutOfMemory,
}

impl Status {
    pub const ALL: [Self; 5] =
        [Self::Done, Self::Error, Self::Crash, Self::TimeOut, Self::OutOfMemory];

    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Error => "error",
            Self::Crash => "crash",
            Self::TimeOut => "time-out",
            Self::OutOfMemory => "out of memory",
        }
    }
}

/// What `measure` said; lengths are shares of the mesh's diagonal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    pub hulls: usize,
    pub vertices: usize,
    pub unusable_hulls: usize,
    pub non_convex_hulls: usize,
    pub non_positive_volumes: usize,
    pub worst_concavity: f64,
    pub phantom_mean: f64,
    pub phantom_p99: f64,
    pub phantom_max: f64,
    pub exposed_mean: f64,
    pub exposed_p99: f64,
    pub exposed_max: f64,
    pub hausdorff: f64,
    pub hollow: Option<f64>,
    pub iou: Option<f64>,
    pub overlap: Option<f64>,
    /// Points on hulls, on their boundary, on the mesh, in space.
    pub samples: [usize; 4],
}

impl From<&Measurement> for Judged {
    fn from(found: &Measurement) -> Self {
        let samples = &found.samples;
        Self {
            hulls: found.hulls,
            vertices: found.vertices,
            unusable_hulls: found.unusable_hulls,
            non_convex_hulls: found.non_convex_hulls,
            non_positive_volumes: found.non_positive_volumes,
            worst_concavity: found.worst_concavity,
            phantom_mean: found.phantom.mean,
            phantom_p99: found.phantom.p99,
            phantom_max: found.phantom.max,
            exposed_mean: found.exposed.mean,
            exposed_p99: found.exposed.p99,
            exposed_max: found.exposed.max,
            hausdorff: found.hausdorff,
            hollow: found.hollow,
            iou: found.iou,
            overlap: found.overlap,
            samples: [samples.hull, samples.boundary, samples.mesh, samples.volume],
        }
    }
}

/// What decomposing gave, apart from the hulls.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Worked {
    pub triangles: usize,
    /// Median over the repeats, one thread where the method lets us choose.
    pub seconds: f64,
    pub repeats: usize,
    /// With all processors; none where the method has no such mode.
    pub seconds_all_threads: Option<f64>,
    /// Whether the hulls were the same with all processors.
    pub same_with_all_threads: Option<bool>,
    /// Seconds by stage in the order of the work, of the first repeat.
    pub stages: Vec<(String, f64)>,
    /// Highest memory in use while decomposing, mesh included, in bytes.
    pub peak_memory: Option<u64>,
    /// The paper's cost, where the method groups a surface.
    pub cost: Option<f64>,
    /// What else the method tells about itself.
    pub details: BTreeMap<String, serde_json::Value>,
}

/// One mesh, one method, one setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub mesh: String,
    /// Length and hash of the file's bytes.
    pub mesh_bytes: u64,
    pub mesh_hash: String,
    pub method: String,
    pub setting: String,
    pub version: String,
    pub status: Status,
    /// What went wrong, in one line.
    pub reason: String,
    /// Whether the time was taken on another machine.
    pub taken_elsewhere: bool,
    pub worked: Option<Worked>,
    pub judged: Option<Judged>,
}

/// What makes a run the same run.
pub type Key = [String; 5];

/// What a journal keeps.
pub trait Entry: Serialize + DeserializeOwned {
    fn key(&self) -> Key;
}

impl Entry for Row {
    fn key(&self) -> Key {
        let Self { mesh, mesh_hash, method, setting, version, .. } = self;
        [mesh, mesh_hash, method, setting, version].map(String::clone)
    }
}

impl Row {
    /// Hulls and their measurement, of a run that has both.
    pub fn done(&self) -> Option<(&Worked, &Judged)> {
        if self.status == Status::Done {
            self.worked.as_ref().zip(self.judged.as_ref())
        } else {
            None
        }
    }
}

/// A file of rows that only grows, so that whatever happens, what is done stays done. Of several
/// rows with the same key the last counts.
pub struct Journal<T> {
    file: File,
    rows: Vec<T>,
    places: HashMap<Key, usize>,
}

impl<T: Entry> Journal<T> {
    /// Opens a journal and reads what it holds. A last line that was cut off is dropped; a broken
    /// line elsewhere is an error.
    pub fn open(path: &Path) -> Result<Self, String> {
        let say = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let mut file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(path)
            .map_err(|error| say(&error))?;
        let mut whole = 0;
        let mut rows = Vec::new();
        let mut reader = BufReader::new(&file);
        let mut line = String::new();
        for number in 1.. {
            line.clear();
            let length = reader.read_line(&mut line).map_err(|error| say(&error))?;
            if !line.ends_with('\n') {
                break;
            }
            let row: T = serde_json::from_str(&line)
                .map_err(|error| say(&format!("line {number}: {error}")))?;
            whole += length as u64;
            rows.push(row);
        }
        file.set_len(whole).map_err(|error| say(&error))?;
        file.seek(SeekFrom::End(0)).map_err(|error| say(&error))?;
        let mut journal = Self { file, rows: Vec::new(), places: HashMap::new() };
        rows.into_iter().for_each(|row| journal.keep(row));
        Ok(journal)
    }

    fn keep(&mut self, row: T) {
        match self.places.get(&row.key()) {
            Some(&place) => self.rows[place] = row,
            None => {
                self.places.insert(row.key(), self.rows.len());
                self.rows.push(row);
            }
        }
    }

    pub fn get(&self, key: &Key) -> Option<&T> {
        self.places.get(key).map(|&place| &self.rows[place])
    }

    pub fn add(&mut self, row: T) -> Result<(), String> {
        let mut line = serde_json::to_string(&row).map_err(|error| error.to_string())?;
        line.push('\n');
        let write = self.file.write_all(line.as_bytes()).and_then(|()| self.file.flush());
        write.map_err(|error| format!("the journal: {error}"))?;
        self.keep(row);
        Ok(())
    }

    pub fn rows(&self) -> &[T] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn row(mesh: &str, setting: &str) -> Row {
        Row {
            mesh: mesh.into(),
            mesh_bytes: 1,
            mesh_hash: "00".into(),
            method: "surface".into(),
            setting: setting.into(),
            version: "1".into(),
            status: Status::Error,
            reason: "no\nreason".into(),
            taken_elsewhere: false,
            worked: None,
            judged: Some(Judged { hausdorff: 0.1 + 0.2, ..Judged::default() }),
        }
    }

    #[test]
    fn what_is_written_is_read_again_and_not_done_twice() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        journal.add(row("a", "1")).unwrap();
        journal.add(row("a", "2")).unwrap();
        drop(journal);
        let journal = Journal::<Row>::open(&path).unwrap();
        assert_eq!(journal.rows(), [row("a", "1"), row("a", "2")]);
        assert!(journal.get(&row("a", "2").key()).is_some());
        assert!(journal.get(&row("b", "2").key()).is_none());
    }

    #[test]
    fn of_a_run_that_was_repeated_the_last_row_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        let again = Row { status: Status::Done, ..row("a", "1") };
        journal.add(row("a", "1")).unwrap();
        journal.add(row("a", "2")).unwrap();
        journal.add(again.clone()).unwrap();
        assert_eq!(journal.rows(), [again.clone(), row("a", "2")]);
        drop(journal);
        assert_eq!(Journal::<Row>::open(&path).unwrap().rows(), [again, row("a", "2")]);
    }

    #[test]
    fn a_line_that_was_cut_off_is_dropped_and_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        journal.add(row("a", "1")).unwrap();
        journal.add(row("a", "2")).unwrap();
        drop(journal);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() - 20]).unwrap();
        let mut journal = Journal::open(&path).unwrap();
        assert_eq!(journal.rows(), [row("a", "1")]);
        journal.add(row("a", "3")).unwrap();
        drop(journal);
        let journal = Journal::<Row>::open(&path).unwrap();
        assert_eq!(journal.rows(), [row("a", "1"), row("a", "3")]);
    }

    #[test]
    fn a_broken_line_in_the_middle_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        std::fs::write(&path, "nonsense\n{}\n").unwrap();
        assert!(Journal::<Row>::open(&path).err().unwrap().contains("line 1"));
    }
}
