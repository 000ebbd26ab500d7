//! What the examples without a window share: an app, bundled meshes, and whether all is ready.

pub mod physics;

use std::path::Path;
use std::time::Duration;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_hullwright::prelude::*;
use hullwright_formats::read_mesh;

/// Time that passes from update to update, however long they take.
const FRAME: Duration = Duration::from_micros(16_667);

/// Just what physics and the plugin need of Bevy.
pub fn app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    physics::plugins(&mut app);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    // `App::run` does that elsewhere; these examples update by themselves.
    app.finish();
    app.cleanup();
    app
}

/// The path of a bundled model.
pub fn bundled(name: &str) -> String {
    format!("{}/assets/{name}.glb", env!("CARGO_MANIFEST_DIR"))
}

pub struct Model {
    pub mesh: Handle<Mesh>,
    pub triangles: usize,
    /// Of the bounding box.
    pub diagonal: f32,
}

/// Reads any file that Hullwright reads, all of its meshes as one.
pub fn load(app: &mut App, path: impl AsRef<Path>) -> Result<Model, hullwright::Error> {
    let mesh = read_mesh(path)?.mesh;
    let positions: Vec<Vec3> =
        mesh.positions.iter().map(|point| Vec3::from(point.map(|x| x as f32))).collect();
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let indices = mesh.triangles.iter().flatten().copied().collect();
    let triangles = mesh.triangles.len();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices));
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    Ok(Model { mesh, triangles, diagonal: low.distance(high) })
}

/// Whether nothing that is tagged waits or runs.
pub fn is_finished(app: &mut App) -> bool {
    let world = app.world_mut();
    world.query::<&DecompositionStatus>().iter(world).all(DecompositionStatus::is_finished)
}
