//! Writes files all or nothing: to a temporary file beside the place, which then replaces it.

use std::io::Write;
use std::path::Path;

use hullwright::Error;

/// The directory that a file is in.
pub(crate) fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes a file all or nothing: one that is already there is replaced in one step, or stays as it
/// was.
///
/// # Errors
/// [`Error::File`] if the directory does not exist, or if writing fails.
pub fn write_file(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
    let path = path.as_ref();
    write(path, bytes).map_err(|error| Error::file(path, error))
}

fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hullwright-");
    // Temporary files are private by default; this one becomes the requested file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(directory(path))?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map(drop).map_err(|error| error.error)
}
