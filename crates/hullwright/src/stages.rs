//! How stages run: one after the other, each reported, timed, and stopped where `Control` says so.
//!
//! A decomposition is one `async` function. [`Stages::run`] and [`Stages::run_slice`] are its only
//! `await`s that may return `Pending`: whoever polls it may do something else between two stages.

use std::future::poll_fn;
use std::ops::Range;
use std::task::Poll;
use std::time::Duration;

use crate::control::{Control, Instant, Stage};
use crate::decomposition::StageTime;
use crate::error::Error;
use crate::parallel;

/// Stages in their order, and the share of their common work that is done before each.
pub(crate) type Plan = &'static [(Stage, f32)];

/// What every method begins with.
const PREPARE: Plan = &[(Stage::Repair, 0.0), (Stage::Openings, 0.7)];

/// A pass of the default method, by usual times on props and scans.
const PASS: Plan = &[
    (Stage::Simplify, 0.0),
    (Stage::Solid, 0.1),
    (Stage::Patches, 0.2),
    (Stage::Merge, 0.35),
    (Stage::Cover, 0.4),
    (Stage::Finalize, 0.6),
];

/// Hulls join until they keep the limit on their number.
pub(crate) const LIMIT: Plan = &[(Stage::Limit, 0.0)];

/// Hulls in the input's units.
pub(crate) const FINISH: Plan = &[(Stage::Finalize, 0.0)];

/// Shares of the whole that are done once the mesh is prepared, once the passes of the preset have
/// ended (where more may follow, for a limit on hulls), and once there are no more.
pub(crate) const PREPARED: f32 = 0.15;
pub(crate) const SEARCHED: f32 = 0.7;
pub(crate) const FINISHED: f32 = 0.99;

/// The paper's method.
pub(crate) const SURFACE: Plan = &[
    (Stage::Simplify, 0.0),
    (Stage::Search, 0.35),
    (Stage::Merge, 0.85),
    (Stage::Hulls, 0.86),
    (Stage::Assign, 0.95),
];

/// The hull of all points.
pub(crate) const HULL: Plan = &[(Stage::Hulls, 0.0), (Stage::Assign, 0.9)];

/// One of `count` equal parts of a part.
pub(crate) fn nth(part: Range<f32>, index: usize, count: usize) -> Range<f32> {
    let at = |index: usize| part.start + (part.end - part.start) * index as f32 / count as f32;
    at(index)..at(index + 1)
}

/// What the stages of one decomposition run under, and how far it has come.
pub(crate) struct Stages {
    given: Control,
    /// The given one; for an optional pass its deadline is a time limit.
    control: Control,
    plan: Plan,
    /// The part of the whole that the plan takes.
    part: Range<f32>,
    /// The last share that was reported.
    fraction: f32,
    times: Vec<StageTime>,
    /// The time that stages have taken since the plan began.
    taken: Duration,
    /// Whether a stage began after the deadline.
    is_late: bool,
}

impl Stages {
    /// Repair and openings come first.
    pub(crate) fn new(control: &Control) -> Self {
        Self {
            given: control.clone(),
            control: control.clone(),
            plan: PREPARE,
            part: 0.0..PREPARED,
            fraction: 0.0,
            times: Vec::new(),
            taken: Duration::ZERO,
            is_late: false,
        }
    }

    /// Goes on to the stages of `plan`, which take `part` of the whole.
    pub(crate) fn begin(&mut self, plan: Plan, part: Range<f32>) {
        (self.plan, self.part) = (plan, part);
        self.control = self.given.clone();
        self.taken = Duration::ZERO;
    }

    /// Goes on to the stages of a pass. Those of an optional one, without which there is a result,
    /// end at the deadline, with [`Error::DeadlineExceeded`].
    pub(crate) fn begin_pass(&mut self, part: Range<f32>, is_optional: bool) {
        self.begin(PASS, part);
        if is_optional {
            self.control = self.given.with_hard_deadline();
        }
    }

    /// Runs a stage, after a yield unless it is the first.
    ///
    /// # Errors
    /// Those of `work`, [`Error::Cancelled`] and [`Error::DeadlineExceeded`].
    pub(crate) async fn run<T>(
        &mut self,
        stage: Stage,
        work: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.run_slice(stage, 0.0, work).await
    }

