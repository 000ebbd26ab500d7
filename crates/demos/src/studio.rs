//! A studio: one lamp with a shadow, one without, and a floor that fades into the background.

use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap};
use bevy::prelude::*;

/// Lux of the lamp with the shadow. With what the others give, a white thing that faces it is just
/// white: there is no tone mapping, so that hulls keep the colours of the palette.
const KEY_LIGHT: f32 = 2300.0;

/// Lux of the lamp from the other side, without a shadow.
const FILL_LIGHT: f32 = 500.0;

/// Candela per square metre from everywhere.
const AMBIENT_LIGHT: f32 = 260.0;

/// Pixels along each side of the shadow map. One map is enough for a scene that is seen at once;
/// the software renderer of a machine without a graphics card draws it in time.
const SHADOW_MAP: usize = 2048;

/// The floor's size, and where it begins and ends to fade, in widths of the scene.
const FLOOR: f32 = 60.0;
const FADE: [f32; 2] = [3.0, 9.0];

/// Farthest shadow from the camera, in widths of the scene.
const SHADOWS: f32 = 5.5;

/// How the studio looks.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct Studio {
    /// The floor, and all behind it.
    pub backdrop: Color,
    /// Width of the scene, in metres.
    pub width: f32,
}

impl Studio {
    /// Paper under a skylight, for a scene of this width in metres.
    pub fn light(width: f32) -> Self {
        Self { backdrop: Color::srgb_u8(226, 224, 220), width }
    }

    /// Slate, for a scene of this width in metres.
    pub fn dark(width: f32) -> Self {
        Self { backdrop: Color::srgb_u8(38, 41, 47), width }
    }

    /// The haze that belongs on the camera.
    pub fn haze(&self) -> DistanceFog {
        DistanceFog { color: self.backdrop, falloff: self.haze_behind(0.0), ..default() }
    }

    /// How the haze thickens if it must not begin before this distance from the camera, in metres.
    pub fn haze_behind(&self, distance: f32) -> FogFalloff {
        let [start, end] = FADE.map(|widths| widths * self.width);
        let start_behind = start.max(distance);
        FogFalloff::Linear { start: start_behind, end: start_behind + end - start }
    }
}

impl Plugin for Studio {
    fn build(&self, app: &mut App) {
        app.insert_resource(*self)
            .insert_resource(ClearColor(self.backdrop))
            .insert_resource(DirectionalLightShadowMap { size: SHADOW_MAP })
            .insert_resource(GlobalAmbientLight { brightness: AMBIENT_LIGHT, ..default() })
            .add_systems(Startup, set_up);
    }
}

fn set_up(
    mut commands: Commands,
    studio: Res<Studio>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: SHADOWS * studio.width,
        ..default()
    };
    let from =
        |x: f32, y: f32, z: f32| Transform::from_xyz(x, y, z).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((
        DirectionalLight {
            illuminance: KEY_LIGHT,
            shadow_maps_enabled: true,
            color: Color::srgb(1.0, 0.98, 0.94),
            ..default()
        },
        shadows.build(),
        from(-1.1, 2.4, 1.3),
    ));
    // With WebGL2 Bevy has one lamp.
    if cfg!(not(target_family = "wasm")) {
        commands.spawn((
            DirectionalLight {
                illuminance: FILL_LIGHT,
                color: Color::srgb(0.86, 0.92, 1.0),
                ..default()
            },
            from(2.0, 0.7, 0.6),
        ));
    }
    commands.spawn((
        Mesh3d(
            meshes.add(Plane3d::default().mesh().size(FLOOR * studio.width, FLOOR * studio.width)),
        ),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: studio.backdrop,
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })),
    ));
}
