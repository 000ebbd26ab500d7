//! Progress, cancellation and deadline of a running decomposition.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::error::Error;

// The clock, also in a browser, where that of the standard library panics.
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub(crate) use std::time::Instant;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub(crate) use web_time::Instant;

/// A stage of a decomposition.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Stage {
    /// Welding, repair, components.
    Repair,
    /// Flat openings are closed, and what lies within the solid is left out.
    Openings,
    /// The solid: its surface, and what is inside.
    Solid,
    /// The surface is divided into patches.
    Patches,
    /// Patches join into pieces; groups of the paper's method into larger ones (section 3.6).
    Merge,
    /// Few pieces are chosen that cover all patches.
    Cover,
    /// Pieces become verified hulls.
    Finalize,
    /// Hulls join until they keep the limit on their number.
    Limit,
    /// Triangles in one plane are merged, and detail below the bound goes; in the paper's method,
    /// simplification to the maximum resolutions (section 3.2).
    Simplify,
    /// Search over resolutions and planar thresholds (sections 3.4 and 3.5).
    Search,
    /// Convex hulls of the groups.
    Hulls,
    /// Source triangles are assigned to hulls.
    Assign,
}

impl Stage {
    /// The stage's name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Repair => "repair",
            Self::Openings => "openings",
            Self::Solid => "solid",
            Self::Patches => "patches",
            Self::Merge => "merge",
            Self::Cover => "cover",
            Self::Finalize => "finalize",
            Self::Limit => "limit",
            Self::Simplify => "simplify",
            Self::Search => "search",
            Self::Hulls => "hulls",
            Self::Assign => "assign",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// How far the work has come.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// Share of the whole work that is done, from 0 to 1; it never falls.
    pub fraction: f32,
}

type Listener = Arc<dyn Fn(Progress) + Send + Sync>;

/// How work is executed: where progress is reported, what stops it, and whether it runs in
/// parallel. Clone it, keep one copy to cancel with, give the other to
/// [`decompose`](crate::decompose).
///
/// `Control::default()` reports nothing, never stops, and runs in parallel.
///
/// ```
/// use std::time::{Duration, Instant};
///
/// let control = hullwright::Control::new()
///     .with_progress(|progress| println!("{}: {:.0} %", progress.stage, 100.0 * progress.fraction))
///     .with_deadline(Instant::now() + Duration::from_secs(2));
/// let other = control.clone();
/// other.cancel();
/// assert!(control.is_cancelled());
/// ```
#[derive(Clone, Default)]
pub struct Control {
    cancelled: Arc<AtomicBool>,
    is_serial: bool,
    deadline: Option<Instant>,
    time_limit: Option<Instant>,
    max_triangles: Option<usize>,
    listener: Option<Listener>,
}

impl Control {
    /// Reports nothing, never stops until [`cancel`](Self::cancel) is called, and runs in parallel.
    pub fn new() -> Self {
        Self::default()
    }

    /// Calls `listener` whenever the work has come further. It may be called from any thread of
    /// the pool, and should return at once.
    #[must_use]
    pub fn with_progress(mut self, listener: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        self.listener = Some(Arc::new(listener));
        self
    }

    /// At `deadline` the best valid result so far is returned. It is soft: optional work is left
    /// out, and what the result needs is finished, with its bound and limits. Where little time is
    /// left, the surface is divided as coarsely as by [`Preset::Fast`](crate::Preset::Fast), and
    /// the search ends so that there is time to verify what it has found. That takes about half of
    /// the time without a deadline: a result within less is late. For a hard stop see
    /// [`with_time_limit`](Self::with_time_limit).
    ///
    /// Only [`surface::decompose`](crate::surface::decompose()) on several threads can have nothing
    /// valid by then, and returns [`Error::DeadlineExceeded`]: it starts no threshold after the
    /// deadline. On one thread it finishes its first threshold, whatever the time.
    ///
    /// In a browser, where [`std::time::Instant`] panics, it is an `Instant` of the crate
    /// `web-time` 1, which is also that of `bevy::platform::time`.
    #[must_use]
    pub fn with_deadline(mut self, deadline: Instant) -> Self {
        self.deadline = Some(deadline);
        self
    }

