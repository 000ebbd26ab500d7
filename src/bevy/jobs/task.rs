//! One decomposition, from its triangles to a shape, in steps: on a thread in the background, or
//! step by step on the main thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use bevy::math::Affine3A;
use bevy_rapier3d::rapier::geometry::{SharedShape, TriMeshFlags};

use crate::hulls_format::HullsFile;
use crate::{Control, Decomposer, Error, MeshView, Method, MethodReport, mass_properties_with};

use crate::bevy::collider::placement::{MapKey, map_hulls};
use crate::bevy::jobs::baked_scene::SceneGeometry;
use crate::bevy::jobs::cache::{ColliderGeometry, GeometryCache, WorkClaim};
use crate::bevy::jobs::content::ContentKey;
use crate::bevy::jobs::disk_cache::DiskCache;
use crate::bevy::jobs::mesh_data::MeshData;
use crate::bevy::jobs::primitive::primitive_around;
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::parameters::Goal;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::HullSource;

/// What a task starts from.
pub(crate) enum TaskInput {
    /// A mesh, and what to make of it.
    Mesh {
        data: MeshData,
        goal: Goal,
        /// Where its hulls may be found.
        baked: Option<Arc<SceneGeometry>>,
    },
    /// Known geometry, of which another shape is wanted.
    Geometry { key: ContentKey, geometry: Arc<ColliderGeometry>, source: HullSource },
}

/// What a task ends with.
#[derive(Debug)]
pub(crate) enum TaskOutput {
    Built(BuiltCollider),
    /// Another job is at work on the same content.
    InProgress(ContentKey),
}

/// A shape that is ready, with what it was made of.
#[derive(Debug, Clone)]
pub(crate) struct BuiltCollider {
    pub key: ContentKey,
    pub geometry: Arc<ColliderGeometry>,
    pub shape: SharedShape,
    pub source: HullSource,
}

/// Work that can be interrupted between its steps.
pub(crate) struct DecompositionTask {
    /// What the first step takes.
    input: Option<TaskInput>,
    /// What later steps go on with.
    work: Option<MeshInProgress>,
    map: Affine3A,
    cache: GeometryCache,
    cache_bytes: usize,
    disk_cache: Option<DiskCache>,
    primitives: bool,
}

struct MeshInProgress {
    decomposer: Decomposer<MethodReport>,
    method: Method,
    data: MeshData,
    key: ContentKey,
    claim: WorkClaim,
}

impl DecompositionTask {
    pub(crate) fn new(
        input: TaskInput,
        map: Affine3A,
        cache: GeometryCache,
        settings: &HullwrightSettings,
    ) -> Self {
        let disk_cache = DiskCache::new(settings, &cache.written);
        let HullwrightSettings { cache_bytes, primitives, .. } = *settings;
        Self { input: Some(input), work: None, map, cache, cache_bytes, disk_cache, primitives }
    }

    /// Runs to the end.
    pub(crate) fn run(mut self, control: &Control) -> Result<TaskOutput, DecompositionError> {
        loop {
            if control.is_cancelled() {
                return Err(Error::Cancelled.into());
            }
            if let Some(output) = self.step(control)? {
                return Ok(output);
            }
        }
    }

    /// Runs one step; `None` if there are more.
    pub(crate) fn step(
        &mut self,
        control: &Control,
    ) -> Result<Option<TaskOutput>, DecompositionError> {
        match self.input.take() {
            Some(TaskInput::Geometry { key, geometry, source }) => {
                self.build(key, geometry, source).map(Some)
            }
            Some(TaskInput::Mesh { data, goal, baked }) => {
                self.start(data, &goal, baked.as_deref(), control)
            }
            None => self.decompose(),
        }
    }

    fn start(
        &mut self,
        data: MeshData,
        goal: &Goal,
        baked: Option<&SceneGeometry>,
        control: &Control,
    ) -> Result<Option<TaskOutput>, DecompositionError> {
        let key = ContentKey::of_mesh(&data, goal);
        if let Some(geometry) = baked.and_then(|baked| baked.get(key)) {
            return self.build(key, geometry.clone(), HullSource::Baked).map(Some);
        }
        if let Some(geometry) = self.cache.geometry(key) {
            return self.build(key, geometry, HullSource::Shared).map(Some);
        }
        let Some(claim) = self.cache.claim(key) else {
            return Ok(Some(TaskOutput::InProgress(key)));
        };
        let method = match goal {
            Goal::Hulls(method) => method,
            Goal::Triangles(_) => {
                let geometry = Arc::new(ColliderGeometry::Triangles(data));
                return self.build(key, geometry, HullSource::Decomposed).map(Some);
            }
            Goal::Primitive(kind) => {
                let geometry = Arc::new(ColliderGeometry::Primitive(*kind, data));
                return self.build(key, geometry, HullSource::Decomposed).map(Some);
            }
        };
        let from_disk = self.disk_cache.as_ref().and_then(|cache| cache.read(key));
        if let Some(file) = from_disk {
            let geometry = Arc::new(ColliderGeometry::Hulls(Box::new(file)));
            return self.build(key, geometry, HullSource::Disk).map(Some);
        }
        let decomposer = method.decomposer(data.view(), control)?;
        self.work = Some(MeshInProgress { decomposer, method: method.clone(), data, key, claim });
        Ok(None)
    }

