//! What a glTF file says of bodies, colliders and their surfaces, put on its nodes: extras such as
//! `{"friction": 0.2}`, and the physics extensions.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::gltf::{GltfExtras, GltfMeshExtras, GltfSceneExtras};
use bevy::prelude::*;
use hullwright_formats::conventions::{
    Body, BodyMotion, DeclaredCollider, Geometry, NodePhysics, SurfaceProperties, read_extras,
    read_surface,
};

use super::collision_systems::CollisionSystems;
use super::complaints::Complaints;
use super::gltf_physics::{ColliderMesh, DeclaredMeshes, GltfPhysics, MadeOfMeshes};
use super::hierarchy::ConvexDecompositionHierarchy;
use super::shapes;
use super::written_hulls::WrittenHulls;
use crate::collider::placement::{GivesSurface, Placements, inherit_surface};
use crate::engine::{Engine, Motion, Velocity};
use crate::tag::outcomes::{DecompositionStatus, Descriptions};

/// Set on an entity once what its file says is on it, so that what a game changes then stays.
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
#[type_path = "hullwright"]
pub(super) struct Declared;

/// On a collider whose shape the file has by its measures.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct DeclaredShape;

/// On a body whose mass is to be set once its colliders are weighed.
#[derive(Component, Debug, Clone)]
pub(super) struct MassToSet(BodyMotion);

/// What a file may say of an entity.
#[derive(QueryData)]
pub(super) struct Said {
    extras: Option<&'static GltfExtras>,
    of_mesh: Option<&'static GltfMeshExtras>,
    of_scene: Option<&'static GltfSceneExtras>,
    physics: Option<&'static GltfPhysics>,
}

type New =
    Or<(Added<GltfExtras>, Added<GltfMeshExtras>, Added<GltfSceneExtras>, Added<GltfPhysics>)>;

/// What files say, and where.
#[derive(SystemParam)]
pub(super) struct Saying<'w, 's> {
    new: Query<'w, 's, Entity, New>,
    changed: Query<'w, 's, Entity, Changed<ConvexDecompositionHierarchy>>,
    hierarchies: Query<'w, 's, &'static ConvexDecompositionHierarchy>,
    said: Query<'w, 's, Said, Without<Declared>>,
    meshes: Query<'w, 's, &'static Mesh3d>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
}

impl Saying<'_, '_> {
    /// Entities of which something may be said that is not done yet, below a hierarchy that follows
    /// artists.
    fn open(&self) -> Vec<Entity> {
        let below = self.changed.iter().flat_map(|root| self.children.iter_descendants(root));
        let mut open: Vec<Entity> = below.chain(&self.new).filter_map(|of| self.node(of)).collect();
        open.sort_unstable();
        open.dedup();
        open.retain(|entity| self.said.contains(*entity) && self.is_followed(*entity));
        open
    }

    /// What is said of a primitive holds for its node.
    fn node(&self, entity: Entity) -> Option<Entity> {
        match self.meshes.contains(entity) {
            true => self.parents.get(entity).ok().map(ChildOf::parent),
            false => Some(entity),
        }
    }

    /// The nearest hierarchy above.
    fn root(&self, entity: Entity) -> Option<Entity> {
        self.parents.iter_ancestors(entity).find(|above| self.hierarchies.contains(*above))
    }

    fn is_followed(&self, entity: Entity) -> bool {
        let hierarchy = self.root(entity).and_then(|root| self.hierarchies.get(root).ok());
        hierarchy.is_some_and(|hierarchy| hierarchy.follows_artists)
    }

    /// Whether the file says that a node above moves.
    fn has_motion_above(&self, node: Entity) -> bool {
        let physics = |above| self.said.get(above).ok()?.physics;
        self.parents.iter_ancestors(node).filter_map(physics).any(|of| of.read().motion.is_some())
    }

    /// The meshes of a node.
    fn primitives(&self, node: Entity) -> Vec<(Handle<Mesh>, Transform)> {
        let children = self.children.get(node).into_iter().flatten();
        let meshes = children.filter_map(|child| self.meshes.get(*child).ok());
        meshes.map(|mesh| (mesh.0.clone(), Transform::IDENTITY)).collect()
    }

