//! The tasks by name.

use copq::{Error, Result};

use super::{Options, Signal, SignalSum, Task, benchmark_a, benchmark_b, gymnasium};
use crate::RobotSpec;
use crate::robot::{self, Preset};

/// A task before its options are chosen.
struct Entry {
    name: &'static str,
    robot: fn(Preset) -> RobotSpec,
    rewards: Rewards,
}

enum Rewards {
    A(benchmark_a::Row),
    B(benchmark_b::Row),
    Gym(gymnasium::Row),
}

const fn a(bonus: f64, weights: [f32; 3]) -> Rewards {
    Rewards::A(benchmark_a::Row { bonus, weights })
}

const fn b(weights: [f64; 3], limit: f64) -> Rewards {
    Rewards::B(benchmark_b::Row { weights, limit })
}

const fn gym(weights: [f64; 3], contact: Option<(f64, Signal)>) -> Rewards {
    Rewards::Gym(gymnasium::Row { weights, contact })
}

const ANT: (f64, Signal) = (-5e-4, Signal::Contact { clip: 1.0, cap: f64::INFINITY });
/// Gymnasium caps the cost at 10.
const HUMANOID: (f64, Signal) = (-5e-7, Signal::Contact { clip: f64::INFINITY, cap: 10.0 / 5e-7 });

#[rustfmt::skip]
const ENTRIES: &[Entry] = &[
    Entry { name: "a/hopper",        robot: robot::hopper,      rewards: a(1.0, [1.0, 1.0, 1.0]) },
    Entry { name: "a/walker2d",      robot: robot::walker2d,    rewards: a(1.0, [1.0, 1.0, 0.5]) },
    Entry { name: "a/halfcheetah",   robot: robot::halfcheetah, rewards: a(0.0, [0.0, 1.0, 1.0]) },
    Entry { name: "a/ant",           robot: robot::ant,         rewards: a(1.0, [1.0, 1.0, 1.0]) },
    Entry { name: "a/humanoid",      robot: robot::humanoid,    rewards: a(5.0, [1.0, 5.0, 1.0]) },
    Entry { name: "b/hopper",        robot: robot::hopper,      rewards: b([1.0, 1.0, 0.001], 740.2) },
    Entry { name: "b/walker2d",      robot: robot::walker2d,    rewards: b([1.0, 1.0, 0.001], 2341.5) },
    Entry { name: "b/ant",           robot: robot::ant,         rewards: b([1.0, 1.0, 0.5], 2622.2) },
    Entry { name: "b/humanoid",      robot: robot::humanoid,    rewards: b([5.0, 1.25, 0.1], 1411.9) },
    Entry { name: "gym/hopper",      robot: robot::hopper,      rewards: gym([1.0, 1.0, 0.001], None) },
    Entry { name: "gym/walker2d",    robot: robot::walker2d,    rewards: gym([1.0, 1.0, 0.001], None) },
    Entry { name: "gym/halfcheetah", robot: robot::halfcheetah, rewards: gym([0.0, 1.0, 0.1], None) },
    Entry { name: "gym/ant",         robot: robot::ant,         rewards: gym([1.0, 1.0, 0.5], Some(ANT)) },
    Entry { name: "gym/humanoid",    robot: robot::humanoid,    rewards: gym([5.0, 1.25, 0.1], Some(HUMANOID)) },
];

/// The names that [`task`] knows.
pub fn tasks() -> Vec<&'static str> {
    ENTRIES.iter().map(|entry| entry.name).collect()
}

/// The task of this name with the default [`Options`]. The error for an unknown name lists the
/// nearest ones.
pub fn task(name: &str) -> Result<Task> {
    task_with(name, &Options::default())
}

/// The task of this name with these options. The error for an unknown name lists the nearest ones.
pub fn task_with(name: &str, options: &Options) -> Result<Task> {
    let entry = ENTRIES.iter().find(|entry| entry.name == name);
    entry.map(|entry| entry.build(options)).ok_or_else(|| Error::unknown("task", name, &tasks()))
}

impl Entry {
    fn build(&self, options: &Options) -> Task {
        let mut robot = (self.robot)(options.preset);
        if let Some(preset) = options.start {
            robot.initial_qpos = robot.pose_of(&(self.robot)(preset));
        }
        robot.observation = robot.observation.with(options.senses);
        Task {
            name: self.name.into(),
            robot,
            objectives: self.rewards.objectives(options),
            horizon: 1000,
        }
    }
}

impl Rewards {
    fn objectives(&self, options: &Options) -> Vec<SignalSum> {
        match self {
            Self::A(row) => row.objectives(options),
            Self::B(row) => row.objectives(options),
            Self::Gym(row) => row.objectives(options),
        }
    }
}
