//! The camera keeps what moves in sight.

use bevy::prelude::*;
use hullwright_demos::orbit::Orbit;
use hullwright_demos::studio::Studio;

use crate::model::Library;
use crate::scene::{Show, Thing, Trial};

/// Share of the way by which the camera follows a stack that falls, in each frame.
const FOLLOW: f32 = 0.2;

/// The haze begins behind what is looked at, however far away that is.
pub fn see_through_haze(
    mut views: Query<(&Orbit, &Transform, &mut DistanceFog)>,
    studio: Res<Studio>,
) {
    for (orbit, eye, mut haze) in &mut views {
        let behind = eye.translation.distance(orbit.target) + orbit.radius;
        let falloff = studio.haze_behind(behind);
        if let (FogFalloff::Linear { start: new, .. }, FogFalloff::Linear { start: old, .. }) =
            (&falloff, &haze.falloff)
            && new != old
        {
            haze.falloff = falloff;
        }
    }
}

/// The camera sees a stack as high as it is: at first a tower, later perhaps a heap.
pub fn follow_stack(
    show: Res<Show>,
    library: Res<Library>,
    things: Query<&Transform, With<Thing>>,
    mut views: Query<&mut Orbit>,
) {
    let Some(model) = library.current.as_ref().filter(|_| show.trial == Trial::Stack) else {
        return;
    };
    let places = || things.iter().map(|thing| thing.translation);
    let Some((low, high)) = places()
        .map(|place| (place, place))
        .reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))
    else {
        return;
    };
    let radius = (high - low).length() / 2.0 + model.half.length();
    for mut view in &mut views {
        let target = view.target.lerp((low + high) / 2.0, FOLLOW);
        let radius = view.radius + FOLLOW * (radius - view.radius);
        // What sleeps is not drawn anew.
        if view.target.distance(target) + (view.radius - radius).abs() > 1e-4 {
            (view.target, view.radius) = (target, radius);
        }
    }
}
