//! Colliders that follow a changing scale: the hulls that are there, with their points moved. Once
//! the scale rests they are made anew, so that no error adds up.

use bevy::ecs::query::QueryData;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties};
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::Pose;
use bevy_rapier3d::rapier::parry::shape::{Ball, Capsule, TypedShape};

use super::changes::Tagged;
use super::placement::Placements;
use super::wake::Sleepers;
use super::work::{AttachedCollider, OwnCollider, OwnMass, Work};
use crate::bevy::jobs::Frame;

/// A larger triangle mesh takes more time than a frame has, and waits until its scale rests.
const MOST_TRIANGLES: usize = 5_000;

/// A collider that may follow.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Follower {
    collider: &'static mut Collider,
    own: &'static mut OwnCollider,
    attached: Option<&'static AttachedCollider>,
    mass: Option<&'static mut ColliderMassProperties>,
    own_mass: Option<&'static mut OwnMass>,
}

/// Gives colliders the scales that their entities have. What the frame's budget is too short for
/// comes first in the next one.
pub(super) fn follow_scales(
    mut work: Work,
    Frame { mut time, settings }: Frame,
    placements: Placements,
    mut followers: Query<Follower, Tagged>,
    mut sleepers: Sleepers,
) {
    let mut budget = time.attaching_budget(&settings);
    let all = &mut work.unfinished.to_follow;
    let mut done = 0;
    while let Some(entity) = all.get_index(done).copied()
        && budget.allows_one()
    {
        done += 1;
        if let Ok(follower) = followers.get_mut(entity)
            && follow(entity, follower, &placements) == Some(())
        {
            sleepers.wake(&placements, entity);
        }
    }
    all.drain(..done);
}

fn follow(entity: Entity, mut follower: FollowerItem, placements: &Placements) -> Option<()> {
    let own = &mut *follower.own;
    // One that the game has put in its place is its own.
    if !own.is(&follower.collider, None) {
        return None;
    }
    let place = placements.placement(entity);
    let shape = moved(&own.made, &(place.map * own.made_map.inverse()))?;
    *follower.collider = Collider::from(shape.clone());
    (own.shape, own.stretch) = (shape, place.stretch);
    if let Some(mass) = &mut follower.mass
        && let Some(own_mass) = &mut follower.own_mass
        && OwnMass::owns(Some(own_mass), Some(mass))
        && let Some(attached) = follower.attached
        && let Ok(Some(present)) = own.weigh(attached.requested.weight, &place.map)
    {
        (**mass, own_mass.0) = (present, present);
    }
    Some(())
}

/// A shape whose points are moved by a map; `None` where it has none, or that takes too long.
/// O(points).
pub(super) fn moved(shape: &SharedShape, map: &Affine3A) -> Option<SharedShape> {
    let matrix = map.matrix3;
    if !(map.is_finite() && matrix.determinant().is_normal()) {
        return None;
    }
    let scale = Vec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    match scale.min_element() > 0.0 && *map == Affine3A::from_scale(scale) {
        true => scaled(shape, scale),
        false => mapped(shape, map),
    }
}

fn scaled(shape: &SharedShape, scale: Vec3) -> Option<SharedShape> {
    let uniform = (scale.x == scale.y && scale.y == scale.z).then_some(scale.x);
    Some(match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => SharedShape::new(hull.clone().scaled(scale)?),
        TypedShape::TriMesh(mesh) if mesh.indices().len() <= MOST_TRIANGLES => {
            SharedShape::new(mesh.clone().scaled(scale))
        }
        TypedShape::Cuboid(cuboid) => SharedShape::new(cuboid.scaled(scale)),
        TypedShape::Ball(Ball { radius }) => SharedShape::ball(radius * uniform?),
        TypedShape::Capsule(Capsule { segment, radius }) => {
            let factor = uniform?;
            SharedShape::capsule(segment.a * factor, segment.b * factor, radius * factor)
        }
        TypedShape::Compound(parts) => {
            let part = |(pose, part): &(Pose, SharedShape)| {
                // What is turned would be sheared.
                if pose.rotation != Pose::IDENTITY.rotation {
                    uniform?;
                }
                let pose = Pose { translation: pose.translation * scale, ..*pose };
                Some((pose, scaled(part, scale)?))
            };
            SharedShape::compound(parts.shapes().iter().map(part).collect::<Option<_>>()?)
        }
        _ => return None,
    })
}

/// By hulls of the moved points.
fn mapped(shape: &SharedShape, map: &Affine3A) -> Option<SharedShape> {
    let one = [(Pose::IDENTITY, shape.clone())];
    let parts = shape.as_compound().map_or(&one[..], |compound| compound.shapes());
    let points = |(pose, part): &(Pose, SharedShape)| -> Option<Vec<[f64; 3]>> {
        let place = |point: &Vec3| {
            map.transform_point3(pose.transform_point(*point)).to_array().map(f64::from)
        };
        Some(part.as_convex_polyhedron()?.points().iter().map(place).collect())
    };
    let hulls: Vec<Vec<[f64; 3]>> = parts.iter().map(points).collect::<Option<_>>()?;
    crate::rapier::shape_from_points(&hulls, [1.0; 3]).ok()
}
