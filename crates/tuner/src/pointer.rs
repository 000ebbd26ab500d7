//! A ball of the probe's radius at the pointer, which rests where the mesh stops it.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_rapier3d::rapier::parry::math::Pose;
use bevy_rapier3d::rapier::parry::query::{ShapeCastOptions, cast_shapes};
use bevy_rapier3d::rapier::parry::shape::Ball as BallShape;
use bevy_rapier3d::rapier::prelude::Vector;
use hullwright_formats::palette::BALL;

use crate::decompose::Tuning;
use crate::model::Library;
use crate::scene::{Show, Thing, Trial, fit_of};
use crate::ui::PANEL;

/// How far a ball goes, in metres: farther than the camera is from the stage.
const FARTHEST: f32 = 100.0;

/// The ball.
#[derive(Component)]
pub struct PointerBall;

/// Makes the ball, unseen.
pub fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let [red, green, blue] = BALL;
    let colour = Color::srgb_u8(red, green, blue);
    let material = StandardMaterial { perceptual_roughness: 0.5, ..colour.into() };
    commands.spawn((
        PointerBall,
        Mesh3d(meshes.add(Sphere::new(1.0).mesh().build())),
        MeshMaterial3d(materials.add(material)),
        Visibility::Hidden,
    ));
}

/// Moves it along the ray below the pointer until it touches the mesh, while that is looked at.
#[allow(clippy::too_many_arguments)]
pub fn follow_pointer(
    mut contexts: EguiContexts,
    views: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    things: Query<&Transform, (With<Thing>, Without<PointerBall>)>,
    mut ball: Query<(&mut Transform, &mut Visibility), With<PointerBall>>,
    library: Res<Library>,
    tuning: Res<Tuning>,
    show: Res<Show>,
) {
    let Ok((mut place, mut visibility)) = ball.single_mut() else { return };
    let pointer = contexts.ctx_mut().ok().and_then(|context| context.pointer_latest_pos());
    let rest = || {
        let fit = fit_of(&tuning, library.current.as_ref()?)?;
        let (mesh, _) = fit.probed.as_ref()?;
        let is_looked_at = show.trial == Trial::Look && show.apart() == 0.0;
        let pointer = pointer.filter(|pointer| is_looked_at && pointer.x > PANEL)?;
        let (camera, eye) = views.iter().next()?;
        let ray = camera.viewport_to_world(eye, Vec2::new(pointer.x, pointer.y)).ok()?;
        let thing = things.iter().next()?;
        let radius = fit.settings.ball();
        let hit = cast_shapes(
            &Pose::from_translation(ray.origin),
            *ray.direction,
            &BallShape::new(radius),
            &Pose::from_parts(thing.translation, thing.rotation),
            Vector::ZERO,
            &**mesh,
            ShapeCastOptions::with_max_time_of_impact(FARTHEST),
        );
        let way = hit.ok()??.time_of_impact;
        Some(Transform::from_translation(ray.get_point(way)).with_scale(Vec3::splat(radius)))
    };
    let rest = rest();
    visibility.set_if_neq(rest.map_or(Visibility::Hidden, |_| Visibility::Inherited));
    if let Some(rest) = rest {
        place.set_if_neq(rest);
    }
}
