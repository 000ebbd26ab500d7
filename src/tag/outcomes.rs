//! What is reported about an entity: its status, the counters, the log, and the one event in which
//! its tag ends.

use std::time::Duration;

use bevy::asset::UntypedAssetId;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use hullwright::Error;
use hullwright_parry::ColliderError;

/// How far an entity's collider has come.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum DecompositionStatus {
    /// Not started.
    Waiting(WaitReason),
    /// Being made.
    Running {
        /// Share of the work that is done, from 0 to 1; it never falls.
        progress: f32,
    },
    /// The collider is there.
    Ready(HullSource),
    /// No decomposition was made, and why.
    Skipped(SkipReason),
    /// There is no collider, and why. It was logged once.
    Failed(DecompositionError),
    /// The tag was removed before the collider was ready.
    Cancelled,
}

impl Default for DecompositionStatus {
    fn default() -> Self {
        Self::Waiting(WaitReason::ForMesh)
    }
}

impl DecompositionStatus {
    /// Whether nothing more will come, unless the entity or its mesh changes.
    pub fn is_finished(&self) -> bool {
        !matches!(self, Self::Waiting(_) | Self::Running { .. })
    }

    /// Whether the entity has a collider, whatever it is made of; `None` while it waits or its
    /// collider is made, when it may have an earlier one or a
    /// [`FallbackCollider`](crate::FallbackCollider).
    pub fn has_collider(&self) -> Option<bool> {
        match self {
            Self::Waiting(_) | Self::Running { .. } => None,
            Self::Ready(_) => Some(true),
            Self::Skipped(reason) => Some(reason.has_collider()),
            Self::Failed(_) | Self::Cancelled => Some(false),
        }
    }
}

/// What an entity waits for.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum WaitReason {
    /// There is no `Mesh3d` on it or below it, and no baked hulls, or they are not loaded.
    ForMesh,
    /// Others go first.
    InQueue,
}

/// Where hulls came from.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum HullSource {
    /// They were made for this entity.
    Decomposed,
    /// They were made for another entity with the same mesh and parameters.
    Shared,
    /// They were read from the cache on disk.
    Disk,
    /// They were baked.
    Baked,
}

/// Why no decomposition was made.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum SkipReason {
    /// The entity has a `Collider` of the game's own, from before or since, which stays. Also that
    /// of an earlier mesh or scale, where the tag was removed before the new one was ready.
    HasCollider,
    /// The body is fixed, so it got the triangle mesh itself.
    FixedBody,
    /// There is no body, so nothing moves it, and it got the triangle mesh itself.
    NoBody,
    /// The tag requests for the triangle mesh.
    TrianglesRequested,
    /// It is hidden, and [`hidden`](crate::SkipSettings::hidden) is set. It starts when it is
    /// shown.
    Hidden,
    /// It is smaller than [`min_size`](crate::SkipSettings::min_size).
    TooSmall,
    /// Every [`DecompositionFocus`](crate::DecompositionFocus) is farther away than
    /// [`focus_radius`](crate::SkipSettings::focus_radius). It starts when one is near.
    TooFar,
}

impl SkipReason {
    /// Whether the entity has a collider: its triangles, or the one that it had.
    pub fn has_collider(self) -> bool {
        match self {
            Self::HasCollider | Self::FixedBody | Self::NoBody | Self::TrianglesRequested => true,
            Self::Hidden | Self::TooSmall | Self::TooFar => false,
        }
    }
}

