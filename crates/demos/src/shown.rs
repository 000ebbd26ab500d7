//! Hulls over the bodies that they were made for, shown and hidden by keys.

use bevy::ecs::system::SystemParam;
use bevy::light::NotShadowCaster;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_hullwright::HullwrightDebug;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::hulls::{HullMaterials, edges_mesh, hulls_mesh, pieces};

/// Whether hulls are shown.
#[derive(Resource)]
pub struct ShownHulls(pub bool);

impl Default for ShownHulls {
    fn default() -> Self {
        Self(true)
    }
}

/// Marks drawn hulls.
#[derive(Component)]
pub struct DrawnHulls;

/// Whether the hulls of a collider that is ready are drawn.
#[derive(Component)]
pub enum Overlay {
    /// Once Rapier has the collider.
    Wanted,
    /// They are.
    Drawn,
}

/// Notes a collider that is ready. It may be so again, when its mesh or scale changes.
pub fn note_ready(event: On<DecompositionReady>, mut commands: Commands) {
    commands.entity(event.entity).insert_if_new(Overlay::Wanted);
}

/// Where colliders are in Rapier, and entities in the scene.
#[derive(SystemParam)]
pub struct Places<'w, 's> {
    contexts: Query<'w, 's, &'static RapierContextColliders>,
    colliders: Query<'w, 's, (&'static RapierColliderHandle, &'static RapierContextEntityLink)>,
    bodies: Query<'w, 's, (), With<RigidBody>>,
    parents: Query<'w, 's, &'static ChildOf>,
    transforms: Query<'w, 's, &'static Transform>,
    globals: Query<'w, 's, &'static GlobalTransform>,
}

impl Places<'_, '_> {
    /// From the space of an entity's collider to that of the entity. They differ by more than the
    /// scale below a body whose parent is scaled: Rapier then puts the collider elsewhere, and the
    /// plugin moves the points instead.
    fn collider_to_entity(&self, entity: Entity) -> Option<Affine3A> {
        let (handle, context) = self.colliders.get(entity).ok()?;
        let collider = self.contexts.get(context.0).ok()?.colliders.get(handle.0)?;
        let (of_body, pose) = match collider.position_wrt_parent() {
            Some(pose) => (self.entity_to_body(entity)?, pose),
            None => (self.globals.get(entity).ok()?.affine(), collider.position()),
        };
        let pose = Affine3A::from_rotation_translation(pose.rotation, pose.translation);
        Some(of_body.inverse() * pose)
    }

    /// From an entity's space to that of the body that it belongs to, which has no scale.
    fn entity_to_body(&self, entity: Entity) -> Option<Affine3A> {
        let mut map = Affine3A::IDENTITY;
        let mut current = entity;
        while !self.bodies.contains(current) {
            map = self.transforms.get(current).ok()?.compute_affine() * map;
            current = self.parents.get(current).ok()?.parent();
        }
        let scale = self.globals.get(current).ok()?.scale();
        Some(Affine3A::from_scale(scale) * map)
    }
}

/// Draws the hulls of colliders that Rapier has.
pub fn draw_new_hulls(
    mut commands: Commands,
    mut ready: Query<(Entity, &Collider, &mut Overlay)>,
    places: Places,
    materials: Res<HullMaterials>,
    mut meshes: ResMut<Assets<Mesh>>,
    shown: Res<ShownHulls>,
) {
    for (entity, collider, mut overlay) in &mut ready {
        if matches!(*overlay, Overlay::Drawn) {
            continue;
        }
        let Some(to_entity) = places.collider_to_entity(entity) else { continue };
        *overlay = Overlay::Drawn;
        let mut pieces = pieces(&collider.raw);
        pieces.iter_mut().for_each(|piece| piece.map(&to_entity));
        let drawn = [
            (hulls_mesh(&pieces, 0.0), &materials.glass),
            (edges_mesh(&pieces, 0.0), &materials.edges),
        ];
        // Not right below: the meshes there of pieces that an artist made are hidden by the plugin.
        let visibility = visibility(shown.0);
        let holder = (DrawnHulls, NoConvexDecomposition, Transform::default(), visibility);
        commands.spawn((holder, ChildOf(entity))).with_children(|holder| {
            for (mesh, material) in drawn {
                let mesh = Mesh3d(meshes.add(mesh));
                holder.spawn((mesh, MeshMaterial3d(material.clone()), NotShadowCaster));
            }
        });
    }
}

/// Visible on its own: pieces that an artist made are hidden, their hulls are not.
fn visibility(is_shown: bool) -> Visibility {
    if is_shown { Visibility::Visible } else { Visibility::Hidden }
}

/// H shows and hides the hulls, G the lines of `HullwrightDebugPlugin`.
pub fn toggle(
    keys: Res<ButtonInput<KeyCode>>,
    mut debug: ResMut<HullwrightDebug>,
    mut shown: ResMut<ShownHulls>,
    mut hulls: Query<&mut Visibility, With<DrawnHulls>>,
) {
    if keys.just_pressed(KeyCode::KeyG) {
        debug.is_drawn = !debug.is_drawn;
    }
    if keys.just_pressed(KeyCode::KeyH) {
        shown.0 = !shown.0;
        for mut visibility in &mut hulls {
            *visibility = self::visibility(shown.0);
        }
    }
}
