//! What one COP-TD3 update costs, in several programs whose losses agree.
//!
//! By itself it prints a table of medians over interleaved rounds. With `--serve` it measures on
//! demand for `bench/run.py`: `check NAME UPDATES` is answered with the losses of a fresh start,
//! `time NAME UPDATES` with an update's milliseconds, as wall time and as CPU time. With `--write`
//! it writes weights and batches for the peers.

use std::collections::BTreeMap;
use std::io::{BufRead, Write, stdin, stdout};
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Parser;
use copq_bench::rounds::{Running, interleave, ratio, text};
use copq_bench::update::{NAMES, make};
use copq_bench::workload::Workload;

/// Times one COP-TD3 update.
#[derive(Parser)]
struct Cli {
    /// walker2d, humanoid or redq.
    #[arg(long, default_value = "walker2d")]
    workload: String,

    /// Number of threads that an update may use.
    #[arg(long, default_value_t = 1)]
    threads: usize,

    /// Interleaved rounds of the table.
    #[arg(long, default_value_t = 21)]
    rounds: usize,

    /// Updates in a round.
    #[arg(long, default_value_t = 20)]
    updates: usize,

    /// Programs to time, each compared with the first; all by default.
    names: Vec<String>,

    /// Do --updates updates and nothing else, without reading a clock: for counting instructions.
    #[arg(long)]
    only: bool,

    /// Answer questions on standard input.
    #[arg(long)]
    serve: bool,

    /// Write weights and batches into a folder, and nothing else.
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    // SAFETY: no other thread has been started. candle and rayon read these when they start theirs.
    unsafe {
        std::env::set_var("RAYON_NUM_THREADS", cli.threads.to_string());
        std::env::set_var("CANDLE_NUM_THREADS", cli.threads.to_string());
    }
    let workload = Workload::named(&cli.workload, cli.threads)?;
    match &cli.write {
        Some(folder) => workload.write(folder),
        None if cli.serve => serve(&workload),
        None if cli.only => {
            names(&cli).iter().try_for_each(|name| running(name, &workload)?.run(cli.updates))
        }
        None => table(&cli, &workload),
    }
}

fn names(cli: &Cli) -> Vec<&str> {
    if cli.names.is_empty() {
        NAMES.to_vec()
    } else {
        cli.names.iter().map(String::as_str).collect()
    }
}

fn running(name: &str, workload: &Workload) -> Result<Running> {
    Ok(Running::new(make(name, workload)?, workload))
}

fn table(cli: &Cli, workload: &Workload) -> Result<()> {
    let names = names(cli);
    let mut running =
        names.iter().map(|name| running(name, workload)).collect::<Result<Vec<_>>>()?;
    let times = interleave(&mut running, cli.rounds, cli.updates)?;
    println!("{workload:?}");
    println!(
        "ms an update, median (smallest-largest) of {} rounds of {} updates",
        cli.rounds, cli.updates
    );
    println!("| program | wall | CPU | CPU to {} |\n|---|--:|--:|--:|", names[0]);
    for (name, of) in names.iter().zip(&times) {
        let wall = text(of, |t| t.wall);
        let cpu = text(of, |t| t.cpu);
        println!("| {name} | {wall} | {cpu} | {} |", ratio(of, &times[0], |t| t.cpu));
    }
    Ok(())
}

fn serve(workload: &Workload) -> Result<()> {
    let mut running = BTreeMap::new();
    for line in stdin().lock().lines() {
        let line = line?;
        let words: Vec<_> = line.split_whitespace().collect();
        let [question, name, updates] = words[..] else {
            bail!("wanted QUESTION NAME UPDATES, got {line}")
        };
        match question {
            "check" => println!("{}", losses(name, updates.parse()?, workload)?),
            "time" => {
                if !running.contains_key(name) {
                    running.insert(name.to_owned(), self::running(name, workload)?);
                }
                let time = running.get_mut(name).map(|running| running.time(updates.parse()?));
                let Some(time) = time.transpose()? else { bail!("{name} is not running") };
                println!("{} {}", time.wall, time.cpu);
            }
            _ => bail!("{question}: wanted check or time"),
        }
        stdout().flush()?;
    }
    Ok(())
}

/// The losses of the first updates on one line: the critics' of each, then the actor's if it moved.
fn losses(name: &str, updates: usize, workload: &Workload) -> Result<String> {
    let mut update = make(name, workload)?;
    let batches = workload.batches();
    let mut all = Vec::new();
    for number in 1..=updates {
        let losses = update.update(number, &batches[(number - 1) % batches.len()])?;
        all.extend(losses.critic.into_iter().chain(losses.actor).map(|loss| loss.to_string()));
    }
    Ok(all.join(" "))
}
