//! One collider, from its mesh to a shape, in steps: on a thread in the background, or step by step
//! on the main thread.

use std::sync::Arc;

use bevy::asset::UntypedAssetId;
use bevy::math::{Affine3A, DMat3, DVec3, Vec3A};
use bevy::tasks::futures_lite::future::yield_now;
use hullwright::hulls_format::{HullsFile, PlacedMesh};
use hullwright::{
    Control, Decomposer, Error, Hull, MassProperties, MeshView, Method, MethodReport,
    mass_properties_with, part_shares,
};
use hullwright_parry::ColliderError;
use hullwright_parry::parry3d::math::{Pose, Vector};
use hullwright_parry::parry3d::shape::{SharedShape, TriMeshFlags};

use super::baked::BakedScene;
use super::cache::{BuiltCollider, ColliderGeometry, GeometryCache, WorkClaim};
use super::elsewhere::{Answer, Lookup};
use super::level::{PlacedData, digest, simplified};
use super::platform::{DiskCache, Elsewhere, Hashing, Runner, look};
use super::progress::SharedProgress;
use super::request::{ContentKey, MapKey, MeshData};
use crate::tag::outcomes::{DecompositionError, HullSource};
use crate::tag::parameters::{Goal, PrimitiveKind};
use crate::tag::settings::HullwrightSettings;

/// What a task starts from.
pub(super) enum TaskInput {
    /// A mesh, and what to make of it.
    Mesh {
        data: MeshData,
        goal: Goal,
        /// Where its hulls may be found: then it is not decomposed, but waits again if they are not
        /// there.
        baked: Option<(UntypedAssetId, BakedScene)>,
    },
    /// Meshes of what never moves, whose surface may be found in a baked scene: otherwise it waits
    /// again.
    Surface { meshes: Vec<PlacedData>, goal: Goal, baked: (UntypedAssetId, BakedScene) },
    /// Known geometry, from which another shape is built.
    Geometry { key: ContentKey, geometry: Arc<ColliderGeometry>, source: HullSource },
}

/// How a task ends.
pub(super) type TaskResult = Result<TaskOutput, DecompositionError>;

/// How a step ends; `None` if there are more.
type StepResult = Result<Option<TaskOutput>, DecompositionError>;

/// What a task ends with.
#[derive(Debug)]
pub(super) enum TaskOutput {
    Built(BuiltCollider),
    /// It has to wait for a decomposition: another job is at work on the same content, or it was
    /// not where it may have been found.
    Wait(ContentKey),
}

/// Work that can be interrupted between its steps.
pub(super) struct DecompositionTask {
    /// What the first step takes.
    input: Option<TaskInput>,
    /// The hash of the mesh that the next step takes.
    hashing: Hashing,
    /// What later steps go on with.
    work: Option<InProgress>,
    map: Affine3A,
    cache: GeometryCache,
    memory_bytes: usize,
    disk_cache: Option<DiskCache>,
    primitives: bool,
    runner: Runner,
}

enum InProgress {
    Hulls(HullsInProgress),
    Surface(SurfaceInProgress),
}

struct HullsInProgress {
    place: Place,
    method: Method,
    data: MeshData,
    key: ContentKey,
    claim: WorkClaim,
}

/// A mesh that is simplified elsewhere. Nobody else makes the same meanwhile.
struct SurfaceInProgress {
    elsewhere: Elsewhere,
    bound: f32,
    data: MeshData,
    key: ContentKey,
    _claim: WorkClaim,
}

/// Where a mesh is decomposed.
enum Place {
    Here(Decomposer<MethodReport>),
    Elsewhere(Elsewhere),
}

impl DecompositionTask {
    pub(super) fn new(
        input: TaskInput,
        map: Affine3A,
        cache: GeometryCache,
        settings: &HullwrightSettings,
        progress: &SharedProgress,
    ) -> Self {
        let disk_cache = cache.on_disk(settings);
        let (memory_bytes, primitives) = (settings.cache.memory_bytes, settings.primitives);
        Self {
            input: Some(input),
            hashing: Hashing::new(),
            work: None,
            map,
            cache,
            memory_bytes,
            disk_cache,
            primitives,
            runner: Runner::new(&settings.budget, progress),
        }
    }

