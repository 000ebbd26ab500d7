//! Public sets of meshes, by repository and commit, so that others can repeat a sweep over them.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, number, number_or_nothing};
use crate::statistics::quantile;
use crate::tools::meshes::{self, Mesh};

/// The sets, with the commit that the last report is about where there is one.
const CORPORA: &str = include_str!("corpora.tsv");

/// A public repository with meshes.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Corpus {
    /// Of its folder, too.
    pub name: String,
    pub repository: String,
    pub commit: String,
    /// What is checked out.
    #[serde(skip)]
    found: Option<String>,
}

impl Corpus {
    /// The commands that bring it.
    fn commands(&self, folder: &Path) -> String {
        let place = folder.join(&self.name).display().to_string();
        let checkout = match self.commit.is_empty() {
            true => String::new(),
            false => format!(" && git -C {place} checkout {}", self.commit),
        };
        format!("git clone {} {place}{checkout}", self.repository)
    }
}

/// All sets.
pub fn all() -> Result<Vec<Corpus>, String> {
    let mut reader = csv::ReaderBuilder::new().delimiter(b'\t').from_reader(CORPORA.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().map_err(|error| format!("corpora: {error}"))
}

/// The sets that are in a folder, each in one of its name, and of each so many meshes, evenly
/// spread. The names of the meshes begin with that of their set.
pub fn find(folder: &Path, most: usize) -> Result<(Vec<Corpus>, Vec<Mesh>), String> {
    let (mut there, mut found) = (Vec::new(), Vec::new());
    let all = all()?;
    for corpus in &all {
        let path = folder.join(&corpus.name);
        if path.is_dir() {
            found.extend(of_corpus(&corpus.name, &path, most)?);
            there.push(Corpus { found: head(&path), ..corpus.clone() });
        }
    }
    if there.is_empty() {
        let commands: Vec<String> = all.iter().map(|corpus| corpus.commands(folder)).collect();
        let folder = folder.display();
        return Err(format!("{folder} has none of the corpora: {}", commands.join("; ")));
    }
    Ok((there, found))
}

fn of_corpus(name: &str, path: &PathBuf, most: usize) -> Result<Vec<Mesh>, String> {
    let meshes = meshes::spread(meshes::find(std::slice::from_ref(path))?, most);
    let named = meshes.into_iter().map(|mesh| {
        let below = mesh.path.strip_prefix(path).unwrap_or(&mesh.path).to_string_lossy();
        Mesh { name: format!("{name}/{}", below.replace('\\', "/")), ..mesh }
    });
    Ok(named.collect())
}

/// The commit that is checked out, if git knows.
fn head(path: &Path) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(path).args(["rev-parse", "HEAD"]).output();
    let commit = String::from_utf8(output.ok().filter(|output| output.status.success())?.stdout);
    commit.ok().map(|commit| commit.trim().to_owned())
}

/// A row for each set.
pub fn table(corpora: &[Corpus], rows: &[Row]) -> Table {
    let header = [
        "set",
        "repository",
        "commit",
        "meshes",
        "done",
        "refused, and why",
        "crashed or stopped",
        "not sound",
        "beyond the bound",
        "median s",
        "99 %",
        "slowest",
        "most MB",
    ];
    let note = "Public repositories, as they are at a commit: of large ones every so many meshes. Reasons by their \
                sort, `file` where it is damaged or of another kind.";
    let mut table = Table::new("Named corpora", note, &header);
    for Corpus { name, repository, found, .. } in corpora {
        let prefix = format!("{name}/");
        let is_own = |row: &&Row| row.mesh.starts_with(&prefix) && row.variation.is_empty();
        let rows: Vec<&Row> = rows.iter().filter(is_own).collect();
        let count = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).count();
        let done = count(&|row| row.status == Status::Done);
        let refused = count(&|row| row.status == Status::Error);
        let times: Vec<f64> = rows.iter().filter_map(|row| row.processor_seconds).collect();
        let time = |share: f64| (!times.is_empty()).then(|| quantile(&times, share));
        let memory = rows.iter().filter_map(|row| row.megabytes()).reduce(f64::max);
        table.rows.push(vec![
            name.clone(),
            repository.clone(),
            found.as_deref().map_or(NOTHING, |commit| commit.get(..10).unwrap_or(commit)).into(),
            rows.len().to_string(),
            done.to_string(),
            reasons(&rows, refused),
            (rows.len() - done - refused).to_string(),
            count(&|row| row.unsound_hulls() > 0).to_string(),
            count(&|row| !row.broken.is_empty()).to_string(),
            number_or_nothing(time(0.5)),
            number_or_nothing(time(0.99)),
            number_or_nothing(time(1.0)),
            memory.map_or_else(|| NOTHING.into(), number),
        ]);
    }
    table
}

