//! The engines and their robots.

use copq::{Env, Result, Rng};
use copq_envs::robot::Preset;
use copq_envs::{Options, Physics, RobotSpec, task_with};

pub const PRESETS: [Preset; 2] = [Preset::GymV5, Preset::Paper];
pub const ROBOTS: [&str; 5] = ["hopper", "walker2d", "halfcheetah", "ant", "humanoid"];

/// An engine, as its crate offers it.
pub struct Engine {
    pub name: &'static str,
    pub physics: fn(&RobotSpec) -> Result<Box<dyn Physics>>,
    pub env: fn(&str, &Options) -> Result<Box<dyn Env>>,
}

pub const ENGINES: &[Engine] = &[
    Engine {
        name: "rapier",
        physics: |robot| Ok(Box::new(copq_envs_rapier::Rapier::new(robot)?)),
        env: copq_envs_rapier::make_with,
    },
    #[cfg(feature = "mujoco-rs")]
    Engine {
        name: "mujoco-rs",
        physics: |robot| Ok(Box::new(copq_envs_mujoco::mujoco_rs::physics(robot)?)),
        env: copq_envs_mujoco::mujoco_rs::make_with,
    },
    #[cfg(feature = "system")]
    Engine {
        name: "system",
        physics: |robot| Ok(Box::new(copq_envs_mujoco::system::physics(robot)?)),
        env: copq_envs_mujoco::system::make_with,
    },
];

impl Engine {
    /// The engine with a robot in it: every engine has every robot.
    pub fn make(&self, robot: &RobotSpec) -> Box<dyn Physics> {
        (self.physics)(robot)
            .unwrap_or_else(|error| panic!("{} on {}: {error}", robot.name, self.name))
    }
}

/// Every robot of both presets.
pub fn robots() -> impl Iterator<Item = RobotSpec> {
    let robot =
        |preset| move |name| task_with(&format!("a/{name}"), &options(preset)).unwrap().robot;
    PRESETS.into_iter().flat_map(move |preset| ROBOTS.map(robot(preset)))
}

/// A preset with the default options.
pub fn options(preset: Preset) -> Options {
    Options { preset, ..Options::default() }
}

/// Every engine with every robot.
pub fn each(mut test: impl FnMut(&Engine, &RobotSpec, Box<dyn Physics>)) {
    for engine in ENGINES {
        robots().for_each(|robot| test(engine, &robot, engine.make(&robot)));
    }
}

/// Bits of qpos and qvel over some steps with a seed's controls.
pub fn play(physics: &mut dyn Physics, robot: &RobotSpec, seed: u64, steps: usize) -> Vec<u64> {
    let mut rng = Rng::with_stream(seed, 97);
    let mut ctrl = vec![0.0; robot.nu()];
    let mut qpos = vec![0.0; robot.nq()];
    let mut qvel = vec![0.0; robot.nv()];
    let mut bits = Vec::new();
    for _ in 0..steps {
        for (ctrl, motor) in ctrl.iter_mut().zip(&robot.actuators) {
            *ctrl = rng.uniform_in(motor.range[0], motor.range[1]);
        }
        physics.step(&ctrl, robot.frame_skip).unwrap();
        physics.qpos(&mut qpos);
        physics.qvel(&mut qvel);
        bits.extend(qpos.iter().chain(&qvel).map(|value| value.to_bits()));
    }
    bits
}

/// The robot at its start.
pub fn reset(physics: &mut dyn Physics, robot: &RobotSpec) {
    physics.reset_to(&robot.initial_qpos, &vec![0.0; robot.nv()]).unwrap();
}
