//! A robot as MJCF, the text that MuJoCo compiles.
//!
//! Every number is written so that it parses back to the same bits.

use std::fmt::Display;

use super::{Actuator, Algorithm, Geom, Integrator, Joint, JointKind, RobotSpec, Shape};

/// First version, as `mj_version` counts, in which a contact begins at the sum of two margins
/// rather than at the larger.
const MARGINS_ADD: i32 = 350;
/// First version of the 3 series: it has a flag for explicit damping and a limit on line searches.
const THREE: i32 = 300;

impl RobotSpec {
    /// The robot and its world as MJCF for this version of MuJoCo, as `mj_version` counts: 222 is
    /// 2.2.2, 3017000 is 3.17.0.
    ///
    /// For versions that take the larger of two margins, the margins are changed so that the result
    /// stays the same: always for contacts with the floor, and for other contacts if a robot's
    /// margins are all equal. For versions without explicit damping it is left out: see
    /// [`RobotSpec::applied_damping`].
    pub fn mjcf(&self, version: i32) -> String {
        let mut text = format!("<mujoco model=\"{}\">\n", escaped(&self.name));
        text += "<compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n";
        text += &self.option(version);
        text += "<worldbody>\n";
        self.geoms_of(None).for_each(|geom| text += &self.geom(geom, version));
        self.roots().for_each(|body| self.body(body, version, &mut text));
        text += "</worldbody>\n<actuator>\n";
        self.actuators.iter().for_each(|actuator| text += &self.motor(actuator));
        text + "</actuator>\n</mujoco>\n"
    }

    /// Damping of each degree of freedom (nv), if [`RobotSpec::mjcf`] left it out and the engine
    /// must apply the force `-damping * qvel` before every physics step; `None` if MuJoCo does it
    /// all.
    pub fn applied_damping(&self, version: i32) -> Option<Vec<f64>> {
        let damping = self.joints.iter().flat_map(|joint| vec![joint.damping; joint.kind.nv()]);
        self.lacks_explicit_damping(version).then(|| damping.collect())
    }

    fn lacks_explicit_damping(&self, version: i32) -> bool {
        self.integrator == Integrator::EulerExplicitDamping && version < THREE
    }

    fn option(&self, version: i32) -> String {
        let integrator = if self.integrator == Integrator::Rk4 { "RK4" } else { "Euler" };
        let solver = match self.solver.algorithm {
            Algorithm::Newton => "Newton",
            Algorithm::Pgs => "PGS",
        };
        let gravity = list(&self.gravity);
        let timestep = self.timestep;
        let iterations = self.solver.iterations;
        let mut text = format!(
            "<option timestep=\"{timestep}\" gravity=\"{gravity}\" integrator=\"{integrator}\" solver=\"{solver}\" \
             iterations=\"{iterations}\""
        );
        if version >= THREE {
            text += &format!(" ls_iterations=\"{}\"", self.solver.ls_iterations);
        }
        if version >= THREE && self.integrator == Integrator::EulerExplicitDamping {
            return text + "><flag eulerdamp=\"disable\"/></option>\n";
        }
        text + "/>\n"
    }

    fn roots(&self) -> impl Iterator<Item = usize> {
        (0..self.bodies.len()).filter(|&body| self.bodies[body].parent.is_none())
    }

    fn geoms_of(&self, body: Option<usize>) -> impl Iterator<Item = &Geom> {
        self.geoms.iter().filter(move |geom| geom.body == body)
    }

