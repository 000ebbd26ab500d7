//! The command line `hullwright`: decomposes meshes into convex hulls, looks at
//! meshes, and measures hulls.
//!
//! Exit code 0 is success, 1 an error in the input or the work, 2 wrong usage.

mod arguments;
mod bake;
mod curve;
mod decompose;
mod inspect;
mod json;
mod measure;
mod output;
mod progress;
mod tables;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Concave triangle meshes into few convex hulls
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Decompose(decompose::Arguments),
    Curve(curve::Arguments),
    Bake(bake::Arguments),
    Inspect(inspect::Arguments),
    Measure(measure::Arguments),
}

/// Why the program ends with an error.
enum Failure {
    /// The arguments make no sense.
    Usage(String),
    /// The input or the work went wrong.
    Work(String),
}

fn main() -> ExitCode {
    let CommandLine { command } = CommandLine::parse();
    let result = match command {
        Command::Decompose(arguments) => decompose::run(&arguments),
        Command::Curve(arguments) => curve::run(&arguments),
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Measure(arguments) => measure::run(&arguments),
    };
    let (reason, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    output::print_error(&reason);
    ExitCode::from(code)
}
