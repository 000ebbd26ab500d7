//! Level cells: small things of a scene that never move share the collider of their cell.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::jobs::request::MeshPart;
use crate::tag::outcomes::SkipReason;

/// On the entity with the collider of a cell, a child of its scene: the entities that share it.
///
/// The scene chooses the size of cells by
/// [`cell_size`](crate::ConvexDecompositionHierarchy::cell_size). From a triangle that was hit to
/// the entity whose mesh it is made of leads [`ColliderParts`](crate::ColliderParts), as from that
/// of any collider.
#[derive(Component, Debug, Default)]
#[relationship_target(relationship = InLevelCell)]
pub struct LevelCell(Vec<Entity>);

impl LevelCell {
    /// Those that share the collider, in the order in which they came.
    pub fn entities(&self) -> &[Entity] {
        &self.0
    }
}

/// On an entity that shares the collider of a cell, and has none of its own.
#[derive(Component, Debug)]
#[component(clone_behavior = Ignore)]
#[relationship(relationship_target = LevelCell)]
pub struct InLevelCell {
    #[relationship]
    pub(super) cell: Entity,
    /// Where it was when it came, in its scene.
    pub(super) place: Affine3A,
    /// The entities with its meshes, and where these are in the cell.
    pub(super) parts: Vec<(Entity, MeshPart)>,
}

impl InLevelCell {
    /// The entity with the collider.
    pub fn cell(&self) -> Entity {
        self.cell
    }
}

/// On what may share colliders with others of its scene: the scene's root, and the side of a cell
/// in metres of the world.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
#[component(clone_behavior = Ignore)]
pub(crate) struct SharesCells {
    pub root: Entity,
    pub size: f32,
}

/// On what was in a cell and moved, or could not be made with the others: it has a collider of its
/// own from then on. Cells that are made anew with each step of a door would be late.
#[derive(Component, Debug)]
#[component(clone_behavior = Ignore)]
pub(super) struct OutOfCells;

/// Which cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct CellKey {
    pub root: Entity,
    pub index: [i32; 3],
    pub size: u32,
    pub reason: SkipReason,
    /// The bits of the bound in metres.
    pub bound: Option<u32>,
}

/// The cell of an entity, and where it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellPlace {
    pub(super) key: CellKey,
    /// In the space of the root.
    pub(super) origin: Vec3,
    pub(super) place: Affine3A,
}

impl CellPlace {
    pub(super) fn to_cell(self) -> Affine3A {
        Affine3A::from_translation(-self.origin) * self.place
    }
}

/// On a cell. A clone of it, which has nothing to share, goes.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct OfCell(pub CellKey);
