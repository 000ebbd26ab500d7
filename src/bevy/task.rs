//! The work on one input, from its triangles to a shape: on a thread in the background, or step by
//! step.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use bevy::math::Affine3A;
use bevy_rapier3d::rapier::geometry::{SharedShape, TriMeshFlags};
use bevy_rapier3d::rapier::math::Vector;

use crate::hulls_format::HullsFile;
use crate::{Control, Decomposer, Parameters, mass_properties};

use super::library::{
    Claim, Content, Library, Material, content_of, read_from_disk, write_to_disk,
};
use super::mesh_data::MeshData;
use super::placement::{MapKey, map_hulls};
use super::{DecompositionFailure, Origin};

/// What there is to be done.
pub(super) enum Task {
    /// From a mesh: hulls within the parameters, or without parameters the mesh as it is.
    Mesh { data: MeshData, parameters: Option<Parameters> },
    /// Another shape of what is known.
    Shape { content: Content, material: Arc<Material>, origin: Origin },
}

/// What came of it.
#[derive(Debug)]
pub(super) enum Outcome {
    Made(Made),
    /// Another job is at work on the same content.
    InWork(Content),
}

#[derive(Debug, Clone)]
pub(super) struct Made {
    pub content: Content,
    pub material: Arc<Material>,
    pub shape: SharedShape,
    pub origin: Origin,
}

/// A job that can be interrupted between its steps.
pub(super) struct Machine {
    state: State,
    map: Affine3A,
    library: Library,
    cache_bytes: usize,
    disk_cache: Option<PathBuf>,
}

enum State {
    Start(Box<Task>),
    Decompose(Box<Decomposing>),
    Done,
}

struct Decomposing {
    decomposer: Decomposer,
    data: MeshData,
    content: Content,
    claim: Claim,
}

impl Machine {
    pub(super) fn new(
        task: Task,
        map: Affine3A,
        library: Library,
        cache_bytes: usize,
        disk_cache: Option<PathBuf>,
    ) -> Self {
        Self { state: State::Start(Box::new(task)), map, library, cache_bytes, disk_cache }
    }

    /// Does all the work.
    pub(super) fn run(mut self, control: &Control) -> Result<Outcome, DecompositionFailure> {
        loop {
            if let Some(outcome) = self.step(control)? {
                return Ok(outcome);
            }
        }
    }

    /// Does a part of the work.
    pub(super) fn step(
        &mut self,
        control: &Control,
    ) -> Result<Option<Outcome>, DecompositionFailure> {
        match std::mem::replace(&mut self.state, State::Done) {
            State::Start(task) => match *task {
                Task::Shape { content, material, origin } => {
                    self.finish(content, material, origin).map(Some)
                }
                Task::Mesh { data, parameters } => self.start(data, parameters.as_ref()),
            },
            State::Decompose(mut work) => match work.decomposer.step(control)? {
                None => {
                    self.state = State::Decompose(work);
                    Ok(None)
                }
                Some(decomposition) => {
                    let Decomposing { data, content, claim, .. } = *work;
                    let MeshData { positions, triangles } = &data;
                    let mass = mass_properties(positions, triangles, &decomposition.hulls, 1.0)?;
                    let file = HullsFile::new("", &decomposition).with_mass_properties(mass);
                    if let Some(directory) = &self.disk_cache {
                        write_to_disk(directory, content, &file);
                    }
                    let material = Arc::new(Material::Hulls(Box::new(file)));
                    let outcome = self.finish(content, material, Origin::Decomposed);
                    drop(claim);
                    outcome.map(Some)
                }
            },
            State::Done => Err(crate::Error::Finished.into()),
        }
    }

    fn start(
        &mut self,
        data: MeshData,
        parameters: Option<&Parameters>,
    ) -> Result<Option<Outcome>, DecompositionFailure> {
        let content = content_of(&data, parameters);
        if let Some(material) = self.library.material(content) {
            return self.finish(content, material, Origin::Shared).map(Some);
        }
        let Some(claim) = self.library.claim(content) else {
            return Ok(Some(Outcome::InWork(content)));
        };
        let Some(parameters) = parameters else {
            let material = Arc::new(Material::Triangles(data));
            return self.finish(content, material, Origin::Decomposed).map(Some);
        };
        let from_disk = self.disk_cache.as_ref().and_then(|path| read_from_disk(path, content));
        if let Some(file) = from_disk {
            let material = Arc::new(Material::Hulls(Box::new(file)));
            return self.finish(content, material, Origin::Disk).map(Some);
        }
        // Jobs are serial: several run at once, and the game needs threads too.
        let parameters = Parameters { parallel: false, ..parameters.clone() };
        let decomposer = Decomposer::new(&data.positions, &data.triangles, &parameters)?;
        self.state = State::Decompose(Box::new(Decomposing { decomposer, data, content, claim }));
        Ok(None)
    }

    fn finish(
        &self,
        content: Content,
        material: Arc<Material>,
        origin: Origin,
    ) -> Result<Outcome, DecompositionFailure> {
        let shape = shape_of(&material, &self.map)?;
        let map = MapKey::new(&self.map);
        self.library.insert(content, &material, map, &shape, self.cache_bytes);
        Ok(Outcome::Made(Made { content, material, shape, origin }))
    }
}

fn shape_of(material: &Material, map: &Affine3A) -> Result<SharedShape, DecompositionFailure> {
    match material {
        Material::Hulls(file) => {
            let hulls = map_hulls(&file.hulls, map)?;
            Ok(crate::rapier::shape(&hulls, [1.0; 3])?)
        }
        Material::Triangles(data) => triangle_mesh(data, map),
    }
}

/// Rapier's triangle mesh. Triangles with a corner that is not finite would spoil its tree.
fn triangle_mesh(data: &MeshData, map: &Affine3A) -> Result<SharedShape, DecompositionFailure> {
    let place = |point: &[f32; 3]| map.transform_point3((*point).into());
    let points: Vec<Vector> = data.positions.iter().map(place).collect();
    let is_usable = |triangle: &&[u32; 3]| triangle.iter().all(|v| points[*v as usize].is_finite());
    let triangles: Vec<[u32; 3]> = data.triangles.iter().filter(is_usable).copied().collect();
    if triangles.is_empty() {
        return Err(crate::Error::NothingUsable {
            triangles: data.triangles.len(),
            degenerate: 0,
            non_finite: data.triangles.len(),
        }
        .into());
    }
    let points = points.into_iter().map(|p| if p.is_finite() { p } else { Vector::ZERO }).collect();
    SharedShape::trimesh_with_flags(points, triangles, TriMeshFlags::MERGE_DUPLICATE_VERTICES)
        .map_err(|error| DecompositionFailure::TriangleMesh(error.to_string()))
}

/// A share of the work that another thread can read.
#[derive(Debug, Clone, Default)]
pub(super) struct ProgressCell(Arc<AtomicU32>);

impl ProgressCell {
    /// A control that reports here.
    pub(super) fn control(&self) -> Control {
        let cell = self.0.clone();
        Control::new().with_progress(move |progress| {
            cell.store(progress.fraction.to_bits(), Ordering::Relaxed)
        })
    }

    pub(super) fn get(&self) -> f32 {
        f32::from_bits(self.0.load(Ordering::Relaxed))
    }
}
