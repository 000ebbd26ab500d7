//! What stands on the stage: the model to be looked at, or as a body that falls, hangs or is
//! stacked.

use std::sync::Arc;

use bevy::light::NotShadowCaster;
use bevy::prelude::*;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use bevy_rapier3d::prelude::*;
use bevy_rapier3d::rapier::dynamics::IntegrationParameters;
use hullwright_demos::RECYCLED_FOR;
use hullwright_demos::hulls::{HullMaterials, edges_mesh, hulls_mesh};
use hullwright_demos::orbit::Orbit;
use hullwright_formats::palette;

use crate::decompose::{Fit, Tuning};
use crate::model::{Library, Model, drawn};

/// How many are stacked.
pub const STACK: usize = 10;

/// Height from which it is dropped, in metres, and how it is tilted then.
const DROP: f32 = 1.1;
const TILT: Vec3 = Vec3::new(0.35, 0.2, 0.55);

/// Room between stacked bodies before they fall onto each other, as a share of their height.
const GAP: f32 = 0.03;

/// The thickest hook, in metres, and the share of a hole's clearance that a hook may take.
const HOOK: f32 = 0.05;
const HOOK_SHARE: f32 = 0.45;

/// Room under what hangs, in metres.
const UNDER: f32 = 0.35;

/// Things turn as in air. What hangs is damped more: Rapier's contacts stay in place during a step,
/// which adds energy to a swing. The damping removes as much, so that it comes to rest in some
/// seconds.
const AIR: Damping = Damping { linear_damping: 0.1, angular_damping: 0.5 };
const HANGING: Damping = Damping { linear_damping: 0.1, angular_damping: 1.5 };

/// How much what a probe fills hides: the gaps below are seen.
const WATER: f32 = 0.6;

/// What is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Trial {
    /// It is looked at.
    #[default]
    Look,
    /// It falls on the floor.
    Drop,
    /// It is hung on a hook.
    Hook,
    /// Ten of it are stacked.
    Stack,
}

/// What is shown, and how.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct Show {
    /// What is tried.
    pub trial: Trial,
    /// Raised to try it again.
    pub attempt: u32,
    /// Whether hulls are shown.
    pub hulls: bool,
    /// Whether the mesh is shown.
    pub mesh: bool,
    /// Whether the edges of hulls are shown.
    pub edges: bool,
    /// Whether what no ball of the probe's radius reaches is shown instead of hulls.
    pub filled: bool,
    /// How far hulls are moved apart while it is looked at.
    pub explosion: f32,
    /// Whether the file's third axis points up, and not its second.
    pub z_up: bool,
}

impl Default for Show {
    fn default() -> Self {
        Self {
            trial: Trial::Look,
            attempt: 0,
            hulls: true,
            mesh: true,
            edges: true,
            filled: false,
            explosion: 0.0,
            z_up: false,
        }
    }
}

impl Show {
    /// How far hulls are moved apart now.
    pub fn apart(&self) -> f32 {
        if self.trial == Trial::Look { self.explosion } else { 0.0 }
    }

    fn stand(&self) -> Quat {
        let turn = if self.z_up { -std::f32::consts::FRAC_PI_2 } else { 0.0 };
        Quat::from_rotation_x(turn)
    }
}

/// All that goes when something else is tried.
#[derive(Component)]
pub struct Prop;

/// The model as a body.
#[derive(Component)]
pub struct Thing;

/// What a thing is drawn with.
#[derive(Component, Clone, Copy, PartialEq)]
pub enum Layer {
    /// The source mesh.
    Mesh,
    /// Its hulls.
    Hulls,
    /// Their edges.
    Edges,
    /// The surface of what no ball of the probe's radius reaches.
    Filled,
}

/// What was arranged last; a change of any of it is a new arrangement.
#[derive(Default)]
pub struct Arranged {
    model: Option<Arc<Model>>,
    fit: Option<Arc<Fit>>,
    trial: Trial,
    attempt: u32,
    apart: f32,
    z_up: bool,
}

