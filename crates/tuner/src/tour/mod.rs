//! A tour without a person: mouse and keys go to every control, each step writes a picture and
//! checks what came of it, and the longest frame is measured, all but the drawing.

mod hand;
mod seen;
mod steps;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Instant;

use bevy::prelude::*;
use hullwright_demos::picture::{PictureTaken, Shutter};

use hand::{Devices, Hand};
use seen::Seen;
pub use seen::Watched;
use steps::{Step, When, steps};

use crate::stopwatch::Stopwatch;

/// Frames for which all has to sleep.
const STILL_FRAMES: usize = 6;

/// Frames without a job after which a step that does not settle is taken as it is: half a minute of
/// a fall.
const MOST_FRAMES: usize = 600;

/// A job that has run for this long, in seconds, is slow.
const BUSY: f32 = 0.6;

/// What the tour is at.
#[derive(Resource)]
pub struct Tour {
    folder: PathBuf,
    steps: VecDeque<Step>,
    hand: Hand,
    state: State,
    before: Seen,
    began: Instant,
    judged: usize,
    failures: usize,
    frames: Frames,
}

enum State {
    /// Frames since the deeds, and for how many of them all was still.
    Waits(usize, usize),
    /// The picture is not there yet.
    Photographs,
    Over,
}

/// How long frames took, in seconds.
#[derive(Default)]
struct Frames {
    quiet: Vec<f32>,
    busy: Vec<f32>,
}

impl Tour {
    /// All steps, or those whose names are given, separated by commas; pictures go to the folder.
    pub fn new(folder: PathBuf, only: Option<&str>) -> Result<Self, String> {
        let mut steps: VecDeque<Step> = steps().into();
        if let Some(names) = only {
            let is_known = |name: &&str| steps.iter().any(|step| step.name == *name);
            if let Some(unknown) = names.split(',').find(|name| !is_known(name)) {
                return Err(format!("there is no step called {unknown}"));
            }
            steps.retain(|step| names.split(',').any(|name| name == step.name));
        }
        std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
        Ok(Self {
            folder,
            steps,
            hand: Hand::default(),
            // The first step begins with hulls.
            state: State::Waits(0, 0),
            before: Seen::default(),
            began: Instant::now(),
            judged: 0,
            failures: 0,
            frames: Frames::default(),
        })
    }

    fn is_ready(&mut self, watched: &Watched) -> bool {
        let (State::Waits(frames, still), Some(step)) = (&mut self.state, self.steps.front())
        else {
            return false;
        };
        *frames += usize::from(watched.busy_seconds().is_none());
        let is_settled = watched.is_current() && watched.is_still();
        *still = if is_settled { *still + 1 } else { 0 };
        if *frames >= MOST_FRAMES {
            let [linear, angular] = watched.speeds();
            let moves = format!("{linear:.3} m/s and {angular:.3} rad/s");
            println!("{}: not settled after {MOST_FRAMES} frames: {moves}", step.name);
            return true;
        }
        match step.when {
            When::Settled => *still >= STILL_FRAMES,
            When::Frames(most) => *frames >= most,
            When::Busy => watched.busy_seconds().is_some_and(|seconds| seconds > BUSY),
        }
    }

    fn judge(&mut self, step: &Step, now: Seen) {
        let holds = (step.holds)(&self.before, &now);
        let verdict = if holds { "yes" } else { "NO" };
        let seconds = self.began.elapsed().as_secs();
        println!("{seconds:>4} s  {}: {}: {verdict}", step.name, step.promise);
        self.judged += 1;
        if !holds {
            println!("  before {:?}\n  now {now:?}", self.before);
            self.failures += 1;
        }
        self.before = now;
    }

    /// The next step, if there is one.
    fn begin(&mut self) {
        for deed in self.steps.front().iter().flat_map(|step| &step.deeds) {
            self.hand.take_on(deed);
        }
        self.state = State::Waits(0, 0);
    }

    fn end(&mut self) -> AppExit {
        self.state = State::Over;
        println!("{} steps, {} failures", self.judged, self.failures);
        println!("frames without a job: {}", summary(&mut self.frames.quiet));
        println!("frames beside a job: {}", summary(&mut self.frames.busy));
        if self.failures == 0 { AppExit::Success } else { AppExit::error() }
    }
}

/// Median and longest, in milliseconds.
fn summary(frames: &mut [f32]) -> String {
    frames.sort_by(f32::total_cmp);
    let Some(longest) = frames.last() else { return "none".into() };
    let median = frames[frames.len() / 2];
    let [median, longest] = [median, *longest].map(|seconds| 1000.0 * seconds);
    format!("{}, median {median:.0} ms, longest {longest:.0} ms", frames.len())
}

/// Goes on with the tour.
#[allow(clippy::too_many_arguments)]
pub fn go_on(
    mut shutter: ResMut<Shutter>,
    mut tour: ResMut<Tour>,
    watched: Watched,
    mut devices: Devices,
    mut taken: MessageReader<PictureTaken>,
    mut exit: MessageWriter<AppExit>,
    mut stopwatch: ResMut<Stopwatch>,
    mut started: Local<bool>,
) {
    let tour = &mut *tour;
    if matches!(tour.state, State::Waits(..)) {
        let is_busy = watched.busy_seconds().is_some();
        let frames = if is_busy { &mut tour.frames.busy } else { &mut tour.frames.quiet };
        frames.extend(stopwatch.last_length().map(|length| length.as_secs_f32()));
    } else {
        // It is drawn, for the picture.
        stopwatch.skip();
    }
    if !std::mem::replace(&mut *started, true) {
        tour.begin();
    }
    if !tour.hand.is_idle() {
        if let Err(error) = tour.hand.go_on(&mut devices) {
            println!("{error}");
            tour.failures += 1;
        }
        return;
    }
    if tour.is_ready(&watched)
        && let Some(step) = tour.steps.pop_front()
    {
        shutter.take(&tour.folder.join(format!("{}.png", step.name)));
        tour.state = State::Photographs;
        // What is on the picture, and not what comes after it.
        tour.judge(&step, watched.look());
        println!("        longest frame {}", stopwatch.take_longest().describe());
        stopwatch.skip();
    }
    for picture in taken.read() {
        tour.failures += usize::from(picture.is_empty);
        if tour.steps.is_empty() {
            exit.write(tour.end());
        } else {
            tour.begin();
        }
    }
}
