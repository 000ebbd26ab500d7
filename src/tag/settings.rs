//! What concerns all entities: the settings, and the sets in which the plugin's systems run.

use std::path::PathBuf;
use std::time::Duration;

use bevy::prelude::*;

/// Whether the platform has threads. In browsers, work goes to workers or is done in slices.
pub(crate) const HAS_THREADS: bool = cfg!(not(target_family = "wasm"));

/// The plugin's settings; may be changed at any time.
///
/// ```
/// use bevy_hullwright::prelude::*;
///
/// # let mut app = bevy::prelude::App::new();
/// let settings = HullwrightSettings {
///     fallback_collider: FallbackCollider::BoundingBox,
///     cache: CacheSettings { disk: Some("cache/hulls".into()), ..Default::default() },
///     ..Default::default()
/// };
/// app.insert_resource(settings);
/// ```
#[derive(Resource, Reflect, Debug, Clone, PartialEq)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct HullwrightSettings {
    /// The collider that an entity has until its own is ready, unless the tag says otherwise.
    /// Default: none.
    pub fallback_collider: FallbackCollider,
    /// Whether a dynamic body is frozen until its colliders are ready, so that it does not fall
    /// through the floor. Its components stay as they are: the physics engine's own body is held,
    /// during its steps. Default true.
    pub freeze_until_ready: bool,
    /// An entity that has waited for this long for a mesh is logged, once: most likely it will
    /// never get one. `None` for never. Default 5 s.
    pub warn_without_mesh_after: Option<Duration>,
    /// Whether what never moves, on fixed bodies (Avian: static) and without a body, gets its exact
    /// triangle mesh instead of hulls: nothing is gained by hulls there. Sensors get hulls, since
    /// triangles have no inside. [`ConvexDecomposition::shape`](crate::ConvexDecomposition::shape)
    /// decides for one entity. Default true.
    pub exact_static_colliders: bool,
    /// Whether hulls that are boxes, balls or capsules within what the verified distances leave of
    /// the bound become these: see
    /// [`shape_with_primitives`](hullwright_parry::shape_with_primitives). For colliders that are
    /// made from then on, and not those whose scale differs along the axes. Default false.
    pub primitives: bool,
    /// Half the thickness of the thinnest thing that moves, in metres of the world; positive. Hulls
    /// may fill what no ball of that radius can reach: fewer hulls. For tags that say nothing else
    /// and keep no cavities. `None` for gaps that stay open whatever moves. Default `None`.
    pub probe_radius: Option<f32>,
    /// How far the triangles of what never moves may be from its mesh, and the mesh from them, in
    /// metres of the world; positive. Then there are few of them, made in the background, and it is
    /// verified: see [`simplify_surface`](hullwright::simplify_surface()). For tags that say
    /// nothing else. `None` for the mesh's own triangles. Default `None`.
    pub level_bound: Option<f32>,
    /// Whether new worlds of Rapier get a `hullwright_rapier::ContactDispatcher`, without which
    /// small things sink into each other. It concerns all colliders of the world. Set it to `false`
    /// if a world has a dispatcher of its own. Without effect in Avian. Default `true`.
    pub contact_dispatcher: bool,
    /// A collider is made anew once its scale, or a part of its input, has not moved for this long;
    /// hulls follow a scale meanwhile. Default 0.1 s.
    pub scale_delay: Duration,
    /// Where the work is done, and how much of it at once.
    pub budget: BudgetSettings,
    /// What is kept of it.
    pub cache: CacheSettings,
    /// What gets no collider.
    pub skip: SkipSettings,
}

/// Where the work is done, and how much of it at once.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct BudgetSettings {
    /// Where the work is done. Default: in the background where there are threads, and in workers
    /// in a browser.
    pub execution: Execution,
    /// The address of the folder with the files for workers, relative to the page: `worker-core.js`
    /// and `hullwright-core.wasm` of the npm package. Read when the first mesh is decomposed in
    /// one. Default `hullwright`.
    pub worker_folder: String,
    /// Threads of the plugin's own for work in the background, or workers; 0 for half of the
    /// processor's, from 1 to 4. One more thread is for what takes no decomposition. They have a
    /// lower priority than the game's where the platform has that. Default 0.
    pub threads: usize,
    /// Most decompositions at once; 0 for one for each of the threads, and in workers never more
    /// than these. What takes none does not count. Default 0.
    pub max_jobs: usize,
    /// Time per frame that the plugin's systems may spend on reading meshes and attaching
    /// colliders, and in slices on all work. One of each goes through even if it takes longer.
    /// Default 1 ms, and 4 ms where there are no threads.
    pub frame_time: Duration,
    /// Most colliders attached per frame: what Bevy and the physics engine do with them comes on
    /// top of the budget. Default 64.
    pub max_attached_per_frame: usize,
}

/// What is kept of the work.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct CacheSettings {
    /// Size of the cache in memory, in bytes; 0 for none. Default 64 MiB.
    pub memory_bytes: usize,
    /// Directory of a cache on disk, made if need be. In a browser a database in IndexedDB, the
    /// first that is named while the page is open. `None` for none, the default. Several processes
    /// may share it.
    pub disk: Option<PathBuf>,
    /// Size of the cache on disk, in bytes: the files that were used least recently are removed. It
    /// may be larger by a sixteenth for a while. Default 256 MiB.
    pub disk_bytes: u64,
}