/// The materials of what is no hull.
#[derive(Resource)]
pub struct Materials {
    clay: Handle<StandardMaterial>,
    iron: Handle<StandardMaterial>,
    water: Handle<StandardMaterial>,
}

impl FromWorld for Materials {
    fn from_world(world: &mut World) -> Self {
        let rgb = |[red, green, blue]: palette::Colour| Color::srgb_u8(red, green, blue);
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let matt = |base_color| StandardMaterial {
            base_color,
            perceptual_roughness: 0.9,
            reflectance: 0.2,
            // Sheets have a back.
            cull_mode: None,
            double_sided: true,
            ..default()
        };
        Self {
            clay: materials.add(matt(rgb(palette::CLAY))),
            iron: materials.add(matt(Color::srgb_u8(120, 126, 136))),
            water: materials.add(StandardMaterial {
                alpha_mode: AlphaMode::Blend,
                ..matt(rgb(palette::FILLED).with_alpha(WATER))
            }),
        }
    }
}

/// The hulls that are shown belong to the model that is shown.
pub fn fit_of<'t>(tuning: &'t Tuning, model: &Arc<Model>) -> Option<&'t Arc<Fit>> {
    tuning.fit.as_ref().filter(|fit| Arc::ptr_eq(&fit.model, model))
}

/// Sets the stage anew when something has changed that is on it.
#[allow(clippy::too_many_arguments)]
pub fn arrange(
    mut commands: Commands,
    library: Res<Library>,
    tuning: Res<Tuning>,
    show: Res<Show>,
    materials: Res<Materials>,
    hull_materials: Res<HullMaterials>,
    mut meshes: ResMut<Assets<Mesh>>,
    props: Query<Entity, With<Prop>>,
    mut views: Query<&mut Orbit>,
    mut arranged: Local<Arranged>,
) {
    let Some(model) = &library.current else { return };
    let fit = fit_of(&tuning, model);
    let is_same_model = arranged.model.as_ref().is_some_and(|old| Arc::ptr_eq(old, model));
    let is_same_fit = match (&arranged.fit, fit) {
        (Some(old), Some(new)) => Arc::ptr_eq(old, new),
        (None, None) => true,
        _ => false,
    };
    let is_same_trial = arranged.trial == show.trial && arranged.z_up == show.z_up;
    let apart = show.apart();
    if is_same_model
        && is_same_fit
        && is_same_trial
        && arranged.attempt == show.attempt
        && arranged.apart == apart
    {
        return;
    }
    for prop in &props {
        commands.entity(prop).despawn();
    }
    let filled = fit.and_then(|fit| fit.probed.as_ref());
    let look = Look {
        mesh: library.drawn.clone(),
        filled: filled.map(|(_, filled)| meshes.add(drawn(filled))),
        hulls: fit.map(|fit| {
            let hulls = meshes.add(hulls_mesh(&fit.pieces, apart));
            (hulls, meshes.add(edges_mesh(&fit.pieces, apart)))
        }),
    };
    let mut builder = Builder {
        commands: &mut commands,
        model,
        fit: fit.map(|fit| fit.as_ref()),
        look: &look,
        materials: &materials,
        hull_materials: &hull_materials,
        meshes: &mut meshes,
        stand: show.stand(),
    };
    let view = match show.trial {
        Trial::Look => builder.look(apart),
        Trial::Drop => builder.drop(),
        Trial::Hook => builder.hook(),
        Trial::Stack => builder.stack(),
    };
    let is_new_view = !is_same_model || !is_same_trial || arranged.apart != apart;
    for mut orbit in views.iter_mut().filter(|_| is_new_view) {
        (orbit.target, orbit.radius) = view;
        if !is_same_model || !is_same_trial {
            orbit.distance = 1.0;
        }
    }
    *arranged = Arranged {
        model: Some(model.clone()),
        fit: fit.cloned(),
        trial: show.trial,
        attempt: show.attempt,
        apart,
        z_up: show.z_up,
    };
}

