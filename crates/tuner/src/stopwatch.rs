//! Where the time of a frame goes: the longest one is kept, part by part.

use std::time::{Duration, Instant};

use bevy::app::MainScheduleOrder;
use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;
use bevy_rapier3d::prelude::PhysicsSet;

/// What lies between one frame's systems and the next one's: drawing, and waiting for it.
const BETWEEN: &str = "between frames";

/// Parts that take less than this share of a frame are not named.
const NAMED_SHARE: f32 = 0.1;

/// A schedule that only marks the end of the one before.
#[derive(ScheduleLabel, Debug, Clone, PartialEq, Eq, Hash)]
struct After(&'static str);

/// Measures every frame, from mark to mark.
pub struct StopwatchPlugin;

impl Plugin for StopwatchPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Stopwatch>();
        mark_end(app, First, "first");
        mark_end(app, PreUpdate, "input");
        mark_end(app, RunFixedMainLoop, "fixed");
        mark_end(app, Update, "other updates");
        mark_end(app, PostUpdate, "places and visibility");
        mark_end(app, Last, "tour");
        app.add_systems(First, begin).add_systems(
            PostUpdate,
            (
                mark("layout").before(PhysicsSet::SyncBackend),
                mark("bodies to Rapier")
                    .after(PhysicsSet::SyncBackend)
                    .before(PhysicsSet::StepSimulation),
                mark("Rapier").after(PhysicsSet::StepSimulation).before(PhysicsSet::Writeback),
                mark("bodies from Rapier").after(PhysicsSet::Writeback),
            ),
        );
    }
}

fn mark_end(app: &mut App, schedule: impl ScheduleLabel, part: &'static str) {
    app.init_schedule(After(part)).add_systems(After(part), mark(part));
    app.world_mut().resource_mut::<MainScheduleOrder>().insert_after(schedule, After(part));
}

/// The frame that runs, and the longest so far.
#[derive(Resource, Default)]
pub struct Stopwatch {
    last: Option<Instant>,
    frame: Frame,
    longest: Frame,
    last_length: Option<Duration>,
    /// Frames that are not measured, with the one that runs.
    skipped: usize,
}

/// The parts of a frame.
#[derive(Debug, Clone, Default)]
pub struct Frame(Vec<(&'static str, Duration)>);

impl Frame {
    /// How long it took.
    pub fn length(&self) -> Duration {
        self.0.iter().map(|(_, time)| *time).sum()
    }

    /// Its length and its greatest parts, in milliseconds.
    pub fn describe(&self) -> String {
        let whole = self.length();
        let mut parts: Vec<_> =
            self.0.iter().filter(|(_, time)| *time > whole.mul_f32(NAMED_SHARE)).collect();
        parts.sort_by_key(|(_, time)| std::cmp::Reverse(*time));
        let parts: Vec<_> =
            parts.iter().map(|(part, time)| format!("{part} {}", time.as_millis())).collect();
        format!("{} ms ({})", whole.as_millis(), parts.join(", "))
    }
}

impl Stopwatch {
    fn mark(&mut self, part: &'static str) {
        let now = Instant::now();
        let time = self.last.map_or(Duration::ZERO, |last| now - last);
        self.last = Some(now);
        match self.frame.0.iter_mut().find(|(name, _)| *name == part) {
            Some((_, sum)) => *sum += time,
            None => self.frame.0.push((part, time)),
        }
    }

    /// The frame before this one ends here.
    fn begin(&mut self) {
        self.mark(BETWEEN);
        let frame = std::mem::take(&mut self.frame);
        self.last_length = (self.skipped == 0).then(|| frame.length());
        if self.last_length.is_some_and(|length| length > self.longest.length()) {
            self.longest = frame;
        }
        self.skipped = self.skipped.saturating_sub(1);
    }

    /// How long the frame before took, if it was measured.
    pub fn last_length(&self) -> Option<Duration> {
        self.last_length
    }

    /// The longest frame since this was last asked for.
    pub fn take_longest(&mut self) -> Frame {
        std::mem::take(&mut self.longest)
    }

    /// Leaves out the frame that runs, and the next: it waits until this one is drawn.
    pub fn skip(&mut self) {
        self.skipped = 2;
    }
}

fn begin(mut stopwatch: ResMut<Stopwatch>) {
    stopwatch.begin();
}

/// A system that ends a part of the frame.
pub fn mark(part: &'static str) -> impl FnMut(ResMut<Stopwatch>) {
    move |mut stopwatch| stopwatch.mark(part)
}
