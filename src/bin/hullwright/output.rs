//! Text for standard output and standard error, either of which may be closed at any time, and why
//! the program ends with an error.

use std::io::Write;

pub use hullwright::internals::terminal::{Failure, print, time};
use serde::Serialize;

/// Prints one line of JSON to standard output.
pub fn print_json(line: &impl Serialize) -> Result<(), Failure> {
    print(&serde_json::to_string(line).map_err(|error| format!("can't print: {error}"))?)
}

/// Prints one line to standard error, whatever the reason holds.
pub fn print_error(reason: &str) {
    let line: Vec<&str> = reason.lines().map(str::trim).collect();
    // There is nobody left to tell.
    let _ = writeln!(std::io::stderr(), "error: {}", line.join(" "));
}

/// A count with its noun, such as "1 hull" or "2 hulls".
pub fn count(number: usize, singular: &str, plural: &str) -> String {
    format!("{number} {}", if number == 1 { singular } else { plural })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_read_well() {
        assert_eq!(count(1, "hull", "hulls"), "1 hull");
        assert_eq!(count(0, "hull", "hulls"), "0 hulls");
    }
}
