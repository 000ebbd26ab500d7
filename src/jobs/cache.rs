//! Results that are known in memory, within a number of bytes: hulls by the content of their mesh,
//! and shapes of them by scale. It is shared with the jobs; its lock is held for a look-up only.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::asset::UntypedAssetId;
use bevy::platform::collections::{HashMap, HashSet};
use hullwright::hulls_format::HullsFile;
use hullwright::{ConvexHull, Hull, PartShare};
use hullwright_parry::parry3d::shape::SharedShape;

use super::platform::{DiskCache, DiskState};
use super::request::{ContentKey, MapKey, MeshData};
use crate::tag::outcomes::HullSource;
use crate::tag::parameters::PrimitiveKind;
use crate::tag::settings::HullwrightSettings;

/// What a collider is made of, in its mesh's own space.
#[derive(Debug)]
pub(crate) enum ColliderGeometry {
    /// Hulls, with mass properties at a density of 1, and for each hull the parts that it is made
    /// of, where there are several and the file does not say it.
    Hulls(Box<HullsFile>, Vec<Vec<PartShare>>),
    /// The mesh itself.
    Triangles(MeshData),
    /// The mesh around which a box, ball or capsule is put.
    Primitive(PrimitiveKind, MeshData),
}

impl ColliderGeometry {
    /// Hulls in single precision, as a glTF file holds them: whichever way they come, their
    /// colliders are the same under any scale.
    pub(super) fn of_hulls(mut file: HullsFile, shares: Vec<Vec<PartShare>>) -> Arc<Self> {
        for x in file.hulls.iter_mut().flat_map(|hull| hull.shape.points.as_flattened_mut()) {
            let rounded = *x as f32;
            // What is beyond its range is an error of the collider.
            if rounded.is_finite() {
                *x = rounded.into();
            }
        }
        Arc::new(Self::Hulls(Box::new(file), shares))
    }

    /// About how much memory it takes.
    fn bytes(&self) -> usize {
        match self {
            Self::Hulls(file, _) => {
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

    /// Keeps what was made with this map, and drops what was not used for longest until `limit`
    /// bytes are left.
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
        let directory = settings.cache.disk.clone()?;
        Some(DiskCache::new(directory, settings.cache.disk_bytes, self.disk.clone()))
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
