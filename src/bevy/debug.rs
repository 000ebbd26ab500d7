//! Every hull drawn in its own colour, and numbers among Bevy's diagnostics (feature `debug`).

use bevy::color::{Color, Hsla};
use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::gizmos::{AppGizmoBuilder, GizmoPlugin};
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::Collider;
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::Pose;
use bevy_rapier3d::rapier::parry::shape::TypedShape;

use crate::bevy::jobs::request::AttachedCollider;
use crate::bevy::plugin::HullwrightSystems;
use crate::bevy::tag::status::DecompositionCounters;

/// Draws the hulls of all colliders that the plugin made, and keeps its diagnostics.
///
/// Beside [`HullwrightPlugin`](crate::bevy::HullwrightPlugin). Lines are drawn where Bevy's `GizmoPlugin`
/// and `GizmoRenderPlugin` are, as in `DefaultPlugins`; on a server without them there are the
/// diagnostics alone.
#[derive(Debug, Clone, Copy, Default)]
pub struct HullwrightDebugPlugin;

/// Whether hulls are drawn; may be changed at any time.
#[derive(Resource, Reflect, Debug, Clone, Copy, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct HullwrightDebug {
    /// Default true.
    pub is_drawn: bool,
}

impl Default for HullwrightDebug {
    fn default() -> Self {
        Self { is_drawn: true }
    }
}

/// The lines' group, for their width and depth in Bevy's `GizmoConfigStore`.
#[derive(Default, Reflect, GizmoConfigGroup)]
#[type_path = "hullwright"]
pub struct HullGizmos;

impl HullwrightDebugPlugin {
    /// Jobs at work.
    pub const RUNNING: DiagnosticPath = DiagnosticPath::const_new("hullwright/running");
    /// Entities that wait, for their meshes or in the queue.
    pub const WAITING: DiagnosticPath = DiagnosticPath::const_new("hullwright/waiting");
    /// Decompositions made so far.
    pub const DECOMPOSED: DiagnosticPath = DiagnosticPath::const_new("hullwright/decomposed");
    /// Colliders whose hulls were made for another entity.
    pub const SHARED: DiagnosticPath = DiagnosticPath::const_new("hullwright/shared");
    /// Colliders whose hulls came from the cache on disk.
    pub const FROM_DISK: DiagnosticPath = DiagnosticPath::const_new("hullwright/from_disk");
    /// Colliders of baked hulls.
    pub const BAKED: DiagnosticPath = DiagnosticPath::const_new("hullwright/baked");
    /// Colliders that are a single hull.
    pub const CONVEX: DiagnosticPath = DiagnosticPath::const_new("hullwright/convex");
    /// Triangle meshes for fixed bodies.
    pub const TRIANGLE_MESHES: DiagnosticPath =
        DiagnosticPath::const_new("hullwright/triangle_meshes");
    /// Entities skipped because they had a collider.
    pub const HAD_COLLIDER: DiagnosticPath = DiagnosticPath::const_new("hullwright/had_collider");
    /// Entities skipped because they are hidden.
    pub const HIDDEN: DiagnosticPath = DiagnosticPath::const_new("hullwright/hidden");
    /// Entities skipped because they are too small.
    pub const TOO_SMALL: DiagnosticPath = DiagnosticPath::const_new("hullwright/too_small");
    /// Entities skipped because every focus is too far.
    pub const TOO_FAR: DiagnosticPath = DiagnosticPath::const_new("hullwright/too_far");
    /// Entities that failed.
    pub const FAILED: DiagnosticPath = DiagnosticPath::const_new("hullwright/failed");
    /// Entities whose work was cancelled.
    pub const CANCELLED: DiagnosticPath = DiagnosticPath::const_new("hullwright/cancelled");
    /// Decompositions in the cache in memory.
    pub const CACHED_COUNT: DiagnosticPath = DiagnosticPath::const_new("hullwright/cached_count");
    /// Size of the cache in memory, in MiB.
    pub const CACHED: DiagnosticPath = DiagnosticPath::const_new("hullwright/cached");
    /// The bound of the decomposition that was made last, in percent of its mesh's diagonal.
    pub const BOUND: DiagnosticPath = DiagnosticPath::const_new("hullwright/bound");
    /// The verified protrusion of its hulls, in percent of its mesh's diagonal.
    pub const PROTRUSION: DiagnosticPath = DiagnosticPath::const_new("hullwright/protrusion");
}

impl Plugin for HullwrightDebugPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HullwrightDebug>().register_type::<HullwrightDebug>();
        for (path, unit, _) in MEASURES {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(unit));
        }
        app.configure_sets(
            PostUpdate,
            HullwrightSystems::Debug
                .after(HullwrightSystems::Attach)
                .after(TransformSystems::Propagate),
        )
        .add_systems(
            PostUpdate,
            measure
                .in_set(HullwrightSystems::Debug)
                .run_if(resource_exists_and_changed::<DecompositionCounters>),
        );
    }

    fn finish(&self, app: &mut App) {
        // Its systems panic without the assets that Bevy's plugin brings; that may come after ours.
        if app.is_plugin_added::<GizmoPlugin>() {
            app.init_gizmo_group::<HullGizmos>().add_systems(
                PostUpdate,
                draw.in_set(HullwrightSystems::Debug)
                    .run_if(|debug: Res<HullwrightDebug>| debug.is_drawn),
            );
        }
    }
}

