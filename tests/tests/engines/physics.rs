//! The contract of `Physics`.

use std::thread;

use copq::{Error, State};

use crate::engine::{each, play, reset};

#[test]
fn sizes_are_the_robots() {
    each(|engine, robot, mut physics| {
        let dims = physics.dims();
        assert_eq!(
            [dims.nq, dims.nv, dims.nu],
            [robot.nq(), robot.nv(), robot.nu()],
            "{} on {}",
            robot.name,
            engine.name
        );
        assert!(!physics.name().is_empty());
        let mut qpos = vec![f64::NAN; dims.nq];
        let mut qvel = vec![f64::NAN; dims.nv];
        reset(&mut *physics, robot);
        physics.qpos(&mut qpos);
        physics.qvel(&mut qvel);
        let apart = qpos
            .iter()
            .zip(&robot.initial_qpos)
            .map(|(got, wanted)| (got - wanted).abs())
            .fold(0.0, f64::max);
        assert!(
            apart < 1e-12 && qvel == vec![0.0; dims.nv],
            "{} on {}: {apart}",
            robot.name,
            engine.name
        );
    });
}

#[test]
fn a_reset_forgets_everything() {
    each(|engine, robot, mut physics| {
        reset(&mut *physics, robot);
        let first = play(&mut *physics, robot, 1, 40);
        play(&mut *physics, robot, 2, 7);
        reset(&mut *physics, robot);
        assert!(play(&mut *physics, robot, 1, 40) == first, "{} on {}", robot.name, engine.name);
    });
}

#[test]
fn a_saved_state_goes_on_bit_for_bit() {
    each(|engine, robot, mut physics| {
        let what = format!("{} on {}", robot.name, engine.name);
        reset(&mut *physics, robot);
        play(&mut *physics, robot, 1, 30);
        let mut state = State::default();
        physics.save(&mut state).unwrap();
        let wanted = play(&mut *physics, robot, 2, 30);
        physics.load(&state).unwrap();
        assert!(play(&mut *physics, robot, 2, 30) == wanted, "{what}, the same engine");
        let mut other = engine.make(robot);
        other.load(&state).unwrap();
        assert!(play(&mut *other, robot, 2, 30) == wanted, "{what}, a new engine");
        assert!(other.load(&State::default()).is_err(), "{what}, an empty state");
    });
}

#[test]
fn numbers_that_are_not_finite_are_errors() {
    each(|engine, robot, mut physics| {
        let what = format!("{} on {}", robot.name, engine.name);
        let mut qpos = robot.initial_qpos.clone();
        qpos[robot.nq() - 1] = f64::NAN;
        assert!(physics.reset_to(&qpos, &vec![0.0; robot.nv()]).is_err(), "{what}");
        reset(&mut *physics, robot);
        let mut ctrl = vec![0.0; robot.nu()];
        ctrl[0] = f64::INFINITY;
        assert!(matches!(physics.step(&ctrl, 1), Err(Error::Env { .. })), "{what}");
        reset(&mut *physics, robot);
        play(&mut *physics, robot, 1, 1);
    });
}

#[test]
fn an_explosion_is_an_error_until_the_next_reset() {
    each(|engine, robot, mut physics| {
        let what = format!("{} on {}", robot.name, engine.name);
        let qvel: Vec<f64> =
            (0..robot.nv()).map(|dof| if dof % 2 == 0 { 1e200 } else { -1e200 }).collect();
        let ctrl = vec![0.0; robot.nu()];
        let exploded = physics.reset_to(&robot.initial_qpos, &qvel);
        let error =
            exploded.and_then(|()| (0..50).try_for_each(|_| physics.step(&ctrl, 1))).unwrap_err();
        assert!(matches!(error, Error::Env { .. }), "{what}: {error}");
        reset(&mut *physics, robot);
        let mended = play(&mut *physics, robot, 1, 10);
        let mut fresh = engine.make(robot);
        reset(&mut *fresh, robot);
        assert!(play(&mut *fresh, robot, 1, 10) == mended, "{what}: a reset mends it");
    });
    assert!(!std::env::current_dir().unwrap().join("MUJOCO_LOG.TXT").exists());
}

#[test]
fn threads_do_not_disturb_each_other() {
    each(|engine, robot, mut physics| {
        reset(&mut *physics, robot);
        let wanted = play(&mut *physics, robot, 3, 25);
        let run = || {
            let mut own = engine.make(robot);
            reset(&mut *own, robot);
            play(&mut *own, robot, 3, 25)
        };
        let runs: Vec<_> = thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(run)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(runs.iter().all(|bits| *bits == wanted), "{} on {}", robot.name, engine.name);
    });
}
