//! Worlds that fail, signals in mid-evaluation, rows that are damaged: nothing is lost in silence.

use std::path::Path;

use copq::{Agent, Env, EnvSpec, Error, Outcome, Result, Rng, State, Stream, Trainer};
use copq_experiments::{Ending, OnEnvError, Plan, Run, RunFolder, Sheet, read_checkpoint};

use crate::point_mass::{self, PointMass, plan};
use crate::resume::{assert_same, open, train};

/// A world whose simulation fails at every so many steps.
struct Unstable {
    inner: PointMass,
    steps: u64,
    every: u64,
}

impl Env for Unstable {
    fn spec(&self) -> &EnvSpec {
        self.inner.spec()
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.inner.reset(seed, obs)
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.steps += 1;
        if self.steps.is_multiple_of(self.every) {
            let what = "the simulation is unstable".to_owned();
            return Err(Error::Env { env: "point".to_owned(), what });
        }
        self.inner.step(action, obs, reward)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("steps", [self.steps]);
        self.inner.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.steps = state.get_one("steps")?;
        self.inner.load(state)
    }
}

fn unstable(folder: RunFolder, plan: &Plan, every: u64) -> Run {
    let noise = Rng::new(plan.run.seed, Stream::Explore);
    let agent = point_mass::pusher(plan.run.seed, noise);
    let env = Unstable { inner: PointMass::new(), steps: 0, every };
    let trainer = Trainer::new(env, Box::new(agent) as Box<dyn Agent>).unwrap();
    Run::new(trainer, Some(Box::new(PointMass::new())), folder, plan.run).unwrap().silent()
}

fn steps_saved(folder: &Path) -> u64 {
    read_checkpoint(folder).unwrap().child("trainer").unwrap().get_one("steps").unwrap()
}

#[test]
fn a_failing_world_stops_the_run_saved_and_the_next_goes_on() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let plan = plan(3, 600);
    let folder = open(&path, &plan);
    let error = unstable(folder, &plan, 185).train().unwrap_err().to_string();
    assert!(
        error.contains("failed after step 184; the run is saved")
            && error.contains("RunFolder::resume")
            && error.ends_with("the simulation is unstable"),
        "{error}"
    );
    assert_eq!(steps_saved(&path), 184);
    let folder = open(&path, &plan);
    // The counter begins anew with the process.
    unstable(folder, &plan, 185).train().unwrap_err();
    assert_eq!(steps_saved(&path), 368);
}

#[test]
fn a_failing_world_is_counted_and_the_run_goes_on_if_it_is_told_so() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let mut plan = plan(3, 600);
    plan.run.on_env_error = OnEnvError::Reset;
    let folder = open(&path, &plan);
    assert!(matches!(unstable(folder, &plan, 150).train().unwrap(), Ending::Finished { .. }));
    let metrics = Sheet::read(&path.join("metrics.csv")).unwrap();
    assert_eq!(metrics.column("env_errors").unwrap().last(), Some(&4.0));
    let log = std::fs::read_to_string(path.join("log.txt")).unwrap();
    assert_eq!(log.matches("the episode counts as truncated").count(), 4, "{log}");
    let hopeless = temporary.path().join("hopeless");
    let folder = open(&hopeless, &plan);
    assert!(unstable(folder, &plan, 1).train().is_err(), "it never does a step");
}

#[test]
fn rows_that_nobody_writes_again_are_not_deleted() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    train(&path, 5, 600);
    let file = path.join("evaluations.csv");
    let sound = std::fs::read_to_string(&file).unwrap();
    let plan = plan(5, 900);
    let damages: [fn(&str) -> String; 3] = [
        |text| text.replace(',', ";"),
        |text| text.replacen("\n250,", "\nx,", 1),
        |text| text.replace("\n250,", "\n250.0,"),
    ];
    for damage in damages {
        std::fs::write(&file, damage(&sound)).unwrap();
        let folder = open(&path, &plan);
        let env = Some(Box::new(PointMass::new()) as Box<dyn Env>);
        let error = Run::new(point_mass::trainer(5), env, folder, plan.run).unwrap_err();
        let error = error.to_string();
        assert!(error.starts_with("line ") && error.contains("evaluations.csv"), "{error}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), damage(&sound));
    }
    std::fs::remove_file(&file).unwrap();
    train(&path, 5, 900);
    assert_eq!(Sheet::read(&file).unwrap().steps(), [750, 900], "without its rows, as was said");
}