/// Turns of the colour wheel from one hull to the next: by the golden ratio neighbours differ and no
/// colour repeats soon.
const HUE_STEP: f32 = 0.618_034;

fn draw(
    mut gizmos: Gizmos<HullGizmos>,
    colliders: Query<(&Collider, &AttachedCollider, &GlobalTransform)>,
) {
    for (collider, attached, transform) in &colliders {
        let to_world = transform.affine() * attached.map.inverse();
        let parts = parts(&collider.raw);
        for (index, (pose, shape)) in parts.iter().enumerate() {
            let hue = (index as f32 * HUE_STEP).fract() * 360.0;
            let colour = Color::from(Hsla::hsl(hue, 0.9, 0.6));
            let place = Affine3A::from_rotation_translation(pose.rotation, pose.translation);
            draw_edges(&mut gizmos, shape, &(to_world * place), colour);
        }
    }
}

fn parts(shape: &SharedShape) -> Vec<(Pose, SharedShape)> {
    match shape.as_compound() {
        Some(compound) => compound.shapes().to_vec(),
        None => vec![(Pose::IDENTITY, shape.clone())],
    }
}

fn draw_edges(
    gizmos: &mut Gizmos<HullGizmos>,
    shape: &SharedShape,
    to_world: &Affine3A,
    colour: Color,
) {
    let mut line = |a: Vec3, b: Vec3| {
        gizmos.line(to_world.transform_point3(a), to_world.transform_point3(b), colour);
    };
    match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => {
            let points = hull.points();
            let corners = hull.vertices_adj_to_face();
            for face in hull.faces() {
                let first = face.first_vertex_or_edge as usize;
                let count = face.num_vertices_or_edges as usize;
                let Some(corners) = corners.get(first..first + count) else { continue };
                let next = corners.iter().cycle().skip(1);
                for (a, b) in corners.iter().zip(next) {
                    if let (Some(a), Some(b)) = (points.get(*a as usize), points.get(*b as usize)) {
                        line(*a, *b);
                    }
                }
            }
        }
        TypedShape::TriMesh(mesh) => {
            for triangle in mesh.triangles() {
                line(triangle.a, triangle.b);
                line(triangle.b, triangle.c);
                line(triangle.c, triangle.a);
            }
        }
        TypedShape::Cuboid(_) => {
            let bounds = shape.compute_local_aabb();
            let [low, high] = [bounds.mins, bounds.maxs];
            let corner = |index: usize| {
                let pick = |bit: usize, low: f32, high: f32| {
                    if index >> bit & 1 == 1 { high } else { low }
                };
                Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
            };
            for from in 0..8_usize {
                for to in (0..3).map(|bit| from | 1 << bit).filter(|to| *to != from) {
                    line(corner(from), corner(to));
                }
            }
        }
        _ => {}
    }
}

const MEBIBYTE: f64 = 1024.0 * 1024.0;

/// Diagnostics with their units.
type Measure = (DiagnosticPath, &'static str, fn(&DecompositionCounters) -> Option<f64>);

const MEASURES: [Measure; 18] = [
    (HullwrightDebugPlugin::RUNNING, "", |of| Some(of.running as f64)),
    (HullwrightDebugPlugin::WAITING, "", |of| Some((of.queued + of.waiting_for_mesh) as f64)),
    (HullwrightDebugPlugin::DECOMPOSED, "", |of| Some(of.decomposed as f64)),
    (HullwrightDebugPlugin::SHARED, "", |of| Some(of.shared as f64)),
    (HullwrightDebugPlugin::FROM_DISK, "", |of| Some(of.from_disk as f64)),
    (HullwrightDebugPlugin::BAKED, "", |of| Some(of.baked as f64)),
    (HullwrightDebugPlugin::CONVEX, "", |of| Some(of.convex as f64)),
    (HullwrightDebugPlugin::TRIANGLE_MESHES, "", |of| Some(of.triangle_meshes as f64)),
    (HullwrightDebugPlugin::HAD_COLLIDER, "", |of| Some(of.had_collider as f64)),
    (HullwrightDebugPlugin::HIDDEN, "", |of| Some(of.hidden as f64)),
    (HullwrightDebugPlugin::TOO_SMALL, "", |of| Some(of.too_small as f64)),
    (HullwrightDebugPlugin::TOO_FAR, "", |of| Some(of.too_far as f64)),
    (HullwrightDebugPlugin::FAILED, "", |of| Some(of.failed as f64)),
    (HullwrightDebugPlugin::CANCELLED, "", |of| Some(of.cancelled as f64)),
    (HullwrightDebugPlugin::CACHED_COUNT, "", |of| Some(of.cached as f64)),
    (HullwrightDebugPlugin::CACHED, " MiB", |of| Some(of.cached_bytes as f64 / MEBIBYTE)),
    (HullwrightDebugPlugin::BOUND, " %", |of| of.last_bound.map(percent)),
    (HullwrightDebugPlugin::PROTRUSION, " %", |of| of.last_protrusion.map(percent)),
];

fn percent(share: f32) -> f64 {
    100.0 * f64::from(share)
}

fn measure(mut diagnostics: Diagnostics, counters: Res<DecompositionCounters>) {
    for (path, _, value) in MEASURES {
        if let Some(value) = value(&counters) {
            diagnostics.add_measurement(&path, || value);
        }
    }
}
