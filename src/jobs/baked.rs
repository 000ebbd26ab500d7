//! Baked hulls: `.hullscene` files as assets, with the hulls of one mesh or of a whole scene, and
//! the components that take hulls from there.

use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, HandleTemplate, LoadContext};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use hullwright::Method;
use hullwright::hulls_format::{
    BakedMesh, BakedTriangles, HullScene, HullsFile, HullsFileError, PlacedMesh, SceneLookup,
    surface_key,
};

use super::cache::ColliderGeometry;
use super::request::{ContentKey, MeshData};
use crate::tag::outcomes::{DecompositionError, DecompositionStatus};
use crate::tag::parameters::Goal;
use crate::tag::template::template_like_default;
use crate::tag::{DEFAULT_DENSITY, HullGrouping, setters};

/// Gives the entity a collider of baked hulls, without a look at any mesh. They are in the mesh's
/// own space, so it belongs where the mesh is, on the entity that has the `Mesh3d` or on the glTF
/// node.
///
/// Its scale is baked into the points as for
/// [`ConvexDecomposition`](crate::ConvexDecomposition).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_rapier3d::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// fn setup(mut commands: Commands, server: Res<AssetServer>) {
///     let props = server.load("props.hullscene");
///     commands.spawn((RigidBody::Dynamic, BakedDecomposition::new(props).with_mesh("mug")));
/// }
/// ```
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[require(DecompositionStatus, Transform)]
pub struct BakedDecomposition {
    /// The baked file.
    pub scene: Handle<BakedScene>,
    /// The name of a mesh in it, or of a node that shows the mesh; `None` for the only mesh.
    pub mesh: Option<String>,
    /// Mass per cubed unit of the world; positive. Default 1.
    pub density: f32,
    /// The mass of the whole collider in the world, whatever its scale, instead of the density;
    /// positive. Default `None`.
    pub mass: Option<f32>,
    /// As [`ConvexDecomposition::children`](crate::ConvexDecomposition::children).
    pub children: Option<HullGrouping>,
}

template_like_default! {
    BakedDecomposition => BakedDecompositionTemplate {
        handle scene: HandleTemplate<BakedScene>,
        mesh: Option<String>,
        density: f32,
        mass: Option<f32>,
        children: Option<HullGrouping>,
    }
}

impl Default for BakedDecomposition {
    fn default() -> Self {
        Self::new(Handle::default())
    }
}

impl BakedDecomposition {
    /// Of the only mesh in a file, with a density of 1.
    pub fn new(scene: Handle<BakedScene>) -> Self {
        Self { scene, mesh: None, density: DEFAULT_DENSITY, mass: None, children: None }
    }
}

setters! { BakedDecomposition:
    /// The same of the mesh with this name.
    with_mesh(mesh: impl Into<String>) = Some(mesh.into());
    /// The same with another density.
    with_density(density: f32) = density;
    /// The same with a child for each hull, or for each group of hulls.
    as_children(children: HullGrouping) = Some(children);
    /// The same with a mass of the whole, or with `None` again a density.
    with_mass(mass: impl Into<Option<f32>>) = mass.into();
}

/// Why a baked file or a recipe could not be loaded, or a baked file not saved.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum LoadHullsError {
    /// It could not be read.
    #[error(transparent)]
    Read(#[from] std::io::Error),
    /// It does not hold what it should.
    #[error(transparent)]
    Content(#[from] HullsFileError),
    /// It is a recipe that can't be followed.
    #[error("recipe: {0}")]
    Recipe(String),
}

/// The hulls of a scene's meshes, made before as `hullwright bake` does: the content of a
/// `.hullscene` file. To reflection it is one value, since the library's types name no engine.
#[derive(Asset, Reflect, Debug, Clone)]
#[reflect(opaque, Debug, Clone)]
#[type_path = "hullwright"]
pub struct BakedScene {
    scene: Arc<HullScene>,
    /// Where the meshes are that may be used, by content.
    usable: Arc<HashMap<ContentKey, usize>>,
    /// Where surfaces are, by what they are made of.
    surfaces: Arc<HashMap<[u8; 32], Vec<usize>>>,
    settings: BakedSceneSettings,
}

/// How a `.hullscene` file is taken. Bevy reads them from the file's `.meta`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct BakedSceneSettings {
    /// Whether a mesh gets its hulls also where another version of the algorithm made them. They
    /// keep the bound that the file says; a server and its players must decide alike. Default
    /// false: it is decomposed anew.
    pub accepts_other_versions: bool,
    /// Whether a glTF mesh is found by its asset path and label, as one that is on the GPU only. It
    /// is compared by its number of triangles and its bounding box alone, so what moved within that
    /// is not noticed, and hashing takes no time. Default false: by its content.
    pub by_label: bool,
}

impl BakedScene {
    /// Of a scene that is already in memory.
    pub fn new(scene: HullScene) -> Self {
        Self::with_settings(scene, BakedSceneSettings::default())
    }

    /// The same with settings.
    pub fn with_settings(scene: HullScene, settings: BakedSceneSettings) -> Self {
        let mut surfaces: HashMap<[u8; 32], Vec<usize>> = HashMap::default();
        for (index, surface) in scene.surfaces.iter().enumerate() {
            surfaces.entry(surface_key(&surface.parts, surface.bound)).or_default().push(index);
        }
        let (scene, surfaces) = (Arc::new(scene), Arc::new(surfaces));
        let mut made = Self { scene, usable: Arc::default(), surfaces, settings };
        let all = made.scene.meshes.iter().enumerate();
        let usable = all.filter(|(_, baked)| made.is_usable(baked)).map(|(index, baked)| {
            let goal = Goal::Hulls(baked.parameters.clone()).hash();
            (ContentKey::Mesh { mesh: baked.hash, goal, parts: None, scene: None }, index)
        });
        made.usable = Arc::new(usable.collect());
        made
    }

