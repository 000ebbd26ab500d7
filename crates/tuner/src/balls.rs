//! Balls that are thrown at what is on the stage.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright_demos::orbit::Orbit;

use crate::scene::Prop;

/// Balls of one throw.
pub const THROW: usize = 12;

/// Radius in metres, mass per cubed metre, and speed in metres per second.
const RADIUS: f32 = 0.075;
const DENSITY: f32 = 120.0;
const SPEED: f32 = 7.0;

/// How far from the target's middle balls may be aimed, in radii of what is seen.
const SPREAD: f32 = 0.35;

/// The angle by which each ball's aim differs from the one before: spread over a disc without a
/// gap.
const GOLDEN_ANGLE: f32 = 2.399_963;

/// How far in front of the eye they begin, as a share of its distance to the target.
const START: f32 = 0.55;

/// Older balls go when there are more than this.
const MOST: usize = 240;

/// Asks for a throw.
#[derive(Message)]
pub struct Throw;

/// A thrown ball; a larger number is a younger one.
#[derive(Component, PartialEq, Eq, PartialOrd, Ord, Clone, Copy)]
pub struct Ball(usize);

/// Throws a handful from the eye to what it looks at.
pub fn throw(
    mut commands: Commands,
    mut asked: MessageReader<Throw>,
    views: Query<(&Orbit, &Transform), With<Camera3d>>,
    balls: Query<(Entity, &Ball)>,
    (mut meshes, mut materials): (ResMut<Assets<Mesh>>, ResMut<Assets<StandardMaterial>>),
    mut look: Local<Option<(Handle<Mesh>, Handle<StandardMaterial>)>>,
    mut thrown: Local<usize>,
) {
    let throws = asked.read().count();
    let Some((orbit, eye)) = views.iter().next().filter(|_| throws > 0) else { return };
    let (mesh, material) = look.get_or_insert_with(|| {
        let colour = StandardMaterial::from(Color::srgb_u8(240, 226, 190));
        (meshes.add(Sphere::new(RADIUS).mesh().build()), materials.add(colour))
    });
    let start = orbit.target.lerp(eye.translation, START);
    let [right, up] = [eye.right(), eye.up()];
    for _ in 0..throws * THROW {
        let number = *thrown % THROW;
        let out = SPREAD * orbit.radius * ((number as f32 + 0.5) / THROW as f32).sqrt();
        let aim = Vec2::from_angle(GOLDEN_ANGLE * number as f32) * out;
        // Side by side from the start: balls that begin in each other fly apart.
        let beside = right * aim.x + up * aim.y + up * (4.0 * RADIUS);
        let way = orbit.target - start;
        let seconds = way.length() / SPEED;
        // It falls on its way.
        let velocity = way / seconds + Vec3::Y * (9.81 * seconds / 2.0);
        commands.spawn((
            Prop,
            Ball(*thrown),
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(start + beside),
            RigidBody::Dynamic,
            Collider::ball(RADIUS),
            ColliderMassProperties::Density(DENSITY),
            Velocity { linear: velocity, angular: Vec3::ZERO },
            Damping { linear_damping: 0.15, angular_damping: 1.2 },
            Ccd::enabled(),
        ));
        *thrown += 1;
    }
    let mut all: Vec<(Ball, Entity)> = balls.iter().map(|(entity, ball)| (*ball, entity)).collect();
    all.sort_unstable();
    for (_, old) in all.iter().take(all.len().saturating_sub(MOST)) {
        commands.entity(*old).despawn();
    }
}
