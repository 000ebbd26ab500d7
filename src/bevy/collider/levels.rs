//! Levels of detail: of the meshes that stand for one thing the finest makes the collider.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::conventions::is_coarser_level;

/// Which meshes are coarser levels of detail.
#[derive(SystemParam)]
pub(crate) struct Levels<'w, 's> {
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    #[cfg(feature = "bevy_gltf")]
    ranges: Query<'w, 's, &'static bevy::camera::visibility::VisibilityRange>,
}

impl Levels<'_, '_> {
    /// Whether an entity is a coarser level, by its name and those beside it, or is not drawn near the camera.
    pub(crate) fn is_coarser(&self, entity: Entity) -> bool {
        self.is_drawn_far_only(entity) || self.has_finer_sibling(entity)
    }

    /// Without a renderer nothing is.
    pub(crate) fn is_drawn_far_only(&self, entity: Entity) -> bool {
        #[cfg(feature = "bevy_gltf")]
        return self.ranges.get(entity).is_ok_and(|range| range.start_margin.end > 0.0);
        #[cfg(not(feature = "bevy_gltf"))]
        return (entity, false).1;
    }

    fn has_finer_sibling(&self, entity: Entity) -> bool {
        let Ok(name) = self.names.get(entity) else { return false };
        let siblings = self.parents.get(entity).and_then(|of| self.children.get(of.parent()));
        let siblings = siblings.into_iter().flatten();
        is_coarser_level(
            name,
            siblings.filter_map(|other| self.names.get(*other).ok()).map(Name::as_str),
        )
    }
}
