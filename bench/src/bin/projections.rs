//! What each projection costs in a whole TD3-COP update on walker2d's shapes, against the clipped double-Q choice by
//! scalarised minimum with as many critics, and against that with two.

use anyhow::Result;
use copq::projection::{ScalarisedMin, by_name, names};
use copq_bench::rounds::{Running, interleave, ratio, text};
use copq_bench::update::Copq;
use copq_bench::workload::Workload;

const ROUNDS: usize = 31;
const UPDATES: usize = 20;

fn main() -> Result<()> {
    let four = Workload::named("walker2d", 1)?;
    let two = Workload { critics: 2, ..four.clone() };
    let mut running = vec![Running::new(Box::new(Copq::projecting(&two, Box::new(ScalarisedMin))?), &two)];
    for name in names() {
        running.push(Running::new(Box::new(Copq::projecting(&four, by_name(name)?)?), &four));
    }
    let times = interleave(&mut running, ROUNDS, UPDATES)?;
    let labels = ["scalarised-min"].iter().zip([2]).chain(names().iter().zip([4; 6]));
    let equal = 1 + names().iter().position(|&name| name == "scalarised-min").unwrap_or(0);
    println!(
        "ms an update, median (smallest-largest) of {ROUNDS} interleaved rounds of {UPDATES} updates; ratios of CPU"
    );
    println!(
        "| projection | critics | ms | CPU ms | to scalarised-min, 4 critics | 2 critics |\n|---|--:|--:|--:|--:|--:|"
    );
    for ((name, critics), of) in labels.zip(&times) {
        let (wall, cpu) = (text(of, |t| t.wall), text(of, |t| t.cpu));
        let to = |other: usize| ratio(of, &times[other], |t| t.cpu);
        println!("| {name} | {critics} | {wall} | {cpu} | {} | {} |", to(equal), to(0));
    }
    Ok(())
}