/// What the plugin has done and is doing.
#[derive(Resource, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionCounters {
    /// Entities that wait for their meshes.
    pub waiting_for_mesh: usize,
    /// Entities in the queue.
    pub queued: usize,
    /// Jobs at work.
    pub running: usize,
    /// Decompositions made so far.
    pub decomposed: usize,
    /// Those of them that were made with a probe, so that hulls may fill what it can't reach.
    pub probed: usize,
    /// Colliders whose hulls were made for another entity.
    pub shared: usize,
    /// Colliders whose hulls came from the cache on disk.
    pub from_disk: usize,
    /// Colliders of baked hulls.
    pub baked: usize,
    /// Colliders that are a single hull, as those of convex meshes are, or a box, ball or capsule.
    pub convex: usize,
    /// Entities with triangles, of what never moves or on request.
    pub triangle_meshes: usize,
    /// Surfaces that were simplified so far, for what never moves.
    pub simplified: usize,
    /// Colliders that were made for the cells of scenes, each for all that share it.
    pub level_cells: usize,
    /// Entities skipped because they had a collider.
    pub had_collider: usize,
    /// Entities skipped because they are hidden.
    pub hidden: usize,
    /// Entities skipped because they are too small.
    pub too_small: usize,
    /// Entities skipped, or whose colliders were dropped, because every focus is too far.
    pub too_far: usize,
    /// Entities that failed.
    pub failed: usize,
    /// Entities whose work was cancelled.
    pub cancelled: usize,
    /// Tags that ended in a collider, whatever it is made of.
    pub with_collider: usize,
    /// Tags that ended without one.
    pub without_collider: usize,
    /// Decompositions in the cache in memory.
    pub cached: usize,
    /// Their size in bytes, about.
    pub cached_bytes: usize,
    /// The bound of the decomposition that was made last, as a share of its mesh's diagonal.
    pub last_bound: Option<f32>,
    /// The verified protrusion of its hulls, as a share of its mesh's diagonal: no point of them
    /// is farther outside the solid.
    pub last_protrusion: Option<f32>,
}

/// Why there is no collider.
#[non_exhaustive]
#[derive(Reflect, Debug, Clone, PartialEq, thiserror::Error)]
#[reflect(opaque)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum DecompositionError {
    /// The asset server could not load the mesh or the baked hulls.
    #[error("the asset could not be loaded")]
    NotLoaded,
    /// The mesh's data is gone: it was uploaded and not kept.
    #[error(
        "the mesh is on the GPU only; bake its scene, or load it with \
         RenderAssetUsages::default(), which keeps MAIN_WORLD"
    )]
    RenderWorldOnly,
    /// The same, and the baked scene has nothing for its asset path and label. It says why.
    #[error("the mesh is on the GPU only, and not taken from the baked scene: {0}")]
    NotBakedByLabel(&'static str),
    /// The mesh has no positions, or not as three `f32`.
    #[error("the mesh has no positions of three f32")]
    NoPositions,
    /// The mesh is made of points or lines.
    #[error("the mesh consists of {0} instead of triangles")]
    NotTriangles(&'static str),
    /// The mesh could not be decomposed or weighed.
    #[error("{0}")]
    Mesh(Error),
    /// Its hulls could not be made a collider.
    #[error("{0}")]
    Collider(ColliderError),
    /// The baked scene has no mesh of this name, or several and none was named.
    #[error("{}", not_baked(name.as_deref(), names))]
    NotBaked {
        /// The name that was given.
        name: Option<String>,
        /// The names of the meshes that it has, and of the nodes that show them.
        names: Vec<String>,
    },
    /// The body that moves it has a negative scale along y or z, and is not fixed: the physics
    /// engine would turn it, and what is drawn.
    #[error(
        "its body is mirrored along y or z, which the physics engine takes for another rotation; mirror the body along x alone, or \
         the meshes below it"
    )]
    MirroredBody,
    /// The work panicked. The panic is contained to it.
    #[error("the work on it panicked")]
    Panicked,
}

fn skipped(reason: SkipReason) -> &'static str {
    match reason {
        SkipReason::Hidden => "hidden",
        SkipReason::TooSmall => "too small",
        SkipReason::TooFar => "too far from every focus",
        // These have a collider.
        SkipReason::HasCollider => "one that has a collider",
        SkipReason::FixedBody => "fixed",
        SkipReason::NoBody => "no part of a body",
        SkipReason::TrianglesRequested => "triangles on request",
    }
}

/// More names would not help.
const MOST_NAMES: usize = 16;

fn not_baked(name: Option<&str>, names: &[String]) -> String {
    let some = names.iter().take(MOST_NAMES).map(|name| format!("`{name}`"));
    let mut some = some.collect::<Vec<_>>().join(", ");
    if names.len() > MOST_NAMES {
        some += ", …";
    }
    match name {
        Some(name) => format!("the baked scene has no mesh `{name}`, but {some}"),
        None => format!("the baked scene has several meshes, so name one: {some}"),
    }
}

impl From<ColliderError> for DecompositionError {
    fn from(error: ColliderError) -> Self {
        match error {
            ColliderError::Mesh(error) => Self::Mesh(error),
            error => Self::Collider(error),
        }
    }
}

