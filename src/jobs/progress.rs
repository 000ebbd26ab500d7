//! How far a job is, while it runs elsewhere.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use hullwright::Control;

/// A share of the work that another thread can read.
#[derive(Debug, Clone, Default)]
pub(super) struct SharedProgress(Arc<AtomicU32>);

impl SharedProgress {
    /// A control that reports here. One thread per job: several run at once, and the game needs
    /// threads too.
    pub(super) fn control(&self) -> Control {
        let cell = self.0.clone();
        Control::new().with_parallel(false).with_progress(move |progress| {
            cell.store(progress.fraction.to_bits(), Ordering::Relaxed)
        })
    }

    #[allow(dead_code, reason = "threads report by the control, workers here")]
    pub(super) fn set(&self, fraction: f32) {
        self.0.store(fraction.to_bits(), Ordering::Relaxed);
    }

    pub(super) fn get(&self) -> f32 {
        f32::from_bits(self.0.load(Ordering::Relaxed))
    }
}
