//! What became of a run: one row.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::journal::{Entry, Key};
use super::judge::Judged;

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
    /// Over the time limit.
    TimeOut,
    /// Over the memory limit.
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