impl From<Error> for DecompositionError {
    fn from(error: Error) -> Self {
        Self::Mesh(error)
    }
}

// Every tag ends in exactly one of these two events, and in exactly one of the finer four: ready,
// skipped, failed or cancelled. What changes later, such as the mesh or the scale, starts anew and
// ends in one of each again.

/// The entity has a collider, whatever it is made of. Also after a changed scale or mesh.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// # let mut app = App::new();
/// app.add_observer(|ready: On<ColliderReady>| println!("{}: {:?}", ready.entity, ready.made_of))
///     .add_observer(|absent: On<ColliderAbsent>| println!("{}: {}", absent.entity, absent.reason));
/// ```
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct ColliderReady {
    /// The tagged entity.
    pub entity: Entity,
    /// What its collider is made of.
    pub made_of: MadeOf,
}

/// What a collider is made of.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum MadeOf {
    /// So many hulls: [`DecompositionReady`] has more.
    Hulls(usize),
    /// The mesh's triangles, of what never moves or on request.
    Triangles,
    /// A box, a ball or a capsule around the mesh.
    Primitive,
    /// It had that collider before.
    Existing,
}

/// The entity has no collider, and no earlier one of the plugin's stays behind.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct ColliderAbsent {
    /// The entity that is or was tagged.
    pub entity: Entity,
    /// Why.
    pub reason: AbsentReason,
}

/// Why there is no collider.
#[derive(Reflect, Debug, Clone, PartialEq, thiserror::Error)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum AbsentReason {
    /// The settings say so.
    #[error("skipped, since it is {}", skipped(*.0))]
    Skipped(SkipReason),
    /// The work failed.
    #[error("{0}")]
    Failed(DecompositionError),
    /// The tag was removed, or the entity despawned, before.
    #[error("the tag was removed, or the entity despawned")]
    Cancelled,
}

/// The entity has its collider of hulls. Also after a changed scale or mesh.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_hullwright::prelude::*;
///
/// # let mut app = App::new();
/// app.add_observer(|ready: On<DecompositionReady>| println!("{}: {}", ready.entity, ready.hulls));
/// ```
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionReady {
    /// The tagged entity.
    pub entity: Entity,
    /// Hulls of the collider, at least 1.
    pub hulls: usize,
    /// How far hulls and mesh are apart at most; `None` where nothing was verified, as by the
    /// paper's method.
    pub verified: Option<VerifiedDistances>,
    /// Where the hulls came from.
    pub source: HullSource,
    /// From the tag, or from what changed, to the collider, by the clock on the wall.
    pub time: Duration,
}

/// How far hulls and mesh are apart at most, as verified, as shares of the mesh's diagonal before
/// scale.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct VerifiedDistances {
    /// No point of a hull is farther outside the solid: things stop before they touch.
    pub protrusion: f32,
    /// No point of the surface is farther outside every hull: things sink in.
    pub uncovered: f32,
}

impl VerifiedDistances {
    /// The larger of both, which is what the tag's bound is about.
    pub fn max(&self) -> f32 {
        self.protrusion.max(self.uncovered)
    }
}

/// No decomposition was made. `reason` says whether the entity has the collider that it had, its
/// triangles, or none.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionSkipped {
    /// The tagged entity.
    pub entity: Entity,
    /// Why.
    pub reason: SkipReason,
}

/// The entity gets no collider.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionFailed {
    /// The tagged entity.
    pub entity: Entity,
    /// Why not.
    pub error: DecompositionError,
}

/// The tag was removed, or the entity despawned, before the collider was ready. A despawned entity
/// is gone when observers run.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionCancelled {
    /// The entity that was tagged.
    pub entity: Entity,
}

/// The only place in which a tag ends.
#[derive(SystemParam)]
pub(crate) struct Outcomes<'w, 's> {
    pub commands: Commands<'w, 's>,
    pub counters: ResMut<'w, DecompositionCounters>,
    statuses: Query<'w, 's, &'static mut DecompositionStatus>,
}

impl Outcomes<'_, '_> {
    /// Shows that an entity waits or runs.
    pub(crate) fn show(&mut self, entity: Entity, status: DecompositionStatus) {
        if let Ok(mut old) = self.statuses.get_mut(entity) {
            old.set_if_neq(status);
        }
    }