#[test]
fn a_damaged_checkpoint_has_one_before_it() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let path = temporary.path().join("run");
    train(&whole, 5, 900);
    train(&path, 5, 700); // checkpoints at 300, 600 and 700
    let newest = path.join("checkpoint.safetensors");
    let mut bytes = std::fs::read(&newest).unwrap();
    let middle = bytes.len() - 5;
    bytes[middle] ^= 4;
    std::fs::write(&newest, bytes).unwrap();
    let plan = plan(5, 900);
    let mut folder = open(&path, &plan);
    let error = folder.load().unwrap_err().to_string();
    assert!(
        error.contains("RunFolder::go_back resumes from") && error.contains("array '"),
        "{error}"
    );
    assert!(!folder.go_back().unwrap(), "it is damaged");
    drop(point_mass::run(folder, &plan));
    assert_eq!(steps_saved(&path), 600);
    assert!(path.join("checkpoint.damaged.safetensors").exists());
    train(&path, 5, 900);
    assert_same(&whole, &path);
}

#[test]
fn going_back_finds_the_next_one_that_is_sound() {
    let temporary = tempfile::tempdir().unwrap();
    let whole = temporary.path().join("whole");
    let path = temporary.path().join("run");
    train(&whole, 5, 900);
    let mut plan = plan(5, 900);
    (plan.run.keep, plan.run.steps) = (3, 700); // checkpoints at 300, 600 and 700
    point_mass::run(open(&path, &plan), &plan).silent().train().unwrap();
    for name in ["checkpoint.safetensors", "checkpoint.1.safetensors"] {
        std::fs::write(path.join(name), "torn").unwrap();
    }
    (plan.run.keep, plan.run.steps) = (2, 900);
    let mut folder = open(&path, &plan);
    assert!(!folder.go_back().unwrap(), "the last one is damaged");
    point_mass::run(folder, &plan).silent().train().unwrap();
    assert_same(&whole, &path);
    assert!(path.join("checkpoint.damaged.safetensors").exists());
}

#[test]
fn going_back_in_vain_moves_nothing_and_what_is_laid_aside_stays() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let mut plan = plan(5, 900);
    plan.run.keep = 3;
    point_mass::run(open(&path, &plan), &plan).silent().train().unwrap();
    let names = ["", ".1", ".2"].map(|age| path.join(format!("checkpoint{age}.safetensors")));
    let read = || names.each_ref().map(|name| std::fs::read(name).unwrap());
    let before = read();
    let back = || {
        let mut folder = open(&path, &plan);
        assert!(folder.go_back().unwrap(), "the last one is sound");
        let env = Some(Box::new(PointMass::new()) as Box<dyn Env>);
        Run::new(point_mass::trainer(5), env, folder, plan.run)
    };
    let rows = path.join("evaluations.csv");
    let sound = std::fs::read_to_string(&rows).unwrap();
    std::fs::write(&rows, sound.replacen("\n250,", "\nx,", 1)).unwrap();
    for _ in 0..2 {
        assert!(back().unwrap_err().to_string().starts_with("line "));
        assert!(read() == before);
    }
    std::fs::write(&rows, sound).unwrap();
    for step in [600, 300] {
        drop(back().unwrap());
        assert_eq!(steps_saved(&path), step);
    }
    for (name, wanted) in [("later", &before[0]), ("later-2", &before[1])] {
        let file = path.join(format!("checkpoint.{name}.safetensors"));
        assert!(std::fs::read(file).unwrap() == *wanted, "{name}");
    }
}

#[test]
fn as_many_checkpoints_stay_as_were_asked_for() {
    let temporary = tempfile::tempdir().unwrap();
    for (keep, wanted) in [(1, vec![900]), (2, vec![900, 600]), (4, vec![900, 600, 300])] {
        let path = temporary.path().join(keep.to_string());
        let mut plan = plan(5, 900);
        plan.run.keep = keep;
        let folder = open(&path, &plan);
        point_mass::run(folder, &plan).silent().train().unwrap();
        let mut steps = Vec::new();
        for age in 0..6 {
            let name = match age {
                0 => "checkpoint.safetensors".to_owned(),
                _ => format!("checkpoint.{age}.safetensors"),
            };
            if let Ok(state) = State::read_file(path.join(name)) {
                let trainer = state.child("trainer").unwrap();
                steps.push(trainer.get_one::<u64>("steps").unwrap());
            }
        }
        assert_eq!(steps, wanted, "of {keep}");
    }
}

