//! Baked hulls: `.hulls` and `.hullscene` files as assets, and recipes: a text in place of a `.hullscene` file that
//! names a scene, whose hulls are made when the asset is loaded or, at build time, processed.

use std::sync::Arc;

use bevy::asset::io::{Reader, Writer};
use bevy::asset::processor::LoadTransformAndSave;
use bevy::asset::saver::{AssetSaver, SavedAsset};
use bevy::asset::transformer::IdentityAssetTransformer;
use bevy::asset::{AssetLoader, AssetPath, AsyncWriteExt, LoadContext};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::cache::ColliderGeometry;
use super::request::ContentKey;
use crate::Method;
use crate::bevy::tag::outcomes::DecompositionStatus;
use crate::bevy::tag::parameters::Goal;
use crate::hulls_format::{HullScene, HullsFile, HullsFileError, SceneLookup};

/// A decomposition that was made before, as `hullwright bake` does: the content of a `.hulls` file. To
/// reflection it is one value, since the library's types name no engine.
#[derive(Asset, Reflect, Debug, Clone)]
#[reflect(opaque, Debug, Clone)]
#[type_path = "hullwright"]
pub struct BakedHulls(pub HullsFile);

/// Gives the entity a collider of baked hulls. They are in the mesh's own space, so it belongs
/// where the mesh is, on the entity that has the `Mesh3d` or on the glTF node.
///
/// Its scale is baked into the points as for
/// [`ConvexDecomposition`](crate::bevy::ConvexDecomposition).
///
/// ```
/// use bevy::prelude::*;
/// use bevy_rapier3d::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// fn setup(mut commands: Commands, server: Res<AssetServer>) {
///     // Beside the `Mesh3d` that they were made from.
///     commands.spawn((RigidBody::Dynamic, BakedDecomposition::new(server.load("mug.hulls"))));
/// }
/// ```
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[require(DecompositionStatus)]
pub struct BakedDecomposition {
    /// The hulls.
    pub hulls: Handle<BakedHulls>,
    /// The mass of the whole collider in the world, whatever its scale, instead of the one in the file,
    /// which grows with the scale.
    pub mass: Option<f32>,
}

impl BakedDecomposition {
    /// With the mass in the file.
    pub fn new(hulls: Handle<BakedHulls>) -> Self {
        Self { hulls, mass: None }
    }
}

/// Loads `.hulls` files. A corrupt, truncated or newer file is a load error.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullsLoader;

impl AssetLoader for HullsLoader {
    type Asset = BakedHulls;
    type Settings = ();
    type Error = LoadHullsError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        _context: &mut LoadContext<'_>,
    ) -> Result<BakedHulls, LoadHullsError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(BakedHulls(HullsFile::from_bytes(&bytes)?))
    }

    fn extensions(&self) -> &[&str] {
        &["hulls"]
    }
}

/// Why a `.hulls` or `.hullscene` asset could not be loaded or saved.
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

/// The hulls of a scene's meshes, made before as `hullwright bake` does: the content of a `.hullscene`
/// file. To reflection it is one value, since the library's types name no engine.
#[derive(Asset, Reflect, Debug, Clone)]
#[reflect(opaque, Debug, Clone)]
#[type_path = "hullwright"]
pub struct BakedScene {
    scene: Arc<HullScene>,
    geometry: Arc<SceneGeometry>,
}

/// What colliders are made of, by content.
pub(super) type SceneGeometry = HashMap<ContentKey, Arc<ColliderGeometry>>;

impl BakedScene {
    /// Of a scene that is already in memory.
    pub fn new(scene: HullScene) -> Self {
        let usable = scene
            .meshes
            .iter()
            .filter(|baked| baked.hulls.is_current() && baked.hulls.mass_properties.is_some());
        let geometry = usable.map(|baked| {
            let goal = Goal::Hulls(baked.parameters.clone()).hash();
            let key = ContentKey::Mesh { mesh: baked.hash, goal };
            (key, ColliderGeometry::of_hulls(baked.hulls.clone()))
        });
        let geometry = Arc::new(geometry.collect());
        Self { scene: Arc::new(scene), geometry }
    }

    /// What the file holds.
    pub fn scene(&self) -> &HullScene {
        &self.scene
    }

    pub(super) fn geometry(&self) -> Arc<SceneGeometry> {
        self.geometry.clone()
    }

    /// Why there are no hulls for a mesh with this content and one of these names; `None` if there are.
    pub(crate) fn absence(
        &self,
        key: ContentKey,
        parameters: &Method,
        names: &[&str],
    ) -> Option<Absence> {
        let ContentKey::Mesh { mesh, .. } = key else { return None };
        if self.geometry.contains_key(&key) {
            return None;
        }
        Some(match self.scene.look_up(mesh, parameters, names) {
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
        })
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
        if recipe::is_recipe(&bytes) {
            let scene = recipe::bake(&bytes, context).await?;
            return Ok(BakedScene::new(scene));
        }
        let _ = context;
        Ok(BakedScene::new(HullScene::from_bytes(&bytes)?))
    }

    fn extensions(&self) -> &[&str] {
        &["hullscene"]
    }
}

/// Writes `.hullscene` files.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullSceneSaver;

/// What Bevy's asset processor does with `.hullscene` files: a recipe becomes the hulls of the scene that it
/// names; a baked file stays as it is. The plugin sets it for the suffix.
pub type HullSceneProcessor =
    LoadTransformAndSave<HullSceneLoader, IdentityAssetTransformer<BakedScene>, HullSceneSaver>;

