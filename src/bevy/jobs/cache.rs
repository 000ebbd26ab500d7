//! Results that are known: in memory, hulls by the content of their mesh, and shapes of them by scale; on disk, a
//! `.hulls` file per mesh and parameters. Both keep within a number of bytes.
//!
//! The cache in memory is shared with the jobs; its lock is held for a look-up only. Several processes may share
//! that on disk: files are written all or nothing, and one that another process has removed is a missing one.

use std::fs::{DirEntry, File, Metadata};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use bevy::asset::UntypedAssetId;
use bevy::platform::collections::{HashMap, HashSet};
use bevy_rapier3d::rapier::geometry::SharedShape;
use sha2::{Digest, Sha256};

use super::request::{ContentKey, MapKey, MeshData};
use crate::bevy::tag::outcomes::HullSource;
use crate::bevy::tag::parameters::PrimitiveKind;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::hulls_format::{HullsFile, MeshHash};
use crate::{ConvexHull, Hull};

/// What a collider is made of, in its mesh's own space.
#[derive(Debug)]
pub(crate) enum ColliderGeometry {
    /// Hulls, with mass properties at a density of 1.
    Hulls(Box<HullsFile>),
    /// The mesh itself.
    Triangles(MeshData),
    /// The mesh around which a box, ball or capsule is put.
    Primitive(PrimitiveKind, MeshData),
}

impl ColliderGeometry {
    pub(super) fn of_hulls(file: HullsFile) -> Arc<Self> {
        Arc::new(Self::Hulls(Box::new(file)))
    }

    /// About how much memory it takes.
    fn bytes(&self) -> usize {
        match self {
            Self::Hulls(file) => {
                let of_hull = |hull: &Hull| {
                    let ConvexHull { points, triangles } = &hull.shape;
                    size_of_val(&**points) + size_of_val(&**triangles) + size_of_val(hull)
                };
                file.hulls.iter().map(of_hull).sum()
            }
            Self::Triangles(data) | Self::Primitive(_, data) => {
                size_of_val(&*data.positions) + size_of_val(&*data.triangles)
            }
        }
    }
}

/// A shape that is ready, with what it was made of.
#[derive(Debug, Clone)]
pub(crate) struct BuiltCollider {
    pub key: ContentKey,
    pub geometry: Arc<ColliderGeometry>,
    pub shape: SharedShape,
    pub source: HullSource,
}

/// A handle to the cache; clones share it.
#[derive(Clone, Default)]
pub(super) struct GeometryCache {
    memory: Arc<Mutex<Memory>>,
    disk: Arc<DiskState>,
}

#[derive(Default)]
struct Memory {
    entries: HashMap<ContentKey, CacheEntry>,
    in_progress: HashSet<ContentKey>,
    bytes: usize,
    /// Counts look-ups; the least recently used entry goes first.
    clock: u64,
}

struct CacheEntry {
    geometry: Arc<ColliderGeometry>,
    shapes: HashMap<MapKey, SharedShape>,
    bytes: usize,
    last_used: u64,
}

/// A shape takes this much of the hulls' or triangles' own size: single precision, but with
/// topology and a tree.
const SHAPE_SHARE: usize = 2;

impl GeometryCache {
    /// Ignores poisoning: no panic leaves the inside half changed.
    fn lock(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn geometry(&self, key: ContentKey) -> Option<Arc<ColliderGeometry>> {
        self.lock().touch(key).map(|entry| entry.geometry.clone())
    }

    /// The shape that was made with this map.
    pub(super) fn built(&self, key: ContentKey, map: MapKey) -> Option<BuiltCollider> {
        let mut memory = self.lock();
        let entry = memory.touch(key)?;
        let (geometry, shape) = (entry.geometry.clone(), entry.shapes.get(&map)?.clone());
        Some(BuiltCollider { key, geometry, shape, source: key.source_of_known() })
    }

    /// Keeps what was made with this map, and drops what was not used for longest until `limit` bytes are left.
    pub(super) fn insert(&self, built: &BuiltCollider, map: MapKey, limit: usize) {
        let mut memory = self.lock();
        memory.insert(built, map);
        while memory.bytes > limit {
            let oldest = memory.entries.iter().min_by_key(|(_, entry)| entry.last_used);
            let Some(key) = oldest.map(|(key, _)| *key) else { break };
            memory.remove(key);
        }
    }

    /// Removes what was made from a baked scene.
    pub(super) fn forget_asset(&self, asset: UntypedAssetId) {
        let mut memory = self.lock();
        let of_asset = |key: &&ContentKey| key.scene() == Some(asset);
        let keys: Vec<ContentKey> = memory.entries.keys().filter(of_asset).copied().collect();
        keys.into_iter().for_each(|key| memory.remove(key));
    }

    /// Claims the work on a content, unless another job has it.
    pub(super) fn claim(&self, key: ContentKey) -> Option<WorkClaim> {
        let is_free = self.lock().in_progress.insert(key);
        is_free.then(|| WorkClaim { cache: self.clone(), key })
    }

    pub(super) fn is_claimed(&self, key: ContentKey) -> bool {
        self.lock().in_progress.contains(&key)
    }

    /// Number of entries and their size.
    pub(super) fn size(&self) -> (usize, usize) {
        let memory = self.lock();
        (memory.entries.len(), memory.bytes)
    }

    /// The cache on disk; `None` if the settings name no directory.
    pub(super) fn on_disk(&self, settings: &HullwrightSettings) -> Option<DiskCache> {
        let (directory, state) = (settings.cache.disk.clone()?, self.disk.clone());
        Some(DiskCache { directory, budget: settings.cache.disk_bytes, state })
    }
}

impl Memory {
    fn touch(&mut self, key: ContentKey) -> Option<&mut CacheEntry> {
        self.clock += 1;
        let entry = self.entries.get_mut(&key)?;
        entry.last_used = self.clock;
        Some(entry)
    }

