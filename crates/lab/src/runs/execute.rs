//! Does one run in a process of its own.

use std::path::Path;

use super::external_tools::ExternalTools;
use super::limits::{self, Limits};
use super::meshes::Mesh;
use super::methods::Run;
use super::record::{Row, Status, Worked};
use super::worker::{self, Line};

/// The row of a run that is not done yet.
pub fn blank_row(mesh: &Mesh, run: &Run, version: String) -> Row {
    Row {
        mesh: mesh.name.clone(),
        mesh_bytes: mesh.bytes,
        mesh_hash: mesh.hash.clone(),
        method: run.method().into(),
        setting: run.setting(),
        version,
        status: Status::Done,
        reason: String::new(),
        taken_elsewhere: false,
        worked: None,
        judged: None,
    }
}

/// Does one run, and writes into the row what came of it. `scratch` is a file that it may use.
pub fn execute(
    run: &Run,
    mesh: &Mesh,
    tools: Option<&ExternalTools>,
    limits: Limits,
    scratch: &Path,
    row: &mut Row,
) -> Result<(), String> {
    let hulls = match (run, tools) {
        (Run::CoacdFiles, Some(tools)) => {
            let seconds = tools.coacd_seconds(&mesh.name).unwrap_or(0.0);
            row.worked = Some(Worked { seconds, repeats: 1, ..Worked::default() });
            row.taken_elsewhere = true;
            Some(tools.folder.coacd_hulls(&mesh.name))
        }
        (Run::Coacd { .. } | Run::Vhacd4 { .. }, Some(tools)) => {
            match tools.run(run, &mesh.name, &mesh.path, scratch, limits)? {
                Ok(worked) => row.worked = Some(worked),
                Err((status, reason)) => {
                    (row.status, row.reason) = (status, reason);
                    return Ok(());
                }
            }
            Some(scratch.to_owned())
        }
        _ => None,
    };
    let ended = limits::run(worker::command(&mesh.path, run, hulls.as_deref())?, limits)?;
    (row.status, row.reason) = (ended.status, ended.reason);
    for line in &ended.lines {
        match serde_json::from_str(line).map_err(|error| format!("a worker said: {error}"))? {
            Line::Worked(worked) => row.worked = Some(worked),
            Line::Judged(judged) => row.judged = Some(*judged),
            Line::AllThreads { seconds, same } => {
                if let Some(worked) = &mut row.worked {
                    worked.seconds_all_threads = Some(seconds);
                    worked.same_with_all_threads = Some(same);
                }
            }
        }
    }
    if row.status == Status::Done && row.judged.is_none() {
        (row.status, row.reason) = (Status::Error, "it ended without a result".into());
    }
    // Where there is none, nothing is left behind.
    let _ = std::fs::remove_file(scratch);
    Ok(())
}