    /// Whether a step does no more than look for an answer.
    pub(super) fn awaits_answer(&self) -> bool {
        let is_elsewhere = |work: &InProgress| match work {
            InProgress::Hulls(work) => matches!(work.place, Place::Elsewhere(_)),
            InProgress::Surface(_) => true,
        };
        self.hashing.is_pending() || self.work.as_ref().is_some_and(is_elsewhere)
    }

    /// Runs to the end, and lets other tasks of the thread run between its steps.
    pub(super) async fn run(mut self, control: Control) -> TaskResult {
        loop {
            if control.is_cancelled() {
                return Err(Error::Cancelled.into());
            }
            if let Some(output) = self.step(&control)? {
                return Ok(output);
            }
            yield_now().await;
        }
    }

    /// Runs one step; `None` if there are more. A panic is an error.
    pub(super) fn step(&mut self, control: &Control) -> StepResult {
        contain_panics(|| match self.input.take() {
            Some(TaskInput::Geometry { key, geometry, source }) => {
                self.build(key, geometry, source)
            }
            Some(TaskInput::Surface { meshes, goal, baked: (id, scene) }) => {
                let meshes: Vec<PlacedMesh> = meshes.iter().map(PlacedData::name).collect();
                let key = ContentKey::of_mesh(digest(&meshes), &goal);
                let own = key.in_scene(id);
                if let Some(geometry) = self.cache.geometry(own) {
                    return self.build(own, geometry, HullSource::Baked);
                }
                match scene.surface(&meshes, goal.bound_of_triangles()) {
                    Some(data) => {
                        let geometry = ColliderGeometry::Triangles(data);
                        self.build(own, geometry.into(), HullSource::Baked)
                    }
                    None => Ok(Some(TaskOutput::Wait(key))),
                }
            }
            Some(TaskInput::Mesh { data, goal, baked }) => match self.hashing.hash(&data) {
                Some(hash) => {
                    let key = ContentKey::of_mesh(hash, &goal).in_parts(&data);
                    self.start(key, data, &goal, baked, control)
                }
                None => {
                    self.input = Some(TaskInput::Mesh { data, goal, baked });
                    Ok(None)
                }
            },
            None => match self.work.take().ok_or(Error::Finished)? {
                InProgress::Hulls(work) => self.decompose(work, control),
                InProgress::Surface(work) => self.simplify(work, control),
            },
        })
    }

    fn start(
        &mut self,
        key: ContentKey,
        data: MeshData,
        goal: &Goal,
        baked: Option<(UntypedAssetId, BakedScene)>,
        control: &Control,
    ) -> StepResult {
        if let Some((id, scene)) = baked {
            let own = key.in_scene(id);
            if let Some(geometry) = self.cache.geometry(own) {
                return self.build(own, geometry, HullSource::Baked);
            }
            return match scene.hulls(key) {
                Some(file) => self.build(own, hulls_in_parts(file, &data)?, HullSource::Baked),
                None => Ok(Some(TaskOutput::Wait(key))),
            };
        }
        if let Some(geometry) = self.cache.geometry(key) {
            return self.build(key, geometry, HullSource::Shared);
        }
        let Some(claim) = self.cache.claim(key) else {
            return Ok(Some(TaskOutput::Wait(key)));
        };
        let geometry = match goal {
            Goal::Triangles { bound: None, .. } => ColliderGeometry::Triangles(data).into(),
            Goal::Triangles { bound: Some(bound), .. } => {
                let bound = *bound;
                if let Some(elsewhere) = self.runner.simplify(&data, bound) {
                    let work = SurfaceInProgress { elsewhere, bound, data, key, _claim: claim };
                    self.work = Some(InProgress::Surface(work));
                    return Ok(None);
                }
                ColliderGeometry::Triangles(simplified(data, bound, control)?).into()
            }
            Goal::Primitive(kind) => ColliderGeometry::Primitive(*kind, data).into(),
            Goal::Hulls(method) => {
                let found = self.disk_cache.as_ref().map(|cache| look(cache, key));
                let place = match found.unwrap_or(Lookup::Missing) {
                    Lookup::Found(file) => {
                        return self.build(key, hulls_in_parts(*file, &data)?, HullSource::Disk);
                    }
                    Lookup::Pending(look) => Place::Elsewhere(look),
                    Lookup::Missing => self.place(&data, method, control)?,
                };
                let method = method.clone();
                let work = HullsInProgress { place, method, data, key, claim };
                self.work = Some(InProgress::Hulls(work));
                return Ok(None);
            }
        };
        self.build(key, geometry, HullSource::Decomposed)
    }

