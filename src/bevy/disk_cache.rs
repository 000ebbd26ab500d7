//! The cache on disk: a `.hulls` file per mesh and parameters.

use std::path::{Path, PathBuf};

use crate::hulls_format::HullsFile;

use super::content::ContentKey;

fn path_of(directory: &Path, key: ContentKey) -> Option<PathBuf> {
    let ContentKey::Mesh(hash) = key else { return None };
    let name: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    Some(directory.join(name).with_extension("hulls"))
}

/// A file that can't be read counts as missing.
pub(super) fn read_from_disk(directory: &Path, key: ContentKey) -> Option<HullsFile> {
    let file = HullsFile::read(path_of(directory, key)?).ok()?;
    (file.is_current() && file.mass_properties.is_some()).then_some(file)
}

/// A file that can't be written is logged: the decomposition succeeded all the same.
pub(super) fn write_to_disk(directory: &Path, key: ContentKey, file: &HullsFile) {
    let Some(path) = path_of(directory, key) else { return };
    let written = std::fs::create_dir_all(directory)
        .map_err(|error| error.to_string())
        .and_then(|()| file.write(&path).map_err(|error| error.to_string()));
    if let Err(error) = written {
        log::warn!("{} could not be cached: {error}", path.display());
    }
}
