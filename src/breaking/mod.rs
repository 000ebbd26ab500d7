//! Bodies that break: a body for each hull, with its part of what is drawn.

mod drawn;

use std::any::TypeId;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use hullwright::{Control, Fragment as FragmentOfMesh, break_apart};
use hullwright_parry::parry3d::shape::SharedShape;

use self::drawn::{Drawn, draw};
use crate::collider::children::groups;
use crate::collider::parts::ColliderParts;
use crate::collider::placement::Placements;
use crate::collider::work::AttachedCollider;
use crate::engine::{Engine, Motion, Velocity, Weight};
use crate::jobs::cache::ColliderGeometry;
use crate::jobs::request::{MeshPart, read_parts};
use crate::jobs::task::map_point;
use crate::tag::HullGrouping;
use crate::tag::outcomes::{DecompositionError, Descriptions};

/// Breaks an entity with a collider of hulls into fragments: [`BreakApartExt::break_apart`]
/// triggers it.
#[derive(EntityEvent, Debug, Clone)]
pub struct BreakApart {
    /// The entity with the collider.
    pub entity: Entity,
    /// What stays together.
    pub grouping: HullGrouping,
}

/// An entity has been broken apart. Where it is triggered the entity is still there; right after,
/// it is despawned with all its children.
#[derive(EntityEvent, Debug, Clone)]
pub struct BrokenApart {
    /// The entity that had the collider.
    pub entity: Entity,
    /// The bodies in its place.
    pub fragments: Vec<Entity>,
}

/// On a body that was a part of another one.
#[derive(Component, Debug, Clone, PartialEq, Eq)]
pub struct Fragment {
    /// The hulls of the whole in whose place it is.
    pub hulls: Vec<u32>,
}

/// On the entity, below a [`Fragment`], that draws where it was cut. It has the material of the
/// fragment's largest part, until the game gives it another one, as when this component is added:
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
/// # #[derive(Component, Clone)] struct MeshMaterial3d(Handle<Mesh>);
///
/// #[derive(Resource)]
/// struct Inside(Handle<Mesh>); // a material
///
/// fn paint_cuts(cut: On<Add<CutFaces>>, inside: Res<Inside>, mut commands: Commands) {
///     commands.entity(cut.entity).insert(MeshMaterial3d(inside.0.clone()));
/// }
/// # let mut app = App::new();
/// app.add_observer(paint_cuts);
/// ```
///
/// Its texture coordinates are in units of the world along the cut.
#[derive(Component, Debug, Clone, Copy, PartialEq, Eq)]
pub struct CutFaces;

/// Bodies that break.
pub trait BreakApartExt {
    /// Breaks an entity with a collider of the plugin's into bodies, and despawns it.
    ///
    /// Each fragment is a dynamic body with a collider of one hull for each that it stands for, and
    /// draws its part of the mesh. Planes between hulls cut it, see [`hullwright::break_apart`];
    /// colliders of fragments lie on their sides of these, so that nothing pushes fragments apart.
    /// Masses add up to that of the whole, and each moves on as it did in the whole. Fragments have
    /// the surface that the collider had (friction, groups, sensors) and the damping, gravity
    /// scale and dominance of its body.
    ///
    /// It takes effect at once: some milliseconds for a prop of thousands of triangles. An entity
    /// that has no hulls yet, or triangles instead, stays as it is, and the log says so. For one
    /// that is despawned or already broken, nothing happens.
    fn break_apart(&mut self, grouping: HullGrouping) -> &mut Self;
}

impl BreakApartExt for EntityCommands<'_> {
    fn break_apart(&mut self, grouping: HullGrouping) -> &mut Self {
        let entity = self.id();
        self.commands().trigger(BreakApart { entity, grouping });
        self
    }
}

pub(super) fn plugin<E: Engine>(app: &mut App) {
    app.add_observer(on_break_apart::<E>);
}

/// A body to be.
struct NewBody {
    fragment: Fragment,
    /// Of the whole, for some of its hulls.
    parts: ColliderParts,
    /// Its centre, and the rotation of the whole.
    place: Transform,
    shape: SharedShape,
    mass: f32,
    drawn: Drawn,
}