    fn insert(&mut self, built: &BuiltCollider, map: MapKey) {
        self.clock += 1;
        let bytes = built.geometry.bytes();
        let entry = self.entries.entry(built.key).or_insert_with(|| {
            self.bytes += bytes;
            let (geometry, shapes) = (built.geometry.clone(), HashMap::default());
            CacheEntry { geometry, shapes, bytes, last_used: 0 }
        });
        entry.last_used = self.clock;
        if entry.shapes.insert(map, built.shape.clone()).is_none() {
            entry.bytes += SHAPE_SHARE * bytes;
            self.bytes += SHAPE_SHARE * bytes;
        }
    }

    fn remove(&mut self, key: ContentKey) {
        if let Some(entry) = self.entries.remove(&key) {
            self.bytes -= entry.bytes;
        }
    }
}

/// Released when the work ends, however it ends.
pub(super) struct WorkClaim {
    cache: GeometryCache,
    key: ContentKey,
}

impl Drop for WorkClaim {
    fn drop(&mut self) {
        self.cache.lock().in_progress.remove(&self.key);
    }
}

/// A directory with files of results, the least recently used of which are removed.
#[derive(Debug, Clone)]
pub(super) struct DiskCache {
    directory: PathBuf,
    budget: u64,
    state: Arc<DiskState>,
}

/// What this process knows of the directory.
#[derive(Debug, Default)]
struct DiskState {
    /// Bytes that may be written before the directory is looked at again. The first file that is written looks at what
    /// earlier runs left.
    unseen: AtomicI64,
    /// Whether the log says that files can't be written.
    is_failure_logged: AtomicBool,
}

/// The directory is looked at once this share of the budget has been written, so that a thousand files
/// are not looked at for each that is written. The cache is larger than its budget by as much.
const UNSEEN_SHARE: u64 = 16;

/// After a removal there is room for this share of the budget, so that the next file does not remove
/// again.
const FREED_SHARE: u64 = 8;

/// No file takes so long to write: the process that began it is gone.
const ABANDONED: Duration = Duration::from_secs(3600);

/// What files begin with while they are written.
const TEMPORARY: &str = ".hullwright-";

impl DiskCache {
    fn path_of(&self, key: ContentKey) -> Option<PathBuf> {
        let ContentKey::Mesh { mesh, goal, scene: None } = key else { return None };
        let mut hasher = Sha256::new_with_prefix(mesh.as_bytes());
        hasher.update(goal);
        let name = MeshHash::from_bytes(hasher.finalize().into()).to_string();
        Some(self.directory.join(name).with_extension("hulls"))
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
        (file.is_current() && file.mass_properties.is_some()).then_some(file)
    }

    /// The first file that can't be written is logged: the decomposition succeeded all the same.
    pub(super) fn write(&self, key: ContentKey, file: &HullsFile) {
        let Some(path) = self.path_of(key) else { return };
        let written = std::fs::create_dir_all(&self.directory)
            .map_err(|error| error.to_string())
            .and_then(|()| file.write(&path).map_err(|error| error.to_string()));
        if let Err(error) = written {
            if !self.state.is_failure_logged.swap(true, Ordering::Relaxed) {
                log::warn!("{} could not be cached, and maybe others: {error}", path.display());
            }
            return;
        }
        let bytes = std::fs::metadata(&path).map_or(0, |metadata| metadata.len() as i64);
        if self.state.unseen.fetch_sub(bytes, Ordering::Relaxed) <= bytes {
            let unseen = (self.budget / UNSEEN_SHARE) as i64;
            self.state.unseen.store(unseen, Ordering::Relaxed);
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
        let kept = self.budget - self.budget / FREED_SHARE;
        for (_, path, size) in files {
            if bytes <= kept {
                break;
            }
            remove(&path);
            bytes -= size;
        }
    }
}

/// One that is gone meanwhile, or of which nothing is known, is left out.
fn file_in(entry: std::io::Result<DirEntry>) -> Option<(DirEntry, Metadata)> {
    let entry = entry.ok()?;
    let metadata = entry.metadata().ok()?;
    metadata.is_file().then_some((entry, metadata))
}

/// Another process may have removed it, or hold it open where that keeps it; then it goes next time.
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
