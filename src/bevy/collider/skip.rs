//! What is not decomposed on request: what is hidden, too small to matter, or too far from every focus.

use bevy::ecs::system::SystemParam;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, ColliderScale};

use crate::bevy::collider::placement::Placement;
use crate::bevy::jobs::mesh_data::MeshPart;
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::AttachedCollider;
use crate::bevy::tag::components::{ConvexDecomposition, DecompositionFocus};
use crate::bevy::tag::outcomes::Outcomes;
use crate::bevy::tag::settings::HullwrightSettings;
#[cfg(feature = "bevy_gltf")]
use crate::bevy::tag::status::DecompositionStatus;
use crate::bevy::tag::status::SkipReason;

/// On entities that are too far from every focus.
#[derive(Component, Debug, Clone, Copy)]
pub(crate) struct FarFromFocus;

/// Entities whose distance is looked at in one frame: some ten microseconds. With ten thousand each has
/// its turn every twentieth frame.
const LOOKED_AT_PER_FRAME: usize = 512;

/// A collider is dropped this much farther than the radius within which it is made, so that it does not
/// come and go at the border.
const DROP_MARGIN: f32 = 1.25;

/// What the rules look at.
#[derive(SystemParam)]
pub(crate) struct SkipRules<'w, 's> {
    distances: Distances<'w, 's>,
    #[cfg(feature = "bevy_gltf")]
    visibilities: Query<'w, 's, &'static Visibility>,
    #[cfg(feature = "bevy_gltf")]
    parents: Query<'w, 's, &'static ChildOf>,
}

impl SkipRules<'_, '_> {
    /// Why an entity is skipped, whatever its mesh.
    pub(crate) fn reason(&self, entity: Entity) -> Option<SkipReason> {
        let settings = &self.distances.settings;
        if settings.skip_hidden && self.is_hidden(entity) {
            return Some(SkipReason::Hidden);
        }
        let radius = settings.focus_radius?;
        self.distances.is_beyond(entity, radius).then_some(SkipReason::TooFar)
    }

    /// As Bevy draws it, also before it has worked that out.
    #[cfg(feature = "bevy_gltf")]
    fn is_hidden(&self, entity: Entity) -> bool {
        let above = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
        let own = above.map_while(|entity| self.visibilities.get(entity).ok());
        own.copied().find(|own| *own != Visibility::Inherited) == Some(Visibility::Hidden)
    }

    /// Without a renderer nothing is.
    #[cfg(not(feature = "bevy_gltf"))]
    fn is_hidden(&self, _entity: Entity) -> bool {
        false
    }
}

/// Where entities and focuses are, and how far the settings let them be apart.
#[derive(SystemParam)]
pub(crate) struct Distances<'w, 's> {
    settings: Res<'w, HullwrightSettings>,
    focuses: Query<'w, 's, Entity, With<DecompositionFocus>>,
    transforms: TransformHelper<'w, 's>,
}

impl Distances<'_, '_> {
    /// Whether all focuses are farther away; without a focus nothing is.
    fn is_beyond(&self, entity: Entity, radius: f32) -> bool {
        let place =
            |entity| Some(self.transforms.compute_global_transform(entity).ok()?.translation());
        let Some(own) = place(entity) else { return false };
        let mut focuses = self.focuses.iter().filter_map(place).peekable();
        focuses.peek().is_some() && focuses.all(|focus| focus.distance(own) > radius)
    }
}

/// Whether meshes are smaller in the world than the settings say. O(vertices), where they say something.
pub(crate) fn is_too_small(
    parts: &[MeshPart],
    placement: &Placement,
    meshes: &Assets<Mesh>,
    settings: &HullwrightSettings,
) -> bool {
    if settings.min_size <= 0.0 {
        return false;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for part in parts {
        let mesh = meshes.get(part.mesh);
        let positions = mesh.and_then(|mesh| mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok());
        // What is wrong with it is said elsewhere.
        let Some(VertexAttributeValues::Float32x3(positions)) = positions else { return false };
        let to_world = placement.map * part.to_input;
        for position in positions {
            let point = to_world.transform_point3(Vec3::from(*position));
            (low, high) = (low.min(point), high.max(point));
        }
    }
    low.distance(high) < settings.min_size
}

/// Entities that have come near start.
pub(crate) fn start_near(
    mut commands: Commands,
    mut queue: ResMut<WorkQueue>,
    distances: Distances,
    far: Query<Entity, (With<FarFromFocus>, With<ConvexDecomposition>)>,
    mut next: Local<usize>,
) {
    let radius = distances.settings.focus_radius;
    let (start, end) = turn(&mut next, far.iter().len());
    for entity in far.iter().skip(start).take(end - start) {
        if !radius.is_some_and(|radius| distances.is_beyond(entity, radius)) {
            commands.entity(entity).try_remove::<FarFromFocus>();
            queue.restart(entity);
        }
    }
}

/// Colliders that are far go, if the settings say so.
pub(crate) fn drop_far(
    mut queue: ResMut<WorkQueue>,
    distances: Distances,
    attached: Query<(Entity, &AttachedCollider), With<ConvexDecomposition>>,
    mut outcomes: Outcomes,
    mut next: Local<usize>,
) {
    let settings = &distances.settings;
    let Some(radius) = settings.focus_radius.filter(|_| settings.drop_far) else { return };
    let (start, end) = turn(&mut next, attached.iter().len());
    for (entity, attached) in attached.iter().skip(start).take(end - start) {
        if !distances.is_beyond(entity, radius * DROP_MARGIN) {
            continue;
        }
        queue.forget(entity);
        let mut commands = outcomes.commands.entity(entity);
        commands.try_remove::<(Collider, ColliderScale, AttachedCollider)>();
        if attached.owns_mass {
            commands.try_remove::<ColliderMassProperties>();
        }
        commands.try_insert(FarFromFocus);
        outcomes.skipped(entity, SkipReason::TooFar);
    }
}

/// Whose turn it is: a range of so many, and where the next one begins.
fn turn(next: &mut usize, count: usize) -> (usize, usize) {
    let start = if *next < count { *next } else { 0 };
    let end = (start + LOOKED_AT_PER_FRAME).min(count);
    *next = end;
    (start, end)
}

/// What was skipped since it was hidden starts when it is shown.
#[cfg(feature = "bevy_gltf")]
pub(crate) fn detect_shown(
    mut queue: ResMut<WorkQueue>,
    changed: Query<(Entity, &Visibility), Changed<Visibility>>,
    children: Query<&Children>,
    statuses: Query<&DecompositionStatus>,
) {
    const HIDDEN: DecompositionStatus = DecompositionStatus::Skipped(SkipReason::Hidden);
    for (entity, visibility) in &changed {
        if *visibility == Visibility::Hidden {
            continue;
        }
        for entity in std::iter::once(entity).chain(children.iter_descendants(entity)) {
            if statuses.get(entity) == Ok(&HIDDEN) {
                queue.restart(entity);
            }
        }
    }
}
