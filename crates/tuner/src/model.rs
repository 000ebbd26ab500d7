//! The mesh that is tuned: one of the bundled models, or a file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, Task, block_on, poll_once};
use hullwright::TriangleMesh;
use hullwright_demos::ASSETS;
use hullwright_formats::read_mesh;

use crate::hang::{Hang, find_hang};

/// The bundled models, the most telling first.
pub const BUNDLED: [&str; 14] = [
    "mug", "teapot", "chair", "dog", "bowl", "lamp", "gear", "spring", "torus", "table", "leaf",
    "l_prism", "u_prism", "plus",
];

/// The diagonal that every mesh has on the stage, in metres, however large it is in its file:
/// Rapier's tolerances are lengths, and so is the camera's distance.
pub const SIZE: f64 = 2.0;

/// A mesh and how it stands on the stage.
#[derive(Debug)]
pub struct Model {
    /// The file's name without its suffix.
    pub name: String,
    /// In its own units.
    pub mesh: TriangleMesh,
    /// In its own units; it goes to the stage's origin.
    centre: [f64; 3],
    /// Metres of the stage for each of its units.
    scale: f64,
    /// Half its width, height and depth on the stage, in metres.
    pub half: Vec3,
    /// How it hangs best.
    pub hang: Hang,
}

impl Model {
    /// Reads a file and looks at it. Slow for large files: for a background task.
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = read_mesh(path).map_err(|error| error.to_string())?;
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into());
        Self::new(name, file.mesh)
    }

    fn new(name: String, mesh: TriangleMesh) -> Result<Self, String> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let used = mesh.triangles.iter().flatten();
        for point in used.filter_map(|vertex| mesh.positions.get(*vertex as usize)) {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let size = [0, 1, 2].map(|axis| high[axis] - low[axis]);
        let diagonal = size.iter().map(|side| side * side).sum::<f64>().sqrt();
        if !diagonal.is_finite() || diagonal <= 0.0 {
            return Err(format!("{name} holds no triangles that can be shown"));
        }
        let scale = SIZE / diagonal;
        let half = Vec3::from(size.map(|side| (side * scale / 2.0) as f32));
        let centre = [0, 1, 2].map(|axis| (low[axis] + high[axis]) / 2.0);
        let mut model = Self { name, mesh, centre, scale, half, hang: Hang::default() };
        model.hang = find_hang(&corners(&model.mesh_on_stage()));
        Ok(model)
    }

    /// A point of the mesh on the stage, with the middle of the mesh at the origin.
    pub fn on_stage(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (point[axis] - self.centre[axis]) * self.scale)
    }

    /// The whole mesh on the stage.
    pub fn mesh_on_stage(&self) -> TriangleMesh {
        let positions = self.mesh.positions.iter().map(|&point| self.on_stage(point)).collect();
        TriangleMesh { positions, ..self.mesh.clone() }
    }

    /// The diagonal of its box, in its own units.
    pub fn diagonal(&self) -> f64 {
        SIZE / self.scale
    }
}

/// Corners of triangles on the stage; those that can't be drawn are left out.
fn corners(mesh: &TriangleMesh) -> Vec<[Vec3; 3]> {
    let point = |vertex: u32| {
        let point = Vec3::from(mesh.positions.get(vertex as usize)?.map(|x| x as f32));
        point.is_finite().then_some(point)
    };
    let corners = |&[a, b, c]: &[u32; 3]| Some([point(a)?, point(b)?, point(c)?]);
    mesh.triangles.iter().filter_map(corners).collect()
}

/// What is drawn of a mesh on the stage: flat triangles, as the decomposition sees them.
pub fn drawn(mesh: &TriangleMesh) -> Mesh {
    let triangles = corners(mesh);
    let normals: Vec<Vec3> = triangles
        .iter()
        .flat_map(|[a, b, c]| [(b - a).cross(c - a).normalize_or_zero(); 3])
        .collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, triangles.into_flattened())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
}

/// The path of a bundled model.
pub fn bundled(name: &str) -> PathBuf {
    Path::new(ASSETS).join(format!("{name}.glb"))
}

/// A model, and the mesh that draws it.
type Loaded = Result<(Arc<Model>, Mesh), String>;

/// The model on the stage, and the one that is being read.
#[derive(Resource, Default)]
pub struct Library {
    /// On the stage.
    pub current: Option<Arc<Model>>,
    /// Draws it.
    pub drawn: Handle<Mesh>,
    /// What went wrong with the last file, for the user.
    pub error: Option<String>,
    reading: Option<Task<Loaded>>,
}

impl Library {
    /// Reads a file in the background; the model on the stage stays until then.
    pub fn open(&mut self, path: impl Into<PathBuf>) {
        let path = path.into();
        self.error = None;
        self.reading = Some(AsyncComputeTaskPool::get().spawn(async move {
            let model = Arc::new(Model::read(&path)?);
            let drawn = drawn(&model.mesh_on_stage());
            Ok((model, drawn))
        }));
    }

    /// Whether a file is being read.
    pub fn is_reading(&self) -> bool {
        self.reading.is_some()
    }
}

/// Takes what was read.
pub fn take_read(mut library: ResMut<Library>, mut meshes: ResMut<Assets<Mesh>>) {
    let Some(task) = library.bypass_change_detection().reading.as_mut() else { return };
    let Some(loaded) = block_on(poll_once(task)) else { return };
    library.reading = None;
    match loaded {
        Ok((model, drawn)) => {
            library.drawn = meshes.add(drawn);
            library.current = Some(model);
        }
        Err(error) => library.error = Some(error),
    }
}
