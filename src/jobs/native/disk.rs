//! The cache on disk: a `.hulls` file per mesh and parameters, within a number of bytes. Several
//! processes may share it: files are written all or nothing, and one that another process has
//! removed is a missing one.

use std::fs::{DirEntry, File, Metadata};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Duration, SystemTime};

use hullwright::hulls_format::HullsFile;
use hullwright_formats::write_file;

use crate::jobs::kept::{is_usable, kept, unseen};
use crate::jobs::request::ContentKey;

/// A directory with files of results, the least recently used of which are removed.
#[derive(Debug, Clone)]
pub(in crate::jobs) struct DiskCache {
    directory: PathBuf,
    budget: u64,
    state: Arc<DiskState>,
}

/// What all handles to the directory share.
#[derive(Debug, Default)]
pub(in crate::jobs) struct DiskState {
    /// Bytes that may be written before the directory is looked at again. The first file that is
    /// written looks at what earlier runs left.
    unseen: AtomicI64,
    /// Whether the log says that files can't be written.
    is_failure_logged: AtomicBool,
}

/// No file takes so long to write: the process that began it is gone.
const ABANDONED: Duration = Duration::from_secs(3600);

/// What files begin with while they are written.
const TEMPORARY: &str = ".hullwright-";

impl DiskCache {
    pub(in crate::jobs) fn new(directory: PathBuf, budget: u64, state: Arc<DiskState>) -> Self {
        Self { directory, budget, state }
    }

    fn path_of(&self, key: ContentKey) -> Option<PathBuf> {
        Some(self.directory.join(key.name()?).with_extension("hulls"))
    }

    /// A file that can't be read counts as missing.
    pub(super) fn read(&self, key: ContentKey) -> Option<HullsFile> {
        let path = self.path_of(key)?;
        let file = HullsFile::read(&path).ok()?;
        // The time of the last use. Where it can't be set, the file is removed earlier.
        let _ = File::options()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_modified(SystemTime::now()));
        is_usable(&file).then_some(file)
    }

    /// The first file that can't be written is logged: the decomposition succeeded all the same.
    pub(in crate::jobs) fn write(&self, key: ContentKey, file: &HullsFile) {
        let Some(path) = self.path_of(key) else { return };
        let written = std::fs::create_dir_all(&self.directory)
            .map_err(|error| error.to_string())
            .and_then(|()| file.to_bytes().map_err(|error| error.to_string()))
            .and_then(|bytes| write_file(&path, &bytes).map_err(|error| error.to_string()));
        if let Err(error) = written {
            if !self.state.is_failure_logged.swap(true, Ordering::Relaxed) {
                log::warn!("{} could not be cached, and maybe others: {error}", path.display());
            }
            return;
        }
        let bytes = std::fs::metadata(&path).map_or(0, |metadata| metadata.len() as i64);
        if self.state.unseen.fetch_sub(bytes, Ordering::Relaxed) <= bytes {
            self.state.unseen.store(unseen(self.budget), Ordering::Relaxed);
            self.evict(SystemTime::now());
        }
    }

    /// Removes the least recently used files until the rest is within the budget, and what crashed
    /// processes left.
    fn evict(&self, now: SystemTime) {
        let Ok(entries) = std::fs::read_dir(&self.directory) else { return };
        let mut files = Vec::new();
        for (entry, metadata) in entries.filter_map(file_in) {
            let Ok(used) = metadata.modified() else { continue };
            let path = entry.path();
            if entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
                if now.duration_since(used).is_ok_and(|age| age > ABANDONED) {
                    remove(&path);
                }
            } else if path.extension().is_some_and(|suffix| suffix == "hulls") {
                files.push((used, path, metadata.len()));
            }
        }
        let mut bytes: u64 = files.iter().map(|(.., bytes)| bytes).sum();
        if bytes <= self.budget {
            return;
        }
        // By name where times are equal, so that processes agree.
        files.sort();
        let kept = kept(self.budget);
        for (_, path, size) in files {
            if bytes <= kept {
                break;
            }
            remove(&path);
            bytes -= size;
        }
    }
}

/// Files that are gone meanwhile, or have no metadata, are left out.
fn file_in(entry: std::io::Result<DirEntry>) -> Option<(DirEntry, Metadata)> {
    let entry = entry.ok()?;
    let metadata = entry.metadata().ok()?;
    metadata.is_file().then_some((entry, metadata))
}

/// Another process may have removed it, or hold it open where that keeps it; then it goes next
/// time.
fn remove(path: &Path) {
    let _ = std::fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache(directory: &Path, budget: u64) -> DiskCache {
        DiskCache { directory: directory.into(), budget, state: Arc::default() }
    }

    /// Files of 100 bytes, used at these seconds.
    fn fill(directory: &Path, used: &[(&str, u64)]) {
        for (name, seconds) in used {
            let path = directory.join(name);
            std::fs::write(&path, [0; 100]).unwrap();
            let time = SystemTime::UNIX_EPOCH + Duration::from_secs(*seconds);
            File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
        }
    }

    fn names(directory: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(directory).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn the_least_recently_used_go_first_and_other_files_stay() {
        let place = tempfile::tempdir().unwrap();
        fill(
            place.path(),
            &[("a.hulls", 30), ("b.hulls", 10), ("c.hulls", 20), ("d.hulls", 40), ("notes.txt", 1)],
        );
        let cache = cache(place.path(), 350);
        cache.evict(SystemTime::now());
        assert_eq!(names(place.path()), ["a.hulls", "c.hulls", "d.hulls", "notes.txt"]);
        cache.evict(SystemTime::now());
        assert_eq!(names(place.path()).len(), 4);
    }

    #[test]
    fn what_a_crashed_process_left_is_removed_and_what_is_being_written_stays() {
        let place = tempfile::tempdir().unwrap();
        fill(place.path(), &[(".hullwright-old", 1000), (".hullwright-new", 9000)]);
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(9010);
        cache(place.path(), 1000).evict(now);
        assert_eq!(names(place.path()), [".hullwright-new"]);
    }

    #[test]
    fn several_may_evict_at_once() {
        let place = tempfile::tempdir().unwrap();
        let used: Vec<(String, u64)> =
            (0..200).map(|index| (format!("{index:03}.hulls"), index)).collect();
        let used: Vec<(&str, u64)> = used.iter().map(|(name, at)| (name.as_str(), *at)).collect();
        fill(place.path(), &used);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| cache(place.path(), 10_000).evict(SystemTime::now()));
            }
        });
        let left = names(place.path());
        assert!(left.len() <= 100 && left.last().is_some_and(|name| name == "199.hulls"));
    }
}
