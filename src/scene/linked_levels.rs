//! Levels of detail that a glTF file links (`MSFT_lod`): its nodes name coarser ones, which make no
//! colliders.

use std::collections::HashSet;

use bevy::asset::LoadContext;
use bevy::gltf::GltfLoaderSettings;
use bevy::gltf::extensions::{ErasedGltfExtensionHandler, GltfExtensionHandler};
use bevy::prelude::*;

use crate::tag::NoConvexDecomposition;

const EXTENSION: &str = "MSFT_lod";

/// Marks the coarser levels of a file while Bevy loads it.
#[derive(Debug, Clone, Default)]
pub(super) struct LinkedLevels {
    coarser: HashSet<usize>,
}

impl GltfExtensionHandler for LinkedLevels {
    fn dyn_clone(&self) -> Box<dyn ErasedGltfExtensionHandler> {
        Box::new(self.clone())
    }

    fn on_root(&mut self, _: &mut LoadContext<'_>, file: &gltf::Gltf, _: &GltfLoaderSettings) {
        let linked = file.nodes().filter_map(|node| {
            let ids = node.extension_value(EXTENSION)?.get("ids")?.as_array()?.clone();
            Some(ids.into_iter().filter_map(|id| usize::try_from(id.as_u64()?).ok()))
        });
        self.coarser = linked.flatten().collect();
    }

    fn on_gltf_node(
        &mut self,
        _: &mut LoadContext<'_>,
        node: &gltf::Node<'_>,
        entity: &mut EntityWorldMut<'_>,
    ) {
        if self.coarser.contains(&node.index()) {
            entity.insert(NoConvexDecomposition);
        }
    }
}