/// What a thing is drawn with, shared by all of them.
struct Look {
    mesh: Handle<Mesh>,
    hulls: Option<(Handle<Mesh>, Handle<Mesh>)>,
    filled: Option<Handle<Mesh>>,
}

/// Middle and radius of what the camera should see.
type View = (Vec3, f32);

struct Builder<'b, 'w, 's> {
    commands: &'b mut Commands<'w, 's>,
    model: &'b Model,
    fit: Option<&'b Fit>,
    look: &'b Look,
    materials: &'b Materials,
    hull_materials: &'b HullMaterials,
    meshes: &'b mut Assets<Mesh>,
    stand: Quat,
}

impl Builder<'_, '_, '_> {
    /// Half its size as it stands.
    fn half(&self) -> Vec3 {
        (self.stand * self.model.half).abs()
    }

    fn look(&mut self, apart: f32) -> View {
        let half = self.half();
        let middle = Vec3::Y * half.y * (1.0 + apart);
        let place = Transform::from_translation(middle).with_rotation(self.stand);
        let thing = self.thing(place, RigidBody::Fixed);
        if apart > 0.0 {
            self.commands.entity(thing).insert(ColliderDisabled);
        }
        (middle, half.length() * (1.0 + 0.8 * apart))
    }

    fn drop(&mut self) -> View {
        let tilt = Quat::from_euler(EulerRot::XYZ, TILT.x, TILT.y, TILT.z);
        let place =
            Transform::from_xyz(0.0, DROP + self.half().y, 0.0).with_rotation(tilt * self.stand);
        self.thing(place, RigidBody::Dynamic);
        (Vec3::Y * 0.7, 1.45)
    }

    fn stack(&mut self) -> View {
        let half = self.half();
        let step = 2.0 * half.y * (1.0 + GAP);
        for level in 0..STACK {
            let place = Transform::from_xyz(0.0, half.y + step * level as f32 + 0.005, 0.0);
            self.thing(place.with_rotation(self.stand), RigidBody::Dynamic);
        }
        let height = step * STACK as f32;
        (Vec3::Y * (height / 2.0), height / 2.0 + half.length())
    }

    /// A hook that sticks out of a post towards the viewer, and the thing on it.
    fn hook(&mut self) -> View {
        let hang = self.model.hang;
        let corners = (0..8).map(|bits| {
            let sign = |bit: i32| if bits >> bit & 1 == 0 { -1.0 } else { 1.0 };
            hang.turn * (self.model.half * Vec3::new(sign(0), sign(1), sign(2)))
        });
        let (low, high) = corners.fold((Vec3::MAX, Vec3::MIN), |(low, high), corner| {
            (low.min(corner), high.max(corner))
        });
        let radius =
            if hang.clearance > 0.0 { HOOK.min(HOOK_SHARE * hang.clearance) } else { HOOK };
        // Without a hole it is laid on the hook from above.
        let at = if hang.clearance > 0.0 { hang.at } else { Vec3::new(0.0, low.y - 0.1, 0.0) };
        let height = UNDER + (at.y - low.y).max(0.6);
        let (back, front) = (low.z - 0.15, high.z + 0.12);
        let length = front - back;
        let peg = Vec3::new(0.0, height, (back + front) / 2.0);
        let iron = self.materials.iron.clone();
        let mut part = |mesh: Mesh, collider: Collider, place: Transform| {
            self.commands.spawn((
                Prop,
                Mesh3d(self.meshes.add(mesh)),
                MeshMaterial3d(iron.clone()),
                place,
                collider,
                Friction::coefficient(0.6),
            ));
        };
        let along = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        part(
            Capsule3d::new(radius, length).into(),
            Collider::capsule_y(length / 2.0, radius),
            Transform::from_translation(peg).with_rotation(along),
        );
        // Its tip is bent up, so that nothing swings off.
        let tip = (3.0 * radius).min(0.9 * hang.clearance.max(radius));
        part(
            Capsule3d::new(radius, tip).into(),
            Collider::capsule_y(tip / 2.0, radius),
            Transform::from_xyz(0.0, height + tip / 2.0, front),
        );
        let post = Vec3::new(0.14, height + 0.25, 0.1);
        part(
            Cuboid::from_size(post).into(),
            Collider::cuboid(post.x / 2.0, post.y / 2.0, post.z / 2.0),
            Transform::from_xyz(0.0, post.y / 2.0, back - 0.05),
        );
        let place = Vec3::Y * height - at;
        let place_and_turn = Transform::from_translation(place).with_rotation(hang.turn);
        let thing = self.thing(place_and_turn, RigidBody::Dynamic);
        self.commands.entity(thing).insert(HANGING);
        (Vec3::Y * (height + place.y) / 2.0, 1.25)
    }

    /// The model as a body; without hulls only to be seen.
    fn thing(&mut self, place: Transform, body: RigidBody) -> Entity {
        let mut thing = self.commands.spawn((Prop, Thing, place, Visibility::default()));
        if let Some(fit) = self.fit {
            thing.insert((body, fit.collider.clone(), fit.mass, AIR, Friction::coefficient(0.6)));
        }
        let glass = self.hull_materials.glass.clone();
        let edges = self.hull_materials.edges.clone();
        thing.with_children(|parts| {
            parts.spawn((
                Layer::Mesh,
                Mesh3d(self.look.mesh.clone()),
                MeshMaterial3d(self.materials.clay.clone()),
            ));
            if let Some((hulls, lines)) = &self.look.hulls {
                parts.spawn((Layer::Hulls, Mesh3d(hulls.clone()), MeshMaterial3d(glass)));
                let edges = (Mesh3d(lines.clone()), MeshMaterial3d(edges), NotShadowCaster);
                parts.spawn((Layer::Edges, edges));
            }
            if let Some(filled) = &self.look.filled {
                let water = MeshMaterial3d(self.materials.water.clone());
                parts.spawn((Layer::Filled, Mesh3d(filled.clone()), water, NotShadowCaster));
            }
        });
        thing.id()
    }
}

