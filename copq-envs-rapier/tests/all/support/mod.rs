//! What several of the tests need: golden data, robots, random actions.
#![allow(dead_code, unused_imports)]

pub mod crane;
pub mod parts;
mod state;
#[path = "../../../../copq-envs/tests/all/support/table.rs"]
mod table;
mod walk;

use copq_envs::robot::{self, Preset};
use copq_envs::{Physics, RobotSpec};
use copq_envs_rapier::Rapier;

pub use state::row;
pub use table::Table;
pub use walk::Walk;

pub const ROBOTS: [&str; 5] = ["hopper", "walker2d", "halfcheetah", "ant", "humanoid"];

pub fn robot(name: &str, preset: Preset) -> RobotSpec {
    match name {
        "hopper" => robot::hopper(preset),
        "walker2d" => robot::walker2d(preset),
        "halfcheetah" => robot::halfcheetah(preset),
        "ant" => robot::ant(preset),
        "humanoid" => robot::humanoid(preset),
        _ => panic!("no robot {name}"),
    }
}

/// A file under tests/data.
pub fn data(name: &str) -> String {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

pub fn qpos(physics: &Rapier) -> Vec<f64> {
    let mut qpos = vec![0.0; physics.dims().nq];
    physics.qpos(&mut qpos);
    qpos
}

pub fn qvel(physics: &Rapier) -> Vec<f64> {
    let mut qvel = vec![0.0; physics.dims().nv];
    physics.qvel(&mut qvel);
    qvel
}

/// The largest difference; fails if a number is not finite or one is missing.
pub fn worst(got: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    got.iter().zip(wanted).fold(0.0, |worst, (got, wanted)| {
        assert!((got - wanted).is_finite(), "{got} against {wanted}");
        f64::max(worst, (got - wanted).abs())
    })
}

/// The controls for actions in [-1, 1].
pub fn controls(robot: &RobotSpec, actions: &[f64]) -> Vec<f64> {
    robot
        .actuators
        .iter()
        .zip(actions)
        .map(|(actuator, action)| actuator.range[1] * action)
        .collect()
}
