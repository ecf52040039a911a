//! What happens to runs in everyday life: readers that go away, closed terminals, odd folders,
//! damaged files, and beginnings from other runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{assert_well, copq, wait_until, words};

const TINY: &str = "--eval-every 100 --eval-episodes 1 --log-every 50 --set start_steps=50 \
                    --set networks.hidden=[8] --set batch=8";

/// A tiny run for so many steps into a folder.
fn train(out: &Path, steps: &str) -> Command {
    let mut command = copq();
    command.arg("train").args(TINY.split(' ')).args(["--steps", steps, "--out"]).arg(out);
    command
}

fn resume(folder: &Path, steps: &str) -> Output {
    copq().arg("resume").arg(folder).args(["--steps", steps]).output().unwrap()
}

/// What may not depend on how a run was interrupted.
fn assert_same(a: &Path, b: &Path) {
    for name in ["metrics.csv", "evaluations.csv", "policy.safetensors", "checkpoint.safetensors"] {
        let read = |folder: &Path| std::fs::read(folder.join(name)).unwrap();
        assert!(read(a) == read(b), "{name} differs in {} and {}", a.display(), b.display());
    }
}

#[test]
fn a_run_outlives_whoever_reads_it() {
    let temporary = tempfile::tempdir().unwrap();
    let shell = |name: &str, redirections: &str| {
        let out = temporary.path().join(name);
        let program = env!("CARGO_BIN_EXE_copq");
        let train = format!("'{program}' train {TINY} --steps 300 --out '{}'", out.display());
        let script = format!("set -o pipefail; {train} {redirections}");
        let status = Command::new("bash").args(["-c", &script]).status().unwrap();
        assert!(status.success(), "{name}: {status}");
        assert!(out.join("checkpoint.safetensors").exists(), "{name}");
        let log = std::fs::read_to_string(out.join("log.txt")).unwrap();
        assert!(log.contains("300 steps: total") && log.contains("steps/s"), "{name}: {log}");
    };
    shell("reader", "2>&1 | head -1 > /dev/null");
    shell("full", "2> /dev/full > /dev/full");
    shell("answer", "2> /dev/null | true");
    shell("closed", "2>&- >&-");
}

#[test]
fn a_closed_terminal_saves_unless_it_was_told_not_to_matter() {
    let temporary = tempfile::tempdir().unwrap();
    let hang_up = |name: &str, ignored: &str| {
        let out = temporary.path().join(name);
        let script = format!("{ignored} exec \"$0\" \"$@\"");
        let mut child = Command::new("bash")
            .args(["-c", &script, env!("CARGO_BIN_EXE_copq"), "train"])
            .args(TINY.split(' '))
            .args(["--steps", "100000", "--out"])
            .arg(&out)
            .stderr(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        wait_for(&out.join("metrics.csv"), 3);
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-HUP", &id]).status().unwrap().success());
        // Once more, as a terminal's shell and the terminal do.
        Command::new("kill").args(["-HUP", &id]).status().unwrap();
        let lines = std::fs::read_to_string(out.join("metrics.csv")).unwrap().lines().count();
        let goes_on = || {
            let text = std::fs::read_to_string(out.join("metrics.csv")).unwrap();
            text.lines().count() > lines + 3
        };
        let began = Instant::now();
        let ended = loop {
            assert!(began.elapsed() < Duration::from_secs(60), "{name}");
            match child.try_wait().unwrap() {
                Some(status) => break Some(status),
                None if goes_on() => break None,
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        child.kill().unwrap();
        child.wait().unwrap();
        ended.map(|status| (status.code(), out.join("checkpoint.safetensors").exists()))
    };
    assert_eq!(hang_up("terminal", ""), Some((Some(75), true)));
    assert_eq!(hang_up("nohup", "trap '' HUP;"), None, "it goes on");
}

/// Waits for so many lines of a file.
fn wait_for(file: &Path, lines: usize) {
    wait_until(&file.to_string_lossy(), || {
        std::fs::read_to_string(file).map_or(0, |text| text.lines().count()) >= lines
    });
}

#[test]
fn a_signal_ends_a_long_evaluation_and_the_resumed_run_does_it_again() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let stopped = temporary.path().join("stopped");
    let train = |out: &Path| {
        let mut command = copq();
        command.args(["train", "--eval-episodes", "1000"]).args(TINY.split(' ').skip(4));
        command.args(["--eval-every", "100", "--steps", "100", "--out"]).arg(out);
        command
    };
    assert_well(&train(&whole).output().unwrap());
    let child = train(&stopped).stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    wait_for(&stopped.join("log.txt"), 1);
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(75), "it can go on, and whoever waits for it shall know");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("stopped and saved at step 0"), "{said}{}", words(&output));
    assert!(!words(&output).contains("nothing to do"), "{}", words(&output));
    assert_well(&resume(&stopped, "100"));
    assert_same(&whole, &stopped);
}

