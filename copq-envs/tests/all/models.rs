//! The robots' constants against those that MuJoCo 3.17.0 compiles from Gymnasium's and Brax's own
//! models.

use approx::abs_diff_eq;
use copq_envs::RobotSpec;
use copq_envs::robot::{self, Geom, Integrator, Joint, JointKind, Preset, Shape, Solver};
use serde_json::Value;

const ROBOTS: [fn(Preset) -> RobotSpec; 5] =
    [robot::hopper, robot::walker2d, robot::halfcheetah, robot::ant, robot::humanoid];

fn each(mut test: impl FnMut(&RobotSpec, &Value, Preset)) {
    for (name, preset) in [("gym", Preset::GymV5), ("brax", Preset::Paper)] {
        for robot in ROBOTS.map(|robot| robot(preset)) {
            let file = format!(
                "{}/tests/data/model_{name}_{}.json",
                env!("CARGO_MANIFEST_DIR"),
                robot.name
            );
            let model = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
            test(&robot, &model, preset);
        }
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

/// Numbers equal but for the rounding of a few operations.
fn same(got: &[f64], wanted: &Value, what: &str) {
    let wanted: Vec<f64> = match wanted {
        Value::Array(values) => values.iter().map(|value| value.as_f64().unwrap()).collect(),
        value => vec![value.as_f64().unwrap()],
    };
    assert_eq!(got.len(), wanted.len(), "{what}");
    for (&got, wanted) in got.iter().zip(wanted) {
        assert!(
            abs_diff_eq!(got, wanted, epsilon = 1e-15 * (1.0 + wanted.abs())),
            "{what}: {got} against {wanted}"
        );
    }
}

#[test]
fn they_contradict_nothing() {
    each(|robot, model, _| {
        robot.check().unwrap();
        let sizes = [robot.nq(), robot.nv(), robot.nu()].map(|size| size as u64);
        assert_eq!(["nq", "nv", "nu"].map(|name| model[name].as_u64().unwrap()), sizes);
    });
}

#[test]
fn bodies() {
    each(|robot, model, _| {
        same(&[robot.total_mass()], &model["total_mass"], &robot.name);
        let wanted = &list(&model["bodies"])[1..];
        assert_eq!(robot.bodies.len(), wanted.len());
        for (body, wanted) in robot.bodies.iter().zip(wanted) {
            let what = format!("{}'s {}", robot.name, body.name);
            let inertial = &body.inertial;
            let parent = body.parent.map_or(0, |parent| parent as u64 + 1);
            assert_eq!(wanted["parent"].as_u64().unwrap(), parent, "{what}");
            same(&body.pos, &wanted["pos"], &what);
            same(&body.quat, &wanted["quat"], &what);
            same(&[inertial.mass], &wanted["mass"], &what);
            same(&inertial.com, &wanted["ipos"], &what);
            same(&inertial.moments, &wanted["inertia"], &what);
            same(&inertial.quat, &wanted["iquat"], &what);
        }
    });
}

#[test]
fn joints() {
    each(|robot, model, _| {
        let wanted = list(&model["joints"]);
        let mut dofs = list(&model["dofs"]).iter();
        assert_eq!(robot.joints.len(), wanted.len());
        for (joint, wanted) in robot.joints.iter().zip(wanted) {
            let what = format!("{}'s {}", robot.name, joint.name);
            assert_eq!(wanted["body"].as_u64().unwrap(), joint.body as u64 + 1, "{what}");
            for dof in dofs.by_ref().take(joint.kind.nv()) {
                same(&[joint.damping], &dof["damping"], &what);
                same(&[joint.armature], &dof["armature"], &what);
            }
            if joint.kind == JointKind::Free {
                assert_eq!(wanted["type"], "free", "{what}");
            } else {
                one_joint(joint, wanted, &what);
            }
        }
        assert!(dofs.next().is_none());
    });
}

fn one_joint(joint: &Joint, wanted: &Value, what: &str) {
    assert_eq!(
        wanted["type"],
        if joint.kind == JointKind::Hinge { "hinge" } else { "slide" },
        "{what}"
    );
    same(&joint.axis, &wanted["axis"], what);
    same(&joint.anchor, &wanted["pos"], what);
    assert_eq!(wanted["limited"].as_bool().unwrap(), joint.range.is_some(), "{what}");
    same(&joint.range.unwrap_or_default(), &wanted["range"], what);
    same(&[joint.stiffness], &wanted["stiffness"], what);
    // Springs rest at the reference; only joints without one have another.
    assert!(joint.stiffness == 0.0 || wanted["springref"] == joint.reference, "{what}");
    same(&joint.softness.solref, &wanted["solref"], what);
    same(&joint.softness.solimp, &wanted["solimp"], what);
}

/// A pair's friction, softness and dimension are mixed from both geoms', so each must be right.
/// Brax's hopper has a margin in its file that Brax does not use.
#[test]
fn geoms() {
    each(|robot, model, preset| {
        let wanted = list(&model["geoms"]);
        assert_eq!(robot.geoms.len(), wanted.len());
        for (geom, wanted) in robot.geoms.iter().zip(wanted) {
            let what = format!("{}'s geom {}", robot.name, geom.name);
            assert_eq!(
                wanted["body"].as_u64().unwrap(),
                geom.body.map_or(0, |body| body as u64 + 1),
                "{what}"
            );
            shape(geom, wanted, &what);
            same(&geom.pos, &wanted["pos"], &what);
            same(&geom.quat, &wanted["quat"], &what);
            same(&geom.friction, &wanted["friction"], &what);
            same(&geom.softness.solref, &wanted["solref"], &what);
            same(&geom.softness.solimp, &wanted["solimp"], &what);
            let margin =
                if preset == Preset::GymV5 { wanted["margin"].as_f64().unwrap() } else { 0.0 };
            assert_eq!(geom.margin, margin, "{what}");
            let bits = [geom.condim.into(), geom.contype, geom.conaffinity].map(u64::from);
            assert_eq!(
                ["condim", "contype", "conaffinity"].map(|name| wanted[name].as_u64().unwrap()),
                bits,
                "{what}"
            );
        }
    });
}

fn shape(geom: &Geom, wanted: &Value, what: &str) {
    let (name, size) = match geom.shape {
        Shape::Plane => return assert_eq!(wanted["type"], "plane", "{what}"),
        Shape::Capsule { radius, half_length } => ("capsule", [radius, half_length, 0.0]),
        Shape::Sphere { radius } => ("sphere", [radius, 0.0, 0.0]),
    };
    assert_eq!(wanted["type"], name, "{what}");
    same(&size, &wanted["size"], what);
}

#[test]
fn motors() {
    each(|robot, model, _| {
        let wanted = list(&model["actuators"]);
        assert_eq!(robot.actuators.len(), wanted.len());
        for (actuator, wanted) in robot.actuators.iter().zip(wanted) {
            let joint =
                list(&model["joints"]).iter().position(|joint| joint["name"] == wanted["joint"]);
            assert_eq!(joint, Some(actuator.joint), "{}", robot.name);
            same(&[actuator.gear], &wanted["gear"], &robot.name);
            same(&actuator.range, &wanted["ctrlrange"], &robot.name);
        }
    });
}

#[test]
fn the_same_pairs_may_collide() {
    each(|robot, model, _| {
        let n = robot.geoms.len();
        let pairs = (0..n)
            .flat_map(|a| (a + 1..n).map(move |b| (a, b)))
            .filter(|&(a, b)| robot.collide(a, b));
        let name = |geom: usize| model["geoms"][geom]["name"].clone();
        let pairs: Vec<_> = pairs.map(|(a, b)| Value::from(vec![name(a), name(b)])).collect();
        assert_eq!(pairs, list(&model["collidable_pairs"]), "{}", robot.name);
        assert!((0..n).all(|a| (0..n).all(|b| robot.collide(a, b) == robot.collide(b, a))));
    });
}

/// Brax's files name a solver that only approximates Brax's; what to use instead is measured in no
/// file.
#[test]
fn the_world() {
    each(|robot, model, preset| {
        same(&[robot.timestep], &model["timestep"], &robot.name);
        same(&robot.gravity, &model["gravity"], &robot.name);
        if preset == Preset::Paper {
            return assert_eq!(robot.integrator, Integrator::EulerExplicitDamping);
        }
        assert_eq!(model["integrator"], u64::from(robot.integrator == Integrator::Rk4));
        let Solver { iterations, ls_iterations, .. } = robot.solver;
        assert_eq!([&model["iterations"], &model["ls_iterations"]], [iterations, ls_iterations]);
    });
}

/// Gymnasium starts at MuJoCo's reference, Brax's ant on bent legs and below it.
#[test]
fn the_start() {
    each(|robot, model, preset| {
        let mut wanted = list(&model["qpos0"]).to_vec();
        if preset == Preset::Paper && robot.name == "ant" {
            let bent = [0.0, 1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0];
            wanted[2] = 0.55.into();
            wanted.splice(7.., bent.map(Value::from));
        }
        same(&robot.initial_qpos, &wanted.into(), &robot.name);
        let limits =
            robot.joints.iter().zip(&robot.initial_qpos[robot.nq() - robot.joints.len()..]).skip(1);
        let legal = limits
            .into_iter()
            .all(|(joint, q)| joint.range.is_none_or(|[low, high]| (low..=high).contains(q)));
        let illegal = robot.name == "humanoid" || (robot.name == "ant" && preset == Preset::GymV5);
        assert_eq!(legal, !illegal, "{}", robot.name);
    });
}
