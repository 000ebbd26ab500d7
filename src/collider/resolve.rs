//! From a tag to a request: which meshes, which scale, which kind of collider, and whether there is
//! anything to do at all. What is hidden, too small to matter, or too far from every focus is
//! skipped on request.

use std::sync::Arc;

use bevy::asset::{LoadState, UntypedAssetId};
use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::math::{Affine3A, Vec3A};
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use hullwright_formats::conventions::{is_coarser_level, level_cell};
use hullwright_parry::ColliderError;

use super::cells::{CellKey, CellPlace, InLevelCell, LevelCell, OfCell, OutOfCells, SharesCells};
use super::members::Cells;
use super::placement::{Placement, Placements};
use super::waiting::Fallbacks;
use super::work::{
    FailedRequest, FarFromFocus, InputBoundary, MadeBefore, Presence, Requested, TooSmallAt, Work,
};
use crate::engine::{Engine, Weight};
use crate::jobs::baked::{BakedDecomposition, BakedScene, FromBakedScene};
use crate::jobs::label::is_for_gpu_only;
use crate::jobs::request::{ColliderRequest, InputId, MapKey, MeshPart};
use crate::jobs::{Frame, Jobs};
use crate::tag::outcomes::{
    DecompositionError, DecompositionStatus, Descriptions, Outcomes, SkipReason, WaitReason,
    entities,
};
use crate::tag::parameters::Goal;
use crate::tag::settings::{FallbackCollider, HullwrightSettings};
use crate::tag::{ConvexDecomposition, DEFAULT_DENSITY, DecompositionFocus};

/// Which meshes are coarser levels of detail: of those that stand for one thing the finest makes
/// the collider.
#[derive(SystemParam)]
pub(crate) struct Levels<'w, 's> {
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    children: Query<'w, 's, &'static Children>,
    #[cfg(feature = "bevy_gltf")]
    ranges: Query<'w, 's, &'static bevy::camera::visibility::VisibilityRange>,
}

impl Levels<'_, '_> {
    /// Whether an entity is a coarser level, by its name and those beside it, or is not drawn near
    /// the camera.
    pub(crate) fn is_coarser(&self, entity: Entity) -> bool {
        self.is_drawn_far_only(entity) || self.has_finer_sibling(entity)
    }

    /// Without a renderer nothing is.
    pub(crate) fn is_drawn_far_only(&self, entity: Entity) -> bool {
        #[cfg(feature = "bevy_gltf")]
        return self.ranges.get(entity).is_ok_and(|range| range.start_margin.end > 0.0);
        #[cfg(not(feature = "bevy_gltf"))]
        return (entity, false).1;
    }

    fn has_finer_sibling(&self, entity: Entity) -> bool {
        let Ok(name) = self.names.get(entity) else { return false };
        let siblings = self.parents.get(entity).and_then(|of| self.children.get(of.parent()));
        let siblings = siblings.into_iter().flatten();
        is_coarser_level(
            name,
            siblings.filter_map(|other| self.names.get(*other).ok()).map(Name::as_str),
        )
    }
}

/// Everything from which requests follow.
#[derive(SystemParam)]
pub(super) struct Scene<'w, 's, E: Engine> {
    tags: Query<'w, 's, Tag<E>>,
    disabled: Query<'w, 's, (), With<Disabled>>,
    boundaries: Query<'w, 's, (), InputBoundary<E>>,
    meshes_on: Query<'w, 's, &'static Mesh3d>,
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    transforms: Query<'w, 's, &'static Transform>,
    levels: Levels<'w, 's>,
    #[cfg(feature = "bevy_gltf")]
    visibilities: Query<'w, 's, &'static Visibility>,
    sharing: Query<'w, 's, &'static SharesCells, Without<OutOfCells>>,
    in_cells: Query<'w, 's, &'static InLevelCell>,
    surfaces: Query<'w, 's, <E as Engine>::Surface>,
    placements: Placements<'w, 's, E>,
    distances: Distances<'w, 's>,
    descriptions: Descriptions<'w, 's>,
    meshes: Res<'w, Assets<Mesh>>,
    scenes: Res<'w, Assets<BakedScene>>,
    server: Option<Res<'w, AssetServer>>,
}

