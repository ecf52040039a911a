//! A snapshot goes on bit for bit: in the same world, in a new one, and in another process.

use crate::support;

use std::process::Command;

use copq::{Env, Outcome, Rng, State};
use copq_envs::robot::Preset;
use copq_envs::{Physics, robot};
use copq_envs_rapier::{Rapier, make};
use support::{ROBOTS, Walk};

/// Observation and reward bits of the next `steps` steps under a fixed sequence of actions, with
/// resets.
fn replay(env: &mut dyn Env, steps: usize) -> Vec<u32> {
    let mut rng = Rng::with_stream(3, 98);
    let mut obs = vec![0.0; env.spec().obs_len];
    let mut action = vec![0.0; env.spec().action_len()];
    let mut reward = vec![0.0; env.spec().objectives.len()];
    let mut bits = Vec::new();
    for _ in 0..steps {
        action.iter_mut().for_each(|value| *value = rng.uniform_in(-1.0, 1.0) as f32);
        let outcome = env.step(&action, &mut obs, &mut reward).unwrap();
        bits.extend(obs.iter().chain(&reward).map(|value| value.to_bits()));
        if outcome != Outcome::Running {
            env.reset(rng.next_u64(), &mut obs).unwrap();
        }
    }
    bits
}

#[test]
fn a_new_environment_goes_on_from_the_middle_of_an_episode() {
    for robot in ROBOTS {
        for seed in 0..3 {
            let task = format!("gym/{robot}");
            let mut walk = Walk::new(make(&task).unwrap(), seed);
            (0..7 + 15 * seed).for_each(|_| {
                walk.step();
            });
            let mut state = State::default();
            walk.env.save(&mut state).unwrap();
            let wanted = replay(&mut *walk.env, 60);

            let mut fresh = make(&task).unwrap();
            fresh.load(&state).unwrap();
            assert!(replay(&mut *fresh, 60) == wanted, "{task} seed {seed}: a new environment");
            walk.env.load(&state).unwrap();
            assert!(
                replay(&mut *walk.env, 60) == wanted,
                "{task} seed {seed}: the old environment"
            );
        }
    }
}

#[test]
fn a_snapshot_of_another_presets_robot_is_refused_and_changes_nothing() {
    for robot in [robot::hopper, robot::ant] {
        let mut gym = Rapier::new(&robot(Preset::GymV5)).unwrap();
        let controls = vec![0.3; gym.dims().nu];
        gym.step(&controls, 10).unwrap();
        let mut before = State::default();
        gym.save(&mut before).unwrap();
        let mut papers = State::default();
        Rapier::new(&robot(Preset::Paper)).unwrap().save(&mut papers).unwrap();
        let error = gym.load(&papers).unwrap_err().to_string();
        assert!(error.contains("robot of a saved state") && error.contains("another"), "{error}");
        let mut after = State::default();
        gym.save(&mut after).unwrap();
        assert_eq!(before, after);
    }
}

#[test]
fn a_snapshot_of_a_snapshot_is_the_same() {
    let mut walk = Walk::new(make("a/hopper").unwrap(), 1);
    (0..30).for_each(|_| {
        walk.step();
    });
    let mut first = State::default();
    let mut second = State::default();
    walk.env.save(&mut first).unwrap();
    let mut fresh = make("a/hopper").unwrap();
    fresh.load(&first).unwrap();
    fresh.save(&mut second).unwrap();
    let world: &[u8] = first.child("physics").unwrap().get("world").unwrap();
    println!("a snapshot takes {} bytes", world.len());
    assert!(first == second);
}

/// On the ground with contacts under way, at the physics level.
fn landed() -> Rapier {
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    physics.reset_to(&[0.0, 1.25, 0.01, -0.1, -0.2, 0.1], &[0.5, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    physics.step(&[0.1, -0.2, 0.3], 100).unwrap();
    physics
}

fn digest(physics: &mut Rapier) -> String {
    let mut qpos = [0.0; 6];
    let mut digest = 0u64;
    for step in 0..200 {
        let turn = f64::from(step % 7) / 7.0 - 0.4;
        physics.step(&[turn, -turn, 0.5 * turn], 1).unwrap();
        physics.qpos(&mut qpos);
        digest = qpos.iter().fold(digest, |digest, value| digest.rotate_left(7) ^ value.to_bits());
    }
    format!("digest {digest:016x}")
}

#[test]
fn another_process_goes_on() {
    let mut physics = landed();
    let mut state = State::default();
    physics.save(&mut state).unwrap();
    let path = std::env::temp_dir().join(format!("copq-rapier-{}.world", std::process::id()));
    std::fs::write(&path, state.get::<u8>("world").unwrap()).unwrap();
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "snapshot::child", "--ignored", "--nocapture"])
        .env("COPQ_WORLD", &path)
        .output()
        .unwrap();
    std::fs::remove_file(&path).unwrap();
    let said = String::from_utf8_lossy(&child.stdout).into_owned();
    assert!(said.contains(&digest(&mut physics)), "{said}");
}

#[test]
#[ignore = "the other half of another_process_goes_on"]
fn child() {
    let Some(path) = std::env::var_os("COPQ_WORLD") else { return };
    let mut state = State::default();
    Rapier::new(&robot::hopper(Preset::GymV5)).unwrap().save(&mut state).unwrap();
    state.put("world", std::fs::read(path).unwrap());
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    physics.load(&state).unwrap();
    println!("{}", digest(&mut physics));
}

#[test]
fn a_foreign_or_broken_snapshot_is_refused() {
    let mut state = State::default();
    let mut physics = Rapier::new(&robot::hopper(Preset::GymV5)).unwrap();
    assert!(physics.load(&state).is_err());
    physics.save(&mut state).unwrap();
    state.put("world", vec![1u8, 2, 3]);
    assert!(physics.load(&state).unwrap_err().to_string().contains("reading a rapier world"));
    state.put("robot", b"cat".as_slice());
    assert!(physics.load(&state).unwrap_err().to_string().contains("robot of a saved state"));
}

/// What a stranger's file may hold: damage anywhere is an error, or a world that moves.
#[test]
fn a_damaged_world_is_no_panic() {
    let spec = robot::hopper(Preset::GymV5);
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&spec.initial_qpos, &[0.0; 6]).unwrap();
    physics.step(&[0.1, -0.2, 0.3], 40).unwrap();
    let mut sound = State::default();
    physics.save(&mut sound).unwrap();
    let world = sound.get::<u8>("world").unwrap().to_vec();
    let mut rng = Rng::with_stream(5, 101);
    let mut refused = 0;
    for _ in 0..300 {
        let mut damaged = world.clone();
        let at = rng.below(damaged.len());
        match rng.below(3) {
            0 => damaged[at] ^= 1 << rng.below(8),
            1 => damaged.truncate(at),
            _ => {
                let end = (at + 64).min(world.len());
                damaged[at..end].fill(rng.below(256) as u8);
            }
        }
        let mut state = sound.clone();
        state.put("world", damaged);
        match physics.load(&state) {
            Err(_) => refused += 1,
            // Moved or said to be no longer finite; either is an answer.
            Ok(()) => drop(physics.step(&[0.0; 3], 4)),
        }
    }
    assert!(refused > 100, "{refused}");
    physics.load(&sound).unwrap();
    physics.step(&[0.1; 3], 4).unwrap();
}
