//! Gymnasium's own environments through the bridge to Python, against copq's on the same MuJoCo.

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use copq::{Env, Outcome, Rng};
use copq_envs::Locomotion;
use copq_envs::robot::Noise;
use copq_envs::task::Signal;
use copq_envs_mujoco::mujoco_rs::physics;
use copq_envs_python::{Options, PythonEnv};

/// The interpreter that scripts/python-worlds.sh makes, with the same MuJoCo.
fn python() -> Option<PathBuf> {
    let usual = concat!(env!("CARGO_MANIFEST_DIR"), "/../third_party/gymnasium/bin/python");
    let python = std::env::var_os("COPQ_TEST_PYTHON").map_or(usual.into(), PathBuf::from);
    if python.exists() {
        return std::path::absolute(python).ok();
    }
    writeln!(
        std::io::stderr(),
        "SKIPPED: there is no {} (scripts/python-worlds.sh)",
        python.display()
    )
    .unwrap_or_default();
    None
}

/// The same interpreter in a folder of its own, where Python's MuJoCo leaves its log.
fn in_folder(python: &Path, folder: &Path) -> PathBuf {
    let script = folder.join("python");
    let [folder, python] = [folder, python].map(Path::display);
    let text = format!("#!/bin/sh\ncd '{folder}' && exec '{python}' \"$@\"\n");
    std::fs::write(&script, text).unwrap();
    std::fs::set_permissions(&script, Permissions::from_mode(0o755)).unwrap();
    script
}

/// Ours, which starts where the model does, without noise; its control is free or has its price.
fn ours(name: &str, is_free: bool) -> Box<dyn Env> {
    let mut task = copq_envs::task(name).unwrap();
    task.robot.reset_noise = [Noise::Uniform(0.0); 2];
    if is_free {
        task.objectives[0].terms.retain(|(_, signal)| *signal != Signal::MotorControl);
    }
    let engine = physics(&task.robot).unwrap();
    Box::new(Locomotion::new(task, engine).unwrap())
}

/// Gymnasium's, likewise.
fn gymnasiums(id: &str, is_free: bool, python: PathBuf) -> PythonEnv {
    let price = if is_free { r#", "ctrl_cost_weight": 0.0"# } else { "" };
    let kwargs = format!(r#"{{"reset_noise_scale": 0.0{price}}}"#);
    let options = Options { python: Some(python), kwargs, ..Options::default() };
    PythonEnv::new(&format!("gymnasium:{id}"), &options).unwrap()
}

/// What a thousand steps of the same actions show, and what they are worth.
fn play(env: &mut dyn Env) -> (Vec<u32>, Vec<f32>) {
    let spec = env.spec().clone();
    let mut rng = Rng::with_stream(5, 1);
    let mut obs = vec![0.0; spec.obs_len];
    let mut reward = [0.0];
    let mut seen = Vec::new();
    let mut rewards = Vec::new();
    env.reset(0, &mut obs).unwrap();
    for _ in 0..1_000 {
        let action: Vec<f32> = std::iter::zip(&spec.action_low, &spec.action_high)
            .map(|(&low, &high)| rng.uniform_in(low.into(), high.into()) as f32)
            .collect();
        let outcome = env.step(&action, &mut obs, &mut reward).unwrap();
        seen.extend(obs.iter().map(|number| number.to_bits()));
        seen.push(u32::from(outcome == Outcome::Terminated));
        rewards.push(reward[0]);
        if outcome != Outcome::Running {
            env.reset(0, &mut obs).unwrap();
        }
    }
    (seen, rewards)
}

#[test]
fn robots_are_gymnasiums_bit_for_bit() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let python = in_folder(&python, folder.path());
    for (name, id) in [
        ("gym/hopper", "Hopper-v5"),
        ("gym/walker2d", "Walker2d-v5"),
        ("gym/halfcheetah", "HalfCheetah-v5"),
    ] {
        let (seen, rewards) = play(&mut *ours(name, true));
        let (wanted, wanted_rewards) = play(&mut gymnasiums(id, true, python.clone()));
        assert_eq!(seen.len(), wanted.len(), "{name}");
        let first = seen.iter().zip(&wanted).position(|(seen, wanted)| seen != wanted);
        assert_eq!(first, None, "{name}: the first number that differs");
        let bits = |rewards: &[f32]| rewards.iter().map(|r| r.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&rewards), bits(&wanted_rewards), "{name}");

        // Gymnasium squares and sums f32 actions in f32: what they cost rounds otherwise.
        let (_, rewards) = play(&mut *ours(name, false));
        let (_, wanted) = play(&mut gymnasiums(id, false, python.clone()));
        for (reward, wanted) in rewards.iter().zip(&wanted) {
            let largest = f32::EPSILON * wanted.abs().max(1.0);
            assert!((reward - wanted).abs() <= largest, "{name}: {reward}, {wanted}");
        }
    }
}
