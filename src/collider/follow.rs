//! Colliders that follow a changing scale: the hulls that are there, with their points moved. Once
//! the scale rests they are made anew, so that no error adds up.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    Collider, ColliderMassProperties, RapierColliderHandle, RapierContextColliders,
    RapierContextEntityLink,
};

use super::changes::Tagged;
use super::moved::moved;
use super::placement::Placements;
use super::wake::Sleepers;
use super::work::{AttachedCollider, OwnCollider, OwnMass, Work};
use crate::jobs::Frame;

/// A collider that may follow.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Follower {
    collider: &'static mut Collider,
    own: &'static mut OwnCollider,
    attached: Option<&'static AttachedCollider>,
    mass: Option<&'static mut ColliderMassProperties>,
    own_mass: Option<&'static mut OwnMass>,
    in_rapier: Option<(&'static RapierColliderHandle, &'static RapierContextEntityLink)>,
}

/// Gives colliders the scales that their entities have. What the frame's budget is too short for
/// comes first in the next one.
pub(super) fn follow_scales(
    mut work: Work,
    Frame { mut time, settings }: Frame,
    placements: Placements,
    mut followers: Query<Follower, Tagged>,
    mut sets: Query<&mut RapierContextColliders>,
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
            && follow(entity, follower, &placements, &mut sets) == Some(())
        {
            sleepers.wake(&placements, entity);
        }
    }
    all.drain(..done);
}

fn follow(
    entity: Entity,
    mut follower: FollowerItem,
    placements: &Placements,
    sets: &mut Query<&mut RapierContextColliders>,
) -> Option<()> {
    let own = &mut *follower.own;
    // One that the game has put in its place is its own.
    if !own.is(&follower.collider, None) {
        return None;
    }
    let place = placements.placement(entity);
    let shape = moved(&own.made, &(place.map * own.made_map.inverse()))?;
    (own.shape, own.stretch) = (shape.clone(), place.stretch);
    // Rapier's own collider is written to: where bevy_rapier sees a change it computes the volume
    // and the density anew, which takes twice as long as to scale.
    let mut set = follower.in_rapier.and_then(|(_, context)| sets.get_mut(context.0).ok());
    let handle = follower.in_rapier.map(|(handle, _)| handle.0);
    let in_rapier = set.as_mut().zip(handle);
    // A clone may have the handle of the original.
    let in_rapier = in_rapier.filter(|(set, of)| set.collider_entity(*of) == Some(entity));
    let mut in_rapier = in_rapier.and_then(|(set, handle)| set.colliders.get_mut(handle));
    let collider = match &mut in_rapier {
        Some(in_rapier) => {
            in_rapier.set_shape(shape.clone());
            follower.collider.bypass_change_detection()
        }
        None => &mut *follower.collider,
    };
    *collider = Collider::from(shape);
    if let Some(mut mass) = follower.mass
        && let Some(mut own_mass) = follower.own_mass
        && OwnMass::owns(Some(&own_mass), Some(&mass))
        && let Some(attached) = follower.attached
        && let Ok(Some(present)) = own.weigh(attached.requested.weight, &place.map)
    {
        own_mass.0 = present;
        let mass = match (in_rapier, present) {
            (Some(in_rapier), ColliderMassProperties::MassProperties(properties)) => {
                in_rapier.set_mass_properties(properties.into_rapier());
                mass.bypass_change_detection()
            }
            _ => &mut *mass,
        };
        *mass = present;
    }
    Some(())
}
