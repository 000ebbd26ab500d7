//! Colliders drawn, every hull in its own colour, and numbers among Bevy's diagnostics (feature
//! `debug`).

mod draw;

use bevy::diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy::gizmos::{AppGizmoBuilder, GizmoPlugin};
use bevy::prelude::*;

use self::draw::draw;
pub use self::draw::{HullGizmos, HullwrightDebug};
use super::tag::outcomes::DecompositionCounters;
use super::tag::settings::HullwrightSystems;

/// Draws colliders that the plugin made and marks what has none, by [`HullwrightDebug`], and keeps
/// its diagnostics.
///
/// Beside [`HullwrightPlugin`](crate::HullwrightPlugin). Lines are drawn where Bevy's `GizmoPlugin`
/// and `GizmoRenderPlugin` are, as in `DefaultPlugins`; on a server without them there are the
/// diagnostics alone.
#[derive(Debug, Clone, Copy, Default)]
pub struct HullwrightDebugPlugin;

/// Declares diagnostics: their paths, units and values.
macro_rules! diagnostics {
    ($($(#[doc = $doc:literal])* $name:ident = $path:literal, $unit:literal, $value:expr;)*) => {
        impl HullwrightDebugPlugin {
            $($(#[doc = $doc])*
            pub const $name: DiagnosticPath = DiagnosticPath::const_new($path);)*
        }

        const MEASURES: &[(DiagnosticPath, &str, fn(&DecompositionCounters) -> Option<f64>)] =
            &[$((HullwrightDebugPlugin::$name, $unit, $value)),*];
    };
}

diagnostics! {
    /// Jobs at work.
    RUNNING = "hullwright/running", "", |of| Some(of.running as f64);
    /// Entities that wait, for their meshes or in the queue.
    WAITING = "hullwright/waiting", "", |of| Some((of.queued + of.waiting_for_mesh) as f64);
    /// Decompositions made so far.
    DECOMPOSED = "hullwright/decomposed", "", |of| Some(of.decomposed as f64);
    /// Decompositions made with a probe so far.
    PROBED = "hullwright/probed", "", |of| Some(of.probed as f64);
    /// Colliders whose hulls were made for another entity.
    SHARED = "hullwright/shared", "", |of| Some(of.shared as f64);
    /// Colliders whose hulls came from the cache on disk.
    FROM_DISK = "hullwright/from_disk", "", |of| Some(of.from_disk as f64);
    /// Colliders of baked hulls.
    BAKED = "hullwright/baked", "", |of| Some(of.baked as f64);
    /// Colliders that are a single hull.
    CONVEX = "hullwright/convex", "", |of| Some(of.convex as f64);
    /// Triangle meshes for fixed bodies.
    TRIANGLE_MESHES = "hullwright/triangle_meshes", "", |of| Some(of.triangle_meshes as f64);
    /// Entities skipped because they had a collider.
    HAD_COLLIDER = "hullwright/had_collider", "", |of| Some(of.had_collider as f64);
    /// Entities skipped because they are hidden.
    HIDDEN = "hullwright/hidden", "", |of| Some(of.hidden as f64);
    /// Entities skipped because they are too small.
    TOO_SMALL = "hullwright/too_small", "", |of| Some(of.too_small as f64);
    /// Entities skipped because every focus is too far.
    TOO_FAR = "hullwright/too_far", "", |of| Some(of.too_far as f64);
    /// Entities that failed.
    FAILED = "hullwright/failed", "", |of| Some(of.failed as f64);
    /// Entities whose work was cancelled.
    CANCELLED = "hullwright/cancelled", "", |of| Some(of.cancelled as f64);
    /// Decompositions in the cache in memory.
    CACHED_COUNT = "hullwright/cached_count", "", |of| Some(of.cached as f64);
    /// Size of the cache in memory, in MiB.
    CACHED = "hullwright/cached", " MiB", |of| Some(of.cached_bytes as f64 / MEBIBYTE);
    /// The bound of the decomposition that was made last, in percent of its mesh's diagonal.
    BOUND = "hullwright/bound", " %", |of| of.last_bound.map(percent);
    /// The verified protrusion of its hulls, in percent of its mesh's diagonal.
    PROTRUSION = "hullwright/protrusion", " %", |of| of.last_protrusion.map(percent);
}

const MEBIBYTE: f64 = 1024.0 * 1024.0;

fn percent(share: f32) -> f64 {
    100.0 * f64::from(share)
}

impl Plugin for HullwrightDebugPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<HullwrightDebug>().register_type::<HullwrightDebug>();
        for (path, unit, _) in MEASURES {
            app.register_diagnostic(Diagnostic::new(path.clone()).with_suffix(*unit));
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

fn measure(mut diagnostics: Diagnostics, counters: Res<DecompositionCounters>) {
    for (path, _, value) in MEASURES {
        if let Some(value) = value(&counters) {
            diagnostics.add_measurement(path, || value);
        }
    }
}
