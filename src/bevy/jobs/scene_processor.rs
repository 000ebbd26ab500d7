//! Baked scenes in Bevy's asset processor: recipes become binary files at build time.

use bevy::asset::io::Writer;
use bevy::asset::processor::LoadTransformAndSave;
use bevy::asset::saver::{AssetSaver, SavedAsset};
use bevy::asset::transformer::IdentityAssetTransformer;
use bevy::asset::{AssetPath, AsyncWriteExt};
use bevy::prelude::*;

use crate::bevy::jobs::baked::LoadHullsError;
use crate::bevy::jobs::baked_scene::{BakedScene, HullSceneLoader};

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
