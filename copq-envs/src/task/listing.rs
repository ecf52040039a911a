//! The tasks as a table for people to read.

use std::fmt::Write;

use copq::Result;

use super::{Options, SignalSum, task_with, tasks};

/// A line for every task with these options: name, lengths of observation and action, and the
/// objectives in order of priority, each with its weight or, for a cost, with the limit of its sum
/// over an episode.
pub fn list_tasks(options: &Options) -> Result<String> {
    let mut text =
        format!("{:<16}{:>6}{:>8}  objectives, highest priority first\n", "task", "sees", "motors");
    for name in tasks() {
        let task = task_with(name, options)?;
        let seen = task.robot.observation.len(&task.robot);
        let motors = task.robot.nu();
        let objectives: Vec<_> = task.objectives.iter().map(describe).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{name:<16}{seen:>6}{motors:>8}  {}", objectives.join(", "));
    }
    Ok(text)
}

fn describe(objective: &SignalSum) -> String {
    match objective.limit {
        Some(limit) => format!("{} <= {limit}", objective.name),
        None => format!("{} x {}", objective.name, objective.weight),
    }
}
