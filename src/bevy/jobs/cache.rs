//! The cache in memory: hulls by the content of their mesh, and shapes of them by scale. Shared
//! with the jobs; its lock is held for a look-up only.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::hulls_format::HullsFile;
use crate::{ConvexHull, Hull};

use crate::bevy::collider::placement::MapKey;
use crate::bevy::jobs::content::ContentKey;
use crate::bevy::jobs::disk_cache::WrittenBytes;
use crate::bevy::jobs::mesh_data::MeshData;
use crate::bevy::jobs::primitive::PrimitiveKind;

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

/// A handle to the cache; clones share it.
#[derive(Resource, Clone, Default)]
pub(crate) struct GeometryCache {
    inner: Arc<Mutex<CacheInner>>,
    /// To the cache on disk.
    pub written: WrittenBytes,
}

#[derive(Default)]
struct CacheInner {
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
    fn lock(&self) -> MutexGuard<'_, CacheInner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn geometry(&self, key: ContentKey) -> Option<Arc<ColliderGeometry>> {
        self.lock().touch(key).map(|entry| entry.geometry.clone())
    }

    pub(crate) fn shape(
        &self,
        key: ContentKey,
        map: MapKey,
    ) -> Option<(Arc<ColliderGeometry>, SharedShape)> {
        let mut inner = self.lock();
        let entry = inner.touch(key)?;
        Some((entry.geometry.clone(), entry.shapes.get(&map)?.clone()))
    }

    pub(crate) fn insert(
        &self,
        key: ContentKey,
        geometry: &Arc<ColliderGeometry>,
        map: MapKey,
        shape: &SharedShape,
    ) {
        self.lock().insert(key, geometry, map, shape);
    }

    /// Drops what was not used for longest, until `limit` bytes are left.
    pub(crate) fn shrink_to(&self, limit: usize) {
        self.lock().shrink_to(limit);
    }

    pub(crate) fn remove(&self, key: ContentKey) {
        self.lock().remove(key);
    }

    /// Claims the work on a content, unless another job has it.
    pub(crate) fn claim(&self, key: ContentKey) -> Option<WorkClaim> {
        let is_free = self.lock().in_progress.insert(key);
        is_free.then(|| WorkClaim { cache: self.clone(), key })
    }

    pub(crate) fn is_claimed(&self, key: ContentKey) -> bool {
        self.lock().in_progress.contains(&key)
    }

    /// Number of entries and their size.
    pub(crate) fn size(&self) -> (usize, usize) {
        let inner = self.lock();
        (inner.entries.len(), inner.bytes)
    }
}

impl CacheInner {
    fn touch(&mut self, key: ContentKey) -> Option<&mut CacheEntry> {
        self.clock += 1;
        let entry = self.entries.get_mut(&key)?;
        entry.last_used = self.clock;
        Some(entry)
    }

    fn insert(
        &mut self,
        key: ContentKey,
        geometry: &Arc<ColliderGeometry>,
        map: MapKey,
        shape: &SharedShape,
    ) {
        self.clock += 1;
        let bytes = geometry.bytes();
        let entry = self.entries.entry(key).or_insert_with(|| {
            self.bytes += bytes;
            let (geometry, shapes) = (geometry.clone(), HashMap::default());
            CacheEntry { geometry, shapes, bytes, last_used: 0 }
        });
        entry.last_used = self.clock;
        if entry.shapes.insert(map, shape.clone()).is_none() {
            entry.bytes += SHAPE_SHARE * bytes;
            self.bytes += SHAPE_SHARE * bytes;
        }
    }

    fn shrink_to(&mut self, limit: usize) {
        while self.bytes > limit {
            let oldest = self.entries.iter().min_by_key(|(_, entry)| entry.last_used);
            let Some(key) = oldest.map(|(key, _)| *key) else { break };
            self.remove(key);
        }
    }

    fn remove(&mut self, key: ContentKey) {
        if let Some(entry) = self.entries.remove(&key) {
            self.bytes -= entry.bytes;
        }
    }
}

/// Released when the work ends, however it ends.
pub(crate) struct WorkClaim {
    cache: GeometryCache,
    key: ContentKey,
}

impl Drop for WorkClaim {
    fn drop(&mut self) {
        self.cache.lock().in_progress.remove(&self.key);
    }
}