type Broken = (&'static ColliderParts, &'static AttachedCollider);

fn on_break_apart<E: Engine>(
    event: On<BreakApart>,
    broken: Query<Option<Broken>>,
    meshes_on: Query<&Mesh3d>,
    placements: Placements<E>,
    meshes: Res<Assets<Mesh>>,
    descriptions: Descriptions,
    mut commands: Commands,
) {
    let entity = event.entity;
    // Two impacts in one frame may both break it.
    let Ok(broken) = broken.get(entity) else { return };
    let refuse = |why: &str| {
        log::warn!("{} can't be broken apart: {why}", descriptions.entity(entity, None));
    };
    let Some((parts, attached)) = broken else {
        return refuse("it has no collider of hulls yet");
    };
    let ColliderGeometry::Hulls(file, _) = parts.geometry() else {
        return refuse("its collider is no hulls; DecompositionShape::Hulls asks for them");
    };
    let entities: Vec<(Entity, MeshPart)> = parts
        .entities()
        .iter()
        .filter_map(|&part| {
            let mesh = meshes_on.get(part).ok()?.id();
            Some((part, MeshPart { mesh, to_input: placements.relative(part, entity) }))
        })
        .collect();
    let (entities, of_input): (Vec<Entity>, Vec<MeshPart>) = entities.into_iter().unzip();
    if entities.is_empty() {
        return refuse("there is no mesh on it or below it");
    }
    let groups = groups(event.grouping, file.hulls.len() as u32, parts);
    let request = &attached.requested.request;
    let made = || -> Result<Vec<NewBody>, DecompositionError> {
        let data = read_parts(&of_input, &request.map_before, &meshes)?;
        let fragments = break_apart(data.view(), &file.hulls, &groups, &Control::new())?;
        let to_world = placements.global_transform(entity);
        let from_hulls = to_world.affine() * request.map_before.inverse();
        let rotation = to_world.rotation();
        let volume: f64 = fragments.iter().map(|fragment| fragment.volume).sum();
        let weight = attached.requested.weight;
        let determinant = from_hulls.matrix3.determinant().abs();
        let by_density = || {
            let whole = file.mass_properties.map_or(volume, |of| of.mass) as f32;
            weight.density * whole * determinant
        };
        let mass = weight.mass.unwrap_or_else(by_density);
        let body = |fragment: FragmentOfMesh| -> Result<Option<NewBody>, DecompositionError> {
            let Some(centre) = middle(&fragment) else { return Ok(None) };
            let translation = from_hulls.transform_point3(centre);
            let place = Transform { translation, rotation, scale: Vec3::ONE };
            let to_body = place.compute_affine().inverse() * from_hulls;
            let moved = map_point(&to_body);
            let hulls = fragment.colliders.iter();
            let hulls: Vec<Vec<[f64; 3]>> =
                hulls.map(|hull| hull.points.iter().map(|point| moved(*point)).collect()).collect();
            let shape = hullwright_parry::shape_from_points(&hulls, [1.0; 3])?;
            let drawn = draw(&fragment, &data, &of_input, &request.map_before, &to_body, &meshes);
            let mass = mass * (fragment.volume / volume) as f32;
            let parts = parts.of_hulls(&fragment.hulls);
            let fragment = Fragment { hulls: fragment.hulls };
            Ok(Some(NewBody { fragment, parts, place, shape, mass, drawn }))
        };
        fragments.into_iter().filter_map(|fragment| body(fragment).transpose()).collect()
    };
    let bodies = match made() {
        Ok(bodies) => bodies,
        Err(error) => return refuse(&error.to_string()),
    };
    let body = placements.body(entity).map(|(body, _)| body);
    commands.queue(move |world: &mut World| spawn::<E>(world, entity, body, &entities, bodies));
}