impl AssetSaver for HullSceneSaver {
    type Asset = BakedScene;
    type Settings = ();
    type OutputLoader = HullSceneLoader;
    type Error = LoadHullsError;

    async fn save(
        &self,
        writer: &mut Writer,
        asset: SavedAsset<'_, '_, BakedScene>,
        _settings: &(),
        _path: AssetPath<'_>,
    ) -> Result<(), LoadHullsError> {
        writer.write_all(&asset.scene().to_bytes()?).await?;
        Ok(())
    }
}

#[cfg(feature = "io")]
mod recipe {
    use bevy::asset::LoadContext;

    use super::LoadHullsError;
    use crate::bake::{BakeOptions, bake_jobs};
    use crate::hulls_format::HullScene;
    use crate::io::read_scene_from_bytes;
    use crate::{Control, Method};

    /// What a recipe says.
    struct Recipe {
        /// The path of the scene, from the folder of the recipe.
        scene: String,
        options: BakeOptions,
    }

    /// The keys there are.
    const KEYS: &str = "scene, parameters, tagged_only";

    /// Whether bytes may be a recipe: JSON instead of the magic number of a baked file.
    pub(super) fn is_recipe(bytes: &[u8]) -> bool {
        bytes.trim_ascii_start().starts_with(b"{")
    }

    /// Bakes the scene that a recipe names.
    pub(super) async fn bake(
        bytes: &[u8],
        context: &mut LoadContext<'_>,
    ) -> Result<HullScene, LoadHullsError> {
        let Recipe { scene, options } = read(bytes)?;
        let wrong = |reason: String| LoadHullsError::Recipe(format!("{scene}: {reason}"));
        let path =
            context.path().resolve_embed_str(&scene).map_err(|error| wrong(error.to_string()))?;
        let bytes =
            context.read_asset_bytes(&path).await.map_err(|error| wrong(error.to_string()))?;
        let meshes = read_scene_from_bytes(&bytes).map_err(|error| wrong(error.to_string()))?;
        let mut baked = Vec::new();
        for job in bake_jobs(meshes, &options) {
            // The others shall have their hulls all the same, and the hierarchy says what is missing.
            match job.run(&Control::new()) {
                Ok(mesh) => baked.push(mesh),
                Err(error) => {
                    let name = job.names.first().map_or("", String::as_str);
                    log::warn!("{path}, mesh `{name}`: {error}");
                }
            }
        }
        let name = path.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(HullScene::new(name, baked))
    }

    fn read(bytes: &[u8]) -> Result<Recipe, LoadHullsError> {
        let wrong = LoadHullsError::Recipe;
        let value: serde_json::Map<String, serde_json::Value> =
            serde_json::from_slice(bytes).map_err(|error| wrong(error.to_string()))?;
        let mut recipe = Recipe { scene: String::new(), options: BakeOptions::default() };
        for (key, value) in &value {
            let expected = |what: &str| wrong(format!("`{key}` should be {what}"));
            match key.as_str() {
                "scene" => {
                    recipe.scene = value.as_str().ok_or_else(|| expected("a path"))?.to_owned();
                }
                "parameters" => {
                    let text = value.as_str().ok_or_else(|| expected("a text"))?;
                    let parameters: Method =
                        text.parse().map_err(|error| wrong(format!("`parameters`: {error}")))?;
                    parameters.validate().map_err(|error| wrong(error.to_string()))?;
                    recipe.options.parameters = parameters;
                }
                "tagged_only" => {
                    recipe.options.tagged_only =
                        value.as_bool().ok_or_else(|| expected("true or false"))?;
                }
                _ => return Err(wrong(format!("there is no `{key}`, but {KEYS}"))),
            }
        }
        if recipe.scene.is_empty() {
            return Err(wrong("`scene` is missing: the path of a glTF file".into()));
        }
        Ok(recipe)
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use crate::{Length, Parameters};

        fn refused(text: &str) -> String {
            match read(text.as_bytes()) {
                Ok(_) => panic!("{text} is accepted"),
                Err(error) => error.to_string(),
            }
        }

        #[test]
        fn a_recipe_names_a_scene_and_its_parameters() {
            let text =
                r#" {"scene": "level.glb", "parameters": "max_error=1%", "tagged_only": true}"#;
            assert!(is_recipe(text.as_bytes()) && !is_recipe(b"\x89HULSC"));
            let recipe = read(text.as_bytes()).unwrap();
            let parameters = Parameters::default().max_error(Length::share(0.01));
            assert_eq!(recipe.scene, "level.glb");
            assert_eq!(recipe.options, BakeOptions::new(parameters).tagged_only(true));
            assert_eq!(read(br#"{"scene": "a.glb"}"#).unwrap().options, BakeOptions::default());
        }

        #[test]
        fn a_wrong_recipe_is_told_what_is_expected() {
            for (text, expected) in [
                (r#"{"scene": "a.glb", "max_error": 1}"#, "scene, parameters, tagged_only"),
                (r#"{"scene": 3}"#, "a path"),
                (r#"{"scene": "a.glb", "parameters": "max_hull=3"}"#, "max_hulls"),
                (r#"{"scene": "a.glb", "parameters": "max_error=-1%"}"#, "max_error"),
                (r#"{"scene": "a.glb", "tagged_only": "yes"}"#, "true or false"),
                ("{}", "`scene` is missing"),
                ("{", "EOF"),
            ] {
                assert!(refused(text).contains(expected), "{text}: {}", refused(text));
            }
        }
    }
}