#[test]
fn evaluation_can_be_off_or_in_the_training_world() {
    let temporary = tempfile::tempdir().unwrap();
    let off = temporary.path().join("off");
    let mut never = plan(5, 600);
    never.run.eval_every = 0;
    let folder = open(&off, &never);
    Run::new(point_mass::trainer(5), None, folder, never.run).unwrap().silent().train().unwrap();
    assert!(Sheet::read(&off.join("evaluations.csv")).unwrap().steps().is_empty());

    let own = temporary.path().join("own");
    let shared = temporary.path().join("shared");
    train(&own, 5, 600);
    let plan = plan(5, 600);
    let folder = open(&shared, &plan);
    Run::new(point_mass::trainer(5), None, folder, plan.run).unwrap().silent().train().unwrap();
    let read = |folder: &Path| std::fs::read(folder.join("evaluations.csv")).unwrap();
    assert_eq!(read(&own), read(&shared), "the training world goes on where it was");
}

/// As after a kill: the best evaluation is of steps that the run will do anew, perhaps otherwise.
#[test]
fn the_best_policy_outlives_its_row() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    train(&path, 5, 500);
    let file = path.join("evaluations.csv");
    let rows = std::fs::read_to_string(&file).unwrap();
    let total = rows.lines().next().unwrap().split(',').position(|n| n == "weighted_total/mean");
    let mut best: Vec<_> = rows.lines().last().unwrap().split(',').collect();
    (best[0], best[total.unwrap()]) = ("750", "1000");
    let policies = path.join("policy-best.safetensors");
    let kill_and_resume = |policy: &str| {
        std::fs::write(&file, format!("{rows}{}\n", best.join(","))).unwrap();
        copq::files::replace(&policies, policy.as_bytes()).unwrap();
        let plan = plan(5, 900);
        point_mass::run(open(&path, &plan), &plan)
    };
    let before = |number: &str| {
        std::fs::read_to_string(path.join(format!("policy-best-before{number}.safetensors"))).ok()
    };
    for policy in ["one", "one", "another"] {
        drop(kill_and_resume(policy));
    }
    assert_eq!((before("").as_deref(), before("-2").as_deref()), (Some("one"), Some("another")));
    assert_eq!(before("-3"), None);
    kill_and_resume("one").silent().train().unwrap();
    let log = std::fs::read_to_string(path.join("log.txt")).unwrap();
    assert!(log.contains("its policy is kept as ") && log.contains("policy-best-before"), "{log}");
    assert!(Sheet::read(&file).unwrap().column("weighted_total/mean").unwrap()[3] < 1_000.0);
}

/// The remedy for a damaged evaluations.csv: without its rows nobody knows how good the best was.
#[test]
fn the_best_policy_outlives_the_file_of_its_row() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    train(&path, 5, 500);
    std::fs::remove_file(path.join("evaluations.csv")).unwrap();
    copq::files::replace(&path.join("policy-best.safetensors"), b"the best").unwrap();
    train(&path, 5, 900);
    let before = std::fs::read_to_string(path.join("policy-best-before.safetensors"));
    assert_eq!(before.ok().as_deref(), Some("the best"));
}

/// Another run may have a folder of this name by now.
#[test]
fn a_run_whose_folder_was_moved_leaves_its_successors_alone() {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let plan = plan(5, 900);
    let forgotten = open(&path, &plan);
    std::fs::rename(&path, temporary.path().join("moved")).unwrap();
    drop(open(&path, &plan));
    // This process is that run's, too: another one's name.
    std::fs::write(path.join(".lock"), "process 1 on elsewhere\n").unwrap();
    let error = forgotten.save(&State::default()).unwrap_err().to_string();
    let wanted = "wanted the one that this run began in, got that of process 1 on elsewhere";
    assert!(error.ends_with(wanted), "{error}");
    assert!(!path.join("checkpoint.safetensors").exists());
    std::fs::remove_dir_all(&path).unwrap();
    let error = forgotten.save(&State::default()).unwrap_err().to_string();
    assert!(error.ends_with("got none"), "{error}");
    assert!(!path.exists());
}
