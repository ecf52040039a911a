//! Slurm's commands, and how it writes times and arrays.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, ensure};

/// Maximum tasks of one array; Slurm's own limit is 1001 unless its administrator has raised it.
const ARRAY: usize = 1_000;
/// The shortest time limit that leaves a run some time to work, in seconds.
const SHORTEST: u64 = 600;

/// How many jobs of a name are in the queue; none if the queue cannot be asked.
pub fn queued(name: &str) -> anyhow::Result<usize> {
    let Ok(output) = Command::new("squeue").args(["-h", "-r", "-n", name]).output() else {
        return Ok(0);
    };
    Ok(String::from_utf8_lossy(&output.stdout).lines().count())
}

/// A time limit in Slurm's format: minutes, minutes:seconds, hours:minutes:seconds, days-hours and
/// so on.
pub fn time(text: &str) -> Result<String, String> {
    let wanted = "wanted a time as Slurm has it, such as 30, 2:00:00 or 1-00:00:00";
    let (days, rest) = text.split_once('-').map_or((None, text), |(days, rest)| (Some(days), rest));
    // Of 32 bits, so that no sum is too large.
    let number = |text: &str| text.parse::<u32>().map(u64::from).map_err(|_| wanted.to_owned());
    let parts = rest.split(':').map(number).collect::<Result<Vec<_>, _>>()?;
    let seconds = match (days, parts.as_slice()) {
        (None, [minutes]) => 60 * minutes,
        (None, [minutes, seconds]) => 60 * minutes + seconds,
        (Some(_), [hours]) => 3_600 * hours,
        (Some(_), [hours, minutes]) => 3_600 * hours + 60 * minutes,
        (_, [hours, minutes, seconds]) => 3_600 * hours + 60 * minutes + seconds,
        _ => return Err(wanted.to_owned()),
    };
    let seconds = seconds + 86_400 * days.map_or(Ok(0), number)?;
    if seconds < SHORTEST {
        return Err("wanted ten minutes at least: a run saves two minutes before".to_owned());
    }
    Ok(text.to_owned())
}

/// The runs as Slurm arrays, each with the number that its own numbers count from.
pub fn arrays(numbers: &[usize], at_once: Option<usize>) -> Vec<[String; 2]> {
    let limit = at_once.map_or(String::new(), |jobs| format!("%{jobs}"));
    let chunk_of = |number: &usize| number / ARRAY;
    numbers
        .chunk_by(|a, b| chunk_of(a) == chunk_of(b))
        .map(|chunk| {
            let first = chunk_of(&chunk[0]) * ARRAY;
            let within: Vec<usize> = chunk.iter().map(|number| number - first).collect();
            [ranges(&within) + &limit, first.to_string()]
        })
        .collect()
}

/// Sorted numbers, written as 0-3,7.
fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let range = |run: &[usize]| match run {
        [one] => one.to_string(),
        _ => format!("{}-{}", run[0], run[run.len() - 1]),
    };
    runs.map(range).collect::<Vec<_>>().join(",")
}

/// Submits a script and returns its job's number.
pub fn sbatch(options: &[&str], script: &Path, arguments: &[&String]) -> anyhow::Result<String> {
    let output = Command::new("sbatch")
        .arg("--parsable")
        .args(options)
        .arg(script)
        .args(arguments)
        .output()
        .context("starting sbatch (Slurm's client; --dry-run only writes the scripts)")?;
    let words = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "sbatch {}: {}", script.display(), words.trim());
    // With several clusters it is ID;CLUSTER.
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(text.trim().split(';').next().unwrap_or_default().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_slurms() {
        for text in ["10", "90:00", "2:00:00", "1-0", "1-12:30", "3-00:00:00"] {
            assert_eq!(time(text).as_deref(), Ok(text));
        }
        for text in ["", "5", "9:59", "x", "1:2:3:4", "0-0:5", "18446744073709551615-0"] {
            assert!(time(text).is_err(), "{text}");
        }
    }

    #[test]
    fn arrays_are_ranges_of_at_most_a_thousand() {
        assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), "0-2,5,7-8");
        assert_eq!(arrays(&[3], None), [["3".to_owned(), "0".to_owned()]]);
        let many: Vec<usize> = (998..2_001).filter(|n| *n != 1_500).collect();
        let wanted = [["998-999%8", "0"], ["0-499,501-999%8", "1000"], ["0%8", "2000"]];
        assert_eq!(arrays(&many, Some(8)), wanted.map(|pair| pair.map(str::to_owned)));
    }
}
