//! What a reader left out or mended, as lines of a report and as warnings.

use std::path::Path;

use hullwright::Error;
use hullwright_cli::terminal::print_warning;
use hullwright_formats::{MeshFile, Note, read_mesh, sum_notes};

use crate::progress::waiting;

/// One line for each kind.
pub fn lines(notes: &[Note]) -> Vec<String> {
    notes.iter().map(|note| format!("file: {note}")).collect()
}

/// The same on standard error, where standard output has no report on the file.
pub fn warn<'a>(notes: impl IntoIterator<Item = &'a Note>, path: &Path) {
    for note in sum_notes(notes) {
        print_warning(&format!("{}: {note}", path.display()));
    }
}

/// Reads a mesh, and warns.
pub fn read_with_warnings(path: &Path) -> Result<MeshFile, Error> {
    let file = waiting("reading", || read_mesh(path))?;
    warn(&file.notes, path);
    Ok(file)
}