    /// What the file holds.
    pub fn scene(&self) -> &HullScene {
        &self.scene
    }

    /// The hulls of a mesh with this content, where they may be used.
    pub(super) fn hulls(&self, key: ContentKey) -> Option<HullsFile> {
        let baked = self.scene.meshes.get(*self.usable.get(&key.whole())?)?;
        Some(baked.hulls.clone())
    }

    pub(crate) fn has_surfaces(&self) -> bool {
        !self.surfaces.is_empty()
    }

    /// The surface within a bound of some meshes, in their order.
    pub(super) fn surface(&self, meshes: &[PlacedMesh], bound: f32) -> Option<MeshData> {
        let same = self.surfaces.get(&surface_key(meshes, bound))?;
        let (surface, order) = same.iter().find_map(|index| {
            let surface = self.scene.surfaces.get(*index)?;
            Some((surface, surface.order_of(meshes)?))
        })?;
        let mut data = MeshData { positions: surface.positions.clone(), ..MeshData::default() };
        for triangles in order.into_iter().flat_map(|part| surface.triangles_of(part)) {
            data.triangles.extend(triangles);
            data.part_ends.push(data.triangles.len() as u32);
        }
        Some(data)
    }

    /// The place of the mesh with a name; of the only mesh without one.
    pub(super) fn index_of(&self, name: Option<&str>) -> Result<usize, DecompositionError> {
        let meshes = &self.scene.meshes;
        let has_name = |baked: &BakedMesh| baked.names.iter().any(|own| Some(&**own) == name);
        let found = match name {
            Some(_) => meshes.iter().position(has_name),
            None => (meshes.len() == 1).then_some(0),
        };
        found.ok_or_else(|| {
            let names = meshes.iter().flat_map(|baked| &baked.names);
            let (name, names) = (name.map(str::to_owned), names.cloned().collect());
            DecompositionError::NotBaked { name, names }
        })
    }

    /// Whether a mesh may have these hulls of it.
    pub(super) fn is_usable(&self, baked: &BakedMesh) -> bool {
        (self.settings.accepts_other_versions || baked.hulls.is_current())
            && baked.hulls.mass_properties.is_some()
    }

    /// Whether meshes are found by their labels also where their content is there.
    pub(crate) fn is_found_by_label(&self) -> bool {
        self.settings.by_label
    }

    /// What is at a place: the hulls of a mesh, whichever version of the algorithm made them, or
    /// after all of these the triangles of one.
    pub(super) fn geometry_of(&self, index: usize) -> Option<Arc<ColliderGeometry>> {
        let HullScene { meshes, triangles, .. } = &*self.scene;
        if let Some(baked) = meshes.get(index) {
            return Some(ColliderGeometry::of_hulls(baked.hulls.clone(), Vec::new()));
        }
        let BakedTriangles { positions, triangles, .. } = triangles.get(index - meshes.len())?;
        let (positions, triangles) = (positions.clone(), triangles.clone());
        let data = MeshData { positions, triangles, part_ends: Vec::new() };
        Some(ColliderGeometry::Triangles(data).into())
    }

    /// Why there are no hulls for a mesh with this content and one of these names.
    pub(crate) fn absence(&self, key: ContentKey, parameters: &Method, names: &[&str]) -> Absence {
        let ContentKey::Mesh { mesh, .. } = key else { return Absence::Missing };
        match self.scene.look_up(mesh, parameters, names) {
            // Without mass properties it counts as missing.
            SceneLookup::Found(_) | SceneLookup::Missing => Absence::Missing,
            SceneLookup::OtherAlgorithm(_) => {
                Absence::Stale("another version of Hullwright baked it".into())
            }
            SceneLookup::OtherParameters(baked) => Absence::Stale(format!(
                "it was baked with {}, not with {}",
                words(&baked.parameters),
                words(parameters)
            )),
            SceneLookup::OtherContent(_) => {
                Absence::Stale("the mesh has changed since it was baked".into())
            }
        }
    }
}

/// Why a scene has no hulls for a mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Absence {
    /// It has hulls of it, but not these.
    Stale(String),
    Missing,
}

/// What differs from the default parameters.
fn words(parameters: &Method) -> String {
    let text = parameters.to_string();
    if text.is_empty() { "the default parameters".into() } else { format!("`{text}`") }
}

/// Takes the hulls of the entity's meshes from a baked scene, where it has them, beside a
/// [`ConvexDecomposition`](crate::ConvexDecomposition).
/// [`ConvexDecompositionHierarchy::with_baked`](crate::ConvexDecompositionHierarchy::with_baked)
/// sets it on all that it tags.
#[derive(Component, Reflect, FromTemplate, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct FromBakedScene(pub Handle<BakedScene>);

/// Loads `.hullscene` files. A corrupt, truncated or newer file is a load error.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullSceneLoader;

impl AssetLoader for HullSceneLoader {
    type Asset = BakedScene;
    type Settings = BakedSceneSettings;
    type Error = LoadHullsError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &BakedSceneSettings,
        _context: &mut LoadContext<'_>,
    ) -> Result<BakedScene, LoadHullsError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(BakedScene::with_settings(HullScene::from_bytes(&bytes)?, *settings))
    }

    fn extensions(&self) -> &[&str] {
        &["hullscene"]
    }
}
