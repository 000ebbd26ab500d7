//! Text for standard output and standard error, either of which may be closed at any time, and why
//! a program ends with an error.

use std::io::{ErrorKind, Write};

use hullwright::Error;
use hullwright::hulls_format::HullsFileError;

/// Why a program ends with an error.
pub enum Failure {
    /// The arguments make no sense: exit code 2.
    Usage(String),
    /// The input or the work went wrong: exit code 1.
    Work(String),
}

impl From<String> for Failure {
    fn from(reason: String) -> Self {
        Self::Work(reason)
    }
}

impl From<&str> for Failure {
    fn from(reason: &str) -> Self {
        Self::Work(reason.into())
    }
}

impl From<Box<dyn std::error::Error>> for Failure {
    fn from(error: Box<dyn std::error::Error>) -> Self {
        Self::Work(error.to_string())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Work(error.to_string())
    }
}

impl From<HullsFileError> for Failure {
    fn from(error: HullsFileError) -> Self {
        Self::Work(error.to_string())
    }
}

/// Prints lines to standard output. A reader that has gone away, such as `head`, is no error.
///
/// # Errors
/// [`Failure::Work`] if they can't be written.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Work(format!("can't print: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints one line of JSON to standard output.
///
/// # Errors
/// [`Failure::Work`] if it can't be written.
pub fn print_json(line: &serde_json::Value) -> Result<(), Failure> {
    print(&line.to_string())
}

/// Prints one line to standard error, whatever the reason holds.
pub fn print_error(reason: &str) {
    print_line("error", reason);
}

/// The same of what is wrong, and done all the same.
pub fn print_warning(reason: &str) {
    print_line("warning", reason);
}

fn print_line(kind: &str, reason: &str) {
    let line: Vec<&str> = reason.lines().map(str::trim).collect();
    // Where standard error is closed, nothing reads it.
    let _ = writeln!(std::io::stderr(), "{kind}: {}", line.join(" "));
}

/// A count with its noun, such as "1 hull" or "2 hulls".
pub fn count(number: usize, singular: &str, plural: &str) -> String {
    format!("{number} {}", if number == 1 { singular } else { plural })
}

/// A duration in few digits.
pub fn time(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.1} ms", seconds * 1000.0) } else { format!("{seconds:.2} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_read_well() {
        assert_eq!(count(1, "hull", "hulls"), "1 hull");
        assert_eq!(count(0, "hull", "hulls"), "0 hulls");
    }

    #[test]
    fn times_have_few_digits() {
        assert_eq!(time(0.0213), "21.3 ms");
        assert_eq!(time(1.5), "1.50 s");
    }
}
