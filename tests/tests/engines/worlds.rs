//! Environments on every engine, and what engines must agree on.

use copq::check_env;
use copq_envs::robot::Preset;
use copq_envs::tasks;

use crate::engine::{ENGINES, PRESETS, options, robots};

#[test]
fn every_environment_keeps_the_contract() {
    for engine in ENGINES {
        let mut checked = 0;
        for (preset, name) in PRESETS
            .into_iter()
            .flat_map(|preset| tasks().into_iter().map(move |name| (preset, name)))
        {
            let made = (engine.env)(name, &options(preset));
            let mut env = made.unwrap_or_else(|error| panic!("{name} on {}: {error}", engine.name));
            let report = check_env(&mut *env)
                .unwrap_or_else(|error| panic!("{name} on {}: {error}", engine.name));
            assert_eq!(env.spec().name, name);
            checked += report.lengths.len();
        }
        println!("{checked} episodes on {}", engine.name);
    }
}

#[test]
fn an_unknown_environment_is_answered_with_the_nearest() {
    for engine in ENGINES {
        let Err(error) = (engine.env)("a/hoper", &options(Preset::default())) else {
            panic!("there is no a/hoper")
        };
        assert!(error.to_string().contains("known: a/hopper"), "{error}");
    }
}

/// Masses, lengths and axes show in the mass matrix and the centre of mass, here away from the
/// start.
#[test]
fn engines_agree_on_the_robot() {
    for robot in robots() {
        let mut qpos = robot.initial_qpos.clone();
        qpos.iter_mut().enumerate().for_each(|(i, value)| *value += 0.1 * (i as f64).sin());
        robot.normalise(&mut qpos);
        let qvel = vec![0.0; robot.nv()];
        let told = ENGINES.iter().map(|engine| {
            let name = engine.name;
            let mut physics = engine.make(&robot);
            physics.reset_to(&qpos, &qvel).unwrap();
            let matrix = physics.mass_matrix().expect(name);
            (name, matrix, physics.centre_of_mass().expect(name))
        });
        let told: Vec<_> = told.collect();
        for (name, matrix, centre) in &told[1..] {
            let (first, wanted, wanted_centre) = &told[0];
            let largest = wanted.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            let apart = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let errors = [apart(matrix, wanted) / largest, apart(centre, wanted_centre)];
            println!("{}: {first} and {name} differ by {errors:?}", robot.name);
            assert!(
                errors.iter().all(|&error| error < 1e-9),
                "{}: {first} and {name}: {errors:?}",
                robot.name
            );
        }
    }
}
