//! See it: every hull in its own colour, and numbers among Bevy's diagnostics (feature `debug`).

use bevy::color::{Color, Hsla};
use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::gizmos::AppGizmoBuilder;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::Collider;
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::Pose;
use bevy_rapier3d::rapier::parry::shape::TypedShape;

use super::attach::Attached;
use super::{DecompositionCounters, HullwrightSystems};

/// Draws the hulls of all colliders that the plugin made, and keeps its diagnostics.
///
/// Beside [`HullwrightPlugin`](super::HullwrightPlugin). Lines are drawn where Bevy's
/// `GizmoRenderPlugin` is, as in `DefaultPlugins`; without it they cost nothing to speak of.
#[derive(Debug, Clone, Copy, Default)]
pub struct HullwrightDebugPlugin;

/// Whether hulls are drawn; may be changed at any time.
#[derive(Resource, Reflect, Debug, Clone, Copy, PartialEq, Eq)]
#[reflect(Resource, Default, Clone, PartialEq)]
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
pub struct HullGizmos;

impl HullwrightDebugPlugin {
    /// Jobs at work.
    pub const RUNNING: DiagnosticPath = DiagnosticPath::const_new("hullwright/running");
    /// Entities that wait, for their meshes or in the queue.
    pub const WAITING: DiagnosticPath = DiagnosticPath::const_new("hullwright/waiting");
    /// Decompositions made so far.
    pub const DECOMPOSED: DiagnosticPath = DiagnosticPath::const_new("hullwright/decomposed");
    /// Entities that failed.
    pub const FAILED: DiagnosticPath = DiagnosticPath::const_new("hullwright/failed");
    /// Size of the cache in memory, in MiB.
    pub const CACHED: DiagnosticPath = DiagnosticPath::const_new("hullwright/cached");
    /// The bound of the decomposition that was made last, in percent of its mesh's diagonal.
    pub const BOUND: DiagnosticPath = DiagnosticPath::const_new("hullwright/bound");
    /// How far its hulls stand out at most, verified, in percent of its mesh's diagonal.
    pub const PHANTOM: DiagnosticPath = DiagnosticPath::const_new("hullwright/stands_out");
}

impl Plugin for HullwrightDebugPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HullwrightDebug>()
            .register_type::<HullwrightDebug>()
            .init_gizmo_group::<HullGizmos>()
            .register_diagnostic(Diagnostic::new(Self::RUNNING))
            .register_diagnostic(Diagnostic::new(Self::WAITING))
            .register_diagnostic(Diagnostic::new(Self::DECOMPOSED))
            .register_diagnostic(Diagnostic::new(Self::FAILED))
            .register_diagnostic(Diagnostic::new(Self::CACHED).with_suffix(" MiB"))
            .register_diagnostic(Diagnostic::new(Self::BOUND).with_suffix(" %"))
            .register_diagnostic(Diagnostic::new(Self::PHANTOM).with_suffix(" %"))
            .add_systems(
                PostUpdate,
                (
                    draw.run_if(|debug: Res<HullwrightDebug>| debug.is_drawn),
                    measure.run_if(resource_changed::<DecompositionCounters>),
                )
                    .after(HullwrightSystems::Attach)
                    .after(TransformSystems::Propagate),
            );
    }
}

/// Turns of the colour wheel from one hull to the next: the golden ratio, by which neighbours
/// differ and none comes again soon.
const HUE_STEP: f32 = 0.618_034;

fn draw(
    mut gizmos: Gizmos<HullGizmos>,
    colliders: Query<(&Collider, &Attached, &GlobalTransform)>,
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

fn measure(mut diagnostics: Diagnostics, counters: Res<DecompositionCounters>) {
    let waiting = counters.queued + counters.waiting_for_mesh;
    diagnostics.add_measurement(&HullwrightDebugPlugin::RUNNING, || counters.running as f64);
    diagnostics.add_measurement(&HullwrightDebugPlugin::WAITING, || waiting as f64);
    diagnostics.add_measurement(&HullwrightDebugPlugin::DECOMPOSED, || counters.decomposed as f64);
    diagnostics.add_measurement(&HullwrightDebugPlugin::FAILED, || counters.failed as f64);
    let cached = counters.cached_bytes as f64 / MEBIBYTE;
    diagnostics.add_measurement(&HullwrightDebugPlugin::CACHED, || cached);
    let percent = |share: f32| 100.0 * f64::from(share);
    if let Some(bound) = counters.last_bound {
        diagnostics.add_measurement(&HullwrightDebugPlugin::BOUND, || percent(bound));
    }
    if let Some(phantom) = counters.last_phantom {
        diagnostics.add_measurement(&HullwrightDebugPlugin::PHANTOM, || percent(phantom));
    }
}
