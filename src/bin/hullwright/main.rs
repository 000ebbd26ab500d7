//! The command line `hullwright`: decomposes meshes into convex hulls, inspects meshes, measures
//! hulls, and shows both.
//!
//! Exit code 0 is success; 1 a refusal, with one line on standard error that says why; 2 wrong usage.

mod arguments;
mod bake;
mod curve;
mod decompose;
mod hulls;
mod inspect;
mod json;
mod measure;
mod outcomes;
mod output;
mod progress;
mod tables;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use output::Failure;

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
    Curve(curve::Arguments),
    Bake(bake::Arguments),
    Inspect(inspect::Arguments),
    Measure(measure::Arguments),
    View(view::Arguments),
}

fn main() -> ExitCode {
    let CommandLine { command } = CommandLine::parse();
    let result = match command {
        Command::Decompose(arguments) => decompose::run(&arguments),
        Command::Curve(arguments) => curve::run(&arguments),
        Command::Bake(arguments) => bake::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Measure(arguments) => measure::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
    };
    let (reason, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    output::print_error(&reason);
    ExitCode::from(code)
}
