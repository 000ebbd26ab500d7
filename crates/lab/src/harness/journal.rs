//! Rows of JSON in a file that only grows, so that an experiment can be stopped and continued.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::Path;

use super::row::Row;

/// Of several rows with the same key the last counts.
pub struct Journal {
    file: File,
    rows: Vec<Row>,
    places: HashMap<[String; 6], usize>,
}

impl Journal {
    /// Opens a journal and reads what it holds. A last line that was cut off is dropped; a broken
    /// line elsewhere is an error.
    pub fn open(path: &Path) -> Result<Self, String> {
        let say = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let mut options = OpenOptions::new();
        let options = options.create(true).truncate(false).read(true).write(true);
        let mut file = options.open(path).map_err(|error| say(&error))?;
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
            let row: Row = serde_json::from_str(&line)
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

    fn keep(&mut self, row: Row) {
        match self.places.get(&row.key()) {
            Some(&place) => self.rows[place] = row,
            None => {
                self.places.insert(row.key(), self.rows.len());
                self.rows.push(row);
            }
        }
    }

    pub fn get(&self, key: &[String; 6]) -> Option<&Row> {
        self.places.get(key).map(|&place| &self.rows[place])
    }

    pub fn add(&mut self, row: Row) -> Result<(), String> {
        let mut line = serde_json::to_string(&row).map_err(|error| error.to_string())?;
        line.push('\n');
        let write = self.file.write_all(line.as_bytes()).and_then(|()| self.file.flush());
        write.map_err(|error| format!("the journal: {error}"))?;
        self.keep(row);
        Ok(())
    }

    pub fn rows(&self) -> &[Row] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::Status;
    use super::*;

    fn row(mesh: &str, setting: &str) -> Row {
        Row {
            mesh: mesh.into(),
            setting: setting.into(),
            status: Status::Error,
            reason: "no\nreason".into(),
            hausdorff: Some(0.1 + 0.2),
            ..Row::default()
        }
    }

    #[test]
    fn what_is_written_is_read_again_and_the_last_row_of_a_task_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        let again = Row { status: Status::Done, ..row("a", "1") };
        for row in [row("a", "1"), row("a", "2"), again.clone()] {
            journal.add(row).unwrap();
        }
        assert_eq!(journal.rows(), [again.clone(), row("a", "2")]);
        drop(journal);
        let journal = Journal::open(&path).unwrap();
        assert_eq!(journal.rows(), [again, row("a", "2")]);
        assert!(journal.get(&row("a", "2").key()).is_some());
        assert!(journal.get(&row("b", "2").key()).is_none());
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
        assert_eq!(Journal::open(&path).unwrap().rows(), [row("a", "1"), row("a", "3")]);
    }

    #[test]
    fn a_broken_line_in_the_middle_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        std::fs::write(&path, "nonsense\n{}\n").unwrap();
        assert!(Journal::open(&path).err().unwrap().contains("line 1"));
    }
}
