//! What users see of an entity: its status, the counters, and the one event in which its tag ends.

use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::bevy::jobs::cache::ColliderGeometry;
use crate::bevy::jobs::queue::Completed;
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::events::{
    DecompositionCancelled, DecompositionFailed, DecompositionReady, DecompositionSkipped,
    VerifiedError,
};
use crate::bevy::tag::status::{
    DecompositionCounters, DecompositionStatus, HullSource, SkipReason,
};
use crate::hulls_format::HullsFile;

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

    fn end(&mut self, entity: Entity, status: DecompositionStatus) {
        if let Ok(mut old) = self.statuses.get_mut(entity) {
            *old = status;
        }
    }

    /// A collider is attached: of hulls, or of triangles, which counts as skipped.
    pub(crate) fn ready(&mut self, completed: &Completed, time: Duration) {
        let entity = completed.entity;
        if let Some(reason) = completed.request.why_triangles() {
            return self.skipped(entity, reason);
        }
        let source = completed.built.source;
        match source {
            HullSource::Decomposed => {}
            HullSource::Shared => self.counters.shared += 1,
            HullSource::Disk => self.counters.from_disk += 1,
            HullSource::Baked => self.counters.baked += 1,
        }
        let (hulls, error) = match &*completed.built.geometry {
            ColliderGeometry::Triangles(_) => (0, None),
            ColliderGeometry::Primitive(..) => (1, None),
            ColliderGeometry::Hulls(file) => (file.hulls.len(), verified_error(file)),
        };
        self.counters.convex += usize::from(hulls == 1);
        self.end(entity, DecompositionStatus::Ready(source));
        self.commands.trigger(DecompositionReady { entity, hulls, error, source, time });
    }

    pub(crate) fn skipped(&mut self, entity: Entity, reason: SkipReason) {
        self.counters.count_skipped(reason);
        self.end(entity, DecompositionStatus::Skipped(reason));
        self.commands.trigger(DecompositionSkipped { entity, reason });
    }

    pub(crate) fn failed(&mut self, entity: Entity, error: DecompositionError) {
        self.counters.failed += 1;
        self.end(entity, DecompositionStatus::Failed(error.clone()));
        self.commands.trigger(DecompositionFailed { entity, error });
    }

    pub(crate) fn cancelled(&mut self, entity: Entity) {
        self.counters.cancelled += 1;
        self.end(entity, DecompositionStatus::Cancelled);
        self.commands.trigger(DecompositionCancelled { entity });
    }
}

fn verified_error(file: &HullsFile) -> Option<VerifiedError> {
    let errors = file.verified?;
    let share = |length: f64| (length / file.diagonal) as f32;
    let (protrusion, uncovered) = (share(errors.protrusion_max), share(errors.uncovered_max));
    Some(VerifiedError { protrusion, uncovered })
}
