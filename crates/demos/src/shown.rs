//! Hulls over the bodies that they were made for, shown and hidden by keys.

use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::HullwrightDebug;
use hullwright::bevy::prelude::*;

use crate::hulls::{HullMaterials, edges_mesh, hulls_mesh, pieces};

/// Whether hulls are shown.
#[derive(Resource)]
pub struct ShownHulls(bool);

impl Default for ShownHulls {
    fn default() -> Self {
        Self(true)
    }
}

/// Marks drawn hulls.
#[derive(Component)]
pub struct DrawnHulls;

/// Draws the hulls of a collider that is ready.
pub fn show_new_hulls(
    event: On<DecompositionReady>,
    mut commands: Commands,
    colliders: Query<(&Collider, &GlobalTransform)>,
    materials: Res<HullMaterials>,
    mut meshes: ResMut<Assets<Mesh>>,
    shown: Res<ShownHulls>,
) {
    let Ok((collider, place)) = colliders.get(event.entity) else { return };
    let pieces = pieces(&collider.raw);
    // A collider holds its entity's scale already.
    let unscaled = Transform::from_scale(place.scale().recip());
    let visibility = if shown.0 { Visibility::Inherited } else { Visibility::Hidden };
    let drawn = [
        (hulls_mesh(&pieces, 0.0), &materials.glass),
        (edges_mesh(&pieces, 0.0), &materials.edges),
    ];
    for (mesh, material) in drawn {
        commands.spawn((
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(material.clone()),
            NotShadowCaster,
            DrawnHulls,
            NoConvexDecomposition,
            unscaled,
            visibility,
            ChildOf(event.entity),
        ));
    }
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
            *visibility = if shown.0 { Visibility::Inherited } else { Visibility::Hidden };
        }
    }
}
