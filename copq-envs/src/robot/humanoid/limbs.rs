//! The humanoid's trunk, legs and arms.

use crate::robot::capsule::{solid_ball, unit};
use crate::robot::{Body, Capsule, Geom, Inertial, Joint, RobotSpec, Shape};

/// Density of everything (kg/m^3).
const DENSITY: f64 = 1000.0;
/// How the waist and the pelvis lean: (1, 0, -0.002, 0) normalised.
const LEANING: [f64; 4] = [0.9999980000060001, 0.0, -0.0019999960000120004, 0.0];
/// Chest, head and upper waist together.
const TORSO: Inertial = Inertial {
    mass: 8.907462370478262,
    com: [-0.0025393839642605218, 0.0, 0.034662591112156124],
    moments: [0.173241525045228, 0.15401014056466444, 0.041119154937622956],
    quat: [0.9999122812058504, 0.0, 0.01324499504386929, 0.0],
};
/// Shin and foot together, as Brax welds them.
const FUSED: Inertial = Inertial {
    mass: 4.522842034827901,
    com: [0.0, 0.0, -0.22814316104946608],
    moments: [0.07965185554566509, 0.07965185554566509, 0.007165968495292965],
    quat: [1.0, 0.0, 0.0, 0.0],
};
/// Right lower arm and hand together.
const RIGHT_ARM: Inertial = Inertial {
    mass: 1.2295401928310803,
    com: [0.10962313368871249, 0.10962313368871249, 0.10962313368871249],
    moments: [0.013667228332107461, 0.013667228332107465, 0.0006215610823377786],
    quat: [0.8804762392171492, -0.36470519963100084, 0.27984814233312133, -0.11591689595929514],
};
/// Left lower arm and hand together.
const LEFT_ARM: Inertial = Inertial {
    mass: 1.2295401928310803,
    com: [0.10962313368871249, -0.10962313368871249, 0.10962313368871249],
    moments: [0.013667228332107463, 0.013667228332107465, 0.0006215610823377783],
    quat: [0.8804762392171499, 0.36470519963100095, 0.2798481423331215, 0.1159168959592952],
};

/// Where the two sides differ.
pub(super) struct Side {
    name: &'static str,
    /// The sign of y.
    y: f64,
    hip_armature: f64,
    knee_stiffness: f64,
    /// Limits of both shoulder joints (degrees).
    shoulder: [f64; 2],
    lower_arm: Inertial,
}

pub(super) const RIGHT: Side = Side {
    name: "right",
    y: -1.0,
    hip_armature: 0.008,
    knee_stiffness: 0.0,
    shoulder: [-85.0, 60.0],
    lower_arm: RIGHT_ARM,
};
pub(super) const LEFT: Side = Side {
    name: "left",
    y: 1.0,
    hip_armature: 0.01,
    knee_stiffness: 1.0,
    shoulder: [-60.0, 85.0],
    lower_arm: LEFT_ARM,
};

impl RobotSpec {
    /// Torso, waist and pelvis; returns the pelvis.
    pub(super) fn trunk(&mut self) -> usize {
        self.bodies.push(Body::new("torso", None, [0.0, 0.0, 1.4], TORSO));
        self.joints.push(Joint::free("root", 0));
        self.geoms.push(Geom::capsule("torso1", 0, lying([0.0; 3], 0.07, 0.07)));
        self.ball("head", 0, 0.09, [0.0, 0.0, 0.19]);
        self.geoms.push(Geom::capsule("uwaist", 0, lying([-0.01, 0.0, -0.12], 0.06, 0.06)));

        let waist = self.limb("lwaist", 0, [-0.01, 0.0, -0.26], lying([0.0; 3], 0.06, 0.06));
        let anchor = [0.0, 0.0, 0.065];
        let z = Joint { anchor, ..Joint::hinge("abdomen_z", waist, [0.0, 0.0, 1.0]) };
        self.joints.push(passive(z, [-45.0, 45.0], [5.0, 0.02, 20.0]));
        let y = Joint { anchor, ..Joint::hinge("abdomen_y", waist, [0.0, 1.0, 0.0]) };
        self.joints.push(passive(y, [-75.0, 30.0], [5.0, 0.02, 10.0]));

        let pelvis =
            self.limb("pelvis", waist, [0.0, 0.0, -0.165], lying([-0.02, 0.0, 0.0], 0.07, 0.09));
        let x =
            Joint { anchor: [0.0, 0.0, 0.1], ..Joint::hinge("abdomen_x", pelvis, [1.0, 0.0, 0.0]) };
        self.joints.push(passive(x, [-35.0, 35.0], [5.0, 0.02, 10.0]));
        (self.bodies[waist].quat, self.bodies[pelvis].quat) = (LEANING, LEANING);
        pelvis
    }