/// How many were refused, and each sort of reason with how often it was given: what is before the
/// first colon. The table of refusals has them whole.
fn reasons(rows: &[&Row], refused: usize) -> String {
    let mut reasons: Vec<(&str, usize)> = Vec::new();
    for row in rows.iter().filter(|row| row.status == Status::Error) {
        let sort = row.reason.split(':').next().unwrap_or_default();
        match reasons.iter_mut().find(|(reason, _)| *reason == sort) {
            Some((_, count)) => *count += 1,
            None => reasons.push((sort, 1)),
        }
    }
    reasons.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let named: Vec<String> =
        reasons.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
    match refused {
        0 => "0".into(),
        _ => format!("{refused}: {}", named.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_has_a_repository_and_a_commit_is_whole_where_it_is_given() {
        let all = all().unwrap();
        assert!(all.len() >= 6);
        for Corpus { name, repository, commit, .. } in all {
            assert!(repository.starts_with("https://") && !name.contains('/'), "{name}");
            let is_whole = commit.len() == 40 && commit.bytes().all(|b| b.is_ascii_hexdigit());
            assert!(commit.is_empty() || is_whole, "{name}: {commit}");
        }
    }

    #[test]
    fn sets_are_found_by_the_names_of_their_folders_and_missing_ones_are_said_with_commands() {
        let root = tempfile::tempdir().unwrap();
        let missing = find(root.path(), 10).unwrap_err();
        assert!(missing.contains("git clone https://github.com/mikedh/trimesh"), "{missing}");
        let folder = root.path().join("trimesh/models");
        std::fs::create_dir_all(&folder).unwrap();
        for file in ["a.off", "b.stl", "c.txt"] {
            std::fs::write(folder.join(file), "").unwrap();
        }
        let (corpora, meshes) = find(root.path(), 10).unwrap();
        assert_eq!(corpora.len(), 1);
        let names: Vec<&str> = meshes.iter().map(|mesh| mesh.name.as_str()).collect();
        assert_eq!(names, ["trimesh/models/a.off", "trimesh/models/b.stl"]);
        assert_eq!(find(root.path(), 1).unwrap().1.len(), 1);
    }

    #[test]
    fn the_table_counts_by_set_and_names_the_reasons() {
        let corpus = Corpus {
            name: "a".into(),
            repository: "https://a".into(),
            commit: String::new(),
            found: Some("0123456789abcdef".into()),
        };
        let row = |mesh: &str, status, reason: &str| Row {
            mesh: mesh.into(),
            status,
            reason: reason.into(),
            processor_seconds: Some(0.5),
            ..Row::default()
        };
        let rows = [
            row("a/x/1.obj", Status::Done, ""),
            row("a/2.obj", Status::Error, "empty: 1 vertex"),
            row("a/3.obj", Status::Error, "empty: 2 vertices"),
            row("a/4.obj", Status::Crash, "signal"),
            row("ab/1.obj", Status::Done, ""),
        ];
        let table = table(&[corpus], &rows);
        let cells = table.rows[0].join(" | ");
        assert!(cells.starts_with("a | https://a | 0123456789 | 4 | 1 | 2: 2 empty | 1 | 0 | 0 |"));
    }
}
