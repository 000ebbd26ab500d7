//! Children that have the collider of their parent, one for each hull or for each group of hulls,
//! so that each may have a surface, events and a kind of its own.

use bevy::ecs::system::EntityCommands;
use bevy::prelude::*;

use super::parts::ColliderParts;
use crate::tag::HullGrouping;

/// On a child that has the collider of some of its parent's hulls. The child is the plugin's: where
/// the collider is made anew, it comes anew, and what the game put on it has to be put there again,
/// as where this component is added:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
/// use bevy_rapier3d::prelude::*;
///
/// #[derive(Component)]
/// struct Ice;
///
/// fn slip(
///     added: On<Add<HullCollider>>,
///     parts: Query<&ColliderParts>,
///     ice: Query<(), With<Ice>>,
///     mut commands: Commands,
/// ) -> Result {
///     let part = parts.get(added.entity)?.part(0);
///     if part.is_some_and(|part| ice.contains(part)) {
///         let combine_rule = CoefficientCombineRule::Min;
///         commands.entity(added.entity).insert(Friction { coefficient: 0.02, combine_rule });
///     }
///     Ok(())
/// }
/// # let mut app = App::new();
/// app.add_observer(slip);
/// ```
#[derive(Component, Debug, Clone, PartialEq, Eq)]
pub struct HullCollider {
    /// Which of the hulls.
    pub hulls: Vec<u32>,
}

/// On an entity whose collider is in children. A clone gets children of its own.
#[derive(Component, Debug, Clone, Copy)]
#[component(clone_behavior = Ignore)]
pub(crate) struct ColliderInChildren;

/// For each hull a number that it shares with those it is taken together with.
pub(crate) fn groups(grouping: HullGrouping, hulls: u32, parts: &ColliderParts) -> Vec<u32> {
    let group = |hull| match grouping {
        HullGrouping::EachHull => hull,
        HullGrouping::EachPart => parts.index_of_part(hull).unwrap_or(0),
    };
    (0..hulls).map(group).collect()
}

/// Takes away the children of an entity that have its colliders.
pub(super) fn detach(entity: &mut EntityCommands) {
    entity.queue_silenced(|mut entity: EntityWorldMut| {
        entity.remove::<ColliderInChildren>();
        let children = entity.get::<Children>().map(|children| children.to_vec());
        entity.world_scope(|world| {
            for child in children.unwrap_or_default() {
                if world.get::<HullCollider>(child).is_some() {
                    world.despawn(child);
                }
            }
        });
    });
}