/// Lets Rapier compute contacts anew as soon as bodies move, while something hangs.
pub fn renew_contacts(show: Res<Show>, mut worlds: Query<&mut RapierContextSimulation>) {
    let is_hung = show.trial == Trial::Hook;
    let usual = IntegrationParameters::default().normalized_contact_recycle_distance;
    for mut world in &mut worlds {
        world
            .bypass_change_detection()
            .integration_parameters
            .normalized_contact_recycle_distance = if is_hung { RECYCLED_FOR } else { usual };
    }
}

/// Shows and hides layers. Hulls are of glass over the mesh, and solid alone.
pub fn show_layers(
    show: Res<Show>,
    materials: Res<HullMaterials>,
    mut layers: Query<(&Layer, &mut Visibility, &mut MeshMaterial3d<StandardMaterial>)>,
) {
    let has_filled = layers.iter().any(|(layer, ..)| *layer == Layer::Filled);
    let is_filled = show.filled && has_filled && show.apart() == 0.0;
    let hulls = if show.mesh && show.apart() == 0.0 { &materials.glass } else { &materials.solid };
    for (layer, mut visibility, mut material) in &mut layers {
        let is_shown = match layer {
            // Hulls that have left it would hide behind it.
            Layer::Mesh => show.mesh && (show.apart() == 0.0 || !show.hulls),
            Layer::Hulls => show.hulls && !is_filled,
            Layer::Filled => is_filled,
            Layer::Edges => show.edges && show.hulls,
        };
        visibility.set_if_neq(if is_shown { Visibility::Inherited } else { Visibility::Hidden });
        if *layer == Layer::Hulls && material.0 != *hulls {
            material.0 = hulls.clone();
        }
    }
}