    fn decompose(&mut self) -> Result<Option<TaskOutput>, DecompositionError> {
        let mut work = self.work.take().ok_or(Error::Finished)?;
        let Some(decomposition) = work.decomposer.step()? else {
            self.work = Some(work);
            return Ok(None);
        };
        let MeshInProgress { data, key, claim, method, .. } = work;
        let hulls = &decomposition.hulls;
        let mass = mass_properties_with(data.view(), hulls, 1.0, &method.solid())?;
        let file = HullsFile::new("", &decomposition).with_mass_properties(mass);
        if let Some(cache) = &self.disk_cache {
            cache.write(key, &file);
        }
        let geometry = Arc::new(ColliderGeometry::Hulls(Box::new(file)));
        let output = self.build(key, geometry, HullSource::Decomposed);
        // Only now that the cache has the result: whoever waits for the claim looks there.
        drop(claim);
        output.map(Some)
    }

    fn build(
        &self,
        key: ContentKey,
        geometry: Arc<ColliderGeometry>,
        source: HullSource,
    ) -> Result<TaskOutput, DecompositionError> {
        let shape = shape_of(&geometry, &self.map, self.primitives)?;
        let map = MapKey::new(&self.map);
        self.cache.insert(key, &geometry, map, &shape);
        self.cache.shrink_to(self.cache_bytes);
        Ok(TaskOutput::Built(BuiltCollider { key, geometry, shape, source }))
    }
}

fn shape_of(
    geometry: &ColliderGeometry,
    map: &Affine3A,
    primitives: bool,
) -> Result<SharedShape, DecompositionError> {
    match geometry {
        ColliderGeometry::Hulls(file) if primitives && is_scale(map) => {
            let scale = [map.matrix3.x_axis.x, map.matrix3.y_axis.y, map.matrix3.z_axis.z];
            Ok(crate::rapier::shape_with_primitives(file, scale)?)
        }
        ColliderGeometry::Hulls(file) => {
            let hulls = map_hulls(&file.hulls, map)?;
            Ok(crate::rapier::shape_from_points(&hulls, [1.0; 3])?)
        }
        ColliderGeometry::Triangles(data) => triangle_mesh(data, map),
        ColliderGeometry::Primitive(kind, data) => Ok(primitive_around(*kind, data, map)?),
    }
}

/// Whether a map does nothing but scale along the axes.
fn is_scale(map: &Affine3A) -> bool {
    let matrix = map.matrix3;
    let diagonal = [matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z];
    *map == Affine3A::from_scale(diagonal.into())
}

/// Without it, what slides over a floor stumbles over the edges between its triangles. Two-sided, since
/// with one side things fall through triangles that a modeller wound the wrong way round.
const TRIANGLE_FLAGS: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED;

/// Rapier's triangle mesh, for what doesn't move.
fn triangle_mesh(data: &MeshData, map: &Affine3A) -> Result<SharedShape, DecompositionError> {
    let place = |point: &[f32; 3]| map.transform_point3((*point).into()).to_array();
    let points: Vec<[f32; 3]> = data.positions.iter().map(place).collect();
    let mesh = MeshView::new(&points, &data.triangles);
    Ok(SharedShape::new(crate::rapier::triangle_mesh(mesh, TRIANGLE_FLAGS)?))
}

/// Contains a panic to one job: it costs a collider, not the game.
pub(crate) fn contain_panics(
    run: impl FnOnce() -> Result<TaskOutput, DecompositionError>,
) -> Result<TaskOutput, DecompositionError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run))
        .unwrap_or(Err(DecompositionError::Panicked))
}

/// A share of the work that another thread can read.
#[derive(Debug, Clone, Default)]
pub(crate) struct SharedProgress(Arc<AtomicU32>);

impl SharedProgress {
    /// A control that reports here. One thread per job: several run at once, and the game needs
    /// threads too.
    pub(crate) fn control(&self) -> Control {
        let cell = self.0.clone();
        Control::new().with_parallel(false).with_progress(move |progress| {
            cell.store(progress.fraction.to_bits(), Ordering::Relaxed)
        })
    }

    pub(crate) fn get(&self) -> f32 {
        f32::from_bits(self.0.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_that_says_so() {
        let result = contain_panics(|| panic!("on purpose, in a test"));
        assert!(matches!(result, Err(DecompositionError::Panicked)));
        assert!(DecompositionError::Panicked.to_string().contains("panicked"));
    }

    #[test]
    fn an_error_stays_what_it_is() {
        let result = contain_panics(|| Err(DecompositionError::NoPositions));
        assert!(matches!(result, Err(DecompositionError::NoPositions)));
    }
}
