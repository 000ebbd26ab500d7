//! The command line `hullwright`: decomposes meshes into convex hulls, inspects meshes, measures
//! hulls, and shows both.
//!
//! Exit code 0 is success; 1 a refusal, with one line on standard error that says why; 2 wrong
//! usage.

mod arguments;
mod bake;
mod curve;
mod decompose;
mod inspect;
mod measure;
mod measure_surface;
mod notes;
mod progress;
mod report;
mod simplify;
mod view;
mod view_simplified;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hullwright_cli::terminal::{Failure, print_error};

/// Approximate convex decomposition of triangle meshes
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Decompose(decompose::Arguments),
    View(view::Arguments),
    Inspect(inspect::Arguments),
    Measure(measure::Arguments),
    Curve(curve::Arguments),
    Simplify(simplify::Arguments),
    Bake(bake::Arguments),
}

fn main() -> ExitCode {
    let CommandLine { command } = CommandLine::parse();
    let result = match command {
        Command::Decompose(arguments) => decompose::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Measure(arguments) => measure::run(&arguments),
        Command::Curve(arguments) => curve::run(&arguments),
        Command::Simplify(arguments) => simplify::run(&arguments),
        Command::Bake(arguments) => bake::run(&arguments),
    };
    let (reason, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    print_error(&reason);
    ExitCode::from(code)
}