#[derive(QueryData)]
struct Tag<E: Engine> {
    tag: Option<&'static ConvexDecomposition>,
    baked: Option<&'static BakedDecomposition>,
    scene: Option<&'static FromBakedScene>,
    cell: Option<(&'static LevelCell, &'static OfCell)>,
    before: MadeBefore<E>,
    is_too_small: Has<TooSmallAt>,
}

/// The next state of an entity.
enum Resolution {
    /// It has no tag any more, nor a collider of the plugin's.
    Gone,
    /// There is no mesh on it or below it.
    NoMesh,
    Skipped(SkipReason),
    Requested(Requested, Presence),
}

/// Compares what marked entities are made of now with what they were: those that differ start anew.
pub(super) fn compare_marked<E: Engine>(mut work: Work, scene: Scene<E>, mut outcomes: Outcomes) {
    for entity in std::mem::take(&mut work.unfinished.marked) {
        if !work.is_resolved(entity) {
            continue;
        }
        let Ok(tag) = scene.tags.get(entity) else {
            work.unfinished.park(entity);
            continue;
        };
        match scene.resolution(entity, &tag, &work.jobs) {
            Resolution::Gone => {}
            Resolution::NoMesh => work.restart(entity),
            Resolution::Skipped(reason) => {
                let status = outcomes.status(entity);
                // What has a collider keeps it while it is hidden or far.
                let is_small = reason == SkipReason::TooSmall;
                let is_kept = !reason.has_collider() && !is_small && tag.before.attached.is_some();
                let is_same = status == Some(DecompositionStatus::Skipped(reason)) || is_kept;
                if work.unfinished.contains(entity) || !is_same {
                    work.restart(entity);
                }
            }
            Resolution::Requested(requested, presence) => {
                let asset = requested.request.input.asset();
                // Other entities may have the same meshes by now.
                if let Some(parts) = tag.before.parts.and_then(|of| of.of_others(&requested.parts))
                {
                    outcomes.commands.entity(entity).try_insert(parts);
                }
                if work.update(entity, &tag.before, requested, &presence) {
                    let who = scene.descriptions.entity(entity, asset);
                    log::warn!(
                        "{who} changes faster than its collider can be made, which follows with \
                         the latest that could be finished; so do others of which nothing is said"
                    );
                }
            }
        }
    }
}

