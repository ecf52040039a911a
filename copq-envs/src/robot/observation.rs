//! What the agent sees of the state.

use crate::{Field, Readings};

use super::RobotSpec;
use super::part::Part;

/// Part of qpos, all of qvel, then the observation's other parts; nothing is scaled or normalised.
///
/// ```
/// use copq_envs::Readings;
/// use copq_envs::robot::{Observation, Preset, hopper};
///
/// // Everything but x: 5 positions, and 6 velocities clipped to 10.
/// let hopper = hopper(Preset::GymV5);
/// let observation = Observation { clip: 10.0, ..Observation::planar() };
/// let mut obs = [0.0; 11];
/// observation.write(&hopper, &hopper.initial_qpos, &[50.0; 6], &Readings::default(), &mut obs);
/// assert_eq!((obs[0], obs[5]), (1.25, 10.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// How many leading entries of qpos are left out (those of the robot's place).
    pub skip: usize,
    /// What is added to the first entry shown, the height (m).
    pub lift: f64,
    /// Velocities are clipped to [-clip, clip]; infinite for no clipping.
    pub clip: f64,
    /// What follows the velocities.
    pub parts: Vec<Part>,
    /// What follows in [`Senses::Gymnasium`] only.
    pub optional: Vec<Part>,
}

/// How much of a robot's observation the agent gets.
///
/// ```
/// use copq_envs::robot::{Preset, Senses, ant};
///
/// let ant = ant(Preset::GymV5);
/// let seen = |senses| ant.observation.clone().with(senses).len(&ant);
/// assert_eq!([Senses::Joints, Senses::Standard, Senses::Gymnasium].map(seen), [27, 27, 105]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Senses {
    /// What benchmarks A and B use: positions and velocities (ant: 27), and, for the humanoid, the
    /// inertia, velocities and forces of its bodies (348 in `GymV5`, 244 in `Paper`).
    #[default]
    Standard,
    /// Positions and velocities only (humanoid: 45, as in CAL); every engine reports these.
    Joints,
    /// All that Gymnasium v5 shows (ant: 105, with contact forces).
    Gymnasium,
}

impl Observation {
    /// For a planar root: everything but x, unclipped.
    pub fn planar() -> Self {
        Self { skip: 1, lift: 0.0, clip: f64::INFINITY, parts: Vec::new(), optional: Vec::new() }
    }

    /// For a free root: everything but x and y, unclipped.
    pub fn free() -> Self {
        Self { skip: 2, ..Self::planar() }
    }

    /// The observation with these senses, with nothing optional left.
    pub fn with(mut self, senses: Senses) -> Self {
        let optional = std::mem::take(&mut self.optional);
        match senses {
            Senses::Standard => {}
            Senses::Joints => self.parts.clear(),
            Senses::Gymnasium => self.parts.extend(optional),
        }
        self
    }

    /// The fields that it is made of, in addition to qpos and qvel.
    pub fn fields(&self) -> impl Iterator<Item = Field> {
        self.parts.iter().flat_map(|part| part.fields()).copied()
    }

    /// Length of the observation of this robot.
    pub fn len(&self, robot: &RobotSpec) -> usize {
        robot.nq() - self.skip
            + robot.nv()
            + self.parts.iter().map(|part| part.len(robot)).sum::<usize>()
    }

    /// Writes the observation of a state ([`Observation::len`] numbers).
    pub fn write(
        &self,
        robot: &RobotSpec,
        qpos: &[f64],
        qvel: &[f64],
        readings: &Readings,
        out: &mut [f32],
    ) {
        let (positions, out) = out.split_at_mut(qpos.len() - self.skip);
        put(qpos[self.skip..].iter().copied(), positions);
        positions[0] = (qpos[self.skip] + self.lift) as f32;
        let (velocities, mut out) = out.split_at_mut(qvel.len());
        put(qvel.iter().map(|velocity| velocity.clamp(-self.clip, self.clip)), velocities);
        for part in &self.parts {
            let (own, rest) = out.split_at_mut(part.len(robot));
            part.write(robot, readings, own);
            out = rest;
        }
    }
}

fn put(values: impl Iterator<Item = f64>, out: &mut [f32]) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out = value as f32);
}