    /// The extras of a scene or a node, of its mesh, and of its primitives, the nearest first.
    fn extras(&self, entity: Entity) -> Vec<&str> {
        let primitives = self.children.get(entity).into_iter().flatten().copied();
        let all =
            std::iter::once(entity).chain(primitives.filter(|child| self.meshes.contains(*child)));
        let all = all.filter_map(|entity| self.said.get(entity).ok());
        all.flat_map(|said| {
            let extras = said.extras.map(|of| of.value.as_str());
            let of_scene = said.of_scene.map(|of| of.value.as_str());
            [extras, of_scene, said.of_mesh.map(|of| of.value.as_str())].into_iter().flatten()
        })
        .collect()
    }
}

/// Puts on entities what their file says, once.
pub(super) fn declare<E: Engine>(
    mut commands: Commands,
    saying: Saying,
    placements: Placements<E>,
    mut groups_of_hulls: WrittenHulls,
    mut systems: ResMut<CollisionSystems>,
    mut complaints: Local<Complaints>,
    descriptions: Descriptions,
) {
    let open = saying.open();
    if open.is_empty() {
        return;
    }
    let groups = groups_of_hulls.take(&mut commands, &open, &mut complaints);
    for node in open {
        commands.entity(node).try_insert(Declared);
        let texts = saying.extras(node);
        let mut surface = SurfaceProperties::default();
        for text in &texts {
            let (of_text, wrong) = read_surface(text);
            surface = surface.or(of_text);
            wrong.into_iter().for_each(|text| complaints.add(text, node));
        }
        if surface != SurfaceProperties::default() {
            let mut node = commands.entity(node);
            E::insert_surface(&mut node, &surface);
            node.try_insert(GivesSurface);
        }
        let is_of_group = saying.parents.get(node).is_ok_and(|of| groups.contains(&of.parent()));
        let physics = saying.said.get(node).ok().and_then(|said| said.physics);
        let Some(physics) = physics.filter(|_| !is_of_group) else { continue };
        let NodePhysics { motion, collider, trigger, .. } = physics.read();
        let place = placements.global_transform(node);
        let has_body = || saying.has_motion_above(node) || placements.body(node).is_some();
        if let Some(motion) = motion {
            insert_body::<E>(&mut commands.entity(node), motion, place);
        } else if E::WITHOUT_BODY.is_some()
            && (collider.is_some() || trigger.is_some())
            && !has_body()
            && let Some(root) = saying.root(node)
        {
            // Not on the node, which would inherit nothing then.
            let place = placements.global_transform(root);
            commands.entity(root).try_insert_if_new(E::body(Motion::Fixed)).try_insert(place);
        }
        // A node has one collider, and the one that extras request comes first.
        let mut is_taken = texts.iter().any(|text| read_extras(text).0.is_some());
        let solid = collider.filter(|_| !is_taken).map(|collider| (collider, &physics.collider));
        let sensor = trigger.map(|mut trigger| {
            trigger.surface.sensor = Some(true);
            (trigger, &physics.trigger)
        });
        for (declared, meshes) in solid.into_iter().chain(sensor) {
            let surface = surface_of(&declared, &mut systems, |text| complaints.add(text, node));
            let scale = place.scale();
            let put = Put { node, is_taken, scale, surface };
            let made = put.collider::<E>(&mut commands, &saying, &declared.geometry, meshes);
            made.unwrap_or_else(|text| complaints.add(text, node));
            is_taken = true;
        }
    }
    complaints.log(&descriptions);
}

/// A material, and the groups that a filter stands for.
fn surface_of(
    declared: &DeclaredCollider,
    systems: &mut CollisionSystems,
    mut complain: impl FnMut(String),
) -> SurfaceProperties {
    let mut surface = declared.surface;
    if let Some(filter) = &declared.filter {
        let (groups, without) = systems.groups(filter);
        if !without.is_empty() {
            complain(format!(
                "there are more than 31 collision systems: {} get no group",
                without.join(", ")
            ));
        }
        surface.collision_groups = Some(groups);
    }
    surface
}

/// A collider to be put on a node, or below it where the node has one.
struct Put {
    node: Entity,
    is_taken: bool,
    scale: Vec3,
    surface: SurfaceProperties,
}