    pub(crate) fn status(&self, entity: Entity) -> Option<DecompositionStatus> {
        self.statuses.get(entity).ok().cloned()
    }

    fn end(&mut self, entity: Entity, status: DecompositionStatus) {
        if let Ok(mut old) = self.statuses.get_mut(entity) {
            *old = status;
        }
    }

    pub(crate) fn ready(&mut self, ready: DecompositionReady, made_of: MadeOf) {
        match ready.source {
            HullSource::Decomposed => {}
            HullSource::Shared => self.counters.shared += 1,
            HullSource::Disk => self.counters.from_disk += 1,
            HullSource::Baked => self.counters.baked += 1,
        }
        self.counters.convex += usize::from(ready.hulls == 1);
        let entity = ready.entity;
        self.end(entity, DecompositionStatus::Ready(ready.source));
        self.commands.trigger(ready);
        self.has_collider(entity, made_of);
    }

    pub(crate) fn skipped(&mut self, entity: Entity, reason: SkipReason) {
        *match reason {
            SkipReason::HasCollider => &mut self.counters.had_collider,
            SkipReason::FixedBody | SkipReason::NoBody | SkipReason::TrianglesRequested => {
                &mut self.counters.triangle_meshes
            }
            SkipReason::Hidden => &mut self.counters.hidden,
            SkipReason::TooSmall => &mut self.counters.too_small,
            SkipReason::TooFar => &mut self.counters.too_far,
        } += 1;
        self.end(entity, DecompositionStatus::Skipped(reason));
        self.commands.trigger(DecompositionSkipped { entity, reason });
        match reason {
            SkipReason::HasCollider => self.has_collider(entity, MadeOf::Existing),
            SkipReason::FixedBody | SkipReason::NoBody | SkipReason::TrianglesRequested => {
                self.has_collider(entity, MadeOf::Triangles);
            }
            SkipReason::Hidden | SkipReason::TooSmall | SkipReason::TooFar => {
                self.has_none(entity, AbsentReason::Skipped(reason));
            }
        }
    }

    pub(crate) fn failed(&mut self, entity: Entity, error: DecompositionError) {
        self.counters.failed += 1;
        self.end(entity, DecompositionStatus::Failed(error.clone()));
        self.commands.trigger(DecompositionFailed { entity, error: error.clone() });
        self.has_none(entity, AbsentReason::Failed(error));
    }

    pub(crate) fn cancelled(&mut self, entity: Entity) {
        self.counters.cancelled += 1;
        self.end(entity, DecompositionStatus::Cancelled);
        self.commands.trigger(DecompositionCancelled { entity });
        self.has_none(entity, AbsentReason::Cancelled);
    }

    fn has_collider(&mut self, entity: Entity, made_of: MadeOf) {
        self.counters.with_collider += 1;
        self.commands.trigger(ColliderReady { entity, made_of });
    }

    fn has_none(&mut self, entity: Entity, reason: AbsentReason) {
        self.counters.without_collider += 1;
        self.commands.trigger(ColliderAbsent { entity, reason });
    }
}

/// What entities are called.
#[derive(SystemParam)]
pub(crate) struct Descriptions<'w, 's> {
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    server: Option<Res<'w, AssetServer>>,
}

impl Descriptions<'_, '_> {
    /// `12v3 "chair" (props.glb#Mesh0/Primitive0)`, as far as it is known.
    pub(crate) fn entity(&self, entity: Entity, asset: Option<UntypedAssetId>) -> String {
        let name = |entity| self.names.get(entity).ok();
        let name = name(entity).or_else(|| self.parents.iter_ancestors(entity).find_map(name));
        let name = name.map(|name| format!(" \"{name}\"")).unwrap_or_default();
        let asset = asset.and_then(|id| self.server.as_ref()?.get_path(id));
        let asset = asset.map(|path| format!(" ({path})")).unwrap_or_default();
        format!("{entity}{name}{asset}")
    }
}

/// One entity by its description, several by their number and the first of them.
pub(crate) fn entities(count: usize, first: &str) -> String {
    match count {
        1 => first.to_owned(),
        _ => format!("{count} entities, the first of them {first}"),
    }
}
