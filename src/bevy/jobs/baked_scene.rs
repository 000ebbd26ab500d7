//! Baked scenes: `.hullscene` files as assets, and what is found in them.

use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use crate::Method;
use crate::hulls_format::{HullScene, SceneLookup};

use crate::bevy::jobs::baked::LoadHullsError;
use crate::bevy::jobs::cache::ColliderGeometry;
use crate::bevy::jobs::content::{ContentKey, goal_hash};
use crate::bevy::tag::parameters::Goal;

/// The hulls of a scene's meshes, made before as `hullwright bake` does: the content of a `.hullscene`
/// file. To reflection it is one value, since the library's types know no engine.
#[derive(Asset, Reflect, Debug, Clone)]
#[reflect(opaque, Debug, Clone)]
#[type_path = "hullwright"]
pub struct BakedScene {
    scene: Arc<HullScene>,
    geometry: Arc<SceneGeometry>,
}

/// What colliders are made of, by content.
#[derive(Debug, Default)]
pub(crate) struct SceneGeometry(HashMap<ContentKey, Arc<ColliderGeometry>>);

impl BakedScene {
    /// Of a scene that is already in memory.
    pub fn new(scene: HullScene) -> Self {
        let usable = scene
            .meshes
            .iter()
            .filter(|baked| baked.hulls.is_current() && baked.hulls.mass_properties.is_some());
        let geometry = usable.map(|baked| {
            let key = ContentKey::Mesh {
                mesh: baked.hash,
                goal: goal_hash(&Goal::Hulls(baked.parameters.clone())),
            };
            (key, Arc::new(ColliderGeometry::Hulls(Box::new(baked.hulls.clone()))))
        });
        let geometry = Arc::new(SceneGeometry(geometry.collect()));
        Self { scene: Arc::new(scene), geometry }
    }

    /// What the file holds.
    pub fn scene(&self) -> &HullScene {
        &self.scene
    }

    pub(crate) fn geometry(&self) -> Arc<SceneGeometry> {
        self.geometry.clone()
    }

    /// Why there are no hulls for a mesh with this content and one of these names.
    pub(crate) fn reason_of_absence(
        &self,
        key: ContentKey,
        parameters: &Method,
        names: &[&str],
    ) -> Option<Absence> {
        let ContentKey::Mesh { mesh, .. } = key else { return None };
        match self.scene.look_up(mesh, parameters, names) {
            // Without mass properties it counts as missing.
            SceneLookup::Found(_) if self.geometry.get(key).is_some() => None,
            SceneLookup::Found(_) | SceneLookup::Missing => Some(Absence::Missing),
            SceneLookup::OtherAlgorithm(_) => {
                Some(Absence::Stale("another version of Hullwright baked it".into()))
            }
            SceneLookup::OtherParameters(baked) => Some(Absence::Stale(format!(
                "it was baked with {}, not with {}",
                words(&baked.parameters),
                words(parameters)
            ))),
            SceneLookup::OtherContent(_) => {
                Some(Absence::Stale("the mesh has changed since it was baked".into()))
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

impl SceneGeometry {
    pub(crate) fn get(&self, key: ContentKey) -> Option<&Arc<ColliderGeometry>> {
        self.0.get(&key)
    }
}

/// Takes the hulls of the entity's meshes from a baked scene, where it has them, beside a
/// [`ConvexDecomposition`](crate::bevy::ConvexDecomposition).
/// [`ConvexDecompositionHierarchy::with_baked`](crate::bevy::ConvexDecompositionHierarchy::with_baked)
/// sets it on all that it tags.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct FromBakedScene(pub Handle<BakedScene>);

/// Loads `.hullscene` files. A corrupt, truncated or newer file is a load error.
///
/// With the feature `io` such a file may be a recipe instead, JSON that names a scene beside it:
/// `{"scene": "level.glb", "parameters": "max_error=1%", "tagged_only": false}`, the last two if need be.
/// Then the hulls are made when it is loaded or, if Bevy processes assets, at build time.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullSceneLoader;

impl AssetLoader for HullSceneLoader {
    type Asset = BakedScene;
    type Settings = ();
    type Error = LoadHullsError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<BakedScene, LoadHullsError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        #[cfg(feature = "io")]
        if crate::bevy::jobs::scene_recipe::is_recipe(&bytes) {
            let scene = crate::bevy::jobs::scene_recipe::bake_recipe(&bytes, context).await?;
            return Ok(BakedScene::new(scene));
        }
        let _ = context;
        Ok(BakedScene::new(HullScene::from_bytes(&bytes)?))
    }

    fn extensions(&self) -> &[&str] {
        &["hullscene"]
    }
}