impl Put {
    /// What is wrong if there can't be one.
    fn collider<E: Engine>(
        self,
        commands: &mut Commands,
        saying: &Saying,
        geometry: &Geometry,
        meshes: &DeclaredMeshes,
    ) -> Result<(), String> {
        let is_convex = match geometry {
            Geometry::Shape(implicit) => {
                // By the specification one of no size is switched off.
                if self.scale == Vec3::ZERO {
                    return Ok(());
                }
                let shape = shapes::shape(implicit).map_err(|error| error.to_string())?;
                let on = if self.is_taken { self.child(commands) } else { self.node };
                let mut on = commands.entity(on);
                E::insert_surface(&mut on, &self.surface);
                E::attach_declared(&mut on, shape, self.scale);
                on.try_insert(DeclaredShape);
                return Ok(());
            }
            Geometry::Node { is_convex, .. } | Geometry::Mesh { is_convex, .. } => *is_convex,
        };
        let placed = match meshes {
            DeclaredMeshes::None => return Ok(()),
            DeclaredMeshes::Own if !self.is_taken => {
                let mut on = commands.entity(self.node);
                E::insert_surface(&mut on, &self.surface);
                on.try_insert(MadeOfMeshes { is_convex });
                return Ok(());
            }
            DeclaredMeshes::Own => saying.primitives(self.node),
            DeclaredMeshes::Placed(placed) => placed.clone(),
        };
        if placed.is_empty() {
            return Err("a collider has no mesh".into());
        }
        let on = self.child(commands);
        for (mesh, place) in placed {
            commands.spawn((Mesh3d(mesh), place, Visibility::Hidden, ColliderMesh, ChildOf(on)));
        }
        let mut on = commands.entity(on);
        E::insert_surface(&mut on, &self.surface);
        on.try_insert(MadeOfMeshes { is_convex });
        Ok(())
    }

    fn child(&self, commands: &mut Commands) -> Entity {
        let child = (Name::new("Collider"), Transform::IDENTITY, Visibility::Inherited);
        commands.spawn((child, Declared, ChildOf(self.node))).id()
    }
}

/// Gives colliders by their measures what they inherit, as those that the plugin makes.
pub(super) fn inherit_surfaces<E: Engine>(
    mut commands: Commands,
    new: Query<Entity, Added<DeclaredShape>>,
    placements: Placements<E>,
    surfaces: Query<E::Surface>,
) {
    for collider in &new {
        let mut commands = commands.entity(collider);
        inherit_surface::<E>(collider, &placements, &surfaces, &mut commands);
    }
}

/// Makes an entity the body that a file says, unless it is one.
fn insert_body<E: Engine>(entity: &mut EntityCommands, motion: BodyMotion, place: GlobalTransform) {
    let [linear, angular] = [motion.linear_velocity, motion.angular_velocity]
        .map(|of| place.rotation() * Vec3::from(of));
    let is_at_rest = linear == Vec3::ZERO && angular == Vec3::ZERO;
    entity.try_insert_if_new(match motion.body {
        Body::Dynamic => E::body(Motion::Dynamic),
        Body::Fixed => E::body(Motion::Fixed),
        Body::Kinematic if is_at_rest => E::body(Motion::Kinematic),
        Body::Kinematic => E::body_of_constant_velocity(),
    });
    // The engine takes a new body's place from it, maybe before Bevy has computed it.
    entity.try_insert(place);
    if !is_at_rest {
        E::set_velocity(entity, Velocity { linear, angular, centre: Vec3::ZERO });
    }
    if motion.gravity_factor != 1.0 {
        E::insert_gravity(entity, motion.gravity_factor);
    }
    let has_mass = motion.mass.is_some() || motion.centre.is_some() || motion.inertia.is_some();
    if motion.body == Body::Dynamic && has_mass {
        entity.try_insert(MassToSet(motion));
    }
}

/// Sets the masses of bodies whose colliders are all there, and were weighed by the engine.
pub(super) fn set_masses<E: Engine>(
    mut commands: Commands,
    open: Query<(Entity, &MassToSet)>,
    colliders: Query<(), With<E::Collider>>,
    bodies: Query<(), With<E::Body>>,
    statuses: Query<&DecompositionStatus>,
    children: Query<&Children>,
) {
    for (body, mass) in &open {
        let (mut all, mut next) = (vec![body], 0);
        while let Some(entity) = all.get(next) {
            let below = children.get(*entity).into_iter().flatten().copied();
            all.extend(below.filter(|child| !bodies.contains(*child)));
            next += 1;
        }
        let is_open =
            |entity: &Entity| statuses.get(*entity).is_ok_and(|status| !status.is_finished());
        if all.iter().any(is_open) {
            continue;
        }
        all.retain(|entity| colliders.contains(*entity));
        let MassToSet(motion) = mass.clone();
        commands.entity(body).queue_silenced(move |mut body: EntityWorldMut| {
            if E::set_declared_mass(&mut body, &motion, &all) {
                body.remove::<MassToSet>();
            }
        });
    }
}
