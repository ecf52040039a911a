//! `copq`, the program: trains, resumes, evaluates, draws and compares. `copq --help` explains it.

mod bounds;
mod coverage;
mod doctor;
mod evaluate;
mod export;
mod keeping;
mod lists;
mod options;
mod plot;
mod python;
mod recipe;
mod report;
mod resume;
mod rollout;
mod saved;
mod sweep;
mod train;
mod training;
mod view;
mod world;

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;

/// Deep Q-learning with a vector of values: safe first, fast second (COP-Q).
///
/// To get started: copq train; copq rollout runs/FOLDER; copq train --bound extremum; copq plot
/// a=runs/FOLDER b=runs/OTHER.
#[derive(Parser)]
#[command(name = "copq", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Train(Box<train::Train>),
    Resume(resume::Resume),
    Sweep(sweep::Sweep),
    Evaluate(evaluate::Evaluate),
    Rollout(rollout::Rollout),
    Plot(plot::Plot),
    Report(report::Report),
    Bounds(bounds::Bounds),
    Coverage(coverage::CoverageCommand),
    Export(export::Export),
    Tasks(lists::Tasks),
    Methods(lists::Methods),
    Doctor(doctor::Doctor),
    /// Prints a shell completion script.
    ///
    /// For bash: copq completions bash > ~/.local/share/bash-completion/completions/copq
    Completions {
        /// Shell to print the script for.
        shell: Shell,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A backtrace helps nobody who mistyped an option.
            writeln!(std::io::stderr(), "Error: {error:#}").unwrap_or_default();
            ExitCode::FAILURE
        }
    }
}

fn run(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Train(train) => train.run(),
        Command::Resume(resume) => resume.run(),
        Command::Sweep(sweep) => sweep.run(),
        Command::Evaluate(evaluate) => evaluate.run(),
        Command::Rollout(rollout) => rollout.run(),
        Command::Plot(plot) => plot.run(),
        Command::Report(report) => report.run(),
        Command::Bounds(bounds) => bounds.run(),
        Command::Coverage(coverage) => coverage.run(),
        Command::Export(export) => export.run(),
        Command::Tasks(tasks) => tasks.run(),
        Command::Methods(methods) => methods.run(),
        Command::Doctor(doctor) => doctor.run(),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "copq", &mut script);
            Ok(options::say(&String::from_utf8(script)?)?)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
