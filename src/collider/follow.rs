//! Colliders that follow a changing scale: the hulls that are there, with their points moved. Once
//! the scale rests they are made anew, so that no error adds up.

use bevy::prelude::*;

use super::changes::Tagged;
use super::children::{ColliderInChildren, HullCollider};
use super::moved::moved;
use super::placement::Placements;
use super::split;
use super::work::{AttachedCollider, OwnCollider, Work};
use crate::engine::Engine;
use crate::jobs::Frame;

/// A collider that may follow, and what the game may have put in its place.
type Follower<E> = (
    &'static mut OwnCollider,
    Option<&'static AttachedCollider>,
    <E as Engine>::Made,
    Has<ColliderInChildren>,
);

/// Gives colliders the scales that their entities have. What the frame's budget is too short for
/// comes first in the next one.
pub(super) fn follow_scales<E: Engine>(
    mut commands: Commands,
    mut work: Work,
    Frame { mut time, settings }: Frame,
    placements: Placements<E>,
    mut followers: Query<Follower<E>, Tagged>,
    of_hulls: Query<(Entity, &HullCollider)>,
    children: Query<&Children>,
) {
    let mut budget = time.attaching_budget(&settings);
    let all = &mut work.unfinished.to_follow;
    let mut done = 0;
    while let Some(entity) = all.get_index(done).copied()
        && budget.allows_one()
    {
        done += 1;
        let Ok((mut own, attached, made, in_children)) = followers.get_mut(entity) else {
            continue;
        };
        // One that the game has put in its place is its own, and one left to the engine follows.
        if !in_children && !E::present(&made).is_some_and(|present| own.is::<E>(present)) {
            continue;
        }
        let place = placements.placement(entity);
        let Some(shape) = moved(&own.made, &(place.map * own.made_map.inverse())) else { continue };
        let collider = own.change::<E>(shape, &place);
        let weight = attached.map(|attached| attached.requested.weight);
        let weight = weight.filter(|_| E::owns_mass(&made));
        if in_children {
            let below = children.get(entity).into_iter().flatten();
            let below = below.filter_map(|child| of_hulls.get(*child).ok());
            split::follow::<E>(&mut commands, below, &own, &place, weight);
        } else {
            let mass = weight.and_then(|weight| own.weigh::<E>(weight, &place.map).ok().flatten());
            E::replace(&mut commands.entity(entity), collider, mass);
        }
        if let Some((body, _)) = placements.body(entity) {
            E::wake(&mut commands, body);
        }
    }
    all.drain(..done);
}