/// Resolves entities whose meshes are not known yet, each at most once per frame.
pub(super) fn resolve<E: Engine>(
    mut work: Work,
    Frame { mut time, settings }: Frame,
    mut fallbacks: ResMut<Fallbacks>,
    mut cells: ResMut<Cells>,
    scene: Scene<E>,
    mut outcomes: Outcomes,
) {
    let mut budget = time.budget(&settings);
    let mut overdue = Vec::new();
    for _ in 0..work.unfinished.unresolved.len() {
        if !budget.allows_one() {
            break;
        }
        let Some(entity) = work.unfinished.unresolved.pop_front() else { break };
        let Ok(tag) = scene.tags.get(entity) else {
            match scene.disabled.contains(entity) {
                true => work.unfinished.park(entity),
                false => {
                    work.unfinished.end(entity);
                    outcomes.cancelled(entity);
                }
            }
            continue;
        };
        let resolution = scene.resolution(entity, &tag, &work.jobs);
        let is_later =
            matches!(resolution, Resolution::NoMesh | Resolution::Requested(_, Presence::Later(_)));
        if tag.before.failed.is_some() && !is_later {
            outcomes.commands.entity(entity).try_remove::<FailedRequest>();
        }
        if tag.is_too_small {
            outcomes.commands.entity(entity).try_remove::<TooSmallAt>();
        }
        if is_later {
            outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::ForMesh));
        }
        let mut commands = outcomes.commands.entity(entity);
        match resolution {
            Resolution::Gone => {
                work.unfinished.end(entity);
                outcomes.cancelled(entity);
            }
            Resolution::NoMesh => {
                tag.before.detach(&mut commands);
                if work.unfinished.resolve_later(entity, settings.warn_without_mesh_after) {
                    overdue.push((entity, None));
                }
            }
            Resolution::Requested(_, Presence::Later(asset)) => {
                if work.unfinished.resolve_later(entity, settings.warn_without_mesh_after) {
                    overdue.push((entity, Some(asset)));
                }
            }
            Resolution::Skipped(reason) => {
                work.unfinished.end(entity);
                match reason {
                    SkipReason::TooFar => commands.try_insert(FarFromFocus),
                    SkipReason::TooSmall => {
                        commands.try_insert(TooSmallAt(scene.placements.stretch(entity)))
                    }
                    _ => &mut commands,
                };
                // One of another mesh or scale would be taken for this one, and the game's own is
                // no business of ours.
                if !reason.has_collider() || tag.before.has_games_collider() {
                    tag.before.detach(&mut commands);
                }
                outcomes.skipped(entity, reason);
            }
            Resolution::Requested(requested, Presence::Never(error)) => {
                work.unfinished.resolve(entity, requested);
                work.jobs.fail(entity, error);
            }
            Resolution::Requested(requested, Presence::There) => {
                let request = requested.request.clone();
                if let Some(place) = &requested.cell {
                    let parts = requested.parts.iter().copied().zip(request.parts.iter().cloned());
                    let member = (entity, &**place);
                    cells.join(&mut outcomes.commands, &mut work.unfinished, member, parts);
                    outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::InQueue));
                    work.unfinished.resolve(entity, requested);
                    continue;
                }
                work.unfinished.resolve(entity, requested);
                if work.jobs.submit(entity, request.clone()) {
                    outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::InQueue));
                    // Before its first collider.
                    if let TagItem { tag: Some(of), baked: None, before, .. } = tag
                        && !before.has_collider()
                        && let kind = of.fallback_collider.unwrap_or(settings.fallback_collider)
                        && kind != FallbackCollider::None
                    {
                        fallbacks.push(entity, request, kind);
                    }
                }
            }
        }
    }
    outcomes.counters.waiting_for_mesh = work.unfinished.unresolved.len();
    // One line for those that have no mesh, and one for those whose asset is not loaded.
    for (is_asset, why) in
        [(false, "there is no Mesh3d on it or below it"), (true, "the asset is not loaded")]
    {
        let mut all = overdue.iter().filter(|(_, asset)| asset.is_some() == is_asset).peekable();
        if let Some((entity, asset)) = all.peek() {
            let first = scene.descriptions.entity(*entity, *asset);
            let who = entities(all.count(), &first);
            log::warn!("no convex decomposition yet for {who}: {why}");
        }
    }
}

impl<E: Engine> Scene<'_, '_, E> {
    fn resolution(&self, entity: Entity, tag: &TagItem<E>, jobs: &Jobs) -> Resolution {
        if tag.before.has_games_collider() {
            return Resolution::Skipped(SkipReason::HasCollider);
        }
        if let Some((cell, OfCell(key))) = tag.cell {
            return self.cell_request(entity, cell, key, jobs);
        }
        match (tag.baked, tag.tag) {
            (Some(baked), _) => self.baked_request(entity, baked, jobs),
            (None, Some(of_meshes)) => match self.reason_to_skip(entity) {
                Some(reason) => Resolution::Skipped(reason),
                None => self.mesh_request(entity, of_meshes, tag.scene, jobs),
            },
            // What it had is the engine's own now.
            (None, None) if tag.before.attached.is_some() => {
                Resolution::Skipped(SkipReason::HasCollider)
            }
            (None, None) => Resolution::Gone,
        }
    }

    /// Why an entity is skipped, whatever its mesh.
    fn reason_to_skip(&self, entity: Entity) -> Option<SkipReason> {
        let settings = &self.distances.settings;
        if settings.skip.hidden && self.is_hidden(entity) {
            return Some(SkipReason::Hidden);
        }
        let radius = settings.skip.focus_radius?;
        self.distances.is_beyond(entity, radius).then_some(SkipReason::TooFar)
    }

    /// As Bevy draws it, also before it has worked that out. Without a renderer nothing is hidden.
    fn is_hidden(&self, entity: Entity) -> bool {
        #[cfg(feature = "bevy_gltf")]
        {
            let above = std::iter::once(entity).chain(self.parents.iter_ancestors(entity));
            let own = above.map_while(|entity| self.visibilities.get(entity).ok());
            own.copied().find(|own| *own != Visibility::Inherited) == Some(Visibility::Hidden)
        }
        #[cfg(not(feature = "bevy_gltf"))]
        {
            let _ = entity;
            false
        }
    }

