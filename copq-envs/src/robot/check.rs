//! Catches descriptions that contradict themselves, before an engine trips over them.

use copq::{Error, Result};

use super::{Health, Part, RobotSpec, VelocityPoint};

impl RobotSpec {
    /// An error that names the first contradiction in the description.
    pub fn check(&self) -> Result<()> {
        self.check_steps()?;
        self.check_bodies()?;
        self.check_joints()?;
        self.check_geoms()?;
        self.check_actuators()?;
        self.check_conventions()?;
        self.check_observation()
    }

    fn check_steps(&self) -> Result<()> {
        if !(self.timestep > 0.0 && self.timestep.is_finite()) {
            return Err(self.wrong("timestep", "a positive number of seconds", self.timestep));
        }
        if self.frame_skip == 0 {
            return Err(self.wrong("frame_skip", "at least 1", 0));
        }
        if self.initial_qpos.len() != self.nq() {
            return Err(self.wrong(
                "initial_qpos",
                format!("{} values", self.nq()),
                self.initial_qpos.len(),
            ));
        }
        Ok(())
    }

    fn check_bodies(&self) -> Result<()> {
        // The bodies on the way from the world to the last one: those that may still get children.
        let mut path: Vec<usize> = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            while path.last().copied() != body.parent {
                if path.pop().is_none() {
                    return Err(self.wrong(
                        &body.name,
                        "bodies listed depth first",
                        "a parent that is later or done",
                    ));
                }
            }
            path.push(index);
            if !(body.inertial.mass > 0.0
                && body.inertial.moments.iter().all(|&moment| moment > 0.0))
            {
                return Err(self.wrong(
                    &body.name,
                    "positive mass and moments",
                    format!("{:?}", body.inertial),
                ));
            }
        }
        Ok(())
    }

    fn check_joints(&self) -> Result<()> {
        let mut last = 0;
        for joint in &self.joints {
            if joint.body < last || joint.body >= self.bodies.len() {
                return Err(self.wrong(
                    &joint.name,
                    "a body, in the order of the bodies",
                    joint.body,
                ));
            }
            if joint.range.is_some_and(|[low, high]| low.is_nan() || high.is_nan() || low >= high) {
                return Err(self.wrong(
                    &joint.name,
                    "lower limit < upper limit",
                    format!("{:?}", joint.range),
                ));
            }
            last = joint.body;
        }
        Ok(())
    }

    fn check_geoms(&self) -> Result<()> {
        let lost =
            self.geoms.iter().find(|geom| geom.body.is_some_and(|body| body >= self.bodies.len()));
        lost.map_or(Ok(()), |geom| {
            Err(self.wrong(&geom.name, "a body of the robot", format!("{:?}", geom.body)))
        })
    }

    fn check_actuators(&self) -> Result<()> {
        for (index, actuator) in self.actuators.iter().enumerate() {
            let [low, high] = actuator.range;
            if low.is_nan() || high.is_nan() || low >= high {
                let what = format!("actuator {index}");
                return Err(self.wrong(
                    &what,
                    "lower limit < upper limit",
                    format!("{low} to {high}"),
                ));
            }
            if self.joints.get(actuator.joint).is_none_or(|joint| joint.kind.nv() != 1) {
                return Err(self.wrong(
                    &format!("actuator {index}"),
                    "a slide or hinge joint",
                    actuator.joint,
                ));
            }
        }
        Ok(())
    }

    /// Health and velocity point look at entries of qpos, which must be there.
    fn check_conventions(&self) -> Result<()> {
        let nq = self.nq();
        if self.health != Health::Always && nq < 3 {
            return Err(self.wrong("health", "at least 3 entries in qpos", nq));
        }
        if let VelocityPoint::Body(body) = self.velocity_point
            && body >= self.bodies.len()
        {
            return Err(self.wrong("velocity_point", "a body of the robot", body));
        }
        if self.velocity_point == VelocityPoint::Xy && nq < 2 {
            return Err(self.wrong("velocity_point", "at least 2 entries in qpos", nq));
        }
        Ok(())
    }

    /// So that an observation neither skips more than there is nor is clipped to nothing.
    fn check_observation(&self) -> Result<()> {
        let nq = self.nq();
        if self.observation.skip >= nq {
            return Err(self.wrong(
                "observation",
                format!("to skip fewer than {nq} entries of qpos"),
                self.observation.skip,
            ));
        }
        let parts = self.observation.parts.iter().chain(&self.observation.optional);
        let fields = parts.filter_map(|part| match *part {
            Part::Field { field, skip, clip } => Some((field, skip, clip)),
            _ => None,
        });
        for (field, skip, clip) in fields {
            if skip > field.len(self) {
                let wanted =
                    format!("to skip at most the {} numbers of {field:?}", field.len(self));
                return Err(self.wrong("observation", wanted, skip));
            }
            if clip.is_nan() || clip < 0.0 {
                let wanted = format!("{field:?} clipped at 0 or more");
                return Err(self.wrong("observation", wanted, clip));
            }
        }
        if self.observation.clip.is_nan() || self.observation.clip < 0.0 {
            let wanted = "velocities clipped at 0 or more";
            return Err(self.wrong("observation", wanted, self.observation.clip));
        }
        Ok(())
    }

    fn wrong(&self, what: &str, wanted: impl ToString, got: impl ToString) -> Error {
        Error::invalid(format!("robot {}: {what}", self.name), wanted, got)
    }
}
