//! What went wrong reaches its entities: as statuses, as events, and in one line of the log.

use std::collections::BTreeMap;
use std::sync::Arc;

use bevy::prelude::*;

use super::placement::Placements;
use super::resolve::has_absolute_unit;
use super::work::{Ask, Work};
use super::{
    DecompositionCounters, DecompositionFailed, DecompositionFailure, DecompositionStatus,
};

/// A failure on its way to its entity.
#[derive(Debug)]
pub(super) struct Failure {
    pub entity: Entity,
    pub why: DecompositionFailure,
    /// Whether the same input failed before, which was logged then.
    pub is_known: bool,
}

/// On entities that failed: what they wanted. Without it nobody would notice that it has changed
/// and may be had now.
#[derive(Component, Debug, Clone)]
pub(super) struct Rejected {
    pub ask: Arc<Ask>,
    why: DecompositionFailure,
}

impl Rejected {
    /// Whether an asset may be had now that it is there.
    pub(super) fn lacks_asset(&self) -> bool {
        self.why == DecompositionFailure::NotLoaded
    }

    /// Whether it may go better at another scale. A mesh that is bad in itself stays so.
    pub(super) fn depends_on_scale(&self) -> bool {
        let is_of_shape = matches!(
            self.why,
            DecompositionFailure::Collider(_) | DecompositionFailure::TriangleMesh(_)
        );
        is_of_shape || self.ask.parameters.as_ref().is_some_and(has_absolute_unit)
    }
}

/// Tells entities that they failed. However many fail of the same in a frame, the log has one line.
pub(super) fn report_failures(
    mut commands: Commands,
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    placements: Placements,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    if work.failures.is_empty() {
        return;
    }
    let mut news: BTreeMap<String, usize> = BTreeMap::new();
    for Failure { entity, why, is_known } in std::mem::take(&mut work.failures) {
        let Some(request) = work.requests.remove(&entity) else { continue };
        counters.failed += 1;
        if !is_known {
            *news.entry(why.to_string()).or_default() += 1;
        }
        if let Some(ask) = request.ask {
            let baked = ask.stretch;
            let rejected = Rejected { ask, why: why.clone() };
            if rejected.depends_on_scale() {
                work.notice_missed_scale(entity, &baked, placements.stretch(entity));
            }
            commands.entity(entity).try_insert(rejected);
        }
        if let Ok(mut status) = statuses.get_mut(entity) {
            *status = DecompositionStatus::Failed(why.clone());
        }
        commands.trigger(DecompositionFailed { entity, failure: why });
    }
    for (text, entities) in news {
        match entities {
            1 => log::warn!("no convex decomposition: {text}"),
            _ => log::warn!("no convex decomposition for {entities} entities: {text}"),
        }
    }
}