    /// Runs a slice of a stage. `share` is the fraction of the stage that was done before.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub(crate) async fn run_slice<T>(
        &mut self,
        stage: Stage,
        share: f32,
        work: impl FnOnce() -> Result<T, Error>,
    ) -> Result<T, Error> {
        if !self.times.is_empty() {
            yield_once().await;
        }
        self.control.check()?;
        self.is_late |= self.control.is_past_deadline();
        self.fraction = self.fraction.max(self.share_before(stage, share));
        self.control.report(stage, self.fraction);
        let start = Instant::now();
        let result = parallel::with(self.control.is_parallel(), work);
        self.add_time(stage, start.elapsed());
        result
    }

    /// The share of the whole before a share of a stage.
    fn share_before(&self, stage: Stage, share: f32) -> f32 {
        let Some(index) = self.plan.iter().position(|&(planned, _)| planned == stage) else {
            return self.fraction;
        };
        let begin = self.plan[index].1;
        let end = self.plan.get(index + 1).map_or(1.0, |&(_, begin)| begin);
        let share = begin + share * (end - begin);
        self.part.start + share * (self.part.end - self.part.start)
    }

    fn add_time(&mut self, stage: Stage, taken: Duration) {
        self.taken += taken;
        let seconds = taken.as_secs_f64();
        match self.times.iter_mut().find(|time| time.stage == stage) {
            Some(time) => time.seconds += seconds,
            None => self.times.push(StageTime { stage, seconds }),
        }
    }

    /// The control of the current plan.
    pub(crate) fn control(&self) -> Control {
        self.control.clone()
    }

    /// The time that the stages of the current plan have taken.
    pub(crate) fn taken(&self) -> Duration {
        self.taken
    }

    /// Whether a stage began after the deadline.
    pub(crate) fn is_late(&self) -> bool {
        self.is_late
    }

    /// Reports the end. The wall-clock time of each stage.
    pub(crate) fn finish(self) -> Vec<StageTime> {
        if let Some(last) = self.times.last() {
            self.control.report(last.stage, 1.0);
        }
        self.times
    }
}

/// Returns `Pending` once. Nothing wakes the task: whoever polls does so when there is time for it.
async fn yield_once() {
    let mut has_yielded = false;
    poll_fn(|_| {
        if has_yielded {
            return Poll::Ready(());
        }
        has_yielded = true;
        Poll::Pending
    })
    .await;
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::decomposer::run_to_end;

    #[test]
    fn progress_never_falls_and_each_stage_has_one_time() {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let listener = Arc::clone(&seen);
        let control = Control::new().with_progress(move |progress| {
            listener.lock().unwrap().push((progress.stage, progress.fraction));
        });
        let mut stages = Stages::new(&control);
        run_to_end(async {
            for &(stage, _) in PREPARE {
                stages.run(stage, || Ok(())).await.unwrap();
            }
            for pass in 0..3 {
                stages.begin_pass(nth(PREPARED..SEARCHED, pass, 3), pass > 0);
                for &(stage, _) in PASS {
                    stages.run(stage, || Ok(())).await.unwrap();
                }
            }
            stages.begin(LIMIT, SEARCHED..FINISHED);
            stages.run(Stage::Limit, || Ok(())).await.unwrap();
        });
        let names: Vec<&str> = stages.finish().iter().map(|time| time.stage.name()).collect();
        let expected = "repair openings simplify solid patches merge cover finalize limit";
        assert_eq!(names.join(" "), expected);
        let seen = seen.lock().unwrap();
        assert!(seen.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert_eq!(seen.last(), Some(&(Stage::Limit, 1.0)));
    }

    #[test]
    fn only_an_optional_pass_ends_at_the_deadline() {
        let control = Control::new().with_deadline(Instant::now());
        for (is_optional, expected) in [(false, Ok(())), (true, Err(Error::DeadlineExceeded))] {
            let mut stages = Stages::new(&control);
            stages.begin_pass(0.0..1.0, is_optional);
            assert_eq!(run_to_end(stages.run(Stage::Solid, || Ok(()))), expected);
            assert_eq!(stages.is_late(), !is_optional);
        }
    }
}