    /// Thigh, shin and foot.
    pub(super) fn leg(&mut self, pelvis: usize, side: &Side, fused: bool) {
        let name = side.name;
        let y = side.y;
        let bone = Capsule::between([0.0; 3], [0.0, -0.01 * y, -0.34], 0.06);
        let thigh = self.limb(&format!("{name}_thigh"), pelvis, [0.0, 0.1 * y, -0.04], bone);
        let x = Joint::hinge(&format!("{name}_hip_x"), thigh, [-y, 0.0, 0.0]);
        self.joints.push(passive(x, [-25.0, 5.0], [5.0, 0.01, 10.0]));
        let z = Joint::hinge(&format!("{name}_hip_z"), thigh, [0.0, 0.0, -y]);
        self.joints.push(passive(z, [-60.0, 35.0], [5.0, 0.01, 10.0]));
        let hip = Joint::hinge(&format!("{name}_hip_y"), thigh, [0.0, 1.0, 0.0]);
        self.joints.push(passive(hip, [-110.0, 20.0], [5.0, side.hip_armature, 20.0]));

        let bone = Capsule::between([0.0; 3], [0.0, 0.0, -0.3], 0.049);
        let shin = self.limb(&format!("{name}_shin"), thigh, [0.0, -0.01 * y, -0.403], bone);
        let knee = Joint::hinge(&format!("{name}_knee"), shin, [0.0, -1.0, 0.0]);
        let knee = Joint { anchor: [0.0, 0.0, 0.02], ..knee };
        self.joints.push(passive(knee, [-160.0, -2.0], [1.0, 0.006, side.knee_stiffness]));

        let foot = format!("{name}_foot");
        if fused {
            self.bodies[shin].inertial = FUSED;
            return self.ball(&foot, shin, 0.075, [0.0, 0.0, -0.35]);
        }
        let centre = [0.0, 0.0, 0.1];
        self.bodies.push(Body::new(
            &foot,
            Some(shin),
            [0.0, 0.0, -0.45],
            solid_ball(DENSITY, 0.075, centre),
        ));
        self.ball(&foot, self.bodies.len() - 1, 0.075, centre);
    }

    /// Upper arm, lower arm and hand.
    pub(super) fn arm(&mut self, side: &Side) {
        let name = side.name;
        let y = side.y;
        let bone = Capsule::between([0.0; 3], [0.16, 0.16 * y, -0.16], 0.04);
        let upper = self.limb(&format!("{name}_upper_arm"), 0, [0.0, 0.17 * y, 0.06], bone);
        let first = Joint::hinge(&format!("{name}_shoulder1"), upper, unit([2.0, -y, 1.0]));
        self.joints.push(passive(first, side.shoulder, [1.0, 0.0068, 1.0]));
        let second = Joint::hinge(&format!("{name}_shoulder2"), upper, unit([0.0, y, 1.0]));
        self.joints.push(passive(second, side.shoulder, [1.0, 0.0051, 1.0]));

        let bone = Capsule::between([0.01, -0.01 * y, 0.01], [0.17, -0.17 * y, 0.17], 0.031);
        let lower = self.limb(&format!("{name}_lower_arm"), upper, [0.18, 0.18 * y, -0.18], bone);
        self.bodies[lower].inertial = side.lower_arm;
        let elbow = Joint::hinge(&format!("{name}_elbow"), lower, unit([0.0, -1.0, -y]));
        self.joints.push(passive(elbow, [-90.0, 50.0], [1.0, 0.0028, 0.0]));
        self.ball(&format!("{name}_hand"), lower, 0.04, [0.18, -0.18 * y, 0.18]);
    }

    /// Adds a body that is one capsule.
    fn limb(&mut self, name: &str, parent: usize, pos: [f64; 3], capsule: Capsule) -> usize {
        let body = self.bodies.len();
        self.bodies.push(Body::new(name, Some(parent), pos, capsule.solid(DENSITY)));
        self.geoms.push(Geom::capsule(&format!("{name}_geom"), body, capsule));
        body
    }

    /// Adds the shape of a ball to a body.
    fn ball(&mut self, name: &str, body: usize, radius: f64, centre: [f64; 3]) {
        self.geoms
            .push(Geom { pos: centre, ..Geom::new(name, Some(body), Shape::Sphere { radius }) });
    }
}

/// A capsule across the body, along y.
fn lying([x, y, z]: [f64; 3], half_length: f64, radius: f64) -> Capsule {
    Capsule::between([x, y - half_length, z], [x, y + half_length, z], radius)
}

/// A joint with limits (degrees) and (damping, armature, stiffness).
fn passive(joint: Joint, range: [f64; 2], [damping, armature, stiffness]: [f64; 3]) -> Joint {
    Joint { range: Some(range.map(f64::to_radians)), damping, armature, stiffness, ..joint }
}
