//! Pieces of a collider that an artist made, as Unreal's `UCX_chair_01` is one of `chair`: each is tied to its mesh, and
//! moves with that mesh's body.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// On a piece of a collider that an artist made: the entity of the mesh that it belongs to. The piece is below it, or is
/// put there.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[type_path = "hullwright"]
#[relationship(relationship_target = ColliderPieces)]
pub struct ColliderPieceOf(#[entities] pub Entity);

/// On a mesh: the pieces that an artist made of its collider. They stand for hulls of its own.
#[derive(Component, Reflect, Debug, Default, Clone, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[relationship_target(relationship = ColliderPieceOf)]
pub struct ColliderPieces(Vec<Entity>);

/// What is tied to what, and where it is.
#[derive(SystemParam)]
pub(super) struct Pieces<'w, 's> {
    tied: Query<'w, 's, &'static ColliderPieceOf>,
    parents: Query<'w, 's, &'static ChildOf>,
    global: TransformHelper<'w, 's>,
}

impl Pieces<'_, '_> {
    /// Ties a piece to its mesh, or frees it. A collider belongs to the body above it, so a piece that is elsewhere comes
    /// below its mesh, in the place where it is.
    pub(super) fn tie(&self, commands: &mut Commands, piece: Entity, whole: Option<Entity>) {
        if self.tied.get(piece).ok().map(|tied| tied.0) == whole {
            return;
        }
        let mut commands = commands.entity(piece);
        let Some(whole) = whole else {
            commands.try_remove::<ColliderPieceOf>();
            return;
        };
        commands.try_insert(ColliderPieceOf(whole));
        if self.parents.iter_ancestors(piece).any(|above| above == whole) {
            return;
        }
        let local = self.place(piece).reparented_to(&self.place(whole));
        commands.try_insert((ChildOf(whole), local));
    }

    /// Where an entity is, also in the frame in which it is spawned.
    pub(super) fn place(&self, entity: Entity) -> GlobalTransform {
        self.global.compute_global_transform(entity).unwrap_or_default()
    }
}
