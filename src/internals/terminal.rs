//! What the command and the laboratory need to print, and to say why they end with an error.

use std::io::{ErrorKind, Write};

use crate::error::Error;
use crate::hulls_format::HullsFileError;

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

/// A duration in few digits.
pub fn time(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.1} ms", seconds * 1000.0) } else { format!("{seconds:.2} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_few_digits() {
        assert_eq!(time(0.0213), "21.3 ms");
        assert_eq!(time(1.5), "1.50 s");
    }
}