    fn body(&self, index: usize, version: i32, text: &mut String) {
        let body = &self.bodies[index];
        let inertial = &self.bodies[index].inertial;
        let pos = list(&body.pos);
        let quat = list(&body.quat);
        *text +=
            &format!("<body name=\"{}\" pos=\"{pos}\" quat=\"{quat}\">\n", escaped(&body.name));
        let mass = inertial.mass;
        let com = inertial.com;
        let moments = inertial.moments;
        let quat = inertial.quat;
        let com = list(&com);
        let moments = list(&moments);
        let quat = list(&quat);
        *text += &format!(
            "<inertial mass=\"{mass}\" pos=\"{com}\" diaginertia=\"{moments}\" quat=\"{quat}\"/>\n"
        );
        self.joints_of(index).for_each(|(_, joint)| *text += &self.joint(joint, version));
        self.geoms_of(Some(index)).for_each(|geom| *text += &self.geom(geom, version));
        let children = (index + 1..self.bodies.len())
            .filter(|&child| self.bodies[child].parent == Some(index));
        children.for_each(|child| self.body(child, version, text));
        *text += "</body>\n";
    }

    fn joint(&self, joint: &Joint, version: i32) -> String {
        let kind = match joint.kind {
            JointKind::Free => "free",
            JointKind::Slide => "slide",
            JointKind::Hinge => "hinge",
        };
        let name = escaped(&joint.name);
        let armature = joint.armature;
        let stiffness = joint.stiffness;
        let damping = if self.lacks_explicit_damping(version) { 0.0 } else { joint.damping };
        let mut text = format!(
            "<joint name=\"{name}\" type=\"{kind}\" damping=\"{damping}\" armature=\"{armature}\" stiffness=\"{stiffness}\""
        );
        if joint.kind != JointKind::Free {
            let axis = list(&joint.axis);
            let anchor = list(&joint.anchor);
            let reference = joint.reference;
            text += &format!(
                " axis=\"{axis}\" pos=\"{anchor}\" ref=\"{reference}\" springref=\"{reference}\""
            );
        }
        text += &match joint.range {
            Some(range) => format!(" limited=\"true\" range=\"{}\"", list(&range)),
            None => " limited=\"false\"".into(),
        };
        let solref = list(&joint.softness.solref);
        let solimp = list(&joint.softness.solimp);
        text + &format!(" solreflimit=\"{solref}\" solimplimit=\"{solimp}\"/>\n")
    }

    fn geom(&self, geom: &Geom, version: i32) -> String {
        let (shape, size) = match geom.shape {
            // MuJoCo treats a size of 0 as infinite; the third number is for drawing only.
            Shape::Plane => ("plane", "0 0 1".into()),
            Shape::Capsule { radius, half_length } => ("capsule", list(&[radius, half_length])),
            Shape::Sphere { radius } => ("sphere", radius.to_string()),
        };
        let name = escaped(&geom.name);
        let pos = list(&geom.pos);
        let quat = list(&geom.quat);
        let friction = list(&geom.friction);
        let margin = self.margin(geom, version);
        let condim = geom.condim;
        let contype = geom.contype;
        let conaffinity = geom.conaffinity;
        let solref = list(&geom.softness.solref);
        let solimp = list(&geom.softness.solimp);
        format!(
            "<geom name=\"{name}\" type=\"{shape}\" size=\"{size}\" pos=\"{pos}\" quat=\"{quat}\" friction=\"{friction}\" \
             condim=\"{condim}\" contype=\"{contype}\" conaffinity=\"{conaffinity}\" margin=\"{margin}\" \
             solref=\"{solref}\" solimp=\"{solimp}\"/>\n"
        )
    }

    /// Where the larger of two margins counts, the floor's is added to those of the robot's geoms.
    fn margin(&self, geom: &Geom, version: i32) -> f64 {
        let floor = self.geoms_of(None).map(|floor| floor.margin).fold(0.0, f64::max);
        match geom.body {
            _ if version >= MARGINS_ADD => geom.margin,
            Some(_) => geom.margin + floor,
            None => 0.0,
        }
    }

    fn motor(&self, actuator: &Actuator) -> String {
        let joint = escaped(&self.joints[actuator.joint].name);
        let gear = actuator.gear;
        let range = list(&actuator.range);
        format!(
            "<motor joint=\"{joint}\" gear=\"{gear}\" ctrllimited=\"true\" ctrlrange=\"{range}\"/>\n"
        )
    }
}

/// Numbers separated by spaces, in Rust's shortest form that parses back to the same bits.
fn list<T: Display>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