    fn place(
        &self,
        data: &MeshData,
        method: &Method,
        control: &Control,
    ) -> Result<Place, DecompositionError> {
        if let Some(started) = self.runner.decompose(data, method) {
            return Ok(Place::Elsewhere(started));
        }
        Ok(Place::Here(method.decomposer(data.view(), control)?))
    }

    fn decompose(&mut self, mut work: HullsInProgress, control: &Control) -> StepResult {
        let file = match &mut work.place {
            Place::Here(decomposer) => match decomposer.step()? {
                None => None,
                Some(decomposition) => {
                    let (data, solid) = (work.data.view(), work.method.solid());
                    let mass = mass_properties_with(data, &decomposition.hulls, 1.0, &solid)?;
                    Some(HullsFile::new("", &decomposition).with_mass_properties(mass))
                }
            },
            Place::Elsewhere(elsewhere) => match elsewhere.answer() {
                Answer::Pending => None,
                Answer::Made(file) => Some(*file),
                Answer::Found(file) => {
                    let geometry = hulls_in_parts(*file, &work.data)?;
                    return self.build(work.key, geometry, HullSource::Disk);
                }
                Answer::Missing => {
                    work.place = self.place(&work.data, &work.method, control)?;
                    None
                }
                // A surface is no answer to this.
                Answer::Refused | Answer::Simplified(_) => {
                    work.place = Place::Here(work.method.decomposer(work.data.view(), control)?);
                    None
                }
                Answer::Trapped => return Err(DecompositionError::Panicked),
            },
        };
        let Some(file) = file else {
            self.work = Some(InProgress::Hulls(work));
            return Ok(None);
        };
        let HullsInProgress { key, claim, data, .. } = work;
        if let Some(cache) = &self.disk_cache {
            cache.write(key, &file);
        }
        let output = self.build(key, hulls_in_parts(file, &data)?, HullSource::Decomposed);
        // Only now that the cache has the result: whoever waits for the claim looks there.
        drop(claim);
        output
    }

    fn simplify(&mut self, work: SurfaceInProgress, control: &Control) -> StepResult {
        let data = match work.elsewhere.answer() {
            Answer::Pending => {
                self.work = Some(InProgress::Surface(work));
                return Ok(None);
            }
            Answer::Trapped => return Err(DecompositionError::Panicked),
            Answer::Simplified(few) => few.in_parts_of(&work.data),
            // Hulls are no answer to this. An error comes again here.
            Answer::Found(_) | Answer::Missing | Answer::Made(_) | Answer::Refused => {
                simplified(work.data, work.bound, control)?
            }
        };
        let geometry = ColliderGeometry::Triangles(data);
        self.build(work.key, geometry.into(), HullSource::Decomposed)
    }

    fn build(
        &self,
        key: ContentKey,
        geometry: Arc<ColliderGeometry>,
        source: HullSource,
    ) -> StepResult {
        let shape = shape_of(&geometry, &self.map, self.primitives)?;
        let built = BuiltCollider { key, geometry, shape, source };
        self.cache.insert(&built, MapKey::new(&self.map), self.memory_bytes);
        Ok(Some(TaskOutput::Built(built)))
    }
}

/// Hulls, with what they are made of where there are several parts. By their shapes alone, so that
/// it is the same for those that come from a cache.
fn hulls_in_parts(
    file: HullsFile,
    data: &MeshData,
) -> Result<Arc<ColliderGeometry>, DecompositionError> {
    // A baked file may hold the shares by the decomposition's own triangles, which are exact.
    let is_known = file.parts.len() == data.part_ends.len();
    if data.part_ends.len() < 2 || is_known {
        return Ok(ColliderGeometry::of_hulls(file, Vec::new()));
    }
    let parts: Vec<u32> =
        (0..data.triangles.len() as u32).map(|triangle| data.part_of(triangle) as u32).collect();
    let shapes: Vec<Hull> = file.hulls.iter().map(|hull| hull.shape.clone().into()).collect();
    let shares = part_shares(data.view(), &parts, &shapes)?;
    Ok(ColliderGeometry::of_hulls(file, shares))
}