/// What gets no collider.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct SkipSettings {
    /// Meshes whose bounding box has a shorter diagonal than this in the world get no collider:
    /// [`SkipReason::TooSmall`](crate::SkipReason::TooSmall). Default 0: none is too small.
    pub min_size: f32,
    /// Whether what is hidden by `Visibility` gets no collider until it is shown:
    /// [`SkipReason::Hidden`](crate::SkipReason::Hidden). With the feature `bevy_gltf` only.
    /// Default false.
    pub hidden: bool,
    /// What is farther than this from every [`DecompositionFocus`](crate::DecompositionFocus) gets
    /// no collider until it is near: [`SkipReason::TooFar`](crate::SkipReason::TooFar). Dynamic
    /// bodies are frozen until then. Without a focus nothing is far. Default `None`: nothing is.
    pub focus_radius: Option<f32>,
    /// Whether a collider is dropped when it is farther than 1.25 times
    /// [`focus_radius`](Self::focus_radius); its hulls stay in the cache. Default false.
    pub drop_far: bool,
}

/// The collider that an entity has until its own is ready.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq)]
#[type_path = "hullwright"]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FallbackCollider {
    /// None.
    #[default]
    None,
    /// The convex hull of the mesh, made in the background too, but soon.
    ConvexHull,
    /// The box along the mesh's axes.
    BoundingBox,
}

/// Where work is done.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum Execution {
    /// On threads of the plugin's own.
    Background,
    /// On the main thread in slices, which end when the frame's budget is spent. A slice is a stage
    /// of the decomposition, or one resolution or threshold of the paper's method, so a frame may
    /// take longer than its budget.
    Slices,
    /// In a browser: decompositions and simplified surfaces in Web Workers, which run the module of
    /// the npm package from [`BudgetSettings::worker_folder`], all else in slices. A panic ends a
    /// worker, not the game.
    /// Without the files, for the paper's method, and in wasm outside a browser as
    /// [`Slices`](Self::Slices); elsewhere as [`Background`](Self::Background).
    Worker,
}

impl Execution {
    /// What it is on this platform.
    pub(crate) fn here(self) -> Self {
        match self {
            Self::Worker if HAS_THREADS => Self::Background,
            Self::Worker if cfg!(not(target_os = "unknown")) => Self::Slices,
            other => other,
        }
    }
}

/// Room for some 1,700 meshes of ten hulls: a hull of 24 vertices takes about 4 kB with its shape.
const DEFAULT_CACHE_BYTES: usize = 64 << 20;

/// Room for some 20,000 meshes of ten hulls, of about 12 kB each.
const DEFAULT_DISK_CACHE_BYTES: u64 = 256 << 20;

/// A sixteenth of a frame at 60 Hz.
const DEFAULT_FRAME_TIME: Duration = Duration::from_millis(1);

/// A quarter of a frame, where all work is done in it.
const FRAME_TIME_WITHOUT_THREADS: Duration = Duration::from_millis(4);

/// With a few microseconds each, about as long as the budget.
const DEFAULT_MAX_ATTACHED: usize = 64;

/// Longer than the pause between two frames of an animated scale, shorter than one notices.
const DEFAULT_SCALE_DELAY: Duration = Duration::from_millis(100);

/// Longer than most scenes take to load.
const DEFAULT_PATIENCE: Duration = Duration::from_secs(5);

impl Default for HullwrightSettings {
    fn default() -> Self {
        Self {
            fallback_collider: FallbackCollider::None,
            freeze_until_ready: true,
            warn_without_mesh_after: Some(DEFAULT_PATIENCE),
            exact_static_colliders: true,
            primitives: false,
            probe_radius: None,
            level_bound: None,
            contact_dispatcher: true,
            scale_delay: DEFAULT_SCALE_DELAY,
            budget: BudgetSettings::default(),
            cache: CacheSettings::default(),
            skip: SkipSettings::default(),
        }
    }
}

impl Default for BudgetSettings {
    fn default() -> Self {
        Self {
            execution: if HAS_THREADS { Execution::Background } else { Execution::Worker },
            worker_folder: "hullwright".into(),
            threads: 0,
            max_jobs: 0,
            frame_time: if HAS_THREADS { DEFAULT_FRAME_TIME } else { FRAME_TIME_WITHOUT_THREADS },
            max_attached_per_frame: DEFAULT_MAX_ATTACHED,
        }
    }
}

impl Default for CacheSettings {
    fn default() -> Self {
        Self { memory_bytes: DEFAULT_CACHE_BYTES, disk: None, disk_bytes: DEFAULT_DISK_CACHE_BYTES }
    }
}

/// The plugin's systems, in `PostUpdate` before Bevy propagates transforms, and before the physics
/// engine where that runs there too: before Rapier's `PhysicsSet::SyncBackend`, and Avian's
/// `PhysicsSystems::First`.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HullwrightSystems {
    /// New and changed tags, meshes and scales are detected.
    DetectChanges,
    /// Jobs finish and start.
    RunJobs,
    /// Colliders are attached and events sent.
    Attach,
    /// Hulls are drawn and counters become diagnostics, by `HullwrightDebugPlugin`; after Bevy
    /// propagates transforms.
    #[cfg(feature = "debug")]
    Debug,
}
