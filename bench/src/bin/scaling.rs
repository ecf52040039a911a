//! How an update's time and memory grow with critics, objectives, rows and width, from walker2d's shapes on.
//!
//! Prints a table, and with a file's name writes `axis,value,program,round,wall_ms,cpu_ms,peak_mb` there as well.

use std::fmt::Write;
use std::process::Command;

use anyhow::{Context, Result, bail};
use copq_bench::rounds::{Running, Time, interleave, ratio, text};
use copq_bench::update::make;
use copq_bench::workload::Workload;

const ROUNDS: usize = 11;
const UPDATES: usize = 4;
const PROGRAMS: [&str; 2] = ["copq", "products"];
const AXES: [(&str, &[usize]); 4] = [
    ("critics", &[2, 4, 8, 16, 32]),
    ("objectives", &[1, 3, 10, 25, 50]),
    ("rows", &[64, 256, 1024, 4096]),
    ("width", &[64, 128, 256, 512, 1024]),
];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--peak", axis, value] => {
            println!("{}", peak(&workload(axis, value.parse()?)?)?);
            Ok(())
        }
        [] => table().map(drop),
        [file] => Ok(std::fs::write(file, table()?)?),
        _ => bail!("wanted at most the name of a file"),
    }
}

/// Prints the table; the rounds as CSV.
fn table() -> Result<String> {
    let mut csv = "axis,value,program,round,wall_ms,cpu_ms,peak_mb\n".to_owned();
    println!("ms an update, median (smallest-largest) of {ROUNDS} interleaved rounds of {UPDATES} updates; one thread");
    println!("| size | ms | CPU ms | CPU to its products | peak MB |\n|---|--:|--:|--:|--:|");
    for (axis, values) in AXES {
        for &value in values {
            let workload = workload(axis, value)?;
            let running = |name| Ok(Running::new(make(name, &workload)?, &workload));
            let mut running = PROGRAMS.map(running).into_iter().collect::<Result<Vec<_>>>()?;
            let times = interleave(&mut running, ROUNDS, UPDATES)?;
            let megabytes = peak_of(axis, value)?;
            let (wall, cpu) = (text(&times[0], |t| t.wall), text(&times[0], |t| t.cpu));
            let to_products = ratio(&times[0], &times[1], |t| t.cpu);
            println!("| {axis} {value} | {wall} | {cpu} | {to_products} | {megabytes} |");
            for (program, of) in PROGRAMS.iter().zip(&times) {
                for (round, Time { wall, cpu }) in of.iter().enumerate() {
                    writeln!(csv, "{axis},{value},{program},{round},{wall},{cpu},{megabytes}")?;
                }
            }
        }
    }
    Ok(csv)
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

/// Peak memory (MB) of a process of its own that does a few updates.
fn peak_of(axis: &str, value: usize) -> Result<u64> {
    let child = Command::new(std::env::current_exe()?).args(["--peak", axis, &value.to_string()]).output()?;
    let answer = String::from_utf8(child.stdout)?;
    answer.trim().parse().with_context(|| String::from_utf8_lossy(&child.stderr).into_owned())
}

/// This process's peak memory (MB) after a few updates on one batch.
fn peak(workload: &Workload) -> Result<u64> {
    let (mut update, batch) = (make("copq", workload)?, workload.batch());
    (1..=4).try_for_each(|number| update.update(number, &batch).map(drop))?;
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no VmHWM in /proc/self/status")?;
    let kilobytes: u64 = line.trim().trim_end_matches(" kB").parse()?;
    Ok(kilobytes.div_ceil(1024))
}