/// Two worlds end one step later than the run's last, which is on no interval.
#[test]
fn a_run_of_several_worlds_that_is_done_is_left_as_it_is() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let line = "train ppo --task b/hopper --envs 2 --steps 133 --eval-every 100 \
                --eval-episodes 1 --set steps_per_epoch=100 --out";
    assert_well(&copq().args(line.split_whitespace()).arg(&run).output().unwrap());
    // Nobody can see whether the last row is written again, unless it is another.
    let file = run.join("evaluations.csv");
    let rows = std::fs::read_to_string(&file).unwrap();
    let last = rows.lines().last().unwrap();
    assert!(last.starts_with("134,1,"), "{last}");
    let rows = rows.replace(last, &last.replacen("134,1,", "134,2,", 1));
    std::fs::write(&file, &rows).unwrap();
    let output = resume(&run, "133");
    assert_well(&output);
    assert!(words(&output).contains("nothing to do"), "{}", words(&output));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), rows);
}

#[test]
fn any_empty_folder_will_do() {
    let temporary = tempfile::tempdir().unwrap();
    let here = temporary.path().join("here");
    std::fs::create_dir(&here).unwrap();
    let run = |out: &Path| train(out, "20").current_dir(&here).output().unwrap();
    assert_well(&run(Path::new(".")));
    assert!(here.join("config.toml").exists());
    let target = temporary.path().join("target");
    let link = temporary.path().join("link");
    std::fs::create_dir(&target).unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    assert_well(&run(&link));
    assert_well(&run(&temporary.path().join("n".repeat(250))));
    assert_well(&run(&temporary.path().join("a/new/one")));
    // A start that was killed, and a disk's own.
    let begun = temporary.path().join("begun");
    std::fs::create_dir_all(begun.join("lost+found")).unwrap();
    std::fs::write(begun.join(".config.toml.part"), "half of a").unwrap();
    assert_well(&run(&begun));
    let output = run(&target);
    assert!(words(&output).contains("one that already exists"), "{}", words(&output));
    // What cannot be trained leaves no folder.
    let never = temporary.path().join("never");
    let output = train(&never, "20").args(["--set", "batch=9000000000000000000"]).output().unwrap();
    assert!(words(&output).contains("batch: wanted what fits into"), "{}", words(&output));
    let huge = ["--set", "target_period=18446744073709551615"];
    assert!(!train(&never, "20").args(huge).output().unwrap().status.success());
    assert!(!never.exists());
}

#[test]
fn files_are_as_readable_as_the_umask_says() {
    use std::os::unix::fs::PermissionsExt;
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("run");
    let script = "umask 022; exec \"$0\" \"$@\"";
    let mut command = Command::new("bash");
    command.args(["-c", script, env!("CARGO_BIN_EXE_copq"), "train"]).args(TINY.split(' '));
    assert_well(&command.args(["--steps", "120", "--out"]).arg(&out).output().unwrap());
    for entry in std::fs::read_dir(&out).unwrap() {
        let entry = entry.unwrap();
        let mode = entry.metadata().unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, 0o644, "{}", entry.path().display());
    }
}

