//! A progress bar on standard error, shown after a second.

use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use hullwright::Control;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shorter work shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// How finely the bar can move.
const STEPS: u64 = 1000;

const TEMPLATE: &str = "{bar:32} {percent:>3} %  {msg}";

/// For work of unknown length.
const SPINNER: &str = "{spinner} {msg}, {elapsed}";

/// Between two frames of a spinner.
const TICK: Duration = Duration::from_millis(100);

/// Runs work that reports no progress, under a spinner if it takes long.
pub fn waiting<T>(message: &'static str, work: impl FnOnce() -> T) -> T {
    let bar = LateBar::new(SPINNER, Some(TICK));
    if let Some(Waiting { bar, .. }) = &bar.waiting {
        bar.set_message(message);
    }
    let result = work();
    bar.finish();
    result
}

/// A bar that appears late, and never where standard error is no terminal.
pub struct LateBar {
    waiting: Option<Waiting>,
}

struct Waiting {
    bar: ProgressBar,
    /// Dropped when the work is done.
    finished: Sender<()>,
    timer: JoinHandle<()>,
}

impl LateBar {
    pub fn start() -> Self {
        Self::new(TEMPLATE, None)
    }

    fn new(template: &str, tick: Option<Duration>) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { waiting: None };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let (finished, is_finished) = channel();
        let late = bar.clone();
        let timer = std::thread::spawn(move || {
            if is_finished.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                late.set_draw_target(ProgressDrawTarget::stderr());
                match tick {
                    Some(tick) => late.enable_steady_tick(tick),
                    None => late.tick(),
                }
            }
        });
        Self { waiting: Some(Waiting { bar, finished, timer }) }
    }

    /// A control that moves the bar.
    pub fn control(&self) -> Control {
        self.control_of_part(0, 1)
    }

    /// A control that moves the bar through one of several parts of the work.
    pub fn control_of_part(&self, part: usize, parts: usize) -> Control {
        match &self.waiting {
            None => Control::new(),
            Some(Waiting { bar, .. }) => {
                let bar = bar.clone();
                Control::new().with_progress(move |progress| {
                    bar.set_message(progress.stage.name());
                    let done = (part as f64 + f64::from(progress.fraction)) / parts as f64;
                    bar.set_position((done * STEPS as f64) as u64);
                })
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Some(Waiting { bar, finished, timer }) = self.waiting {
            drop(finished);
            // Else it might show the bar after it was taken away. Without it there is no bar.
            let _ = timer.join();
            bar.finish_and_clear();
        }
    }
}
