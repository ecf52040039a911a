//! Motion without contacts against MuJoCo's, 20 environment steps of random torques 20 m above the
//! floor.

use crate::support;

use copq_envs::Physics;
use copq_envs::robot::Preset;
use copq_envs_rapier::Rapier;
use support::{ROBOTS, Table, controls, data, qpos, robot, worst};

/// Largest errors of the centre of mass (m) and of any entry of qpos (m, rad).
struct Bounds {
    centre: f64,
    qpos: f64,
}

/// About twice what was measured. The timesteps are 0.002 (hopper, walker), 0.003 (humanoid) and
/// 0.01 s; MuJoCo takes them with Runge-Kutta's method, but for the halfcheetah. The ant starts
/// with its ankles half a radian outside their limits.
fn bounds(robot: &str) -> Bounds {
    let (centre, qpos) = match robot {
        "hopper" => (1.5e-5, 3e-3),
        "walker2d" => (3e-4, 2.5e-2),
        "halfcheetah" => (3e-2, 1.6e-2),
        "ant" => (2e-2, 2e-1),
        _ => (1.5e-3, 1.6e-2),
    };
    Bounds { centre, qpos }
}

fn fly(name: &str) -> Bounds {
    let golden = Table::parse(&data(&format!("flight_{name}.csv")));
    let spec = robot(name, Preset::GymV5);
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&golden.vector(0, "qpos"), &golden.vector(0, "qvel")).unwrap();
    let start = physics.centre_of_mass().unwrap();
    let mut errors = Bounds { centre: 0.0, qpos: 0.0 };
    for step in 1..golden.len() {
        physics.step(&controls(&spec, &golden.vector(step, "u")), spec.frame_skip).unwrap();
        let t = step as f64 * spec.dt();
        // Semi-implicit steps sum to g t (t + timestep) / 2.
        let fallen = 0.5 * 9.81 * t * (t + spec.timestep);
        let centre = [start[0], start[1], start[2] - fallen];
        errors.centre = errors.centre.max(worst(&physics.centre_of_mass().unwrap(), &centre));
        let mut pose = golden.vector(step, "qpos");
        // Where the root falls is told by the centre of mass; joints and attitude are left to
        // compare.
        let root = if spec.nq() > spec.nv() { 3 } else { 2 };
        pose[..root].copy_from_slice(&qpos(&physics)[..root]);
        errors.qpos = errors.qpos.max(worst(&qpos(&physics), &pose));
    }
    errors
}

#[test]
fn robots_fly_as_in_mujoco() {
    for name in ROBOTS {
        let errors = fly(name);
        let bounds = bounds(name);
        println!("{name}: centre {:.1e}, qpos {:.1e}", errors.centre, errors.qpos);
        assert!(errors.centre < bounds.centre && errors.qpos < bounds.qpos, "{name}");
    }
}
