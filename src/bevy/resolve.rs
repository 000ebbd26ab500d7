//! From a tag to an ask: which meshes, which scale, which kind of collider, and whether there is
//! anything to do at all.

use std::sync::Arc;

use bevy::asset::{AssetId, LoadState, UntypedAssetId};
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, RigidBody};

use crate::{Parameters, Unit};

use super::attach::Attached;
use super::baked::{BakedDecomposition, BakedHulls};
use super::failing::{Failure, Rejected};
use super::job::Made;
use super::library::{Content, Library, Material, parameters_text};
use super::meanwhile::StandIn;
use super::mesh_data::Part;
use super::placement::{MapKey, Placements};
use super::work::{Ask, Delivery, SourceId, Work};
use super::{
    ConvexDecomposition, DecompositionCounters, DecompositionFailure, DecompositionStatus,
    HullwrightSettings, Meanwhile, NoConvexDecomposition, Origin, Skip, Wait,
};

/// What is looked at to know what an entity wants.
#[derive(SystemParam)]
pub(super) struct Scene<'w, 's> {
    tags: Query<'w, 's, TagComponents>,
    below: Query<'w, 's, InputEnds>,
    meshes_on: Query<'w, 's, &'static Mesh3d>,
    children: Query<'w, 's, &'static Children>,
    rejected: Query<'w, 's, (), With<Rejected>>,
    placements: Placements<'w, 's>,
    meshes: Res<'w, Assets<Mesh>>,
    baked: Res<'w, Assets<BakedHulls>>,
    server: Option<Res<'w, AssetServer>>,
}

type TagComponents = (
    Option<&'static ConvexDecomposition>,
    Option<&'static BakedDecomposition>,
    Has<Collider>,
    Has<Attached>,
    Has<StandIn>,
);

/// What ends an input: an entity with any of these belongs to itself.
type InputEnds =
    (Has<ConvexDecomposition>, Has<BakedDecomposition>, Has<RigidBody>, Has<NoConvexDecomposition>);

/// What is to become of an entity.
enum Resolution {
    /// It is gone, or has no tag any more.
    Gone,
    /// Its meshes are not there yet.
    Later,
    HasCollider,
    Failed(Box<Ask>, DecompositionFailure),
    Ask(Box<Ask>),
}

impl Resolution {
    fn not_loaded(ask: Box<Ask>) -> Self {
        Self::Failed(ask, DecompositionFailure::NotLoaded)
    }
}

/// Looks at entities whose meshes are not known yet, each at most once per frame.
pub(super) fn resolve(
    mut commands: Commands,
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    library: Res<Library>,
    scene: Scene,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let mut budget = work.budget(&settings);
    for _ in 0..work.to_resolve.len() {
        if !budget.allows_one() {
            break;
        }
        let Some(entity) = work.to_resolve.pop_front() else { break };
        let mut set_status = |new| {
            if let Ok(mut status) = statuses.get_mut(entity) {
                status.set_if_neq(new);
            }
        };
        let set_ask = |work: &mut Work, ask| {
            if let Some(request) = work.requests.get_mut(&entity) {
                request.ask = Some(ask);
            }
        };
        let resolution = scene.resolution(entity, &settings);
        if scene.rejected.contains(entity) && !matches!(resolution, Resolution::Later) {
            commands.entity(entity).try_remove::<Rejected>();
        }
        match resolution {
            Resolution::Gone => {
                work.requests.remove(&entity);
            }
            Resolution::Later => work.to_resolve.push_back(entity),
            Resolution::HasCollider => {
                work.requests.remove(&entity);
                counters.had_collider += 1;
                set_status(DecompositionStatus::Skipped(Skip::HasCollider));
            }
            Resolution::Failed(ask, why) => {
                work.failures.push(Failure { entity, why, is_known: false });
                set_ask(&mut work, ask.into());
            }
            Resolution::Ask(ask) => {
                let ask: Arc<Ask> = Arc::from(ask);
                match known(&work, &library, &ask) {
                    Some(Ok(made)) => {
                        let ask = ask.clone();
                        work.deliveries.push_back(Delivery { entity, ask, made });
                    }
                    Some(Err(why)) => {
                        work.failures.push(Failure { entity, why, is_known: true });
                    }
                    None => {
                        work.queue.push(entity);
                        if scene.wants_stand_in(entity, &settings) {
                            work.to_fill.push_back(entity);
                        }
                        set_status(DecompositionStatus::Waiting(Wait::InQueue));
                    }
                }
                set_ask(&mut work, ask);
            }
        }
    }
    work.spend(&budget);
}

/// A result that is there without any work.
fn known(work: &Work, library: &Library, ask: &Ask) -> Option<Result<Made, DecompositionFailure>> {
    let content = match work.known.get(&ask.source)? {
        Ok(content) => *content,
        Err(failure) => return Some(Err(failure.clone())),
    };
    let (material, shape) = library.shape(content, ask.map_key())?;
    let origin = match content {
        Content::Mesh(_) => Origin::Shared,
        Content::Baked(_) => Origin::Baked,
    };
    Some(Ok(Made { content, material, shape, origin }))
}

