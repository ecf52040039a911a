//! What has changed since a run began, or between two runs: its policy, its length, its films.

use std::path::Path;

use crate::common::{TINY, copq_in, read, run};

/// All that it says, whether it fails or not.
fn said(folder: &Path, line: &str) -> String {
    let output = copq_in(folder, line).output().unwrap();
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
}

/// A sweep of tiny runs that differ in their seeds, with more options.
fn write_sweep(folder: &Path, seeds: &str, options: &str) {
    let text = format!(
        "[grid]\nseed = {seeds}\n[all]\neval-every = 50\neval-episodes = 1\nlog-every = 10\n\
         set = [\"networks.hidden=[8,8]\", \"batch=8\", \"start_steps=40\"]\n{options}"
    );
    std::fs::write(folder.join("tiny.toml"), text).unwrap();
}

/// The sweep's run of a seed.
fn run_of(folder: &Path, seed: u64) -> String {
    let end = format!("-s{seed}");
    let names = std::fs::read_dir(folder.join("runs/tiny")).unwrap().flatten();
    let mut names = names.map(|entry| entry.file_name().into_string().unwrap());
    format!("runs/tiny/{}", names.find(|name| name.ends_with(&end)).unwrap())
}

#[test]
fn a_run_knows_the_policy_that_it_began_with() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for seed in [7, 8] {
        run(folder, &format!("train {TINY} --steps 60 --seed {seed} --out teacher-{seed}"));
    }
    let teach = |seed: u64| {
        let from = folder.join(format!("teacher-{seed}/policy.safetensors"));
        std::fs::copy(from, folder.join("policy.safetensors")).unwrap();
    };
    teach(7);
    let options = "steps = 60\ninit-from = \"policy.safetensors\"\n";
    write_sweep(folder, "[0]", options);
    run(folder, "sweep run tiny.toml");
    assert!(run(folder, "sweep status tiny.toml").contains("| done |"));
    // Another policy in its place is another method, and no run of it is done.
    teach(8);
    assert!(run(folder, "sweep status tiny.toml").contains("| changed |"));
    assert!(said(folder, "sweep run tiny.toml").contains("plan.init_checksum (a run resumes with"));
    write_sweep(folder, "[1]", options);
    run(folder, "sweep run tiny.toml");
    let page = run(folder, "report runs --out page.html --parts parts");
    assert!(page.contains("2 runs: 2 done"), "{page}");
    let rows = read(folder.join("parts/final.csv"));
    assert_eq!(rows.matches("policy=").count(), 2, "{rows}");
    let run_of = |seed: u64| run_of(folder, seed);
    let line = format!("plot a={} a={}", run_of(0), run_of(1));
    assert!(said(folder, &line).contains("from policy.safetensors ("), "{}", said(folder, &line));
    // A policy that is gone has been what it was; a run from before checksums goes on.
    std::fs::remove_file(folder.join("policy.safetensors")).unwrap();
    write_sweep(folder, "[0, 1]", options);
    assert_eq!(run(folder, "sweep status tiny.toml").matches("| done |").count(), 2);
    teach(7);
    let config = folder.join(run_of(0)).join("config.toml");
    let text = read(&config);
    let old: String = text
        .lines()
        .filter(|line| !line.starts_with("init_checksum"))
        .fold(String::new(), |all, line| all + line + "\n");
    assert!(old.len() < text.len());
    std::fs::write(&config, old).unwrap();
    std::fs::remove_file(folder.join(run_of(0)).join("DONE")).unwrap();
    write_sweep(folder, "[0]", options);
    run(folder, "sweep run tiny.toml");
    assert!(run(folder, "sweep status tiny.toml").contains("| done |"));
    // Killed before it had a copy, a run takes no other policy for its own.
    let begun = folder.join("begun");
    std::fs::create_dir(&begun).unwrap();
    std::fs::write(begun.join("config.toml"), text).unwrap();
    teach(8);
    let words = said(folder, "resume begun");
    assert!(words.contains("with which the run begins: wanted the policy of checksum"), "{words}");
}

#[test]
fn a_film_is_of_the_policy_that_there_is() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    run(folder, &format!("train {TINY} --steps 60 --out runs/a-s0"));
    let film = folder.join("runs/a-s0/rollout.gif");
    let report = || drop(run(folder, "report runs --rollouts"));
    report();
    assert!(std::fs::read(&film).unwrap().starts_with(b"GIF89a"));
    // As new as the policy, it stays; older than the policy, it is made again.
    std::fs::write(&film, "a film").unwrap();
    report();
    assert_eq!(read(&film), "a film");
    let hour = std::time::Duration::from_secs(3_600);
    let earlier = std::time::SystemTime::now() - hour;
    std::fs::File::options().append(true).open(&film).unwrap().set_modified(earlier).unwrap();
    report();
    assert!(std::fs::read(&film).unwrap().starts_with(b"GIF89a"));
}

/// Over more steps its step size falls otherwise from the first on.
#[test]
fn a_longer_run_whose_step_size_falls_is_another() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let write = |steps: u64| {
        let text = format!(
            "[all]\nmethod = \"ppo\"\nsteps = {steps}\neval-every = 0\n\
             set = [\"steps_per_epoch=64\"]\n"
        );
        std::fs::write(folder.join("tiny.toml"), text).unwrap();
    };
    write(128);
    run(folder, "sweep run tiny.toml");
    write(256);
    let wanted = "its step size falls over 128 steps, the file's over 256, which is another run";
    let before = said(folder, "sweep status tiny.toml");
    assert!(before.contains("| changed |") && before.contains(wanted), "{before}");
    assert!(said(folder, "sweep run tiny.toml").contains(wanted));
    let after = said(folder, "sweep status tiny.toml");
    assert_eq!(after.matches(wanted).count(), 1, "{after}");
    // As it says.
    let (_, advice) = after.split_once("copq resume ").unwrap();
    let (name, _) = advice.split_once(" --steps").unwrap();
    run(folder, &format!("resume {name} --steps 256"));
    write(64);
    let words = said(folder, "sweep run tiny.toml");
    assert!(words.contains("wanted 128, got 64") && !words.contains("is another run"), "{words}");
}