fn shape_of(
    geometry: &ColliderGeometry,
    map: &Affine3A,
    primitives: bool,
) -> Result<SharedShape, DecompositionError> {
    let matrix = map.matrix3;
    let scale = [matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z];
    let is_scale = *map == Affine3A::from_scale(scale.into());
    match geometry {
        ColliderGeometry::Hulls(file, _) if is_scale => Ok(match primitives {
            true => hullwright_parry::shape_with_primitives(file, scale)?,
            false => hullwright_parry::shape(&file.hulls, scale)?,
        }),
        ColliderGeometry::Hulls(file, _) => {
            // A map that flattens leaves no body.
            if !(map.is_finite() && matrix.determinant().is_normal()) {
                let scale = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec3A::length);
                return Err(ColliderError::InvalidScale { scale }.into());
            }
            let (place, hulls) = (map_point(map), file.hulls.iter());
            let hulls: Vec<Vec<[f64; 3]>> = hulls
                .map(|hull| hull.shape.points.iter().map(|point| place(*point)).collect())
                .collect();
            Ok(hullwright_parry::shape_from_points(&hulls, [1.0; 3])?)
        }
        ColliderGeometry::Triangles(data) => triangle_mesh(data, map),
        ColliderGeometry::Primitive(kind, data) => Ok(primitive_around(*kind, data, map)?),
    }
}

/// Without it, what slides over a floor stumbles over the edges between its triangles. Two-sided,
/// since with one side things fall through triangles that a modeller wound the wrong way round.
const TRIANGLE_FLAGS: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED;

/// Parry's triangle mesh, for what doesn't move.
fn triangle_mesh(data: &MeshData, map: &Affine3A) -> Result<SharedShape, DecompositionError> {
    let place = |point: &[f32; 3]| map.transform_point3((*point).into()).to_array();
    let points: Vec<[f32; 3]> = data.positions.iter().map(place).collect();
    let mesh = MeshView::new(&points, &data.triangles);
    Ok(SharedShape::new(hullwright_parry::triangle_mesh(mesh, TRIANGLE_FLAGS)?))
}

/// The least thickness of a box, as a share of its longest side: a plane is a thin one.
const THINNEST: f32 = 1e-3;

/// The shape around a mesh that is moved by `map`, along the axes of the collider. O(size).
///
/// # Errors
/// If no point is finite, or all are one spot.
pub(crate) fn primitive_around(
    kind: PrimitiveKind,
    data: &MeshData,
    map: &Affine3A,
) -> Result<SharedShape, ColliderError> {
    let points: Vec<Vector> =
        data.used_points().map(|point| map.transform_point3(point.into())).collect();
    let (middle, half) = bounding_box(&points).ok_or(Error::NothingUsable {
        triangles: data.triangles.len(),
        degenerate: 0,
        non_finite: 0,
    })?;
    let half = half.max(Vector::splat(THINNEST * half.max_element()));
    let distances =
        |from: &dyn Fn(Vector) -> f32| points.iter().map(|p| from(*p)).fold(0.0, f32::max);
    let shape = match kind {
        PrimitiveKind::Cuboid => SharedShape::cuboid(half.x, half.y, half.z),
        // By the vertices, which lie on the surface of the ball that was meant, and not by the box,
        // which is smaller where no vertex lies on an axis.
        PrimitiveKind::Ball => SharedShape::ball(distances(&|point| (point - middle).length())),
        PrimitiveKind::Capsule => {
            // Of equal sides the first.
            let by_length = |a: &Vector, b: &Vector| half.dot(*a).total_cmp(&half.dot(*b));
            let axis = [Vector::Z, Vector::Y, Vector::X].into_iter().max_by(by_length);
            let axis = axis.unwrap_or(Vector::X);
            let radius = distances(&|point| (point - middle).reject_from_normalized(axis).length());
            let end = axis * (half.dot(axis) - radius).max(0.0);
            SharedShape::capsule(-end, end, radius)
        }
    };
    Ok(match middle == Vector::ZERO {
        true => shape,
        false => SharedShape::compound(vec![(Pose::from_translation(middle), shape)]),
    })
}

