//! The log of all tests together.

use std::sync::Mutex;

/// Keeps what is logged.
pub struct Log;

static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());

impl Log {
    pub fn install() {
        // Only the first succeeds, and one is enough.
        let _ = log::set_logger(&Self).map(|()| log::set_max_level(log::LevelFilter::Warn));
    }

    pub fn lines_with(text: &str) -> Vec<String> {
        LINES.lock().unwrap().iter().filter(|line| line.contains(text)).cloned().collect()
    }
}

impl log::Log for Log {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        LINES.lock().unwrap().push(record.args().to_string());
    }

    fn flush(&self) {}
}
