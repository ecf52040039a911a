//! A description that contradicts itself is refused by name.

use copq_envs::robot::{self, Part, Preset, VelocityPoint};
use copq_envs::{Field, RobotSpec};

fn refused(spoil: impl Fn(&mut RobotSpec)) -> String {
    let mut robot = robot::walker2d(Preset::GymV5);
    robot.check().unwrap();
    spoil(&mut robot);
    robot.check().unwrap_err().to_string()
}

#[test]
fn bodies_come_depth_first() {
    // The left leg below the right foot's side of the tree, after the left thigh: breadth first.
    let error = refused(|robot| robot.bodies[5].parent = Some(1));
    assert!(error.contains("walker2d: leg_left: wanted bodies listed depth first"), "{error}");
    assert!(
        refused(|robot| robot.bodies[1].parent = Some(2))
            .contains("thigh: wanted bodies listed depth first")
    );
}

/// Only what is driven needs a name.
#[test]
fn parts_may_be_called_nothing() {
    let mut robot = robot::walker2d(Preset::GymV5);
    robot.bodies.iter_mut().for_each(|body| body.name.clear());
    robot.geoms.iter_mut().for_each(|geom| geom.name.clear());
    robot.joints[..3].iter_mut().for_each(|joint| joint.name.clear());
    robot.check().unwrap();
}

type Spoil = fn(&mut RobotSpec);

#[test]
fn contradictions_are_named() {
    let spoiled: [(&str, Spoil); 27] = [
        ("timestep", |robot| robot.timestep = 0.0),
        ("frame_skip", |robot| robot.frame_skip = 0),
        ("initial_qpos", |robot| robot.initial_qpos.truncate(3)),
        ("leg: wanted positive mass", |robot| robot.bodies[2].inertial.mass = 0.0),
        ("foot_joint: wanted lower limit < upper limit", |robot| {
            robot.joints[5].range = Some([1.0, 1.0])
        }),
        ("foot_joint: wanted an axis", |robot| robot.joints[5].axis = [0.0; 3]),
        ("foot_joint: wanted an axis", |robot| robot.joints[5].axis[2] = f64::NAN),
        ("bodies: wanted names that differ, got 'leg' twice", |robot| {
            robot.bodies[3].name = "leg".into()
        }),
        ("bodies: wanted names", |robot| robot.bodies[0].name = "world".into()),
        ("joints: wanted names", |robot| robot.joints[1].name = robot.joints[0].name.clone()),
        ("geoms: wanted names", |robot| robot.geoms[1].name = robot.geoms[0].name.clone()),
        ("actuator 2: wanted a slide or hinge", |robot| robot.actuators[2].joint = 9),
        ("actuator 2: wanted a slide or hinge joint that has a name", |robot| {
            robot.joints[5].name.clear()
        }),
        ("actuator 1: wanted lower limit < upper limit, both finite", |robot| {
            robot.actuators[1].range[1] = f64::INFINITY
        }),
        ("foot_joint: wanted a solref", |robot| robot.joints[5].softness.solref = [-100.0, -1.0]),
        ("foot_joint: wanted a solref", |robot| robot.joints[5].softness.solref[1] = f64::NAN),
        ("floor: wanted a solimp", |robot| robot.geoms[0].softness.solimp[0] = -0.1),
        ("floor: wanted a solimp", |robot| robot.geoms[0].softness.solimp[1] = f64::NAN),
        ("floor: wanted a solimp", |robot| robot.geoms[0].softness.solimp[2] = 0.0),
        ("floor: wanted a solimp", |robot| robot.geoms[0].softness.solimp[3] = 1.0),
        ("floor: wanted a solimp", |robot| robot.geoms[0].softness.solimp[4] = 0.5),
        ("velocity_point", |robot| robot.velocity_point = VelocityPoint::Body(7)),
        ("observation", |robot| robot.observation.skip = 9),
        ("actuator 1: wanted lower limit", |robot| robot.actuators[1].range = [1.0, -1.0]),
        ("velocities clipped", |robot| robot.observation.clip = -1.0),
        ("to skip at most the 42 numbers of ContactForce", |robot| {
            let field = Field::ContactForce;
            robot.observation.parts = vec![Part::Field { field, skip: 43, clip: 1.0 }]
        }),
        ("Velocity clipped at 0", |robot| {
            let field = Field::Velocity;
            robot.observation.optional = vec![Part::Field { field, skip: 0, clip: f64::NAN }]
        }),
    ];
    for (what, spoil) in spoiled {
        let error = refused(spoil);
        assert!(error.contains(what), "{error}");
    }
}
