//! Tags the nodes of scenes: which have meshes, what they and their meshes are called, what their
//! extras say, and which tag follows from that, by a default, by names, by the artist. Pieces of a
//! collider that an artist made, as Unreal's `UCX_chair_01` is one of `chair`, are tied to their
//! mesh.

use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::Allow;
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
#[cfg(feature = "bevy_gltf")]
use hullwright_formats::conventions::{Body, ExtrasTag};
use hullwright_formats::conventions::{
    ColliderKind, NameTag, mesh_tag, node_tag, whole_of, without_copy_number,
};

use super::complaints::Complaints;
#[cfg(feature = "bevy_gltf")]
use super::gltf_physics::{ColliderMesh, GltfPhysics, HullsInFile, MadeOfMeshes};
use super::hierarchy::{ConvexDecompositionHierarchy, HierarchyStatus, HierarchyWork};
use crate::collider::cells::SharesCells;
use crate::collider::placement::GivesSurface;
use crate::collider::resolve::Levels;
use crate::collider::work::MadeBefore;
use crate::engine::{Engine, Motion};
use crate::jobs::baked::{BakedDecomposition, BakedScene, FromBakedScene};
use crate::tag::outcomes::Descriptions;
use crate::tag::{ConvexDecomposition, DecompositionShape, NoConvexDecomposition};

/// Set on what a hierarchy tagged, so that another setting can take it back, also after it was
/// saved and loaded.
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
#[type_path = "hullwright"]
pub(super) struct TaggedByHierarchy;

/// Set on what a hierarchy hides, so that another setting can show it again.
#[cfg(feature = "bevy_gltf")]
#[derive(Component, Reflect, Debug, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
#[type_path = "hullwright"]
pub(super) struct HiddenByHierarchy;

/// Bevy spawns the primitives of a mesh below their node, without a transform of their own.
fn is_identity(transform: Option<&Transform>) -> bool {
    transform.is_none_or(|transform| *transform == Transform::IDENTITY)
}

