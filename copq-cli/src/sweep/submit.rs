//! A sweep for Slurm or GNU parallel: readable files, and then the command that submits them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf, absolute};

use anyhow::{Context, ensure};
use clap::ValueEnum;
use copq::files;

use super::file::SweepFile;
use super::slurm::{arrays, queued, sbatch, time};
use crate::options::{count, note, say};

/// Seconds before its time limit at which a run is told to save.
const WARNING: u32 = 120;

/// Submits all runs that are not done yet to Slurm, or writes a list of them for GNU parallel.
///
/// Keeps what it submits in a folder in submit/ beside the runs, one for the sweep's file as it is
/// now: the runs, this program, the scripts, and each run's output. Whatever happens to the file or
/// the program, what waits in a queue does not change (except Python environments, which are not
/// copied).
///
/// Slurm restarts a run that it has stopped at its time limit, or whose node died. The run
/// continues from its last checkpoint. Once the queue is empty, the same command submits what is
/// not done.
#[derive(clap::Args)]
pub struct Submit {
    #[command(flatten)]
    named: super::Named,

    /// What runs them: slurm submits an array of jobs, and then one that makes the report; parallel
    /// writes a list for GNU parallel.
    #[arg(long, default_value = "slurm")]
    engine: Engine,

    /// Only write the files.
    #[arg(long)]
    dry_run: bool,

    /// Slurm partition.
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,

    /// Slurm account.
    #[arg(long, value_name = "NAME")]
    account: Option<String>,

    /// Time limit of each run between two saves, in Slurm's format (2:00:00, 1-00:00:00), at least
    /// ten minutes. A run that reaches it is saved and continues in another turn.
    #[arg(long, value_name = "TIME", default_value = "4:00:00", value_parser = time)]
    time: String,

    /// Memory of each run, in Slurm's format.
    ///
    /// The replay takes 0.09 GB for a million of the hopper's transitions, 1.1 GB for a million of
    /// the humanoid's, and as much again while a checkpoint is written or read.
    #[arg(long, value_name = "SIZE", default_value = "2G")]
    memory: String,

    /// Number of runs at the same time. [default: slurm: as many as it allows; parallel: one per
    /// core]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    at_once: Option<usize>,

    /// Further option for sbatch, such as --sbatch=--constraint=avx512; may be given several times.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    sbatch: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    Slurm,
    Parallel,
}

/// Where everything is.
struct Place {
    /// The folder of what is submitted, and its name: a checksum of the runs.
    folder: PathBuf,
    name: String,
    /// The sweep's file as it is now.
    file: PathBuf,
    /// The script that starts this program's copy in the folder that the file's paths are relative
    /// to.
    run: PathBuf,
}

impl Submit {
    pub fn run(self) -> anyhow::Result<()> {
        let sweep = SweepFile::read_to_begin(&self.named.file)?;
        let numbers = sweep.undone();
        let total = sweep.tasks.len();
        if numbers.is_empty() {
            return Ok(say(&format!("all {total} runs are done; nothing is left to submit\n"))?);
        }
        let place = Self::write_down(&sweep)?;
        say(&format!("{} of {total} runs are not done yet\n", numbers.len()))?;
        match self.engine {
            Engine::Slurm => self.slurm(&sweep, &place, &numbers),
            Engine::Parallel => self.parallel(&sweep, &place),
        }
    }

