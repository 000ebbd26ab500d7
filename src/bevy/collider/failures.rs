//! Errors reach their entities: as statuses, as events, and in one line of the log.

use std::collections::BTreeMap;

use bevy::prelude::*;

use crate::bevy::collider::placement::Placements;
use crate::bevy::jobs::queue::{Failed, WorkQueue};
use crate::bevy::jobs::request::FailedRequest;
use crate::bevy::tag::describe::{Descriptions, asset_of, entities};
use crate::bevy::tag::outcomes::Outcomes;

/// Reports failures. However many entities fail of the same in a frame, the log has one line.
pub(crate) fn report_failures(
    mut queue: ResMut<WorkQueue>,
    placements: Placements,
    descriptions: Descriptions,
    mut outcomes: Outcomes,
) {
    if queue.failed.is_empty() {
        return;
    }
    // By their text: how many, and the first of them.
    let mut to_log: BTreeMap<String, (usize, String)> = BTreeMap::new();
    for Failed { entity, error, is_known } in std::mem::take(&mut queue.failed) {
        let Some(unfinished) = queue.unfinished.remove(&entity) else { continue };
        if !is_known {
            let asset = unfinished.request.as_ref().and_then(|request| asset_of(&request.input));
            let line = to_log.entry(error.to_string());
            line.or_insert_with(|| (0, descriptions.entity(entity, asset))).0 += 1;
        }
        if let Some(request) = unfinished.request {
            let baked = request.stretch;
            let failed = FailedRequest { request, error: error.clone() };
            if failed.depends_on_scale() {
                queue.detect_missed_scale(entity, &baked, placements.stretch(entity));
            }
            outcomes.commands.entity(entity).try_insert(failed);
        }
        outcomes.failed(entity, error);
    }
    for (text, (count, first)) in to_log {
        log::warn!("no convex decomposition for {}: {text}", entities(count, &first));
    }
}
