//! The laboratory: benchmarks, the stability report, the experiments of the paper that the surface
//! method comes from, and HACD to compare with. Run as `cargo lab COMMAND`.
//!
//! Exit code 0 is success, 1 an error in the input or the work, 2 wrong usage.

mod bench;
mod contact;
mod experiments;
mod gallery;
mod hacd;
// The unused rest is for tests.
#[allow(dead_code)]
#[path = "../../../tests/independent/mod.rs"]
mod independent;
#[cfg(test)]
mod independent_tests;
mod paper;
mod report;
mod runs;
mod stability;
mod statistics;
mod sweep;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use contact::{seams, small};
use experiments::{
    agreement, budgets, cancel, corpus, identical, openings, presets, props, stages, table1,
    targets, turned, versus_paper, volume,
};
use hullwright_cli::terminal::Failure;
use runs::worker;

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
    #[command(hide = true)]
    BenchRun(worker::Arguments),
    Sweep(sweep::Arguments),
    #[command(hide = true)]
    SweepRun(sweep::worker::Arguments),
    Stability(stability::Arguments),
    #[command(hide = true)]
    StabilityRun(stability::worker::Arguments),
    Paper(paper::Arguments),
    Table1(table1::Arguments),
    Targets(targets::Arguments),
    Agreement(agreement::Arguments),
    Budgets(budgets::Arguments),
    Corpus(corpus::Arguments),
    Identical(identical::Arguments),
    Openings(openings::Arguments),
    Presets(presets::Arguments),
    Props(props::Arguments),
    Stages(stages::Arguments),
    Cancel(cancel::Arguments),
    Turned(turned::Arguments),
    VersusPaper(versus_paper::Arguments),
    Volume(volume::Arguments),
    SmallContacts(small::Arguments),
    Seams(seams::Arguments),
    View(view::Arguments),
    Gallery(gallery::Arguments),
}

fn main() -> ExitCode {
    let CommandLine { command } = CommandLine::parse();
    let result = match command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::BenchRun(arguments) => worker::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::SweepRun(arguments) => sweep::worker::run(&arguments),
        Command::Stability(arguments) => stability::run(&arguments),
        Command::StabilityRun(arguments) => stability::worker::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Table1(arguments) => table1::run(&arguments),
        Command::Targets(arguments) => targets::run(&arguments),
        Command::Budgets(arguments) => budgets::run(&arguments),
        Command::Agreement(arguments) => agreement::run(&arguments),
        Command::Corpus(arguments) => corpus::run(&arguments),
        Command::Identical(arguments) => identical::run(&arguments),
        Command::Openings(arguments) => openings::run(&arguments),
        Command::Presets(arguments) => presets::run(&arguments),
        Command::Props(arguments) => props::run(&arguments),
        Command::Stages(arguments) => stages::run(&arguments),
        Command::Cancel(arguments) => cancel::run(&arguments),
        Command::Turned(arguments) => turned::run(&arguments),
        Command::VersusPaper(arguments) => versus_paper::run(&arguments),
        Command::Volume(arguments) => volume::run(&arguments),
        Command::SmallContacts(arguments) => small::run(&arguments),
        Command::Seams(arguments) => seams::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Gallery(arguments) => gallery::run(&arguments),
    };
    let (reason, code) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(reason)) => (reason, 1),
        Err(Failure::Usage(reason)) => (reason, 2),
    };
    eprintln!("error: {}", reason.replace('\n', " "));
    ExitCode::from(code)
}
