//! Stand-ins for colliders that are not ready: the convex hull or the bounding box.

use bevy::prelude::*;
use bevy::tasks::{block_on, poll_once};
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, ColliderScale};
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::{Pose, Vector};

use crate::Hull;
use crate::hull::{HullBuilder, solid_hull};

use super::mesh_data::{MeshData, read_parts};
use super::run::pool;
use super::work::{StandInJob, Work};
use super::{ConvexDecomposition, DecompositionStatus, Execution, HullwrightSettings, Meanwhile};

/// On entities whose collider is a stand-in of ours.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct StandIn {
    /// Whether we set the mass properties, or found them set.
    pub owns_mass: bool,
}

/// Makes stand-ins for those in the queue, within the frame's budget.
pub(super) fn stand_in(
    mut commands: Commands,
    mut work: ResMut<Work>,
    settings: Res<HullwrightSettings>,
    meshes: Res<Assets<Mesh>>,
    tags: Query<(&ConvexDecomposition, Has<Collider>, Has<ColliderMassProperties>)>,
) {
    let work = &mut *work;
    let mut insert = |entity: Entity, shape: SharedShape| {
        let Ok((tag, false, has_mass)) = tags.get(entity) else { return };
        let mut commands = commands.entity(entity);
        commands.try_insert((
            Collider::from(shape),
            ColliderScale::Absolute(Vec3::ONE),
            StandIn { owns_mass: !has_mass },
        ));
        if !has_mass {
            commands.try_insert(ColliderMassProperties::Density(tag.density));
        }
    };
    let mut budget = work.budget(&settings);
    while !work.to_fill.is_empty() && budget.allows_one() {
        let Some(entity) = work.to_fill.pop_front() else { break };
        let (Ok((tag, ..)), Some(request)) = (tags.get(entity), work.requests.get(&entity)) else {
            continue;
        };
        let Some(ask) = &request.ask else { continue };
        let Ok(data) = read_parts(&ask.parts, &(ask.map * ask.before), &meshes) else { continue };
        match tag.meanwhile.unwrap_or(settings.meanwhile) {
            Meanwhile::Nothing => {}
            Meanwhile::BoundingBox => {
                if let Some(shape) = bounding_box(&data) {
                    insert(entity, shape);
                }
            }
            Meanwhile::ConvexHull if settings.execution == Execution::Slices => {
                if let Some(shape) = convex_hull(&data) {
                    insert(entity, shape);
                }
            }
            Meanwhile::ConvexHull => {
                let task = pool().spawn(async move { convex_hull(&data) });
                work.stand_ins.push(StandInJob { entity, task });
            }
        }
    }
    work.stand_ins.retain_mut(|job| {
        if !job.task.is_finished() {
            return true;
        }
        if let Some(Some(shape)) = block_on(poll_once(&mut job.task)) {
            insert(job.entity, shape);
        }
        false
    });
    work.spend(&budget);
}

/// Takes stand-ins off where nothing follows.
pub(super) fn remove_stand_ins(
    mut commands: Commands,
    stand_ins: Query<(Entity, &StandIn, &DecompositionStatus)>,
) {
    for (entity, stand_in, status) in &stand_ins {
        if !matches!(status, DecompositionStatus::Failed(_) | DecompositionStatus::Cancelled) {
            continue;
        }
        let mut entity = commands.entity(entity);
        entity.try_remove::<(StandIn, Collider, ColliderScale)>();
        if stand_in.owns_mass {
            entity.try_remove::<ColliderMassProperties>();
        }
    }
}

/// Nothing for what has no thickness: Rapier's boxes have.
fn bounding_box(data: &MeshData) -> Option<SharedShape> {
    let corners = data.triangles.iter().flatten();
    let points = corners.filter_map(|vertex| data.positions.get(*vertex as usize));
    let mut low = Vector::INFINITY;
    let mut high = Vector::NEG_INFINITY;
    for point in points.map(|point| Vector::from(*point)).filter(|point| point.is_finite()) {
        (low, high) = (low.min(point), high.max(point));
    }
    let half = (high - low) / 2.0;
    let pose = Pose::from_translation(low + half);
    let is_usable = half.is_finite() && half.min_element() > 0.0;
    is_usable
        .then(|| SharedShape::compound(vec![(pose, SharedShape::cuboid(half.x, half.y, half.z))]))
}

fn convex_hull(data: &MeshData) -> Option<SharedShape> {
    let corners = data.triangles.iter().flatten();
    let points: Vec<[f64; 3]> = corners
        .filter_map(|vertex| data.positions.get(*vertex as usize))
        .filter(|point| point.iter().all(|x| x.is_finite()))
        .map(|point| point.map(f64::from))
        .collect();
    let (hull, _) = solid_hull(&mut HullBuilder::new(), &points, [0.0; 3], 0.0).ok()?;
    let hull = Hull {
        volume: hull.volume(),
        bounds: hull.bounds()?,
        points: hull.points,
        triangles: hull.triangles,
        component: 0,
        source_triangles: Vec::new(),
        added_thickness: 0.0,
        cap_growth: 0.0,
        phantom_max: None,
    };
    crate::rapier::shape(&[hull], [1.0; 3]).ok()
}
