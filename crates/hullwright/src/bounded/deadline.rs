//! What a deadline changes. It is soft: what a result needs is finished, the rest is left out.
//!
//! Where little time is left the surface is divided coarsely, and the search ends while there is
//! time to verify what it has found. Once there is a result, nothing is begun after the deadline,
//! and what was begun ends there.

use std::time::Duration;

use super::settings::Settings;
use crate::control::Control;
use crate::error::Error;

/// Where less time is left than this multiple of the solid's time, the surface is divided as by the
/// fastest preset.
const HURRIED_BELOW: f64 = 2.3;

/// Before a deadline, this multiple of the time of the stages before merging is kept for
/// finalizing, which takes 0.35 times as long in the median, and 1.5 times for one mesh of ten.
const KEPT_FOR_FINALIZING: f64 = 1.0;

/// The deadline of a control, and whether it has cut the work short.
pub(crate) struct Deadline {
    control: Control,
    has_result: bool,
    is_cut_short: bool,
}

impl Deadline {
    pub(crate) fn new(control: &Control) -> Self {
        Self { control: control.clone(), has_result: false, is_cut_short: false }
    }

    /// Settings for dividing the surface, where the solid has taken `taken`: hurried ones if little
    /// time is left.
    ///
    /// # Errors
    /// [`Error::DeadlineExceeded`] where a pass has a result: a hurried one would not be better.
    pub(crate) fn for_patches(
        &mut self,
        settings: &Settings,
        taken: Duration,
    ) -> Result<Settings, Error> {
        let needed = taken.mul_f64(HURRIED_BELOW);
        if self.control.time_left().is_none_or(|left| left >= needed) {
            return Ok(settings.clone());
        }
        if self.has_result {
            return Err(Error::DeadlineExceeded);
        }
        self.is_cut_short = true;
        Ok(settings.hurried())
    }

    /// A control for the search, whose deadline leaves time to verify; the stages before it have
    /// taken `taken`.
    pub(crate) fn for_search(&self, control: &Control, taken: Duration) -> Control {
        control.with_sooner_deadline(taken.mul_f64(KEPT_FOR_FINALIZING))
    }

    /// Notes whether the search ended at its deadline.
    pub(crate) fn end_search(&mut self, control: &Control) {
        self.is_cut_short |= control.is_past_deadline();
    }

    /// The result of a pass; `None` for one that ended at the deadline after another had a result.
    ///
    /// # Errors
    /// Those of the pass.
    pub(crate) fn end_pass<T>(&mut self, pass: Result<T, Error>) -> Result<Option<T>, Error> {
        let is_limit = self.control.check().is_err();
        match pass {
            Err(Error::DeadlineExceeded) if self.has_result && !is_limit => {
                self.is_cut_short = true;
                Ok(None)
            }
            pass => {
                self.has_result |= pass.is_ok();
                pass.map(Some)
            }
        }
    }

    /// Whether there is time for another pass.
    pub(crate) fn allows_another_pass(&mut self) -> bool {
        let is_past = self.control.is_past_deadline();
        self.is_cut_short |= is_past;
        !is_past
    }

    /// Whether work was left out.
    pub(crate) fn is_cut_short(&self) -> bool {
        self.is_cut_short
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Instant;
    use crate::mesh::Normalization;
    use crate::parameters::Parameters;

    fn minute() -> Duration {
        Duration::from_secs(60)
    }

    #[test]
    fn with_little_time_left_the_first_pass_is_hurried_and_a_further_one_ends() {
        let control = Control::new().with_deadline(Instant::now() + minute());
        let settings = &Settings::of_preset(&Parameters::default(), &Normalization::UNIT)[0];
        let mut deadline = Deadline::new(&control);
        let calm = deadline.for_patches(settings, minute() / 10).unwrap();
        assert!(calm.dissolve_attempts > 0 && !deadline.is_cut_short());
        let hurried = deadline.for_patches(settings, minute() / 2).unwrap();
        assert!(hurried.dissolve_attempts == 0 && deadline.is_cut_short());
        assert_eq!(deadline.end_pass(Ok(())), Ok(Some(())));
        let further = deadline.for_patches(settings, minute() / 2);
        assert_eq!(further.err(), Some(Error::DeadlineExceeded));
    }

    #[test]
    fn the_deadline_ends_a_further_pass_without_an_error() {
        let late = Err::<(), Error>(Error::DeadlineExceeded);
        let mut deadline = Deadline::new(&Control::new());
        assert_eq!(deadline.end_pass(late.clone()), Err(Error::DeadlineExceeded));
        assert_eq!(deadline.end_pass(Ok(())), Ok(Some(())));
        assert_eq!(deadline.end_pass(late), Ok(None));
        assert!(deadline.is_cut_short());
    }

    #[test]
    fn the_time_limit_and_cancelling_stay_errors() {
        let control = Control::new().with_time_limit(Instant::now());
        let mut deadline = Deadline::new(&control);
        assert_eq!(deadline.end_pass(Ok(())), Ok(Some(())));
        for error in [Error::DeadlineExceeded, Error::Cancelled] {
            assert_eq!(deadline.end_pass(Err::<(), Error>(error.clone())), Err(error));
        }
    }

    #[test]
    fn the_search_ends_early_enough_to_verify() {
        let control = Control::new().with_deadline(Instant::now() + minute());
        let mut deadline = Deadline::new(&control);
        deadline.end_search(&deadline.for_search(&control, minute() / 2));
        assert!(!deadline.is_cut_short() && deadline.allows_another_pass());
        deadline.end_search(&deadline.for_search(&control, 2 * minute()));
        assert!(deadline.is_cut_short());
    }
}