impl Scene<'_, '_> {
    fn resolution(&self, entity: Entity, settings: &HullwrightSettings) -> Resolution {
        let Ok((tag, baked, has_collider, is_attached, is_stand_in)) = self.tags.get(entity) else {
            return Resolution::Gone;
        };
        if has_collider && !is_attached && !is_stand_in {
            return Resolution::HasCollider;
        }
        match (baked, tag) {
            (Some(baked), _) => self.baked(entity, baked),
            (None, Some(tag)) => self.mesh(entity, tag, settings),
            (None, None) => Resolution::Gone,
        }
    }

    fn baked(&self, entity: Entity, baked: &BakedDecomposition) -> Resolution {
        let id = baked.hulls.id();
        let is_missing = !self.baked.contains(id);
        if is_missing && !self.is_lost(id.untyped()) {
            return Resolution::Later;
        }
        let placement = self.placements.placement(entity);
        let ask = Box::new(Ask {
            source: Arc::new(SourceId::Baked(id)),
            parts: Vec::new(),
            parameters: None,
            before: Affine3A::IDENTITY,
            map: placement.map,
            stretch: placement.stretch,
        });
        if is_missing { Resolution::not_loaded(ask) } else { Resolution::Ask(ask) }
    }

    fn mesh(
        &self,
        entity: Entity,
        tag: &ConvexDecomposition,
        settings: &HullwrightSettings,
    ) -> Resolution {
        let mut parts = Vec::new();
        self.collect(entity, entity, &mut parts);
        if parts.is_empty() {
            return Resolution::Later;
        }
        let missing = parts.iter().map(|part| part.mesh).find(|mesh| !self.meshes.contains(*mesh));
        if missing.is_some_and(|mesh| !self.is_lost(mesh.untyped())) {
            return Resolution::Later;
        }
        let placement = self.placements.placement(entity);
        let is_fixed = matches!(self.placements.body(entity), Some((_, RigidBody::Fixed)));
        let parameters =
            (!is_fixed || !settings.exact_fixed_bodies).then(|| tag.parameters.clone());
        // A bound in metres means metres of the world, so the mesh is scaled first.
        let is_scaled_first = parameters.as_ref().is_some_and(has_absolute_unit);
        let (before, map) = match is_scaled_first {
            true => (placement.map, Affine3A::IDENTITY),
            false => (Affine3A::IDENTITY, placement.map),
        };
        let source = SourceId::Mesh {
            parts: parts.iter().map(|part| (part.mesh, MapKey::new(&part.to_input))).collect(),
            recipe: *blake3::hash(parameters_text(parameters.as_ref()).as_bytes()).as_bytes(),
            before: MapKey::new(&before),
        };
        let ask = Box::new(Ask {
            source: Arc::new(source),
            parts,
            parameters,
            before,
            map,
            stretch: placement.stretch,
        });
        if missing.is_some() { Resolution::not_loaded(ask) } else { Resolution::Ask(ask) }
    }

    /// The meshes on an entity and below it, in the order of the children.
    fn collect(&self, top: Entity, entity: Entity, parts: &mut Vec<Part>) {
        if entity != top {
            let is_left_out = |(tag, baked, body, excluded)| tag || baked || body || excluded;
            if self.below.get(entity).is_ok_and(is_left_out) {
                return;
            }
        }
        if let Ok(mesh) = self.meshes_on.get(entity) {
            let to_input = self.placements.relative(entity, top);
            parts.push(Part { mesh: mesh.id(), to_input });
        }
        if let Ok(children) = self.children.get(entity) {
            for child in children {
                self.collect(top, *child, parts);
            }
        }
    }

    /// Whether an asset that is not there will not come.
    fn is_lost(&self, id: UntypedAssetId) -> bool {
        let state = self.server.as_ref().and_then(|server| server.get_load_state(id));
        matches!(state, Some(LoadState::Failed(_)))
    }

    /// Whether something stands in for the first collider of an entity.
    fn wants_stand_in(&self, entity: Entity, settings: &HullwrightSettings) -> bool {
        let Ok((Some(tag), None, false, ..)) = self.tags.get(entity) else { return false };
        tag.meanwhile.unwrap_or(settings.meanwhile) != Meanwhile::Nothing
    }

    /// The hulls of a baked asset.
    pub(super) fn baked_material(&self, id: AssetId<BakedHulls>) -> Option<Arc<Material>> {
        let BakedHulls(file) = self.baked.get(id)?;
        Some(Arc::new(Material::Hulls(Box::new(file.clone()))))
    }

    pub(super) fn meshes(&self) -> &Assets<Mesh> {
        &self.meshes
    }
}

/// Whether the result depends on how large the mesh is in the world.
pub(super) fn has_absolute_unit(parameters: &Parameters) -> bool {
    matches!(parameters.bounded.max_error, Unit::Absolute(_))
        || matches!(parameters.surface.unit, Unit::Absolute(_))
}
