//! What the agent sees of the state.

use crate::RobotSpec;

/// Part of qpos, then all of qvel, clipped; neither scaled nor normalised (Gymnasium's layout).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// How many leading entries of qpos are left out (1: a planar robot does not see its x).
    pub skip: usize,
    /// Velocities are clipped to [-clip, clip]; infinite for no clipping.
    pub clip: f64,
}

impl Observation {
    /// Length of the observation of this robot.
    pub fn len(&self, robot: &RobotSpec) -> usize {
        robot.nq() - self.skip + robot.nv()
    }

    /// Writes the observation of a state.
    pub fn write(&self, qpos: &[f64], qvel: &[f64], out: &mut [f32]) {
        let clipped = qvel.iter().map(|velocity| velocity.clamp(-self.clip, self.clip));
        let values = qpos[self.skip..].iter().copied().chain(clipped);
        out.iter_mut().zip(values).for_each(|(out, value)| *out = value as f32);
    }
}
