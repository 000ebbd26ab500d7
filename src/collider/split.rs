//! A collider that is split among children, and follows their parent's scale.

use bevy::prelude::*;
use hullwright_parry::ColliderError;
use hullwright_parry::parry3d::math::Pose;
use hullwright_parry::parry3d::shape::SharedShape;

use super::children::{HullCollider, groups};
use super::parts::ColliderParts;
use super::placement::Placement;
use super::work::OwnCollider;
use crate::engine::{Engine, Weight};
use crate::tag::HullGrouping;

/// Children in the place of an entity's collider.
pub(super) fn attach<E: Engine>(
    commands: &mut Commands,
    entity: Entity,
    own: &OwnCollider,
    place: &Placement,
    parts: &ColliderParts,
    (grouping, weight): (HullGrouping, Weight),
    cache: &mut E::Cache,
) -> Result<(), ColliderError> {
    let shapes = hulls(&own.shape);
    let groups = groups(grouping, shapes.len() as u32, parts);
    let mut taken: Vec<u32> = groups.clone();
    taken.sort_unstable();
    taken.dedup();
    for group in taken {
        let hulls: Vec<u32> =
            (0..).zip(&groups).filter(|(_, of)| **of == group).map(|of| of.0).collect();
        let shape = joined(&shapes, &hulls);
        let mass = share(&shapes, &hulls);
        let mass = own.weigh::<E>(weighed(weight, mass), &place.map)?;
        let collider = E::collider(&shape, place.engine_scale, cache);
        let child = commands.spawn((Transform::IDENTITY, ChildOf(entity))).id();
        E::copy_surface(&mut commands.entity(entity), child);
        let mut child = commands.entity(child);
        E::attach(&mut child, collider);
        if let Some(mass) = mass {
            E::set_mass(&mut child, mass);
        }
        // At last, so that what observers put there stays.
        child.insert((parts.of_hulls(&hulls), HullCollider { hulls }));
    }
    Ok(())
}

/// Gives children the shape that their parent has by now.
pub(super) fn follow<'a, E: Engine>(
    commands: &mut Commands,
    children: impl Iterator<Item = (Entity, &'a HullCollider)>,
    own: &OwnCollider,
    place: &Placement,
    weight: Option<Weight>,
) {
    let shapes = hulls(&own.shape);
    for (child, HullCollider { hulls }) in children {
        let shape = joined(&shapes, hulls);
        let collider = E::collider(&shape, place.engine_scale, &mut E::Cache::default());
        let weight = weight.map(|weight| weighed(weight, share(&shapes, hulls)));
        let mass = weight.and_then(|weight| own.weigh::<E>(weight, &place.map).ok().flatten());
        E::replace(&mut commands.entity(child), collider, mass);
    }
}

/// Each hull of a shape.
fn hulls(shape: &SharedShape) -> Vec<(Pose, SharedShape)> {
    match shape.as_compound() {
        Some(compound) => compound.shapes().to_vec(),
        None => vec![(Pose::IDENTITY, shape.clone())],
    }
}

/// Some hulls as one shape.
fn joined(all: &[(Pose, SharedShape)], hulls: &[u32]) -> SharedShape {
    let mut own: Vec<(Pose, SharedShape)> =
        hulls.iter().filter_map(|&hull| all.get(hull as usize).cloned()).collect();
    match own.pop() {
        Some((pose, single)) if own.is_empty() && pose == Pose::IDENTITY => single,
        last => {
            own.extend(last);
            SharedShape::compound(own)
        }
    }
}

/// The share of some hulls in the volume of all.
fn share(all: &[(Pose, SharedShape)], hulls: &[u32]) -> f32 {
    let volume = |(_, shape): &(Pose, SharedShape)| shape.mass_properties(1.0).mass();
    let own = hulls.iter().filter_map(|&hull| all.get(hull as usize)).map(volume).sum::<f32>();
    own / all.iter().map(volume).sum::<f32>()
}

/// A share of a weight. Each child has the centre and, as far as its mass goes, the inertia of the
/// whole: together they weigh and turn as the whole does.
fn weighed(weight: Weight, share: f32) -> Weight {
    Weight { density: weight.density * share, mass: weight.mass.map(|mass| mass * share) }
}
