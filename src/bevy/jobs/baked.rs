//! Baked hulls: `.hulls` files as assets, and the component that gives an entity a collider of
//! them.

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::hulls_format::{HullsFile, HullsFileError};

use crate::bevy::tag::status::DecompositionStatus;

/// A decomposition that was made before, as `hullwright bake` does: the content of a `.hulls` file. To
/// reflection it is one value, since the library's types know no engine.
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
