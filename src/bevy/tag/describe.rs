//! Names entities in messages: by id, name and asset.

use bevy::asset::UntypedAssetId;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::bevy::jobs::request::InputId;

/// What entities are called.
#[derive(SystemParam)]
pub(crate) struct Descriptions<'w, 's> {
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    server: Option<Res<'w, AssetServer>>,
}

impl Descriptions<'_, '_> {
    /// `12v3 "chair" (props.glb#Mesh0/Primitive0)`, as far as it is known.
    pub(crate) fn entity(&self, entity: Entity, asset: Option<UntypedAssetId>) -> String {
        let name = |entity| self.names.get(entity).ok();
        let name = name(entity).or_else(|| self.parents.iter_ancestors(entity).find_map(name));
        let name = name.map(|name| format!(" \"{name}\"")).unwrap_or_default();
        let asset = asset.and_then(|id| self.server.as_ref()?.get_path(id));
        let asset = asset.map(|path| format!(" ({path})")).unwrap_or_default();
        format!("{entity}{name}{asset}")
    }
}

/// The asset that stands for an input: its first mesh, or its baked hulls.
pub(crate) fn asset_of(input: &InputId) -> Option<UntypedAssetId> {
    match input {
        InputId::Meshes { parts, .. } => parts.first().map(|(mesh, _)| mesh.untyped()),
        InputId::Baked(id) => Some(id.untyped()),
    }
}

/// One entity by its description, several by their number and the first of them.
pub(crate) fn entities(count: usize, first: &str) -> String {
    match count {
        1 => first.to_owned(),
        _ => format!("{count} entities, the first of them {first}"),
    }
}