    fn baked_request(&self, entity: Entity, baked: &BakedDecomposition, jobs: &Jobs) -> Resolution {
        let id = baked.scene.id().untyped();
        let Placement { map, stretch, .. } = self.placements.placement(entity);
        let edition = jobs.edition([id]);
        let request = ColliderRequest {
            input: Arc::new(InputId::Baked { scene: id, mesh: baked.mesh.clone(), edition }),
            parts: Vec::new(),
            goal: None,
            map_before: Affine3A::IDENTITY,
            map,
        };
        let missing = Some(id).filter(|_| !self.scenes.contains(&baked.scene));
        let presence = self.presence(entity, missing, &map);
        let weight = Weight { density: baked.density, mass: baked.mass };
        let mut meshes = Vec::new();
        self.collect(entity, entity, &mut meshes);
        let parts = meshes.into_iter().map(|(entity, _)| entity).collect();
        let children = baked.children;
        let request = Arc::new(request);
        let requested = Requested { request, stretch, weight, children, parts, cell: None };
        Resolution::Requested(requested, presence)
    }

    /// Whether what an entity requests is there, apart from this asset.
    fn presence(
        &self,
        entity: Entity,
        missing: Option<UntypedAssetId>,
        map: &Affine3A,
    ) -> Presence {
        let matrix = map.matrix3;
        match missing {
            Some(asset) if self.failed_to_load(asset) => {
                Presence::Never(DecompositionError::NotLoaded)
            }
            Some(asset) => Presence::Later(asset),
            None if self.placements.has_mirrored_body(entity) => {
                Presence::Never(DecompositionError::MirroredBody)
            }
            // A map that flattens leaves no body.
            None if !(map.is_finite() && matrix.determinant().is_normal()) => {
                let scale = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec3A::length);
                Presence::Never(ColliderError::InvalidScale { scale }.into())
            }
            None => Presence::There,
        }
    }

    fn mesh_request(
        &self,
        entity: Entity,
        tag: &ConvexDecomposition,
        scene: Option<&FromBakedScene>,
        jobs: &Jobs,
    ) -> Resolution {
        let mut meshes = Vec::new();
        self.collect(entity, entity, &mut meshes);
        if meshes.is_empty() {
            return Resolution::NoMesh;
        }
        let (entities, parts): (Vec<Entity>, Vec<MeshPart>) = meshes.into_iter().unzip();
        let missing = parts.iter().map(|part| part.mesh).find(|mesh| !self.meshes.contains(*mesh));
        let mut missing = missing.map(AssetId::untyped);
        let goal = self.goal(entity, tag);
        let mut baked = None;
        if let Some(FromBakedScene(scene)) = scene {
            let id = scene.id().untyped();
            let may_have_surfaces = || self.scenes.get(scene).is_none_or(BakedScene::has_surfaces);
            // The mesh's own triangles are taken from there where it has none.
            let is_needed = match goal {
                Goal::Hulls(_) => true,
                Goal::Triangles { bound: Some(_), .. } if may_have_surfaces() => true,
                Goal::Triangles { .. } => {
                    let mut meshes = parts.iter().filter_map(|part| self.meshes.get(part.mesh));
                    meshes.any(is_for_gpu_only)
                }
                Goal::Primitive(_) => false,
            };
            match self.scenes.get(scene) {
                Some(of) => baked = (is_needed || of.is_found_by_label()).then_some(id),
                None if is_needed && !self.failed_to_load(id) => {
                    baked = Some(id);
                    missing = missing.or(baked);
                }
                None => {}
            }
        }
        let Placement { map: to_collider, stretch, .. } = self.placements.placement(entity);
        if missing.is_none() && self.is_too_small(&parts, &to_collider) {
            return Resolution::Skipped(SkipReason::TooSmall);
        }
        let presence = self.presence(entity, missing, &to_collider);
        let cell = self.cell_of(entity, &goal, &parts).map(Box::new);
        let request = Arc::new(request(parts, goal, baked, to_collider, jobs));
        let weight = Weight { density: tag.density, mass: tag.mass };
        let children = tag.children;
        let requested = Requested { request, stretch, weight, children, parts: entities, cell };
        Resolution::Requested(requested, presence)
    }

    /// The cell whose collider an entity shares: what never moves, is small, and has nothing of a
    /// surface or a body by itself.
    fn cell_of(&self, entity: Entity, goal: &Goal, parts: &[MeshPart]) -> Option<CellPlace> {
        use SkipReason::{FixedBody, NoBody};
        let Goal::Triangles { reason: reason @ (FixedBody | NoBody), bound } = *goal else {
            return None;
        };
        let &SharesCells { root, size } = self.sharing.get(entity).ok()?;
        let body = |entity| self.placements.body(entity).map(|(body, _)| body);
        let mut meshes = parts.iter().filter_map(|part| self.meshes.get(part.mesh));
        if entity == root
            || body(entity) != body(root)
            || self.surfaces.get(entity).is_ok_and(|own| E::has_surface(&own))
            || meshes.any(is_for_gpu_only)
        {
            return None;
        }
        let scale = self.placements.stretched(root);
        let place = self.placements.relative(entity, root);
        let (low, high) = self.world_box(parts, &(scale * place))?;
        let index = level_cell(low.to_array(), high.to_array(), size)?;
        let middle = (Vec3::from_array(index.map(|x| x as f32)) + 0.5) * size;
        let origin = scale.inverse().transform_point3(middle);
        let bound = bound.map(f32::to_bits);
        let key = CellKey { root, index, size: size.to_bits(), reason, bound };
        origin.is_finite().then_some(CellPlace { key, origin, place })
    }

    /// The collider of all in a cell.
    fn cell_request(
        &self,
        entity: Entity,
        cell: &LevelCell,
        key: &CellKey,
        jobs: &Jobs,
    ) -> Resolution {
        let members = cell.entities().iter().filter_map(|member| self.in_cells.get(*member).ok());
        let (entities, parts): (Vec<Entity>, Vec<MeshPart>) =
            members.flat_map(|member| &member.parts).cloned().unzip();
        let missing = parts.iter().map(|part| part.mesh).find(|mesh| !self.meshes.contains(*mesh));
        let mut missing = missing.map(AssetId::untyped);
        let mut scenes = cell.entities().iter().filter_map(|member| self.tags.get(*member).ok());
        let baked = scenes.find_map(|member| Some(member.scene?.0.id()));
        let baked = baked.filter(|id| match self.scenes.get(*id) {
            Some(scene) => scene.has_surfaces(),
            None => !self.failed_to_load(id.untyped()),
        });
        missing = missing.or(baked.filter(|id| !self.scenes.contains(*id)).map(AssetId::untyped));
        let baked = baked.map(AssetId::untyped);
        let Placement { map, stretch, .. } = self.placements.placement(entity);
        let presence = self.presence(entity, missing, &map);
        let bound = key.bound.map(f32::from_bits);
        let goal = Goal::Triangles { reason: key.reason, bound };
        let request = Arc::new(request(parts, goal, baked, map, jobs));
        let weight = Weight { density: DEFAULT_DENSITY, mass: None };
        let (parts, children, cell) = (entities, None, None);
        let requested = Requested { request, stretch, weight, children, parts, cell };
        Resolution::Requested(requested, presence)
    }

    fn goal(&self, entity: Entity, tag: &ConvexDecomposition) -> Goal {
        if let Some(reason) = self.placements.why_triangles(entity, tag.shape) {
            return Goal::triangles(tag, reason, self.distances.settings.level_bound);
        }
        let mut goal = Goal::of(tag, self.distances.settings.probe_radius);
        if self.is_primitive_among_others(entity) {
            goal.keep_openings_of_part();
        }
        goal
    }

    /// Whether an entity is one of several primitives of a glTF mesh, which Bevy spawns as children
    /// of one node without transforms of their own.
    fn is_primitive_among_others(&self, entity: Entity) -> bool {
        let is_primitive = |entity: Entity| {
            let transform = self.transforms.get(entity);
            self.meshes_on.contains(entity)
                && transform.is_ok_and(|transform| *transform == Transform::IDENTITY)
        };
        let Ok(siblings) = self.parents.get(entity).and_then(|of| self.children.get(of.parent()))
        else {
            return false;
        };
        is_primitive(entity) && siblings.iter().filter(|child| is_primitive(*child)).count() > 1
    }

    /// The meshes on an entity and below it, in the order of the children, of several levels of
    /// detail the finest.
    fn collect(&self, top: Entity, entity: Entity, parts: &mut Vec<(Entity, MeshPart)>) {
        let is_left_out = || self.boundaries.contains(entity) || self.levels.is_coarser(entity);
        if entity != top && is_left_out() {
            return;
        }
        if let Ok(mesh) = self.meshes_on.get(entity) {
            let to_input = self.placements.relative(entity, top);
            parts.push((entity, MeshPart { mesh: mesh.id(), to_input }));
        }
        if let Ok(children) = self.children.get(entity) {
            for child in children {
                self.collect(top, *child, parts);
            }
        }
    }

    /// Whether meshes are smaller in the world than the settings say. O(vertices), where they say
    /// something.
    fn is_too_small(&self, parts: &[MeshPart], map: &Affine3A) -> bool {
        let min_size = self.distances.settings.skip.min_size;
        if min_size <= 0.0 {
            return false;
        }
        // What is wrong with it is said elsewhere.
        let world_box = self.world_box(parts, map);
        world_box.is_some_and(|(low, high)| low.distance(high) < min_size)
    }

    /// The box around meshes that are moved by a map; `None` where some have none. O(vertices).
    fn world_box(&self, parts: &[MeshPart], map: &Affine3A) -> Option<(Vec3, Vec3)> {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for part in parts {
            let mesh = self.meshes.get(part.mesh);
            let positions = mesh.and_then(|mesh| mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok());
            // What is on the GPU only has its box.
            let corners = mesh.and_then(|mesh| mesh.final_aabb).map(|aabb| {
                let ends = [aabb.min, aabb.max];
                let corner = |of: usize| [0, 1, 2].map(|axis| ends[of >> axis & 1][axis]);
                [0, 1, 2, 3, 4, 5, 6, 7].map(corner)
            });
            let points = match (positions, &corners) {
                (Some(VertexAttributeValues::Float32x3(positions)), _) => &positions[..],
                (_, Some(corners)) => corners,
                (_, None) => return None,
            };
            let to_world = *map * part.to_input;
            for point in points {
                let point = to_world.transform_point3(Vec3::from(*point));
                (low, high) = (low.min(point), high.max(point));
            }
        }
        Some((low, high))
    }

    /// Whether an asset that is not there will not come.
    fn failed_to_load(&self, id: UntypedAssetId) -> bool {
        let state = self.server.as_ref().and_then(|server| server.get_load_state(id));
        matches!(state, Some(LoadState::Failed(_)))
    }
}

