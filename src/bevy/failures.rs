//! Errors reach their entities: as statuses, as events, and in one line of the log.

use std::collections::BTreeMap;

use bevy::prelude::*;

use super::events::DecompositionFailed;
use super::placement::Placements;
use super::queue::{Failed, WorkQueue};
use super::request::FailedRequest;
use super::status::{DecompositionCounters, DecompositionStatus};

/// Reports failures. However many entities fail of the same in a frame, the log has one line.
pub(super) fn report_failures(
    mut commands: Commands,
    mut queue: ResMut<WorkQueue>,
    mut counters: ResMut<DecompositionCounters>,
    placements: Placements,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    if queue.failed.is_empty() {
        return;
    }
    let mut to_log: BTreeMap<String, usize> = BTreeMap::new();
    for Failed { entity, error, is_known } in std::mem::take(&mut queue.failed) {
        let Some(unfinished) = queue.unfinished.remove(&entity) else { continue };
        counters.failed += 1;
        if !is_known {
            *to_log.entry(error.to_string()).or_default() += 1;
        }
        if let Some(request) = unfinished.request {
            let baked = request.stretch;
            let failed = FailedRequest { request, error: error.clone() };
            if failed.depends_on_scale() {
                queue.detect_missed_scale(entity, &baked, placements.stretch(entity));
            }
            commands.entity(entity).try_insert(failed);
        }
        if let Ok(mut status) = statuses.get_mut(entity) {
            *status = DecompositionStatus::Failed(error.clone());
        }
        commands.trigger(DecompositionFailed { entity, error });
    }
    for (text, entities) in to_log {
        match entities {
            1 => log::warn!("no convex decomposition: {text}"),
            _ => log::warn!("no convex decomposition for {entities} entities: {text}"),
        }
    }
}
