//! A progress bar on standard error, for a person who waits longer than a second.

use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use hullwright::Control;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work that is done sooner shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// How finely the bar can move.
const STEPS: u64 = 1000;

const TEMPLATE: &str = "{bar:32} {percent:>3} %  {msg}";

/// A bar that appears late, and never where standard error is no terminal.
pub struct LateBar {
    bar: Option<(ProgressBar, Sender<()>)>,
}

impl LateBar {
    pub fn start() -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { bar: None };
        }
        let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            bar.set_style(style);
        }
        let (finished, is_finished) = channel();
        let waiting = bar.clone();
        std::thread::spawn(move || {
            if is_finished.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                waiting.set_draw_target(ProgressDrawTarget::stderr());
                waiting.tick();
            }
        });
        Self { bar: Some((bar, finished)) }
    }

    /// A control that moves the bar.
    pub fn control(&self) -> Control {
        match &self.bar {
            None => Control::new(),
            Some((bar, _)) => {
                let bar = bar.clone();
                Control::new().with_progress(move |progress| {
                    bar.set_message(progress.stage.name());
                    bar.set_position((f64::from(progress.fraction) * STEPS as f64) as u64);
                })
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Some((bar, finished)) = self.bar {
            drop(finished);
            bar.finish_and_clear();
        }
    }
}