/// On a piece of a collider that an artist made: the entity of the mesh that it belongs to. The
/// piece is below it, or is put there.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq)]
#[reflect(Component, Clone, PartialEq)]
#[type_path = "hullwright"]
#[relationship(relationship_target = ColliderPieces)]
pub struct ColliderPieceOf(#[entities] pub Entity);

/// On a mesh: the pieces that an artist made of its collider. They stand for hulls of its own.
#[derive(Component, Reflect, Debug, Default, Clone, PartialEq, Eq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[relationship_target(relationship = ColliderPieceOf)]
pub struct ColliderPieces(Vec<Entity>);

/// What is tied to what, and where it is: a piece moves with the body of its mesh.
#[derive(SystemParam)]
pub(super) struct Pieces<'w, 's> {
    tied: Query<'w, 's, &'static ColliderPieceOf>,
    parents: Query<'w, 's, &'static ChildOf>,
    global: TransformHelper<'w, 's>,
}

impl Pieces<'_, '_> {
    /// Ties a piece to its mesh, or frees it. A collider belongs to the body above it, so a piece
    /// that is elsewhere comes below its mesh, in the place where it is.
    fn tie(&self, commands: &mut Commands, piece: Entity, whole: Option<Entity>) {
        if self.tied.get(piece).ok().map(|tied| tied.0) == whole {
            return;
        }
        let mut commands = commands.entity(piece);
        let Some(whole) = whole else {
            commands.try_remove::<ColliderPieceOf>();
            return;
        };
        commands.try_insert(ColliderPieceOf(whole));
        if self.parents.iter_ancestors(piece).any(|above| above == whole) {
            return;
        }
        let local = self.place(piece).reparented_to(&self.place(whole));
        commands.try_insert((ChildOf(whole), local));
    }

    /// Where an entity is, also in the frame in which it is spawned.
    fn place(&self, entity: Entity) -> GlobalTransform {
        self.global.compute_global_transform(entity).unwrap_or_default()
    }
}

/// All of a scene that says what becomes of its meshes.
#[derive(SystemParam)]
pub(super) struct Nodes<'w, 's, E: Engine> {
    meshes: Query<'w, 's, (Entity, Option<&'static Transform>), SceneMeshes>,
    names: Query<'w, 's, &'static Name>,
    pub parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    hierarchies: Query<'w, 's, (), With<ConvexDecompositionHierarchy>>,
    exist: Query<'w, 's, (), Allow<Disabled>>,
    before: Query<'w, 's, MadeBefore<E>>,
    pub own_tags: Query<'w, 's, (), OwnTag>,
    /// What hierarchies said before: a tag, or hulls of the file, or neither for no collider.
    pub tagged: Query<'w, 's, TagOrHulls, With<TaggedByHierarchy>>,
    from_scenes: Query<'w, 's, &'static FromBakedScene>,
    shares: Query<'w, 's, &'static SharesCells>,
    levels: Levels<'w, 's>,
    pieces: Pieces<'w, 's>,
    #[cfg(feature = "bevy_gltf")]
    hidden: Query<'w, 's, (), With<HiddenByHierarchy>>,
    #[cfg(feature = "bevy_gltf")]
    extras: Query<'w, 's, Extras>,
    #[cfg(feature = "bevy_gltf")]
    declared: Query<'w, 's, DeclaredColliders>,
}

type TagOrHulls = (Option<&'static ConvexDecomposition>, Option<&'static BakedDecomposition>);

#[cfg(feature = "bevy_gltf")]
type SceneMeshes = (With<Mesh3d>, Without<ColliderMesh>);
#[cfg(not(feature = "bevy_gltf"))]
type SceneMeshes = With<Mesh3d>;

/// Tagged, but not by a hierarchy.
type OwnTag = (
    Or<(With<ConvexDecomposition>, With<BakedDecomposition>, With<NoConvexDecomposition>)>,
    Without<TaggedByHierarchy>,
);

#[cfg(feature = "bevy_gltf")]
type Extras = (
    Option<&'static bevy::gltf::GltfExtras>,
    Option<&'static bevy::gltf::GltfMeshExtras>,
    Option<&'static bevy::gltf::GltfMeshName>,
);

/// What the file has of colliders: the mesh's own, hulls, others.
#[cfg(feature = "bevy_gltf")]
type DeclaredColliders =
    (Option<&'static MadeOfMeshes>, Option<&'static HullsInFile>, Option<&'static GltfPhysics>);

impl<E: Engine> Nodes<'_, '_, E> {
    fn children_of(&self, node: Entity) -> impl Iterator<Item = Entity> {
        self.children.get(node).into_iter().flatten().copied()
    }

    fn meshes_right_below(&self, node: Entity) -> impl Iterator<Item = Entity> {
        self.children_of(node).filter(|child| self.meshes.contains(*child))
    }

    /// All of a scene. What is below another hierarchy is that one's.
    fn on_and_below(&self, root: Entity) -> Vec<Entity> {
        let (mut all, mut next) = (vec![root], 0);
        while let Some(entity) = all.get(next) {
            all.extend(self.children_of(*entity).filter(|it| !self.hierarchies.contains(*it)));
            next += 1;
        }
        all
    }

    /// The entities that stand for one mesh each: those with a `Mesh3d`, or the parents of
    /// primitives.
    pub(super) fn nodes_with_meshes(&self, root: Entity) -> Vec<Entity> {
        let mut seen = EntityHashSet::default();
        let is_root_node = self.is_gltf_node(root);
        let meshes =
            self.on_and_below(root).into_iter().filter_map(|entity| self.meshes.get(entity).ok());
        meshes
            .map(|(entity, transform)| match self.parents.get(entity) {
                Ok(parent)
                    if entity != root
                        && (parent.parent() != root || is_root_node)
                        && is_identity(transform) =>
                {
                    parent.parent()
                }
                _ => entity,
            })
            .chain(self.made_of_meshes(root))
            .filter(|node| seen.insert(*node))
            .collect()
    }

    /// Colliders that the file makes of meshes elsewhere.
    fn made_of_meshes(&self, root: Entity) -> Vec<Entity> {
        #[cfg(feature = "bevy_gltf")]
        return {
            let is_made = |entity: &Entity| {
                self.declared.get(*entity).is_ok_and(|(of_meshes, ..)| of_meshes.is_some())
            };
            self.on_and_below(root).into_iter().filter(is_made).collect()
        };
        #[cfg(not(feature = "bevy_gltf"))]
        return (root, Vec::new()).1;
    }

    /// The hulls of a node's mesh that its file has.
    #[cfg(feature = "bevy_gltf")]
    pub(super) fn hulls_in_file(&self, node: Entity) -> Option<&HullsInFile> {
        self.declared.get(node).ok()?.1
    }

    /// Whether a node has hulls that an artist edited.
    #[cfg(feature = "bevy_gltf")]
    pub(super) fn has_edited_hulls(&self, node: Entity) -> bool {
        self.tagged.get(node).is_ok_and(|(_, hulls)| hulls.is_some())
    }

    /// Where the hulls of a node may be found: in its own file, or in that of its scene.
    fn baked_of(
        &self,
        node: Entity,
        hierarchy: &ConvexDecompositionHierarchy,
    ) -> Option<Handle<BakedScene>> {
        #[cfg(feature = "bevy_gltf")]
        if let Some(hulls) = self.hulls_in_file(node) {
            return Some(hulls.scene.clone());
        }
        let _ = node;
        hierarchy.baked.clone()
    }

    /// The name of the glTF mesh that an entity is a primitive of.
    fn mesh_name(&self, entity: Entity) -> Option<&str> {
        #[cfg(feature = "bevy_gltf")]
        return self.extras.get(entity).ok()?.2.map(|name| name.0.as_str());
        #[cfg(not(feature = "bevy_gltf"))]
        return (entity, None).1;
    }

    /// Whether the meshes right below are the primitives of one glTF mesh, whose name they have
    /// then, and not meshes of their own.
    fn is_gltf_node(&self, entity: Entity) -> bool {
        let mut names = self.meshes_right_below(entity).map(|mesh| self.mesh_name(mesh));
        let Some(Some(first)) = names.next() else { return false };
        names.all(|name| name == Some(first))
    }

    /// The node's own name, and the one that its primitives have of their mesh.
    pub(super) fn names_of(&self, node: Entity) -> [Option<&str>; 2] {
        let own = self.names.get(node).ok().map(Name::as_str);
        let mut entities = std::iter::once(node).chain(self.children_of(node));
        [own, entities.find_map(|entity| self.mesh_name(entity))]
    }

    /// The extras of a node, of its mesh, and of its primitives.
    #[cfg(feature = "bevy_gltf")]
    pub(super) fn extras_of(&self, node: Entity) -> impl Iterator<Item = &str> {
        let with_extras = std::iter::once(node).chain(self.meshes_right_below(node));
        with_extras.filter_map(|entity| self.extras.get(entity).ok()).flat_map(
            |(of_node, of_mesh, _)| {
                let texts = [of_node.map(|of| &of.value), of_mesh.map(|of| &of.value)];
                texts.into_iter().flatten().map(String::as_str)
            },
        )
    }

    /// Whether a node or one above it is none of the game's.
    pub(super) fn is_left_out(&self, node: Entity, root: Entity) -> bool {
        std::iter::once(node)
            .chain(self.parents.iter_ancestors(node))
            .take_while(|entity| *entity != root)
            .filter_map(|entity| self.names.get(entity).ok())
            .any(|name| node_tag(name) == Some(NameTag::LeftOut))
    }

    /// Whether a node is a coarser level of detail, by itself or by all its primitives.
    fn is_coarser_level(&self, node: Entity) -> bool {
        let mut primitives = self.meshes_right_below(node).peekable();
        self.levels.is_coarser(node)
            || primitives.peek().is_some()
                && !self.meshes.contains(node)
                && primitives.all(|primitive| self.levels.is_drawn_far_only(primitive))
    }

    /// Hides the meshes of a node, or shows those that were hidden.
    #[cfg(feature = "bevy_gltf")]
    pub(super) fn show(&self, commands: &mut Commands, node: Entity, is_drawn: bool) {
        // What else is below the node stays as it is.
        let is_mesh = |entity: &Entity| self.meshes.contains(*entity);
        let primitives = self.children_of(node).filter(|child| {
            self.meshes.get(*child).is_ok_and(|(_, transform)| is_identity(transform))
        });
        for mesh in std::iter::once(node).filter(is_mesh).chain(primitives) {
            let is_hidden = self.hidden.contains(mesh);
            let mut mesh = commands.entity(mesh);
            if !is_drawn {
                mesh.try_insert((Visibility::Hidden, HiddenByHierarchy));
            } else if is_hidden {
                mesh.try_remove::<HiddenByHierarchy>().try_insert(Visibility::Inherited);
            }
        }
    }

    #[cfg(not(feature = "bevy_gltf"))]
    pub(super) fn show(&self, _commands: &mut Commands, _node: Entity, _is_drawn: bool) {}
}

/// What may have come below a hierarchy with all below it, or gone.
type Moved = (Or<(Changed<ChildOf>, Added<Disabled>)>, Allow<Disabled>);

/// Meshes that may be primitives now, or no longer.
type Turned = (Changed<Transform>, With<Mesh3d>, With<ChildOf>);

/// Colliders that a file has come to have.
#[cfg(feature = "bevy_gltf")]
type NewlyDeclared = Or<(Added<MadeOfMeshes>, Added<HullsInFile>)>;

/// To which hierarchy a mesh belongs, and whether it has no transform of its own.
pub(super) struct Owner {
    root: Entity,
    is_primitive: bool,
}

/// Hierarchies, and what is new about them.
#[derive(SystemParam)]
pub(super) struct Hierarchies<'w, 's> {
    all: Query<'w, 's, (&'static ConvexDecompositionHierarchy, &'static mut HierarchyWork)>,
    changed: Query<'w, 's, Entity, Changed<ConvexDecompositionHierarchy>>,
    gone: RemovedComponents<'w, 's, ConvexDecompositionHierarchy>,
    new_meshes: Query<'w, 's, Entity, Added<Mesh3d>>,
    meshes_gone: RemovedComponents<'w, 's, Mesh3d>,
    moved: Query<'w, 's, Entity, Moved>,
    turned: Query<'w, 's, (Entity, &'static Transform), Turned>,
    tags_gone: RemovedComponents<'w, 's, ConvexDecomposition>,
    baked_gone: RemovedComponents<'w, 's, BakedDecomposition>,
    exclusions_gone: RemovedComponents<'w, 's, NoConvexDecomposition>,
    #[cfg(feature = "bevy_gltf")]
    declared: Query<'w, 's, Entity, NewlyDeclared>,
    parents_gone: RemovedComponents<'w, 's, ChildOf>,
    disabled_gone: RemovedComponents<'w, 's, Disabled>,
    children: Query<'w, 's, &'static Children, Allow<Disabled>>,
}

impl Hierarchies<'_, '_> {
    /// Those that are new or changed, and those to which meshes came or from which they went;
    /// whether more came than went.
    fn take_news<E: Engine>(
        &mut self,
        nodes: &Nodes<E>,
        owners: &mut EntityHashMap<Owner>,
    ) -> EntityHashMap<bool> {
        let nearest = |entity: Entity| {
            let above = std::iter::once(entity).chain(nodes.parents.iter_ancestors(entity));
            above.into_iter().find(|entity| nodes.hierarchies.contains(*entity))
        };
        let mut roots = EntityHashMap::default();
        for root in self.changed.iter().chain(self.gone.read()) {
            // What is below it belonged to the one above, or will.
            let outer = nodes.parents.get(root).ok().and_then(|of| nearest(of.parent()));
            roots.extend([Some(root), outer].into_iter().flatten().map(|root| (root, true)));
        }
        let moved = self.moved.iter().chain(self.parents_gone.read());
        let moved = moved.chain(self.disabled_gone.read());
        let moved = moved.flat_map(|entity| {
            std::iter::once(entity).chain(self.children.iter_descendants(entity))
        });
        let moved: Vec<Entity> = moved.collect();
        // What has lost its mesh elsewhere is untagged here.
        for node in moved.iter().filter(|node| nodes.tagged.contains(**node)) {
            roots.extend(nearest(*node).map(|root| (root, false)));
        }
        // What has lost its own tag is the scene's to tag.
        let untagged = self.tags_gone.read().chain(self.baked_gone.read());
        for node in untagged.chain(self.exclusions_gone.read()) {
            if !nodes.tagged.contains(node)
                && !nodes.own_tags.contains(node)
                && let Some(root) = nearest(node)
            {
                roots.entry(root).or_insert(false);
            }
        }
        for (mesh, transform) in &self.turned {
            if let Some(Owner { root, is_primitive }) = owners.get(&mesh)
                && *is_primitive != is_identity(Some(transform))
            {
                roots.insert(*root, true);
            }
        }
        let meshes = self.new_meshes.iter().chain(self.meshes_gone.read()).chain(moved);
        for mesh in meshes {
            let now = nodes.meshes.contains(mesh).then(|| nearest(mesh)).flatten();
            let before = match now {
                Some(_) => owners.get(&mesh).map(|owner| owner.root),
                None => owners.remove(&mesh).map(|owner| owner.root),
            };
            if let Some(root) = now {
                roots.insert(root, true);
            }
            if let Some(root) = before.filter(|root| Some(*root) != now) {
                roots.entry(root).or_insert(false);
            }
        }
        #[cfg(feature = "bevy_gltf")]
        roots.extend(self.declared.iter().filter_map(nearest).map(|root| (root, true)));
        roots
    }
}

/// Tags what is new below a hierarchy, and all below one that is new or changed.
pub(super) fn tag_hierarchies<E: Engine>(
    mut commands: Commands,
    mut hierarchies: Hierarchies,
    nodes: Nodes<E>,
    descriptions: Descriptions,
    mut complaints: Local<Complaints>,
    mut owners: Local<EntityHashMap<Owner>>,
) {
    if hierarchies.all.is_empty() && owners.is_empty() {
        return;
    }
    for (root, has_news) in hierarchies.take_news(&nodes, &mut owners) {
        if let Ok((hierarchy, mut work)) = hierarchies.all.get_mut(root) {
            let below = nodes.on_and_below(root).into_iter();
            owners.extend(below.filter_map(|mesh| {
                let is_primitive = is_identity(nodes.meshes.get(mesh).ok()?.1);
                Some((mesh, Owner { root, is_primitive }))
            }));
            let all = nodes.nodes_with_meshes(root);
            let wholes = match hierarchy.follows_artists {
                true => Wholes::of_pieces(&nodes, &all),
                false => Wholes::default(),
            };
            let rules = Rules { nodes: &nodes, root, hierarchy, wholes };
            rules.untag(&mut commands, &all);
            rules.tag(&mut commands, all, &mut work, has_news, &mut complaints);
        }
    }
    complaints.log(&descriptions);
}

/// Nothing waits for a hierarchy that is removed before it has ended. What it has tagged stays
/// tagged.
pub(super) fn on_hierarchy_gone(
    removed: On<Remove<ConvexDecompositionHierarchy>>,
    mut commands: Commands,
    statuses: Query<&HierarchyStatus, Allow<Disabled>>,
) {
    let mut commands = commands.entity(removed.entity);
    commands.try_remove::<(HierarchyWork, GivesSurface)>();
    if !statuses.get(removed.entity).is_ok_and(HierarchyStatus::is_finished) {
        commands.try_remove::<HierarchyStatus>();
    }
}

/// What becomes of each node of a scene.
struct Rules<'a, 'w, 's, E: Engine> {
    nodes: &'a Nodes<'w, 's, E>,
    root: Entity,
    hierarchy: &'a ConvexDecompositionHierarchy,
    wholes: Wholes,
}

/// Pieces made by the artist, and the meshes whose colliders they are.
#[derive(Default)]
struct Wholes {
    by_piece: EntityHashMap<Entity>,
    with_pieces: EntityHashSet,
}

impl Wholes {
    fn of_pieces<E: Engine>(nodes: &Nodes<E>, all: &[Entity]) -> Self {
        let names = || {
            let of_node = |node: &Entity| nodes.names_of(*node).map(|name| (*node, name));
            all.iter().flat_map(of_node).filter_map(|(node, name)| Some((node, name?)))
        };
        let mut by_name: HashMap<&str, Vec<(Entity, &str)>> = HashMap::default();
        for (node, name) in names() {
            by_name.entry(without_copy_number(name)).or_default().push((node, name));
        }
        let mut wholes = Self::default();
        for (piece, name) in names() {
            let Some(NameTag::PieceOf { rest, .. }) = node_tag(name) else { continue };
            let rest = whole_of(rest, |name| by_name.contains_key(name));
            let candidates = by_name.get(rest).into_iter().flatten();
            let candidates = candidates.filter(|(whole, _)| *whole != piece);
            // Of several with the name that above it, then the copy that it was copied with, then
            // one beside it.
            let (is_above, parent) = (
                |whole| nodes.parents.iter_ancestors(piece).any(|above| above == whole),
                |node| nodes.parents.get(node).ok().map(ChildOf::parent),
            );
            let copy = |name: &str| name.get(without_copy_number(name).len()..).map(str::to_owned);
            let whole = candidates.min_by_key(|(whole, of)| {
                (!is_above(*whole), copy(of) != copy(name), parent(*whole) != parent(piece))
            });
            if let Some((whole, _)) = whole {
                wholes.by_piece.insert(piece, *whole);
                wholes.with_pieces.insert(*whole);
            }
        }
        wholes
    }
}

impl<E: Engine> Rules<'_, '_, '_, E> {
    /// The first rule that matches a node.
    fn treatment(&self, node: Entity, complaints: &mut Complaints) -> Treatment {
        let by_name = &self.hierarchy.by_name;
        let mut names = self.nodes.names_of(node).into_iter().flatten();
        if let Some(tag) = names.find_map(|name| by_name.get(name)) {
            return tag.clone().into();
        }
        let follows_artists = self.hierarchy.follows_artists;
        let by_artist = follows_artists.then(|| self.by_artist(node, complaints)).flatten();
        by_artist.unwrap_or_else(|| match self.nodes.is_coarser_level(node) {
            true => None.into(),
            false => self.hierarchy.default_tag.clone().into(),
        })
    }

    /// The tag on which names and extras build.
    fn base(&self) -> ConvexDecomposition {
        self.hierarchy.default_tag.clone().unwrap_or_default()
    }

    /// By extras and names; `None` where they say nothing.
    fn by_artist(&self, node: Entity, complaints: &mut Complaints) -> Option<Treatment> {
        if self.nodes.is_left_out(node, self.root) {
            return Some(treatment(NameTag::LeftOut, self.base()));
        }
        let [own, of_mesh] = self.nodes.names_of(node);
        let by_name = || own.and_then(node_tag).or_else(|| of_mesh.and_then(mesh_tag));
        let by_name = || Some(treatment(by_name()?, self.base()));
        let piece_of = self.wholes.by_piece.get(&node).copied();
        let mut result = self.by_extras(node, complaints).or_else(by_name);
        #[cfg(feature = "bevy_gltf")]
        {
            result = self.by_file(node, result);
        }
        if let Some(result) = &mut result {
            result.piece_of = piece_of;
            result.is_drawn &= piece_of.is_none();
        }
        if self.wholes.with_pieces.contains(&node) {
            // Its pieces are its collider, whatever else is said of it.
            let body = result.and_then(|result| result.body);
            return Some(Treatment { body, ..None.into() });
        }
        result
    }

    /// By hulls that the file has of a mesh, or else, if nothing is said of the node, by what its
    /// physics extension says. A mesh of which that says nothing has no collider. Unedited
    /// hulls are what a decomposition would give, and stand for it where there would be one.
    #[cfg(feature = "bevy_gltf")]
    fn by_file(&self, node: Entity, said: Option<Treatment>) -> Option<Treatment> {
        let (made_of, hulls, physics) = self.nodes.declared.get(node).ok()?;
        if let Some(hulls) = hulls {
            let treatment = said.unwrap_or_else(|| Some(self.base()).into());
            return Some(if hulls.is_edited { treatment.with_hulls(hulls) } else { treatment });
        }
        said.or_else(|| match (made_of, physics) {
            (Some(MadeOfMeshes { is_convex: true }), _) => {
                Some(Some(made_of_kind(ColliderKind::ConvexHull, self.base())).into())
            }
            (Some(_), _) => Some(Some(self.base()).into()),
            (None, Some(_)) => Some(None.into()),
            (None, None) => None,
        })
    }

    /// By the extras of a node or of its mesh.
    fn by_extras(&self, node: Entity, complaints: &mut Complaints) -> Option<Treatment> {
        #[cfg(feature = "bevy_gltf")]
        return self.nodes.extras_of(node).find_map(|text| {
            let (tag, wrong) = hullwright_formats::conventions::read_extras(text);
            for text in wrong {
                complaints.add(text, node);
            }
            Some(with_extras(&tag?, self.base()))
        });
        #[cfg(not(feature = "bevy_gltf"))]
        return (node, complaints, None).2;
    }

    /// Takes back what was said of nodes that stand for no mesh any more. What is put elsewhere
    /// keeps it.
    fn untag(&self, commands: &mut Commands, all: &[Entity]) {
        let nodes = self.nodes;
        let all: EntityHashSet = all.iter().copied().collect();
        let below = nodes.on_and_below(self.root).into_iter().filter(|node| !all.contains(node));
        for node in
            below.filter(|node| nodes.tagged.get(*node).is_ok_and(|tagged| tagged != (None, None)))
        {
            let mut commands = commands.entity(node);
            if let Ok(before) = nodes.before.get(node) {
                before.detach(&mut commands);
            }
            commands.try_remove::<(ConvexDecomposition, BakedDecomposition, FromBakedScene)>();
            commands.try_remove::<(TaggedByHierarchy, SharesCells)>();
        }
    }

    /// Tags all nodes with meshes.
    fn tag(
        &self,
        commands: &mut Commands,
        all: Vec<Entity>,
        work: &mut HierarchyWork,
        mut has_news: bool,
        complaints: &mut Complaints,
    ) {
        let Self { nodes, hierarchy, .. } = self;
        let has_meshes = !all.is_empty();
        let (mut tagged, mut left_out) = (Vec::new(), 0);
        for node in all {
            if nodes.own_tags.contains(node) {
                continue;
            }
            let Treatment { tag, hulls, is_drawn, body, piece_of } =
                self.treatment(node, complaints);
            nodes.show(commands, node, is_drawn);
            nodes.pieces.tie(commands, node, piece_of);
            let mut commands = commands.entity(node);
            if let Some(body) = body {
                commands.try_insert_if_new(E::body(body));
                // The engine takes a new body's place from it, maybe before Bevy has computed it in
                // this frame.
                commands.try_insert(nodes.pieces.place(node));
            }
            let baked = nodes.baked_of(node, hierarchy).filter(|_| tag.is_some());
            let baked = baked.map(FromBakedScene);
            // What is set anew starts anew.
            if baked.as_ref() != nodes.from_scenes.get(node).ok() {
                match baked {
                    Some(baked) => commands.try_insert(baked),
                    None => commands.try_remove::<FromBakedScene>(),
                };
            }
            let size = hierarchy.cell_size.filter(|size| *size > 0.0 && tag.is_some());
            let shares = size.map(|size| SharesCells { root: self.root, size });
            if shares.as_ref() != nodes.shares.get(node).ok() {
                match shares {
                    Some(shares) => commands.try_insert(shares),
                    None => commands.try_remove::<SharesCells>(),
                };
            }
            has_news |= !nodes.tagged.contains(node);
            let before = nodes.tagged.get(node);
            let is_as_before = before == Ok((tag.as_ref(), hulls.as_ref()));
            match tag.is_some() || hulls.is_some() {
                true => tagged.push(node),
                false => left_out += 1,
            }
            match (tag, hulls) {
                _ if is_as_before => {}
                (_, Some(hulls)) => {
                    commands.try_remove::<(ConvexDecomposition, NoConvexDecomposition)>();
                    commands.try_insert((hulls, TaggedByHierarchy));
                }
                (Some(tag), None) => {
                    commands.try_remove::<(BakedDecomposition, NoConvexDecomposition)>();
                    commands.try_insert((tag, TaggedByHierarchy));
                }
                (None, None) => {
                    commands.try_remove::<(BakedDecomposition, ConvexDecomposition)>();
                    // Else it would be part of the input of a node above it.
                    commands.try_insert((NoConvexDecomposition, TaggedByHierarchy));
                }
            }
        }
        if work.is_open {
            // Those that are gone before they have ended are in the report.
            tagged.extend(work.nodes.iter().filter(|node| !nodes.exist.contains(**node)));
        }
        match has_news || work.is_open {
            true => work.begin(tagged, left_out, has_meshes),
            false => (work.nodes, work.left_out) = (tagged, left_out),
        }
    }
}

/// What becomes of a node with a mesh.
#[derive(Debug, Clone, PartialEq)]
struct Treatment {
    /// `None` for no collider.
    tag: Option<ConvexDecomposition>,
    /// Hulls that an artist edited, which stand for those of the tag.
    hulls: Option<BakedDecomposition>,
    is_drawn: bool,
    /// The body that it becomes, if it is none.
    body: Option<Motion>,
    /// The mesh of whose collider it is a piece.
    piece_of: Option<Entity>,
}

impl From<Option<ConvexDecomposition>> for Treatment {
    fn from(tag: Option<ConvexDecomposition>) -> Self {
        Self { tag, hulls: None, is_drawn: true, body: None, piece_of: None }
    }
}

#[cfg(feature = "bevy_gltf")]
impl Treatment {
    /// The same with hulls of the file, where the tag would make hulls.
    fn with_hulls(mut self, hulls: &HullsInFile) -> Self {
        use DecompositionShape::{Auto, ConvexHull, Hulls};
        if let Some(tag) = self.tag.take_if(|tag| matches!(tag.shape, Auto | Hulls | ConvexHull)) {
            let (density, mass, children) = (tag.density, tag.mass, tag.children);
            let scene = hulls.scene.clone();
            self.hulls = Some(BakedDecomposition { scene, mesh: None, density, mass, children });
        }
        self
    }
}

/// What becomes of a node with such a name; `base` is the tag that the scene has for such nodes.
fn treatment(name_tag: NameTag, base: ConvexDecomposition) -> Treatment {
    let (tag, is_drawn, body) = match name_tag {
        NameTag::Collider(kind) => (made_of_kind(kind, base), true, None),
        NameTag::ColliderOnly(kind) => (made_of_kind(kind, base), false, None),
        NameTag::Body(kind) => (made_of_kind(kind, base), true, Some(Motion::Dynamic)),
        // The mass of the whole is not that of a piece.
        NameTag::PieceOf { kind, .. } => (made_of_kind(kind, base.with_mass(None)), false, None),
        NameTag::LeftOut => return Treatment { is_drawn: false, ..None.into() },
    };
    Treatment { is_drawn, body, ..Some(tag).into() }
}

fn made_of_kind(kind: ColliderKind, base: ConvexDecomposition) -> ConvexDecomposition {
    match kind {
        // As the scene says for what moves and what does not.
        ColliderKind::Decomposition => base,
        ColliderKind::Hulls => base.with_shape(DecompositionShape::Hulls),
        ColliderKind::Triangles => base.with_shape(DecompositionShape::Triangles),
        ColliderKind::ConvexHull => base.with_shape(DecompositionShape::ConvexHull),
        ColliderKind::Cuboid => base.with_shape(DecompositionShape::Cuboid),
        ColliderKind::Ball => base.with_shape(DecompositionShape::Ball),
        ColliderKind::Capsule => base.with_shape(DecompositionShape::Capsule),
    }
}

/// What becomes of a node with such extras; `base` is the tag that the scene has. No collider where
/// they exclude one.
#[cfg(feature = "bevy_gltf")]
fn with_extras(extras: &ExtrasTag, base: ConvexDecomposition) -> Treatment {
    let body = extras.body.map(|body| match body {
        Body::Dynamic => Motion::Dynamic,
        Body::Fixed => Motion::Fixed,
        Body::Kinematic => Motion::Kinematic,
    });
    let tag = extras.kind.map(|kind| {
        let tag = made_of_kind(kind, base);
        ConvexDecomposition {
            max_error: extras.max_error.map_or(tag.max_error, Into::into),
            preset: extras.preset.map_or(tag.preset, Into::into),
            openings: extras.openings.map_or(tag.openings, Into::into),
            probe_radius: extras.probe_radius.or(tag.probe_radius),
            level_bound: extras.level_bound.or(tag.level_bound),
            max_hulls: extras.max_hulls.or(tag.max_hulls),
            max_vertices: extras.max_vertices.or(tag.max_vertices),
            keep_cavities: extras.keep_cavities.unwrap_or(tag.keep_cavities),
            density: extras.density.unwrap_or(tag.density),
            // One stands for the other.
            mass: extras.density.map_or(extras.mass.or(tag.mass), |_| extras.mass),
            fallback_collider: extras.fallback.map(Into::into).or(tag.fallback_collider),
            ..tag
        }
    });
    Treatment { body, ..tag.into() }
}