/// The middle of what it collides with; `None` without anything.
fn middle(fragment: &FragmentOfMesh) -> Option<Vec3> {
    let points = fragment.colliders.iter().flat_map(|hull| &hull.points);
    let (sum, count) = points.fold((Vec3::ZERO, 0), |(sum, count), point| {
        (sum + Vec3::from(point.map(|x| x as f32)), count + 1)
    });
    (count > 0).then(|| sum / count as f32)
}

/// Puts bodies in the place of an entity.
fn spawn<E: Engine>(
    world: &mut World,
    whole: Entity,
    body: Option<Entity>,
    parts: &[Entity],
    bodies: Vec<NewBody>,
) {
    let velocity = body.map_or_else(Velocity::default, |body| E::velocity(world, body));
    let looks = looks(world);
    let mut fragments = Vec::with_capacity(bodies.len());
    for NewBody { fragment, parts: known, place, shape, mass, drawn } in bodies {
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        let surfaces: Vec<(Entity, Handle<Mesh>)> = drawn
            .surfaces
            .into_iter()
            .map(|(part, mesh)| (parts[part], meshes.add(mesh)))
            .collect();
        let cuts = drawn.cuts.map(|mesh| meshes.add(mesh));
        let moves = (E::body(Motion::Dynamic), fragment, place);
        let new = world.spawn(moves).id();
        fragments.push(new);
        let mut commands = world.commands();
        E::copy_surface(&mut commands.entity(whole), new);
        if let Some(body) = body {
            E::copy_dynamics(&mut commands.entity(body), new);
        }
        let collider = E::collider(&shape, Vec3::ONE, &mut E::Cache::default());
        let weight = Weight { density: 1.0, mass: Some(mass) };
        let mut entity = commands.entity(new);
        E::attach(&mut entity, collider);
        E::set_mass(&mut entity, E::mass_by_volume(&shape, weight));
        E::set_velocity(&mut entity, velocity.at(place.translation));
        let look = |commands: &mut Commands, part: Entity, on: Entity| {
            let looks = looks.clone();
            commands.entity(part).clone_with_opt_in(on, move |builder| {
                builder.allow_by_ids(looks);
            });
        };
        let largest = surfaces.first().map(|(part, _)| *part);
        let mut drawn_on: EntityHashMap<Entity> = EntityHashMap::default();
        for (part, mesh) in surfaces {
            let on = match drawn_on.is_empty() {
                true => commands.entity(new).insert(Mesh3d(mesh)).id(),
                false => commands.spawn((Mesh3d(mesh), ChildOf(new))).id(),
            };
            look(&mut commands, part, on);
            drawn_on.insert(part, on);
        }
        // A part of which it draws nothing has the same place as the largest.
        let on = |part: &Entity| drawn_on.get(part).copied().unwrap_or(new);
        let entities: Vec<Entity> = known.entities().iter().map(on).collect();
        commands.entity(new).insert(known.of_others(&entities).unwrap_or(known));
        if let Some(mesh) = cuts {
            let on = commands.spawn((Mesh3d(mesh), ChildOf(new))).id();
            if let Some(part) = largest {
                look(&mut commands, part, on);
            }
            commands.entity(on).insert(CutFaces);
        }
    }
    let mut commands = world.commands();
    commands.trigger(BrokenApart { entity: whole, fragments });
    commands.entity(whole).try_despawn();
    world.flush();
}

/// What draws a mesh, apart from the mesh: components of Bevy's, by the beginnings of their paths,
/// since this crate builds no renderer.
const LOOKS: [&str; 5] = [
    "bevy_pbr::mesh_material::MeshMaterial3d<",
    "bevy_camera::visibility::Visibility",
    "bevy_camera::visibility::render_layers::RenderLayers",
    "bevy_light::NotShadow",
    "bevy_gltf::assets::GltfMaterialName",
];

/// The types of what draws a mesh, as far as the app has registered them.
fn looks(world: &World) -> Vec<TypeId> {
    let Some(registry) = world.get_resource::<AppTypeRegistry>() else { return Vec::new() };
    let registry = registry.read();
    let all = registry.iter().filter(|of| {
        let path = of.type_info().type_path();
        LOOKS.iter().any(|look| path.starts_with(look))
    });
    all.map(|of| of.type_id()).collect()
}
