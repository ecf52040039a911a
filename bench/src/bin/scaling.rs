//! How an update's time and memory grow with critics, objectives, rows and width, starting from
//! walker2d's shapes.
//!
//! Prints a table for one thread. Sizes that take long get fewer rounds.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Parser;
use copq_bench::rounds::{Running, Time, interleave, ratio, text};
use copq_bench::update::make;
use copq_bench::workload::Workload;

const UPDATES: usize = 4;
const PROGRAMS: [&str; 2] = ["copq", "products"];
const AXES: [(&str, &[usize]); 4] = [
    ("critics", &[2, 4, 8, 16, 32]),
    ("objectives", &[1, 3, 10, 25, 50]),
    ("rows", &[64, 256, 1024, 4096]),
    ("width", &[64, 128, 256, 512, 1024]),
];

/// Times updates of many sizes.
#[derive(Parser)]
struct Cli {
    /// Interleaved rounds of each size.
    #[arg(long, default_value_t = 15)]
    rounds: usize,

    /// Seconds that a size may take, unless three rounds take longer.
    #[arg(long, default_value_t = 6.0)]
    seconds: f64,

    /// File to write the rounds' times to.
    #[arg(long)]
    csv: Option<PathBuf>,

    /// Print the peak memory (MB) of one size, and nothing else.
    #[arg(long, num_args = 2, value_names = ["AXIS", "VALUE"])]
    peak: Vec<String>,
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    if let [axis, value] = &cli.peak[..] {
        println!("{}", peak(&workload(axis, value.parse()?)?)?);
        return Ok(());
    }
    println!(
        "at most {} interleaved rounds of {UPDATES} updates, one thread; ratios of CPU time.\n",
        cli.rounds
    );
    println!("| size | ms an update | CPU ms | to its products | peak MB |\n|---|--:|--:|--:|--:|");
    let mut csv = "axis,value,program,round,wall_ms,cpu_ms,peak_mb\n".to_owned();
    for (axis, values) in AXES {
        for &value in values {
            measure(axis, value, &cli, &mut csv)?;
        }
    }
    cli.csv.map_or(Ok(()), |file| Ok(std::fs::write(file, csv)?))
}

/// Prints one size's row and adds its rounds to the CSV.
fn measure(axis: &str, value: usize, cli: &Cli, csv: &mut String) -> Result<()> {
    let workload = workload(axis, value)?;
    let running = |name| Ok(Running::new(make(name, &workload)?, &workload));
    let mut running = PROGRAMS.map(running).into_iter().collect::<Result<Vec<_>>>()?;
    let rounds = affordable(&mut running, cli)?;
    let times = interleave(&mut running, rounds, UPDATES)?;
    let megabytes = peak_of(axis, value)?;
    let wall = text(&times[0], |t| t.wall);
    let cpu = text(&times[0], |t| t.cpu);
    println!(
        "| {axis} {value} | {wall} | {cpu} | {} | {megabytes} |",
        ratio(&times[0], &times[1], |t| t.cpu)
    );
    for (program, of) in PROGRAMS.iter().zip(&times) {
        for (round, Time { wall, cpu }) in of.iter().enumerate() {
            writeln!(csv, "{axis},{value},{program},{round},{wall},{cpu},{megabytes}")?;
        }
    }
    Ok(())
}

/// How many rounds fit into the time for one size, estimated from a first round.
fn affordable(running: &mut [Running], cli: &Cli) -> Result<usize> {
    let times =
        running.iter_mut().map(|running| running.time(UPDATES)).collect::<Result<Vec<_>>>()?;
    let seconds: f64 = times.iter().map(|time| 1e-3 * time.wall * UPDATES as f64).sum();
    Ok(((cli.seconds / seconds) as usize).clamp(cli.rounds.min(3), cli.rounds))
}

fn workload(axis: &str, value: usize) -> Result<Workload> {
    let base = Workload::named("walker2d", 1)?;
    Ok(match axis {
        "critics" => Workload { critics: value, ..base },
        "objectives" => Workload { objectives: value, ..base },
        "rows" => Workload { rows: value, ..base },
        "width" => Workload { width: value, ..base },
        _ => bail!("{axis}: no such axis"),
    })
}

/// Peak memory (MB) of a separate process that does a few updates.
fn peak_of(axis: &str, value: usize) -> Result<u64> {
    let child = Command::new(std::env::current_exe()?)
        .args(["--peak", axis, &value.to_string()])
        .output()?;
    let answer = String::from_utf8(child.stdout)?;
    answer.trim().parse().with_context(|| String::from_utf8_lossy(&child.stderr).into_owned())
}

/// This process's peak memory (MB) after a few updates on one batch.
fn peak(workload: &Workload) -> Result<u64> {
    let mut update = make("copq", workload)?;
    let batch = workload.batch();
    (1..=4).try_for_each(|number| update.update(number, &batch).map(drop))?;
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .context("no VmHWM in /proc/self/status")?;
    let kilobytes: u64 = line.trim().trim_end_matches(" kB").parse()?;
    Ok(kilobytes.div_ceil(1024))
}
