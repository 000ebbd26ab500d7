//! What is known already: hulls by the content of their mesh, and shapes of them by scale. Shared
//! with the jobs, so nobody holds its lock for longer than a look-up.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::asset::AssetId;
use bevy::platform::collections::{HashMap, HashSet};
use bevy::prelude::*;
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::hulls_format::HullsFile;
use crate::{ALGORITHM_VERSION, Parameters};

use super::baked::BakedHulls;
use super::mesh_data::MeshData;
use super::placement::MapKey;

/// What a body is made of, in its mesh's own space.
#[derive(Debug)]
pub(super) enum Material {
    /// Hulls, with mass properties at a density of 1.
    Hulls(Box<HullsFile>),
    /// The mesh itself.
    Triangles(MeshData),
}

/// Names a material by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Content {
    /// Hash of a mesh, the parameters and the algorithm's version.
    Mesh([u8; 32]),
    Baked(AssetId<BakedHulls>),
}

/// Hashes what determines a result. O(size).
pub(super) fn content_of(data: &MeshData, parameters: Option<&Parameters>) -> Content {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&ALGORITHM_VERSION.to_le_bytes());
    hasher.update(parameters_text(parameters).as_bytes());
    hasher.update(&(data.positions.len() as u64).to_le_bytes());
    let mut bytes = Vec::with_capacity(12 * data.positions.len().max(data.triangles.len()));
    bytes.extend(data.positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    hasher.update(&bytes);
    bytes.clear();
    bytes.extend(data.triangles.iter().flatten().flat_map(|x| x.to_le_bytes()));
    hasher.update(&bytes);
    Content::Mesh(*hasher.finalize().as_bytes())
}

/// Parameters as a text that differs if the result may. On how many threads it is made does not
/// matter.
pub(super) fn parameters_text(parameters: Option<&Parameters>) -> String {
    match parameters {
        Some(parameters) => format!("{:?}", Parameters { parallel: false, ..parameters.clone() }),
        None => "triangles".into(),
    }
}

#[derive(Resource, Clone, Default)]
pub(super) struct Library(Arc<Mutex<Shelves>>);

#[derive(Default)]
pub(super) struct Shelves {
    entries: HashMap<Content, Entry>,
    in_work: HashSet<Content>,
    bytes: usize,
    /// Counts look-ups; the least recently used goes first.
    clock: u64,
}

struct Entry {
    material: Arc<Material>,
    shapes: HashMap<MapKey, SharedShape>,
    bytes: usize,
    used: u64,
}

/// A shape takes this much of the hulls' or triangles' own size: single precision, but with
/// topology and a tree.
const SHAPE_SHARE: usize = 2;

impl Library {
    /// A poisoned lock is as good as another: nothing is left half done under it.
    fn lock(&self) -> MutexGuard<'_, Shelves> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn material(&self, content: Content) -> Option<Arc<Material>> {
        self.lock().touch(content).map(|entry| entry.material.clone())
    }

    pub(super) fn shape(
        &self,
        content: Content,
        map: MapKey,
    ) -> Option<(Arc<Material>, SharedShape)> {
        let mut shelves = self.lock();
        let entry = shelves.touch(content)?;
        Some((entry.material.clone(), entry.shapes.get(&map)?.clone()))
    }

    pub(super) fn insert(
        &self,
        content: Content,
        material: &Arc<Material>,
        map: MapKey,
        shape: &SharedShape,
        limit: usize,
    ) {
        self.lock().insert(content, material, map, shape, limit);
    }

    pub(super) fn remove(&self, content: Content) {
        self.lock().remove(content);
    }

    /// Says that somebody works at it, unless somebody does already.
    pub(super) fn claim(&self, content: Content) -> Option<Claim> {
        let is_free = self.lock().in_work.insert(content);
        is_free.then(|| Claim { library: self.clone(), content })
    }

    pub(super) fn is_claimed(&self, content: Content) -> bool {
        self.lock().in_work.contains(&content)
    }

    /// Number of entries and their size.
    pub(super) fn size(&self) -> (usize, usize) {
        let shelves = self.lock();
        (shelves.entries.len(), shelves.bytes)
    }
}

impl Shelves {
    fn touch(&mut self, content: Content) -> Option<&mut Entry> {
        self.clock += 1;
        let entry = self.entries.get_mut(&content)?;
        entry.used = self.clock;
        Some(entry)
    }

    fn insert(
        &mut self,
        content: Content,
        material: &Arc<Material>,
        map: MapKey,
        shape: &SharedShape,
        limit: usize,
    ) {
        self.clock += 1;
        let own = material.bytes();
        let entry = self.entries.entry(content).or_insert_with(|| {
            self.bytes += own;
            Entry { material: material.clone(), shapes: HashMap::default(), bytes: own, used: 0 }
        });
        entry.used = self.clock;
        if entry.shapes.insert(map, shape.clone()).is_none() {
            entry.bytes += SHAPE_SHARE * own;
            self.bytes += SHAPE_SHARE * own;
        }
        while self.bytes > limit {
            let oldest = self.entries.iter().min_by_key(|(_, entry)| entry.used);
            let Some(content) = oldest.map(|(content, _)| *content) else { break };
            self.remove(content);
        }
    }

    fn remove(&mut self, content: Content) {
        if let Some(entry) = self.entries.remove(&content) {
            self.bytes -= entry.bytes;
        }
    }
}

/// Ends with the work, however that ends.
pub(super) struct Claim {
    library: Library,
    content: Content,
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.library.lock().in_work.remove(&self.content);
    }
}

impl Material {
    /// About how much memory it takes.
    fn bytes(&self) -> usize {
        match self {
            Self::Hulls(file) => {
                let of_hull = |hull: &crate::Hull| {
                    size_of_val(&*hull.points) + size_of_val(&*hull.triangles) + size_of_val(hull)
                };
                file.hulls.iter().map(of_hull).sum()
            }
            Self::Triangles(data) => size_of_val(&*data.positions) + size_of_val(&*data.triangles),
        }
    }
}

fn path_of(directory: &Path, content: Content) -> Option<PathBuf> {
    let Content::Mesh(hash) = content else { return None };
    let name: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    Some(directory.join(name).with_extension("hulls"))
}

/// What the cache on disk holds. A file that can't be read is as good as none.
pub(super) fn read_from_disk(directory: &Path, content: Content) -> Option<HullsFile> {
    let file = HullsFile::read(path_of(directory, content)?).ok()?;
    (file.is_current() && file.mass_properties.is_some()).then_some(file)
}

/// A cache that can't be written is no failure of the decomposition.
pub(super) fn write_to_disk(directory: &Path, content: Content, file: &HullsFile) {
    let Some(path) = path_of(directory, content) else { return };
    let written = std::fs::create_dir_all(directory)
        .map_err(|error| error.to_string())
        .and_then(|()| file.write(&path).map_err(|error| error.to_string()));
    if let Err(error) = written {
        log::warn!("{} could not be cached: {error}", path.display());
    }
}