    /// Makes the folder, with the file that the runs will read and the program that they will run.
    fn write_down(sweep: &SweepFile) -> anyhow::Result<Place> {
        let out = absolute(&sweep.out)?;
        ensure!(
            !out.to_string_lossy().contains(':'),
            "'{}': wanted a folder without : in its name, which separates library paths",
            out.display()
        );
        let text = sweep.frozen(&out)?;
        let name = format!("{:08x}", crc32c::crc32c(text.as_bytes()));
        let folder = out.join("submit").join(&name);
        let logs = folder.join("logs");
        fs::create_dir_all(&logs).map_err(files::failed("making", &logs))?;
        let file = folder.join("sweep.toml");
        files::replace(&file, text.as_bytes())?;
        // A copy, so that all runs use one build whatever is compiled meanwhile.
        let program = folder.join("copq");
        let this = std::env::current_exe()?;
        if !program.exists() {
            files::replace_with(&program, |path| {
                fs::copy(&this, path).map(drop).map_err(files::failed("copying", &this))
            })?;
        } else if fs::read(&program)? != fs::read(&this)? {
            let shown = program.display();
            note(&format!(
                "runs continue with the program that began them, {shown}; remove it to use this one"
            ));
        }
        // Also MuJoCo's library, which is still where it was built.
        for library in libraries() {
            let copy = folder.join(library.file_name().unwrap_or_default());
            let bytes = fs::read(&library).map_err(files::failed("reading", &library))?;
            if fs::read(&copy).ok().as_ref() != Some(&bytes) {
                files::replace(&copy, &bytes)?;
            }
        }
        let start = std::env::current_dir()?;
        let run = folder.join("run.sh");
        let [here, beside, program] = [word(&start)?, word(&folder)?, word(&program)?];
        let script = format!(
            "#!/bin/sh\n# The program that the sweep was submitted with, by the libraries beside it.\n\
             cd {here} || exit\n\
             export LD_LIBRARY_PATH={beside}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\n\
             exec {program} \"$@\"\n"
        );
        files::replace(&run, script.as_bytes())?;
        Ok(Place { folder, name, file, run })
    }

    fn slurm(&self, sweep: &SweepFile, place: &Place, numbers: &[usize]) -> anyhow::Result<()> {
        let threads = sweep.tasks.iter().map(|task| task.plan.threads).max().unwrap_or(1);
        let runs = place.folder.join("runs.sbatch");
        files::replace(&runs, self.array_script(place, threads)?.as_bytes())?;
        let report = place.folder.join("report.sbatch");
        files::replace(&report, self.report_script(place)?.as_bytes())?;
        let arrays = arrays(numbers, self.at_once);
        if self.dry_run {
            for (i, [array, first]) in arrays.iter().enumerate() {
                let after = if self.is_chained(i) { " --dependency=afterany:ID" } else { "" };
                say(&format!("sbatch --array={array}{after} {} {first}\n", word(&runs)?))?;
            }
            let report = word(&report)?;
            let line = "sbatch --dependency=afterany:ID --kill-on-invalid-dep=yes";
            return Ok(say(&format!("{line} {report} # ID: the jobs' numbers, joined by :\n"))?);
        }
        let queued = queued(&place.job())?;
        ensure!(
            queued == 0,
            "this sweep has {queued} jobs called {} in the queue already; wait for them, or scancel \
             --name={}",
            place.job(),
            place.job()
        );
        let mut ids: Vec<String> = Vec::new();
        for [array, first] in &arrays {
            let mut options = vec![format!("--array={array}")];
            // A limit applies to one array: the next one waits for it.
            options.extend(
                ids.last()
                    .filter(|_| self.is_chained(ids.len()))
                    .map(|before| format!("--dependency=afterany:{before}")),
            );
            let options: Vec<&str> = options.iter().map(String::as_str).collect();
            let id = sbatch(&options, &runs, &[first])?;
            say(&format!("job {id}: runs {array} from {first} on\n"))?;
            ids.push(id);
        }
        let after = format!("--dependency=afterany:{}", ids.join(":"));
        let id = sbatch(&[&after, "--kill-on-invalid-dep=yes"], &report, &[])?;
        Ok(say(&format!("job {id}: the report, when the runs have ended\n"))?)
    }

    /// Whether an array waits for the one before it.
    fn is_chained(&self, array: usize) -> bool {
        array > 0 && self.at_once.is_some()
    }

