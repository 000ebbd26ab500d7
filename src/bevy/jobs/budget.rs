//! The time that the plugin's systems may take in a frame.

use std::time::Duration;

use bevy::platform::time::Instant;

use crate::bevy::tag::settings::HullwrightSettings;

/// What the systems of this frame have taken so far.
#[derive(Debug, Default)]
pub(crate) struct FrameTime {
    spent: Duration,
}

impl FrameTime {
    pub(crate) fn start_frame(&mut self) {
        self.spent = Duration::ZERO;
    }

    /// The time that a system may take: what the others have left of the frame's budget.
    pub(crate) fn budget(&self, settings: &HullwrightSettings) -> Budget {
        let length = settings.frame_budget.saturating_sub(self.spent);
        Budget { start: Instant::now(), length, has_started: false }
    }

    /// Adds what a system has taken.
    pub(crate) fn spend(&mut self, budget: &Budget) {
        self.spent += budget.start.elapsed();
    }
}

/// The time that one system may take in this frame.
pub(crate) struct Budget {
    start: Instant,
    length: Duration,
    has_started: bool,
}

impl Budget {
    /// Whether there is time for another piece of work; for the first there always is.
    pub(crate) fn allows_one(&mut self) -> bool {
        let allows = !self.has_started || self.start.elapsed() < self.length;
        self.has_started = true;
        allows
    }
}