/// Middle and half sides of the box around points; `None` if that is no more than one spot.
fn bounding_box(points: &[Vector]) -> Option<(Vector, Vector)> {
    let low = points.iter().fold(Vector::INFINITY, |low, point| low.min(*point));
    let high = points.iter().fold(Vector::NEG_INFINITY, |high, point| high.max(*point));
    let half = (high - low) / 2.0;
    (half.is_finite() && half.max_element() > 0.0).then_some((low + half, half))
}

/// Mass properties of a body of the same density after it is moved by a map.
pub(crate) fn map_mass(properties: &MassProperties, map: &Affine3A) -> MassProperties {
    let linear = map.matrix3.as_dmat3();
    let volume = linear.determinant().abs();
    let inertia = DMat3::from_cols_array_2d(&properties.inertia);
    // Inertia is the trace of the second moments minus the second moments; these map as a
    // quadratic form.
    let trace = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
    let second = DMat3::from_diagonal(DVec3::splat(trace / 2.0)) - inertia;
    let second = linear * second * linear.transpose() * volume;
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - second;
    let mut mapped = *properties;
    mapped.mass *= volume;
    mapped.centre = map_point(map)(properties.centre);
    mapped.inertia = inertia.to_cols_array_2d();
    mapped
}

/// Where a map puts a point.
pub(crate) fn map_point(map: &Affine3A) -> impl Fn([f64; 3]) -> [f64; 3] + use<> {
    let (linear, offset) = (map.matrix3.as_dmat3(), map.translation.as_dvec3());
    move |point| (linear * DVec3::from(point) + offset).to_array()
}

/// Contains a panic to one job: it costs a collider, not the game. Where panics abort, as in
/// browsers, nothing can.
pub(crate) fn contain_panics<T>(
    run: impl FnOnce() -> Result<T, DecompositionError>,
) -> Result<T, DecompositionError> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run))
        .unwrap_or(Err(DecompositionError::Panicked))
}

#[cfg(test)]
mod tests {
    use bevy::tasks::block_on;
    use bevy::utils::default;

    use super::*;

    /// A decomposition that panics at its first sign of progress.
    fn panicking_task() -> (DecompositionTask, Control) {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let data = MeshData { positions, triangles, part_ends: Vec::new() };
        let input = TaskInput::Mesh { data, goal: Goal::Hulls(Method::default()), baked: None };
        let cache = GeometryCache::default();
        let task = DecompositionTask::new(
            input,
            Affine3A::IDENTITY,
            cache,
            &default(),
            &SharedProgress::default(),
        );
        (task, Control::new().with_progress(|_| panic!("on purpose, in a test")))
    }

    #[test]
    fn a_panic_is_an_error_that_says_so_in_the_background_and_in_slices() {
        let (task, control) = panicking_task();
        let result = block_on(task.run(control));
        assert!(matches!(result, Err(DecompositionError::Panicked)), "{result:?}");
        let (mut task, control) = panicking_task();
        let result = (0..100).find_map(|_| task.step(&control).transpose());
        assert!(matches!(result, Some(Err(DecompositionError::Panicked))), "{result:?}");
        assert!(DecompositionError::Panicked.to_string().contains("panicked"));
    }

    #[test]
    fn an_error_stays_what_it_is() {
        let result = contain_panics(|| Err::<(), _>(DecompositionError::NoPositions));
        assert!(matches!(result, Err(DecompositionError::NoPositions)), "{result:?}");
    }

    #[test]
    fn what_panicked_can_be_tried_again() {
        let (mut task, control) = panicking_task();
        let cache = task.cache.clone();
        while let Ok(None) = task.step(&control) {}
        let (mut again, _) = panicking_task();
        again.cache = cache;
        let control = Control::new();
        let result = (0..100).find_map(|_| again.step(&control).transpose());
        assert!(matches!(result, Some(Ok(TaskOutput::Built(_)))), "{result:?}");
    }
}
