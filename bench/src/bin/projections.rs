//! What each projection costs in a whole COP-TD3 update on walker2d's shapes, compared with clipped
//! double-Q by scalarised minimum with as many critics, and with two.

use std::sync::Arc;

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use copq::projection::{ScalarisedMin, by_name, names};
use copq_bench::rounds::{Running, Time, interleave, ratio, text};
use copq_bench::update::Copq;
use copq_bench::workload::Workload;

const UPDATES: usize = 20;

/// Times an update with every projection and 4 critics, and with the scalarised minimum and 2.
#[derive(Parser)]
struct Cli {
    /// Interleaved rounds.
    #[arg(long, default_value_t = 31)]
    rounds: usize,

    /// File to write the rounds' times to.
    #[arg(long)]
    csv: Option<PathBuf>,
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    let four = Workload::named("walker2d", 1)?;
    let two = Workload { critics: 2, ..four.clone() };
    let mut running =
        vec![Running::new(Box::new(Copq::projecting(&two, Arc::new(ScalarisedMin))?), &two)];
    for name in names() {
        running.push(Running::new(Box::new(Copq::projecting(&four, by_name(name)?)?), &four));
    }
    let times = interleave(&mut running, cli.rounds, UPDATES)?;
    let cases: Vec<_> =
        [("scalarised-min", 2)].into_iter().chain(names().iter().map(|&name| (name, 4))).collect();
    print(&cases, &times, cli.rounds)?;
    cli.csv.map_or(Ok(()), |file| Ok(std::fs::write(file, csv(&cases, &times)?)?))
}

/// Prints a table of all (projection, critics) cases.
fn print(cases: &[(&str, usize)], times: &[Vec<Time>], rounds: usize) -> Result<()> {
    let position =
        |case| cases.iter().position(|&other| other == case).context("no scalarised minimum");
    let two = position(("scalarised-min", 2))?;
    let four = position(("scalarised-min", 4))?;
    println!("{rounds} interleaved rounds of {UPDATES} updates, one thread; ratios of CPU time.\n");
    println!("| projection | critics | ms | CPU ms | to scalarised-min, 4 critics | 2 critics |");
    println!("|---|--:|--:|--:|--:|--:|");
    for (&(name, critics), of) in cases.iter().zip(times) {
        let wall = text(of, |t| t.wall);
        let cpu = text(of, |t| t.cpu);
        let to = |other: usize| ratio(of, &times[other], |t| t.cpu);
        println!("| {name} | {critics} | {wall} | {cpu} | {} | {} |", to(four), to(two));
    }
    Ok(())
}

fn csv(cases: &[(&str, usize)], times: &[Vec<Time>]) -> Result<String> {
    let mut csv = "projection,critics,round,wall_ms,cpu_ms\n".to_owned();
    for ((name, critics), of) in cases.iter().zip(times) {
        for (round, Time { wall, cpu }) in of.iter().enumerate() {
            writeln!(csv, "{name},{critics},{round},{wall},{cpu}")?;
        }
    }
    Ok(csv)
}