/// What is requested of meshes.
fn request(
    parts: Vec<MeshPart>,
    goal: Goal,
    baked: Option<UntypedAssetId>,
    to_collider: Affine3A,
    jobs: &Jobs,
) -> ColliderRequest {
    // A bound in metres means metres of the world, so the mesh is scaled first.
    let (map_before, map) = match goal.has_absolute_length() {
        true => (to_collider, Affine3A::IDENTITY),
        false => (Affine3A::IDENTITY, to_collider),
    };
    let input = Arc::new(InputId::Meshes {
        parts: parts.iter().map(|part| (part.mesh, MapKey::new(&part.to_input))).collect(),
        goal: goal.hash(),
        map_before: MapKey::new(&map_before),
        scene: baked,
        edition: jobs.edition(parts.iter().map(|part| part.mesh.untyped()).chain(baked)),
    });
    ColliderRequest { input, parts, goal: Some(goal), map_before, map }
}

/// Where entities and focuses are, and how far the settings let them be apart.
#[derive(SystemParam)]
pub(super) struct Distances<'w, 's> {
    pub settings: Res<'w, HullwrightSettings>,
    focuses: Query<'w, 's, Entity, With<DecompositionFocus>>,
    transforms: TransformHelper<'w, 's>,
}

impl Distances<'_, '_> {
    /// Whether all focuses are farther away; without a focus nothing is.
    pub(super) fn is_beyond(&self, entity: Entity, radius: f32) -> bool {
        let place =
            |entity| Some(self.transforms.compute_global_transform(entity).ok()?.translation());
        let Some(own) = place(entity) else { return false };
        let mut focuses = self.focuses.iter().filter_map(place).peekable();
        focuses.peek().is_some() && focuses.all(|focus| focus.distance(own) > radius)
    }
}
