//! The two sets of conventions that the robots come in.

use super::{Integrator, RobotSpec, Solver};

/// Which version of a robot it is.
///
/// ```
/// use copq_envs::robot::{Preset, hopper};
///
/// assert_eq!(hopper(Preset::GymV5).initial_qpos[1], 1.25); // z from the floor
/// assert_eq!(hopper(Preset::Paper).initial_qpos[1], 0.0); // z from the reference pose
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Preset {
    /// Gymnasium's v5 robots: their MuJoCo models, observations and resets.
    #[default]
    GymV5,
    /// Brax's robots, which the COP-Q paper trained. Only some geoms touch the floor and none touch
    /// each other, joint damping is explicit, and reset noise has the paper's scale of 0.005.
    /// Contacts are computed the engine's way, not Brax's.
    Paper,
}

impl RobotSpec {
    /// Brax's contacts and integrator: the geoms with these names touch the floor, always with
    /// friction and without margin; nothing else makes contact.
    pub(super) fn braxed(mut self, touching: &[&str]) -> Self {
        for geom in &mut self.geoms {
            let touches = touching.contains(&geom.name.as_str());
            (geom.contype, geom.conaffinity) = (touches.into(), geom.body.is_none().into());
            (geom.condim, geom.margin) = (3, 0.0);
        }
        Self { integrator: Integrator::EulerExplicitDamping, solver: Solver::MUJOCO, ..self }
    }
}
