//! Recipes: a text that names a scene, whose hulls are made when the asset is loaded or, at build
//! time, processed.

use bevy::asset::io::{Reader, Writer};
use bevy::asset::processor::LoadTransformAndSave;
use bevy::asset::saver::{AssetSaver, SavedAsset};
use bevy::asset::transformer::IdentityAssetTransformer;
use bevy::asset::{AssetLoader, AssetPath, AsyncWriteExt, LoadContext};
use bevy::prelude::*;
use hullwright::hulls_format::HullScene;
use hullwright::{Control, Method};
use hullwright_formats::bake::{BakeOptions, bake_jobs, bake_triangles, extras_complaints};
use hullwright_formats::{read_scene_from_bytes, sum_notes};

use super::baked::{BakedScene, BakedSceneSettings, HullSceneLoader, LoadHullsError};
use super::task::contain_panics;
use crate::tag::settings::HAS_THREADS;

/// Loads `.hullrecipe` files (feature `bake`): JSON that names a scene beside it, `{"scene":
/// "level.glb", "parameters": "max_error=1%", "tagged_only": false, "triangles": false}`, the last
/// three if need be. The hulls are made when it is loaded or, if Bevy processes assets, at build
/// time.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullRecipeLoader;

impl AssetLoader for HullRecipeLoader {
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
        // Elsewhere it is read in the background.
        if !HAS_THREADS {
            log::warn!(
                "{}: frames wait while a recipe's scene is decomposed; ship the `.hullscene` that \
                 `hullwright bake` makes",
                context.path()
            );
        }
        Ok(BakedScene::new(bake(&bytes, context).await?))
    }

    fn extensions(&self) -> &[&str] {
        &["hullrecipe"]
    }
}

/// Writes `.hullscene` files.
#[derive(TypePath, Debug, Clone, Copy, Default)]
#[type_path = "hullwright"]
pub struct HullSceneSaver;

/// What Bevy's asset processor makes of a recipe: the hulls of the scene that it names. The plugin
/// sets it for the suffix.
pub type HullRecipeProcessor =
    LoadTransformAndSave<HullRecipeLoader, IdentityAssetTransformer<BakedScene>, HullSceneSaver>;

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
    ) -> Result<BakedSceneSettings, LoadHullsError> {
        writer.write_all(&asset.scene().to_bytes()?).await?;
        Ok(BakedSceneSettings::default())
    }
}

/// What a recipe says.
struct Recipe {
    /// The path of the scene, from the folder of the recipe.
    scene: String,
    options: BakeOptions,
}

/// The keys there are.
const KEYS: &str = "scene, parameters, tagged_only, triangles";

/// Bakes the scene that a recipe names.
async fn bake(bytes: &[u8], context: &mut LoadContext<'_>) -> Result<HullScene, LoadHullsError> {
    let Recipe { scene, options } = read(bytes)?;
    let wrong = |reason: String| LoadHullsError::Recipe(format!("{scene}: {reason}"));
    let path =
        context.path().resolve_embed_str(&scene).map_err(|error| wrong(error.to_string()))?;
    let bytes = context.read_asset_bytes(&path).await.map_err(|error| wrong(error.to_string()))?;
    let meshes = read_scene_from_bytes(&bytes).map_err(|error| wrong(error.to_string()))?;
    for note in sum_notes(meshes.iter().flat_map(|mesh| &mesh.notes)) {
        log::warn!("{path}: {note}");
    }
    for complaint in extras_complaints(&meshes) {
        log::warn!("{path}, {complaint}");
    }
    let mut baked = Vec::new();
    let triangles = bake_triangles(&meshes, &options);
    for job in bake_jobs(meshes, &options) {
        // A mesh that fails does not keep the others from their hulls; the hierarchy reports it.
        match contain_panics(|| Ok(job.run(&Control::new())?)) {
            Ok(mesh) => baked.push(mesh),
            Err(error) => {
                let name = job.names.first().map_or("", String::as_str);
                log::warn!("{path}, mesh `{name}`: {error}");
            }
        }
    }
    let name = path.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(HullScene::new(name, baked).with_triangles(triangles))
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
            "tagged_only" | "triangles" => {
                let value = value.as_bool().ok_or_else(|| expected("true or false"))?;
                match key.as_str() {
                    "triangles" => recipe.options.triangles = value,
                    _ => recipe.options.tagged_only = value,
                }
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
    use hullwright::{Length, Parameters};

    fn refused(text: &str) -> String {
        match read(text.as_bytes()) {
            Ok(_) => panic!("{text} is accepted"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_recipe_names_a_scene_and_its_parameters() {
        let text = r#" {"scene": "level.glb", "parameters": "max_error=1%", "tagged_only": true,
            "triangles": true}"#;
        let recipe = read(text.as_bytes()).unwrap();
        let parameters = Parameters::default().with_max_error(Length::share(0.01));
        assert_eq!(recipe.scene, "level.glb");
        assert_eq!(
            recipe.options,
            BakeOptions::new(parameters).with_tagged_only(true).with_triangles(true)
        );
        assert_eq!(read(br#"{"scene": "a.glb"}"#).unwrap().options, BakeOptions::default());
    }

    #[test]
    fn a_wrong_recipe_is_told_what_is_expected() {
        for (text, expected) in [
            (r#"{"scene": "a.glb", "max_error": 1}"#, "scene, parameters, tagged_only, triangles"),
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