    /// Past `limit` the work ends with [`Error::DeadlineExceeded`], as soon as it would when
    /// cancelled and wherever it is. Together with a deadline, which ends in a result, it is set
    /// somewhat later.
    ///
    /// ```
    /// use std::time::{Duration, Instant};
    ///
    /// // An upload may take a second, or two if that yields a result.
    /// let now = Instant::now();
    /// let control = hullwright::Control::new()
    ///     .with_deadline(now + Duration::from_secs(1))
    ///     .with_time_limit(now + Duration::from_secs(2))
    ///     .with_max_triangles(1_000_000);
    /// # assert!(!control.is_past_deadline());
    /// ```
    #[must_use]
    pub fn with_time_limit(mut self, limit: Instant) -> Self {
        self.time_limit = Some(limit);
        self
    }

    /// Meshes with more triangles are refused before any of them is looked at, with
    /// [`Error::TooLarge`]. It limits memory: `docs/reliability.md` has the bytes per triangle.
    #[must_use]
    pub fn with_max_triangles(mut self, limit: usize) -> Self {
        self.max_triangles = Some(limit);
        self
    }

    /// Whether independent parts of the work run on rayon's current pool (feature `parallel`), as
    /// they do by default. The result does not depend on it.
    #[must_use]
    pub fn with_parallel(mut self, is_parallel: bool) -> Self {
        self.is_serial = !is_parallel;
        self
    }

    /// Whether independent parts of the work run on rayon's current pool.
    pub fn is_parallel(&self) -> bool {
        !self.is_serial
    }

    /// Stops the work, also that of every clone: it returns [`Error::Cancelled`] soon after.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether [`cancel`](Self::cancel) was called on this control or a clone of it.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Whether the deadline has passed.
    pub fn is_past_deadline(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// The same with a deadline, if there is one, that is `by` so much sooner.
    pub(crate) fn with_sooner_deadline(&self, by: Duration) -> Self {
        let sooner = |deadline: Instant| deadline.checked_sub(by).unwrap_or_else(Instant::now);
        Self { deadline: self.deadline.map(sooner), ..self.clone() }
    }

    /// The same with a time limit at the deadline.
    pub(crate) fn with_hard_deadline(&self) -> Self {
        let limits = [self.time_limit, self.deadline];
        Self { time_limit: limits.into_iter().flatten().min(), ..self.clone() }
    }

    /// Time until the deadline, if there is one.
    pub(crate) fn time_left(&self) -> Option<Duration> {
        self.deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()))
    }

    /// An error once the work is cancelled, or past the time limit.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.is_cancelled() {
            Err(Error::Cancelled)
        } else if self.time_limit.is_some_and(|limit| Instant::now() >= limit) {
            Err(Error::DeadlineExceeded)
        } else {
            Ok(())
        }
    }

    /// An error for a mesh above the limit.
    pub(crate) fn admit(&self, triangles: usize) -> Result<(), Error> {
        match self.max_triangles {
            Some(limit) if triangles > limit => {
                Err(Error::TooLarge { what: "triangles", count: triangles, limit })
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn report(&self, stage: Stage, fraction: f32) {
        if let Some(listener) = &self.listener {
            listener(Progress { stage, fraction });
        }
    }
}

impl fmt::Debug for Control {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Control")
            .field("cancelled", &self.is_cancelled())
            .field("deadline", &self.deadline)
            .field("time_limit", &self.time_limit)
            .field("max_triangles", &self.max_triangles)
            .field("parallel", &self.is_parallel())
            .field("progress", &self.listener.is_some())
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sooner_deadline_passes_sooner_and_is_cancelled_with_the_other() {
        let minute = Duration::from_secs(60);
        let control = Control::new().with_deadline(Instant::now() + minute);
        let sooner = control.with_sooner_deadline(2 * minute);
        assert!(sooner.is_past_deadline() && !control.is_past_deadline());
        assert!(!control.with_sooner_deadline(minute / 2).is_past_deadline());
        assert!(!Control::new().with_sooner_deadline(minute).is_past_deadline());
        control.cancel();
        assert!(sooner.is_cancelled());
    }

    #[test]
    fn a_hard_deadline_is_a_time_limit_and_delays_none() {
        let now = Instant::now();
        let past = |control: Control| control.with_hard_deadline().check();
        assert_eq!(past(Control::new()), Ok(()));
        assert_eq!(past(Control::new().with_deadline(now)), Err(Error::DeadlineExceeded));
        let later = now + Duration::from_secs(60);
        assert_eq!(past(Control::new().with_deadline(later)), Ok(()));
        let limited = Control::new().with_deadline(later).with_time_limit(now);
        assert_eq!(past(limited), Err(Error::DeadlineExceeded));
        let left = Control::new().with_deadline(later).time_left();
        assert!(left.is_some_and(|left| left > Duration::ZERO));
        assert_eq!(Control::new().time_left(), None);
    }
}
