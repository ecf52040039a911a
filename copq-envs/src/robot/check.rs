//! Catches descriptions that contradict themselves, before an engine trips over them.

use std::collections::HashSet;
use std::iter;

use copq::{Error, Result};

use super::{Health, JointKind, Part, RobotSpec, Softness, VelocityPoint};

impl RobotSpec {
    /// An error that names the first contradiction in the description.
    pub fn check(&self) -> Result<()> {
        self.check_steps()?;
        self.check_names()?;
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

    /// MuJoCo finds parts by their names, and calls the world `world`.
    fn check_names(&self) -> Result<()> {
        let bodies = self.bodies.iter().map(|body| body.name.as_str());
        self.check_own("bodies", iter::once("world").chain(bodies))?;
        self.check_own("joints", self.joints.iter().map(|joint| joint.name.as_str()))?;
        self.check_own("geoms", self.geoms.iter().map(|geom| geom.name.as_str()))
    }

    fn check_own<'a>(&self, parts: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
        let mut known = HashSet::new();
        let again = names.filter(|name| !name.is_empty()).find(|name| !known.insert(*name));
        again.map_or(Ok(()), |name| {
            Err(self.wrong(parts, "names that differ", format!("'{name}' twice")))
        })
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
                        "a parent that comes later, or whose children are complete",
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
            let length = joint.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
            // MuJoCo also refuses the shortest.
            if joint.kind != JointKind::Free && !(length > 1e-9 && length.is_finite()) {
                let wanted = "an axis of finite, nonzero length";
                return Err(self.wrong(&joint.name, wanted, format!("{:?}", joint.axis)));
            }
            self.check_softness(&joint.name, &joint.softness)?;
            last = joint.body;
        }
        Ok(())
    }

    fn check_geoms(&self) -> Result<()> {
        for geom in &self.geoms {
            if geom.body.is_some_and(|body| body >= self.bodies.len()) {
                let got = format!("{:?}", geom.body);
                return Err(self.wrong(&geom.name, "a body of the robot", got));
            }
            self.check_softness(&geom.name, &geom.softness)?;
        }
        Ok(())
    }

    fn check_softness(&self, part: &str, softness: &Softness) -> Result<()> {
        let flaw = softness.flaw();
        flaw.map_or(Ok(()), |wanted| Err(self.wrong(part, wanted, format!("{softness:?}"))))
    }

    fn check_actuators(&self) -> Result<()> {
        for (index, actuator) in self.actuators.iter().enumerate() {
            let what = format!("actuator {index}");
            let [low, high] = actuator.range;
            if !(low < high && low.is_finite() && high.is_finite()) {
                let wanted = "lower limit < upper limit, both finite";
                return Err(self.wrong(&what, wanted, format!("{low} to {high}")));
            }
            let joint = self.joints.get(actuator.joint).filter(|joint| joint.kind.nv() == 1);
            if joint.is_none_or(|joint| joint.name.is_empty()) {
                let wanted = "a slide or hinge joint that has a name";
                return Err(self.wrong(&what, wanted, actuator.joint));
            }
        }
        Ok(())
    }

    /// Health and velocity point look at entries of qpos, which must exist.
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

    /// Observations must not skip more than there is, nor clip to a bound that is negative or NaN.
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
