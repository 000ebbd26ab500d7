//! A camera that goes around what it looks at: drag to turn it, wheel to come nearer.

use bevy::camera::PerspectiveProjection;
use bevy::core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit};
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;

use crate::studio::Studio;

/// Angle from the top of the picture to its bottom, in radians: that of a long lens, which leaves
/// upright things upright.
const FIELD_OF_VIEW: f32 = 0.5;

/// Radians for each pixel that the mouse is dragged.
const TURN: f32 = 0.007;

/// Share of the distance for each click of the wheel.
const CLICK: f32 = 0.1;

/// Pixels that count as one click, for wheels and pads that report pixels.
const PIXELS_PER_CLICK: f32 = 40.0;

/// The camera stays above the floor, and below the zenith.
const ELEVATIONS: [f32; 2] = [0.03, 1.5];

/// Distances, in radii of what is framed.
const DISTANCES: [f32; 2] = [0.3, 6.0];

/// What the camera looks at, and from where.
#[derive(Component, Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// The middle of what is seen.
    pub target: Vec3,
    /// Radius of a ball that just fits into the picture, in metres.
    pub radius: f32,
    /// How much farther away than that it is; 1 for just fitting.
    pub distance: f32,
    /// Angle about the vertical, in radians: 0 looks along -z.
    pub azimuth: f32,
    /// Angle above the horizon, in radians.
    pub elevation: f32,
    /// Share of the window's width, at its left, that something else covers.
    pub covered: f32,
}

impl Orbit {
    /// From the front and a little above.
    pub fn new(target: Vec3, radius: f32) -> Self {
        Self { target, radius, distance: 1.0, azimuth: 0.5, elevation: 0.35, covered: 0.0 }
    }

    /// The same from other angles, in radians.
    #[must_use]
    pub fn from_angles(self, azimuth: f32, elevation: f32) -> Self {
        Self { azimuth, elevation, ..self }
    }

    /// Where the camera stands in a window of these proportions, width by height.
    pub fn transform(&self, aspect: f32) -> Transform {
        let free = aspect * (1.0 - self.covered);
        let half = (FIELD_OF_VIEW / 2.0).tan();
        let narrow = (half * free.min(1.0)).atan();
        let distance = self.distance * self.radius / narrow.sin();
        let turn = Quat::from_rotation_y(self.azimuth) * Quat::from_rotation_x(-self.elevation);
        // Sideways, so that the target is in the middle of what is not covered.
        let sideways = -self.covered * aspect * half * distance;
        Transform::from_translation(self.target + turn * Vec3::new(sideways, 0.0, distance))
            .with_rotation(turn)
    }
}

/// Moves every camera that has an [`Orbit`].
pub struct OrbitPlugin;

impl Plugin for OrbitPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, (drag, place).chain());
    }
}

/// A camera for a studio.
pub fn camera(orbit: Orbit, studio: &Studio) -> impl Bundle + use<> {
    (
        Camera3d::default(),
        // The palette's colours as they are.
        Tonemapping::None,
        DebandDither::Disabled,
        Projection::Perspective(PerspectiveProjection { fov: FIELD_OF_VIEW, ..default() }),
        studio.haze(),
        orbit.transform(1.0),
        orbit,
    )
}

fn drag(
    mut cameras: Query<&mut Orbit>,
    wants: Res<EguiWantsInput>,
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    mut is_dragged: Local<bool>,
) {
    let is_free = !wants.wants_any_pointer_input();
    // A drag belongs to where it began.
    *is_dragged = buttons.pressed(MouseButton::Left)
        && (*is_dragged || is_free && buttons.just_pressed(MouseButton::Left));
    for mut orbit in &mut cameras {
        if *is_dragged && motion.delta != Vec2::ZERO {
            let [low, high] = ELEVATIONS;
            orbit.azimuth -= TURN * motion.delta.x;
            orbit.elevation = (orbit.elevation + TURN * motion.delta.y).clamp(low, high);
        }
        if is_free && scroll.delta.y != 0.0 {
            let clicks = match scroll.unit {
                MouseScrollUnit::Line => scroll.delta.y,
                MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_PER_CLICK,
            };
            let [low, high] = DISTANCES;
            orbit.distance = (orbit.distance * (-CLICK * clicks).exp()).clamp(low, high);
        }
    }
}

fn place(mut cameras: Query<(&Orbit, &mut Transform)>, windows: Query<&Window>) {
    let Some(window) = windows.iter().next() else { return };
    let aspect = window.width() / window.height().max(1.0);
    for (orbit, mut transform) in &mut cameras {
        transform.set_if_neq(orbit.transform(aspect));
    }
}
