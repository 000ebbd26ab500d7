//! How far all work is: a resource for a loading screen, and run conditions.

use bevy::prelude::*;

use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::scene::hierarchy_status::{HierarchyStatus, HierarchyWork};
use crate::bevy::tag::status::DecompositionStatus;

/// How far all work is, from the first tag since everything was finished.
///
/// It is up to date after the plugin's systems, in `PostUpdate`. Whether all is done says
/// [`all_decompositions_done`] also for what was tagged since.
#[derive(Resource, Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionProgress {
    /// Entities that are finished, however they ended.
    pub finished: usize,
    /// Entities in all; scenes that are not there yet count as one.
    pub total: usize,
    /// Share of the work that is done, from 0 to 1, with jobs at work by their own progress. It never
    /// falls until all is finished.
    pub fraction: f32,
}

impl DecompositionProgress {
    /// Whether all is finished, or there was nothing to do.
    pub fn is_done(&self) -> bool {
        self.finished == self.total
    }
}

/// A run condition: nothing that is tagged waits or is at work, and no scene below a
/// [`ConvexDecompositionHierarchy`](crate::bevy::ConvexDecompositionHierarchy) is still to come. It looks
/// at every tagged entity, so it also knows those of this frame. O(tagged entities).
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # let mut app = App::new();
/// app.add_systems(Update, start_level.run_if(all_decompositions_done));
/// # fn start_level() {}
/// ```
pub fn all_decompositions_done(
    statuses: Query<&DecompositionStatus>,
    hierarchies: Query<&HierarchyStatus>,
) -> bool {
    hierarchies.iter().all(HierarchyStatus::is_finished)
        && statuses.iter().all(DecompositionStatus::is_finished)
}

/// A run condition: the opposite of [`all_decompositions_done`], for what a loading screen shows.
pub fn decompositions_pending(
    statuses: Query<&DecompositionStatus>,
    hierarchies: Query<&HierarchyStatus>,
) -> bool {
    !all_decompositions_done(statuses, hierarchies)
}

/// What must not reach 1 before all is finished.
const ALMOST: f32 = 0.999;

/// Sums up the work.
pub(crate) fn sum_up_progress(
    mut queue: ResMut<WorkQueue>,
    mut progress: ResMut<DecompositionProgress>,
    hierarchies: Query<&HierarchyWork>,
) {
    let to_come = hierarchies.iter().filter(|work| work.is_to_come()).count();
    let open = queue.unfinished.len() + to_come;
    if open == 0 {
        queue.entered = 0;
        if !progress.is_done() || progress.fraction < 1.0 {
            let total = progress.total;
            *progress = DecompositionProgress { finished: total, total, fraction: 1.0 };
        }
        return;
    }
    let total = queue.entered.max(queue.unfinished.len()) + to_come;
    let finished = total - open;
    let running: f32 =
        queue.jobs.iter().map(|job| job.shown_progress * job.entities.len() as f32).sum();
    let fraction = ((finished as f32 + running) / total as f32).min(ALMOST);
    let least = if progress.is_done() { 0.0 } else { progress.fraction };
    let now = DecompositionProgress { finished, total, fraction: fraction.max(least) };
    progress.set_if_neq(now);
}
