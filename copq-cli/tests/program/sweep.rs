//! A sweep of small runs: planned, trained, stopped and gone on with, and what it says of failures.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{copq, wait_until};

fn sweep(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = copq();
    command.arg("sweep").args(arguments).current_dir(folder);
    command
}

fn text(output: &Output) -> String {
    let all = [output.stdout.clone(), output.stderr.clone()].concat();
    String::from_utf8(all).unwrap()
}

const TINY: &str = r#"
[all]
eval-every = 60
eval-episodes = 1
log-every = 20
checkpoint-every = 40
set = ["networks.hidden=[8,8]"]
"#;

/// What a paper has, and says.
const PAPER: &str = r#"
[[published]]
source = "Table 7"
task = "a/hopper"
of = "final"
seeds = 5
scores = { cop-td3 = [3042, 99], extremum = [2435, 1190] }

[[claim]]
says = "it learns"
source = "section 5.1"
task = "a/hopper"
of = "final"
method = "cop-td3"
is = "above"
than = "extremum"
"#;

fn write(folder: &Path, text: &str) {
    std::fs::write(folder.join("tiny.toml"), text.to_owned() + TINY).unwrap();
}

fn file(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn a_grid_is_trained_once_and_as_copq_train_would() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    write(
        folder,
        r#"
exclude = [{ bound = "extremum", seed = 1 }]

[grid]
bound = ["cholesky", "extremum"]
seed = [0, 1]

[[arm]]
name = "short"
steps = 90
set = ["batch=8", "start_steps=40"]

[[include]]
method = "ppo"
task = "b/hopper"
steps = 128
set = ["steps_per_epoch=64"]
"#,
    );
    let plan = text(&sweep(folder, &["plan", "tiny.toml"]).output().unwrap());
    assert_eq!(plan.lines().count(), 4, "{plan}");
    // What adds up does, wherever it stands.
    let whole = "copq train --bound cholesky --checkpoint-every 40 --eval-episodes 1 --eval-every 60 \
        --log-every 20 --seed 0 --set 'networks.hidden=[8,8]' --set batch=8 --set start_steps=40 \
        --steps 90 --out runs/tiny/short-";
    assert!(plan.contains(whole), "{plan}");
    let output = sweep(folder, &["run", "tiny.toml", "--jobs", "2"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert_eq!(status.matches("| done |").count(), 4, "{status}");
    let again = sweep(folder, &["run", "tiny.toml"]).output().unwrap();
    assert!(text(&again).starts_with("4 runs, 4 of them done"), "{}", text(&again));
    // The second run's line of the plan, typed by hand, leaves the same bytes.
    let line = plan.lines().nth(1).unwrap();
    let run = folder.join(line.split_whitespace().nth(1).unwrap());
    let (_, command) = line.split_once("copq train").unwrap();
    let (command, _) = command.split_once(" --out ").unwrap();
    let by_hand = Command::new("sh")
        .args(["-c", &format!("exec \"$0\" train {command} --out by-hand")])
        .arg(env!("CARGO_BIN_EXE_copq"))
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(by_hand.status.success(), "{}", text(&by_hand));
    for name in ["metrics.csv", "evaluations.csv", "checkpoint.safetensors"] {
        assert!(file(&run, name) == file(&folder.join("by-hand"), name), "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_goes_on_to_the_same_bytes() {
    let temporary = tempfile::tempdir().unwrap();
    let run = |name: &str, wait: bool| {
        let folder = temporary.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        write(
            &folder,
            "[grid]\nseed = [0, 1]\nsteps = [1500]\nset = [\"batch=8\"]\n[[arm]]\nset = [\"start_steps=40\"]\n",
        );
        let mut child = sweep(&folder, &["run", "tiny.toml", "--jobs", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        if !wait {
            let runs = folder.join("runs/tiny");
            wait_until("a checkpoint", || {
                std::fs::read_dir(&runs).is_ok_and(|runs| {
                    runs.flatten().any(|run| run.path().join("checkpoint.safetensors").is_file())
                })
            });
            let id = child.id().to_string();
            assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
            assert_eq!(child.wait().unwrap().code(), Some(75));
            child = sweep(&folder, &["run", "tiny.toml"]).stdout(Stdio::null()).spawn().unwrap();
        }
        assert!(child.wait().unwrap().success());
        let mut runs: Vec<_> = std::fs::read_dir(folder.join("runs/tiny"))
            .unwrap()
            .flatten()
            .map(|e| e.path())
            .collect();
        runs.sort();
        assert_eq!(runs.len(), 2, "{runs:?}");
        runs.iter().map(|run| file(run, "checkpoint.safetensors")).collect::<Vec<_>>()
    };
    assert!(run("whole", true) == run("stopped", false));
}

#[test]
fn mistakes_are_told_before_and_failures_after() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (text_of_file, wanted) in [
        ("grid = 3", "invalid type"),
        ("", "wanted one run at least"),
        ("[grid]\nmethd = [\"td3\"]", "unexpected argument '--methd'"),
        ("[grid]\nmethod = [\"td4\"]", "invalid value 'td4'"),
        ("[grid]\nmethod = [\"td4\"]", "[possible values: cop-td3,"),
        ("[grid]\nseed = [1, 1]", "wanted each run once"),
        ("[grid]\nsteps = [1, 2]", "differ in nothing that a folder is named by"),
        ("[grid]\nout = [\"a\"]", "wanted it for the whole sweep"),
        ("[grid]\nlike = [\"a\"]", "like: wanted options one by one"),
        ("exclude = [{}]\n[grid]\nseed = [1]", "exclude: wanted options that some run has"),
        ("exclude = [{ sed = 1 }]\n[grid]\nseed = [1]", "got { sed = 1 }"),
        ("[grid]\nseed = [1]\n[[arm]]\nname = \"../a\"", "name of an arm: wanted plain"),
        ("[grid]\nseed = [1]\n[[claim]]\nsays = 3", "invalid type: integer `3`"),
    ] {
        std::fs::write(folder.join("bad.toml"), text_of_file).unwrap();
        let output = sweep(folder, &["plan", "bad.toml"]).output().unwrap();
        assert!(!output.status.success() && text(&output).contains(wanted), "{}", text(&output));
    }
    // What could not begin is told before anything begins.
    for (grid, wanted) in [
        ("method = [\"rcpo\"]\ntask = [\"a/hopper\"]", "a task with a cost"),
        ("task = [\"a/hoper\"]", "unknown task 'a/hoper'"),
        ("order = [\"xyz\"]", "order of objectives: wanted"),
        ("set = [\"batch=0\"]", "batch: wanted at least 1"),
        ("init-from = [\"nowhere\"]", "'nowhere'"),
    ] {
        write(folder, &format!("[grid]\n{grid}\nsteps = [100]\n"));
        let output = sweep(folder, &["plan", "tiny.toml"]).output().unwrap();
        assert!(!output.status.success() && text(&output).contains(wanted), "{}", text(&output));
    }
    std::fs::write(folder.join("a.toml"), "files = [\"b.toml\"]").unwrap();
    std::fs::write(folder.join("b.toml"), "files = [\"a.toml\"]").unwrap();
    let output = sweep(folder, &["plan", "a.toml"]).output().unwrap();
    assert!(
        text(&output).contains("wanted files that do not name each other"),
        "{}",
        text(&output)
    );
    // A folder that is somebody else's fails the run, and not the others.
    write(folder, "[grid]\nseed = [0, 1]\nsteps = [60]\nset = [\"start_steps=5000\"]\n");
    let plan = text(&sweep(folder, &["plan", "tiny.toml"]).output().unwrap());
    let taken = folder.join(plan.split_whitespace().nth(1).unwrap());
    std::fs::create_dir_all(&taken).unwrap();
    std::fs::write(taken.join("letter.txt"), "dear diary").unwrap();
    let output = sweep(folder, &["run", "tiny.toml"]).output().unwrap();
    let words = text(&output);
    assert!(!output.status.success(), "{words}");
    assert!(words.contains("failed: ") && words.contains("one that already exists"), "{words}");
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert!(status.contains("| failed |") && status.contains("already exists"), "{status}");
    assert!(status.contains("| done | 60 | 60 |"), "{status}");
}

#[test]
fn what_is_done_is_done_for_the_file_as_it_is() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let of = |steps: u64, seed: u64| {
        write(
            folder,
            &format!("[grid]\nseed = [{seed}]\nsteps = [{steps}]\nset = [\"start_steps=5000\"]\n"),
        );
    };
    let run = || {
        let output = sweep(folder, &["run", "tiny.toml"]).output().unwrap();
        (output.status.code(), text(&output))
    };
    of(60, 0);
    assert_eq!(run().0, Some(0));
    // More steps: it goes on.
    of(120, 0);
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert!(status.contains("| changed | 60 | 120 |"), "{status}");
    assert_eq!(run().0, Some(0));
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert!(status.contains("| done | 120 | 120 |"), "{status}");
    // Fewer: what is wrong is said, by the pool and later.
    of(60, 0);
    let (code, words) = run();
    assert!(code == Some(1) && words.contains("at least the planned 120, got 60"), "{words}");
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert!(
        status.contains("| changed |") && status.contains("wanted at least the planned 120"),
        "{status}"
    );
    // A file that has changed since its pool began trains nothing by mistake.
    let task = sweep(folder, &["task", "tiny.toml", "--task", "0", "--expect", "abc"]).output();
    assert!(text(&task.unwrap()).contains("begins with, has changed since this sweep was begun"));
}

/// The files that the repository has, but for those of Python environments, which need its
/// packages.
#[test]
fn the_repositorys_sweeps_can_be_planned() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let has_mujoco = cfg!(any(feature = "mujoco", feature = "system"));
    let mut planned = 0;
    for entry in std::fs::read_dir(folder.join("experiments")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let needs_mujoco = text.contains("mujoco") || text.contains("files =");
        if text.contains("python =") || needs_mujoco && !has_mujoco {
            continue;
        }
        let output = sweep(folder, &["plan", path.to_str().unwrap()]).output().unwrap();
        assert!(output.status.success(), "{}: {}", path.display(), self::text(&output));
        planned += 1;
    }
    assert!(planned >= if has_mujoco { 14 } else { 2 }, "{planned}");
}

/// Two pools of one sweep share its runs, and each run is trained once.
#[cfg(unix)]
#[test]
fn two_pools_do_no_harm() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    write(folder, "[grid]\nseed = [0, 1, 2, 3]\nsteps = [300]\nset = [\"start_steps=5000\"]\n");
    let pool = || {
        let mut command = sweep(folder, &["run", "tiny.toml", "--jobs", "2"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let pools = [pool(), pool()];
    for pool in pools {
        let output = pool.wait_with_output().unwrap();
        let words = text(&output);
        assert!(matches!(output.status.code(), Some(0 | 75)), "{words}");
        assert!(!words.contains("failed:"), "{words}");
    }
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert_eq!(status.matches("| done | 300 | 300 |").count(), 4, "{status}");
    let leftovers = std::fs::read_dir(folder.join("runs/tiny")).unwrap().flatten();
    let leftovers = leftovers.filter(|entry| entry.path().extension().is_some_and(|e| e == "err"));
    assert_eq!(leftovers.count(), 0);
}

/// One run that another process is at, and one that is told to save.
#[cfg(unix)]
#[test]
fn a_task_says_by_its_code_what_has_become_of_it() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    write(folder, "[grid]\nseed = [0]\nsteps = [400000]\nset = [\"start_steps=500000\"]\n");
    let task = || sweep(folder, &["task", "tiny.toml", "--task", "0"]);
    let mut first = task().stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_until("it begins", || {
        let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
        status.contains("| running |")
    });
    let second = task().output().unwrap();
    assert_eq!(second.status.code(), Some(73));
    let who = format!("process {} on ", first.id());
    assert!(text(&second).contains(&who), "{}", text(&second));
    let id = first.id().to_string();
    assert!(Command::new("kill").args(["-USR1", &id]).status().unwrap().success());
    assert_eq!(first.wait().unwrap().code(), Some(75));
    let status = text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    assert!(status.contains("| stopped |"), "{status}");
}

/// As the system does where no memory is left.
#[cfg(unix)]
#[test]
fn a_killed_run_says_how_it_ended() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    write(folder, "[grid]\nseed = [0]\nsteps = [400000]\nset = [\"start_steps=500000\"]\n");
    let status = || text(&sweep(folder, &["status", "tiny.toml"]).output().unwrap());
    let mut pool = sweep(folder, &["run", "tiny.toml"]);
    let pool = pool.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    let process = loop {
        assert!(begun.elapsed() < Duration::from_secs(60), "it does not begin");
        let status = status();
        if let Some((_, words)) = status.split_once(": process ") {
            break words.split(' ').next().unwrap().to_owned();
        }
    };
    assert!(Command::new("kill").args(["-KILL", &process]).status().unwrap().success());
    let words = text(&pool.wait_with_output().unwrap());
    assert!(words.contains("failed: ended by signal: 9 (SIGKILL)"), "{words}");
    assert!(status().contains("ended by signal: 9 (SIGKILL)"), "{}", status());
}

#[test]
fn what_is_submitted_is_written_down() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let grid = "out = \"a b\"\n[grid]\nseed = [0, 1, 2]\nsteps = [60]\n";
    write(folder, grid);
    let submit = |arguments: &[&str]| {
        let output = sweep(folder, &[&["submit", "tiny.toml"], arguments].concat()).output();
        text(&output.unwrap())
    };
    let slurm = submit(&["--dry-run", "--partition", "gpu", "--sbatch=--nice", "--at-once", "2"]);
    assert!(slurm.contains("sbatch --array=0-2%2 '"), "{slurm}");
    let folders = std::fs::read_dir(folder.join("a b/submit")).unwrap().flatten();
    let folders: Vec<_> = folders.map(|entry| entry.path()).collect();
    let [submitted] = folders.as_slice() else { panic!("{folders:?}") };
    let script = std::fs::read_to_string(submitted.join("runs.sbatch")).unwrap();
    // One task of an array has the array's own number, by which all would be requeued.
    let turn = "requeue \"${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\"";
    for line in ["#SBATCH --partition=gpu\n", "#SBATCH --nice\n", "/sweep.toml' --task", turn] {
        assert!(script.contains(line), "{script}");
    }
    let shell = |arguments: &[&str], name: &str| {
        Command::new("bash").args(arguments).arg(submitted.join(name)).output().unwrap()
    };
    assert!(shell(&["-n"], "runs.sbatch").status.success());
    // Its file means the same runs, wherever it is read.
    let frozen = submitted.join("sweep.toml");
    let plan = text(&sweep(folder, &["plan", frozen.to_str().unwrap()]).output().unwrap());
    assert!(plan.contains("/a b/cop-td3-a-hopper") && plan.lines().count() == 3, "{plan}");
    // A list for GNU parallel is one that any shell can run; its lines stay, whatever is done.
    let parallel = submit(&["--engine", "parallel"]);
    assert!(parallel.contains("--resume-failed"), "{parallel}");
    let list = std::fs::read_to_string(submitted.join("runs.txt")).unwrap();
    assert_eq!(list.lines().count(), 3, "{list}");
    let run = shell(&[], "runs.txt");
    assert!(run.status.success(), "{}", text(&run));
    let again = submit(&["--engine", "parallel"]);
    assert!(again.starts_with("all 3 runs are done"), "{again}");
    assert!(std::fs::read_to_string(submitted.join("runs.txt")).unwrap() == list);
    for (time, wanted) in [("9:00", "ten minutes at least"), ("soon", "a time as Slurm has it")] {
        let said = submit(&["--dry-run", "--time", time]);
        assert!(said.contains(wanted), "{said}");
    }
}

#[test]
fn a_papers_numbers_and_claims_stand_beside_the_runs() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let arms = "out = \"runs\"\n[all]\nsteps = 60\n[grid]\nseed = [0, 1, 2]\n[[arm]]\nname = \"cop-td3\"\n\
                [[arm]]\nname = \"extremum\"\nbound = \"extremum\"\n";
    std::fs::write(folder.join("inner.toml"), arms.to_owned() + PAPER).unwrap();
    // A file that takes another in has its paper, and so has the copy of a submission.
    std::fs::write(folder.join("outer.toml"), "files = [\"inner.toml\"]\nout = \"runs\"").unwrap();
    let said = |arguments: &[&str]| text(&sweep(folder, arguments).output().unwrap());
    said(&["submit", "outer.toml", "--dry-run"]);
    let submitted =
        std::fs::read_dir(folder.join("runs/submit")).unwrap().flatten().next().unwrap();
    let frozen = submitted.path().join("sweep.toml");
    for file in ["inner.toml", "outer.toml", frozen.to_str().unwrap()] {
        let report = said(&["report", file]);
        assert!(report.contains("6 waiting"), "{file}: {report}");
        let page = std::fs::read_to_string(folder.join("runs/report.html")).unwrap();
        for part in [
            "<td class=\"text\">it learns (section 5.1)</td>",
            "<td>too few seeds</td><td>undecided</td>",
            "<td>3042 ± 99 (5)</td>",
            "a/hopper: Table 7",
        ] {
            assert!(page.contains(part), "{file}: {part}");
        }
    }
    let wrong = arms.to_owned() + &PAPER.replace("than = \"extremum\"", "than = \"eigen\"");
    std::fs::write(folder.join("wrong.toml"), wrong).unwrap();
    let words = "than of the claim that it learns: wanted cop-td3 or extremum, got eigen";
    for action in ["plan", "report"] {
        let text = said(&[action, "wrong.toml"]);
        assert!(text.contains(words), "{action}: {text}");
    }
}

/// A dozen settings are no name for a folder.
#[test]
fn many_settings_make_a_short_name() {
    let temporary = tempfile::tempdir().unwrap();
    let keys = ["tau", "pessimism", "exploration_std", "networks.critic_lr", "networks.actor_lr"];
    let set: Vec<String> =
        keys.iter().map(|key| format!("\"{key}=0.0012345678901234567890\"")).collect();
    let file = format!(
        "[grid]\nseed = [0, 1]\n[all]\nset = [{}]\n[[arm]]\nname = \"{}\"\n",
        set.join(", "),
        "a".repeat(60)
    );
    std::fs::write(temporary.path().join("long.toml"), file).unwrap();
    let output = sweep(temporary.path(), &["plan", "long.toml"]).output().unwrap();
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    let names: std::collections::BTreeSet<&str> =
        said.split_whitespace().filter(|word| word.contains("aaaa")).collect();
    assert_eq!(names.len(), 2, "{said}");
    assert!(names.iter().all(|name| name.len() < 200), "{said}");
}
