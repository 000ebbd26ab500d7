//! The laboratory: benchmarks, the stability report, the experiments of the paper that the surface
//! method comes from, and what makes assets and pictures. Run as `cargo lab COMMAND`.
//!
//! Exit code 0 is success, 1 an error in the input or the work, 2 wrong usage.

mod assets;
mod bench;
mod burst;
mod concavity;
mod floor;
mod gallery;
mod growth;
mod harness;
// The unused rest is for tests.
mod fragments;
#[allow(dead_code)]
#[path = "../../hullwright/tests/independent/mod.rs"]
mod independent;
#[cfg(test)]
mod independent_tests;
mod least;
mod level;
mod paper;
mod pictures;
mod plots;
mod reach;
mod report;
mod shapes;
mod stability;
mod stages;
mod statistics;
mod sweep;
mod targets;
mod tools;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hullwright_cli::terminal::Failure;
use hullwright_cli::{render, terminal};

/// Experiments with Hullwright: benchmarks, stability, and the paper's comparisons
#[derive(Parser)]
#[command(name = "cargo lab", version, max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bench(bench::Arguments),
    Sweep(sweep::Arguments),
    Stability(stability::Arguments),
    Growth(growth::Arguments),
    Targets(targets::Arguments),
    Paper(paper::Arguments),
    Reach(reach::Arguments),
    Floor(floor::Arguments),
    Concavity(concavity::Arguments),
    Stages(stages::Arguments),
    Least(least::Arguments),
    Level(level::Arguments),
    Gallery(gallery::Arguments),
    Pictures(pictures::Arguments),
    Assets(assets::Arguments),
    #[command(hide = true)]
    Run(harness::worker::Arguments),
    #[command(hide = true)]
    Grow(growth::worker::Arguments),
}

fn main() -> ExitCode {
    let CommandLine { command } = CommandLine::parse();
    let result = match command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Stability(arguments) => stability::run(&arguments),
        Command::Growth(arguments) => growth::run(&arguments),
        Command::Targets(arguments) => targets::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Reach(arguments) => reach::run(&arguments),
        Command::Floor(arguments) => floor::run(&arguments),
        Command::Concavity(arguments) => concavity::run(&arguments),
        Command::Stages(arguments) => stages::run(&arguments),
        Command::Least(arguments) => least::run(&arguments),
        Command::Level(arguments) => level::run(&arguments),
        Command::Gallery(arguments) => gallery::run(&arguments),
        Command::Pictures(arguments) => pictures::run(&arguments),
        Command::Assets(arguments) => assets::run(&arguments),
        Command::Run(arguments) => harness::worker::run(&arguments),
        Command::Grow(arguments) => growth::worker::run(&arguments),
    };
    let (reason, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    eprintln!("error: {}", reason.replace('\n', " "));
    ExitCode::from(code)
}