    fn parallel(&self, sweep: &SweepFile, place: &Place) -> anyhow::Result<()> {
        let list = place.folder.join("runs.txt");
        let [run, file] = [word(&place.run)?, word(&place.file)?];
        let line = |number: usize| format!("sh {run} sweep task {file} --task {number}\n");
        // All of them, always in the same order: parallel knows a run by its line. Those that are
        // done end at once.
        let lines: String = (0..sweep.tasks.len()).map(line).collect();
        files::replace(&list, lines.as_bytes())?;
        let log = word(&place.folder.join("joblog"))?;
        let jobs = self.at_once.map_or(String::new(), |jobs| format!(" -j {jobs}"));
        let list = word(&list)?;
        // After Ctrl-C the runs have two minutes to save.
        let command = format!(
            "parallel --joblog {log} --resume-failed --termseq TERM,120000,KILL,25{jobs} < {list}"
        );
        Ok(say(&format!("{command}\n"))?)
    }

    /// The head of a script: its name, where its output goes, and what the user has asked for.
    fn head(&self, place: &Place, name: &str, log: &str) -> anyhow::Result<String> {
        let shown = place.folder.to_str().context("the folder's name: wanted letters")?;
        ensure!(
            !shown.contains(['"', '\n', '%']),
            "'{shown}': wanted a folder that Slurm can name, without \", % and new lines"
        );
        let mut lines = vec![
            format!("#SBATCH --job-name={name}"),
            format!("#SBATCH --output=\"{shown}/logs/{log}\""),
            "#SBATCH --open-mode=append".to_owned(),
        ];
        lines.extend(self.partition.iter().map(|name| format!("#SBATCH --partition={name}")));
        lines.extend(self.account.iter().map(|name| format!("#SBATCH --account={name}")));
        lines.extend(self.sbatch.iter().map(|option| format!("#SBATCH {option}")));
        Ok(format!("#!/bin/bash\n{}\n", lines.join("\n")))
    }

    fn array_script(&self, place: &Place, threads: usize) -> anyhow::Result<String> {
        let head = self.head(place, &place.job(), "%A_%a.txt")?;
        let Self { time, memory, .. } = self;
        let [run, file] = [word(&place.run)?, word(&place.file)?];
        Ok(format!(
            r#"{head}#SBATCH --ntasks=1 --cpus-per-task={threads} --mem={memory} --time={time}
#SBATCH --requeue --signal=B:USR1@{WARNING}

# One run of a sweep. $1 is the number of the array's first run.
sh {run} sweep task {file} --task $((SLURM_ARRAY_TASK_ID + $1)) &
run=$!

# Near the time limit the run saves and gets another turn; when it is cancelled, it saves.
again=
trap 'again=yes; kill -USR1 $run' USR1
trap 'kill -TERM $run' TERM
wait $run
code=$?
while kill -0 $run 2> /dev/null; do # a signal has ended the wait
    wait $run
    code=$?
done
if test "$again" && test $code = 75; then
    # By both numbers: one task of an array has the array's own, by which all would be requeued.
    exec scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
fi
exit $code
"#
        ))
    }

    fn report_script(&self, place: &Place) -> anyhow::Result<String> {
        let head = self.head(place, &format!("{}-report", place.job()), "report.txt")?;
        let [run, file] = [word(&place.run)?, word(&place.file)?];
        Ok(format!(
            "{head}#SBATCH --ntasks=1 --mem=2G --time=30:00\n\nexec sh {run} sweep report {file}\n"
        ))
    }
}

impl Place {
    /// The name of its jobs.
    fn job(&self) -> String {
        format!("copq-{}", self.name)
    }
}

/// MuJoCo's library as this program has loaded it, unless it is the system's own: on another node,
/// or after `cargo clean`, it is missing. Empty where the system does not say.
fn libraries() -> BTreeSet<PathBuf> {
    let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let path = |line: &str| line.split_once('/').map(|(_, path)| PathBuf::from(format!("/{path}")));
    let is_own = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("libmujoco") && !path.starts_with("/usr") && path.is_file()
    };
    maps.lines().filter_map(path).filter(is_own).collect()
}

/// A path as one shell word.
fn word(path: &Path) -> anyhow::Result<String> {
    let text = path.to_str().with_context(|| {
        format!("'{}': wanted a path of letters, got other bytes", path.display())
    })?;
    Ok(copq_experiments::quoted(text))
}