#[test]
fn a_run_begins_with_another_ones_policy_or_like_another() {
    let temporary = tempfile::tempdir().unwrap();
    let path = |name: &str| temporary.path().join(name);
    assert_well(&train(&path("teacher"), "220").output().unwrap());
    assert!(path("teacher").join("policy-best.safetensors").exists());

    let policy = path("teacher").join("policy.safetensors");
    let mut pupil = train(&path("pupil"), "220");
    assert_well(&pupil.arg("--init-from").arg(policy).output().unwrap());
    let config = std::fs::read_to_string(path("pupil").join("config.toml")).unwrap();
    assert!(config.contains("init_from = "), "{config}");
    assert!(config.contains("warm_up = \"policy\""), "it acts from the first step on: {config}");
    assert!(path("pupil").join("policy-init.safetensors").exists());
    let first = |name: &str| {
        let text = std::fs::read_to_string(path(name).join("evaluations.csv")).unwrap();
        text.lines().nth(1).unwrap().to_owned()
    };
    assert_ne!(first("pupil"), first("teacher"), "it knows something at step 0");

    let mut like = copq();
    like.args(["train", "--like"]).arg(path("teacher")).arg("--out").arg(path("twin"));
    assert_well(&like.output().unwrap());
    assert_same(&path("teacher"), &path("twin"));
    let mut like = copq();
    like.args(["train", "--like"]).arg(path("teacher")).arg("--out").arg(path("other"));
    assert_well(&like.args(["--seed", "7", "--set", "batch=16"]).output().unwrap());
    let config = std::fs::read_to_string(path("other").join("config.toml")).unwrap();
    for words in ["seed = 7", "batch = 16", "steps = 220", "hidden = [8]"] {
        assert!(config.contains(words), "{words}: {config}");
    }
    // A run like one that began with a policy begins with its copy, whatever became of the other.
    let file = path("teacher").join("policy.safetensors");
    std::fs::write(file, "no policy any more").unwrap();
    let mut like = copq();
    like.args(["train", "--like"]).arg(path("pupil")).arg("--out").arg(path("pupils-twin"));
    assert_well(&like.output().unwrap());
    assert_same(&path("pupil"), &path("pupils-twin"));
    // A run goes on without its teacher, from its first step too.
    std::fs::remove_dir_all(path("teacher")).unwrap();
    assert_well(&resume(&path("pupil"), "230"));
    let begun = path("begun");
    std::fs::create_dir(&begun).unwrap();
    for file in ["config.toml", "policy-init.safetensors"] {
        std::fs::copy(path("pupil").join(file), begun.join(file)).unwrap();
    }
    assert_well(&resume(&begun, "230"));
    assert_eq!(first("begun"), first("pupil"));

    let mut wrong = copq();
    wrong.args(["train", "sac", "--init-from"]).arg(path("pupil")).arg("--out").arg(path("x"));
    let output = wrong.output().unwrap();
    assert!(words(&output).contains("the policy to begin with: wanted"), "{}", words(&output));
}

#[test]
fn a_refused_resume_leaves_the_run_as_it_was() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    assert_well(&train(&run, "120").output().unwrap());
    let read = |name: &str| std::fs::read(run.join(name)).unwrap();
    let names = ["DONE", "config.toml", "log.txt", "metrics.csv", "timings.csv"];
    let before = names.map(read);
    let rows = String::from_utf8(read("evaluations.csv")).unwrap();
    std::fs::write(run.join("evaluations.csv"), rows.replace("\n100,", "\n100.0,")).unwrap();
    let output = resume(&run, "130");
    assert!(words(&output).contains("line 3 of"), "{}", words(&output));
    assert_eq!(names.map(read), before);
    std::fs::write(run.join("evaluations.csv"), rows).unwrap();
    assert_well(&resume(&run, "130"));
}

#[test]
fn the_last_policy_is_the_one_that_was_written_last() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    let mut command = train(&run, "200");
    assert_well(&command.args(["--checkpoint-every", "200"]).output().unwrap());
    // As after a kill between two checkpoints: an evaluation's policy beside an older checkpoint.
    let policy = std::fs::read(run.join("policy-best.safetensors")).unwrap();
    std::fs::write(run.join("policy.safetensors"), &policy).unwrap();
    let out = temporary.path().join("out.safetensors");
    let export = |run: &Path| copq().arg("export").arg(run).arg("--out").arg(&out).output();
    assert_well(&export(&run).unwrap());
    assert!(std::fs::read(&out).unwrap() == policy);
    std::fs::remove_file(run.join("checkpoint.safetensors")).unwrap();
    assert_well(&copq().arg("evaluate").arg(&run).args(["--episodes", "1"]).output().unwrap());
}

/// Every array of a checkpoint, damaged in turn: each is found before anything is believed.
#[test]
fn no_damaged_checkpoint_goes_on() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    assert_well(&train(&run, "120").output().unwrap());
    let file = run.join("checkpoint.safetensors");
    let sound = std::fs::read(&file).unwrap();
    let header = 8 + u64::from_le_bytes(sound[..8].try_into().unwrap()) as usize;
    let mut at = 4;
    while at < sound.len() {
        let mut damaged = sound.clone();
        damaged[at] ^= 1 << (at % 8);
        std::fs::write(&file, &damaged).unwrap();
        let output = resume(&run, "130");
        let said = words(&output);
        assert_eq!(output.status.code(), Some(1), "byte {at}: {said}");
        assert!(said.contains("checkpoint.safetensors"), "byte {at}: {said}");
        assert!(!said.contains("panicked"), "byte {at}: {said}");
        at += if at < header { header / 8 } else { (sound.len() - header) / 24 };
    }
    let config: PathBuf = run.join("config.toml");
    let text = std::fs::read_to_string(&config).unwrap();
    std::fs::write(&file, &sound).unwrap();
    std::fs::write(&config, text.replace("discount = 0.995", "discount = 0.9")).unwrap();
    let output = resume(&run, "130");
    assert!(words(&output).contains("discount of the saved learner"), "{}", words(&output));
    std::fs::write(&config, text).unwrap();
    assert_well(&resume(&run, "130"));
}

#[test]
fn checkpoints_without_a_replay_are_small_and_go_on() {
    let temporary = tempfile::tempdir().unwrap();
    let size = |folder: &Path, name: &str| std::fs::metadata(folder.join(name)).unwrap().len();
    let run = |replay: &str| {
        let out = temporary.path().join(replay);
        let mut command = train(&out, "400");
        command.args(["--checkpoint-every", "200", "--replay", replay]);
        assert_well(&command.output().unwrap());
        out
    };
    let [all, last, none] = ["all", "last", "none"].map(run);
    let newest = "checkpoint.safetensors";
    let before = "checkpoint.1.safetensors";
    assert_eq!(size(&all, newest), size(&last, newest));
    assert!(size(&none, newest) + 20_000 < size(&all, newest), "400 steps take 60 bytes each");
    assert!(size(&last, before) < size(&all, before));

    // It gathers 50 steps, as before the first update, and learns on.
    assert_well(&resume(&none, "600"));
    let metrics = std::fs::read_to_string(none.join("metrics.csv")).unwrap();
    let column = metrics.lines().next().unwrap().split(',').position(|name| name == "q/safety");
    let cell = |step: &str| {
        let row = metrics.lines().find(|line| line.starts_with(&format!("{step},"))).unwrap();
        row.split(',').nth(column.unwrap()).unwrap().to_owned()
    };
    assert_eq!((cell("400").is_empty(), cell("450").is_empty()), (false, false), "{metrics}");
    assert!(!cell("600").is_empty());
    let log = std::fs::read_to_string(none.join("log.txt")).unwrap();
    assert!(log.contains("has no replay: learning resumes at step 450"), "{log}");

    // Again, and from a run that was still gathering.
    assert_well(&resume(&none, "620"));
    assert_well(&resume(&none, "700"));
    let metrics = std::fs::read_to_string(none.join("metrics.csv")).unwrap();
    let row = metrics.lines().find(|line| line.starts_with("650,")).unwrap();
    assert!(row.split(',').nth(column.unwrap()).unwrap().is_empty(), "{row}");
    assert_eq!(metrics.lines().last().unwrap().split(',').next(), Some("700"));
}
