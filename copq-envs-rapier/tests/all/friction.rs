//! Ground friction: a planar robot must feel it (frames with rounding noise out of the plane lose
//! all of it).

use crate::support;

use approx::assert_abs_diff_eq;
use copq::Rng;
use copq_envs::robot::{Geom, Joint, Preset};
use copq_envs::{Field, Physics, RobotSpec, robot};
use copq_envs_rapier::Rapier;
use support::parts::{ball, block, contraption, floor};
use support::{controls, qvel};

/// Forward speed of the centre of mass (m/s) after 0.1 s on the foot, from 1 m/s and upright,
/// measured over one timestep.
fn speed_after_sliding(spec: &RobotSpec) -> f64 {
    let mut physics = Rapier::new(spec).unwrap();
    // 4 cm below its usual height the foot touches the floor.
    physics.reset_to(&[0.0, 1.21, 0.0, 0.0, 0.0, 0.0], &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    physics.step(&[0.0; 3], 49).unwrap();
    let before = physics.centre_of_mass().unwrap()[0];
    physics.step(&[0.0; 3], 1).unwrap();
    (physics.centre_of_mass().unwrap()[0] - before) / spec.timestep
}

/// The foot (friction 2) sticks and the body tips over it. MuJoCo 3.17.0: 0.440 m/s.
#[test]
fn the_floor_slows_a_sliding_hopper_as_in_mujoco() {
    let speed = speed_after_sliding(&robot::hopper(Preset::GymV5));
    println!("{speed}");
    assert_abs_diff_eq!(speed, 0.440, epsilon = 0.03);
}

#[test]
fn without_friction_it_slides_on() {
    let mut spec = robot::hopper(Preset::GymV5);
    spec.geoms.iter_mut().for_each(|geom| geom.friction = [0.0; 3]);
    let speed = speed_after_sliding(&spec);
    assert_abs_diff_eq!(speed, 1.0, epsilon = 1e-3);
}

/// All of rapier's contacts have one softness: that of what may touch the floor.
#[test]
fn the_roughness_of_what_touches_nothing_does_not_count() {
    let spec = robot::hopper(Preset::GymV5);
    let mut adorned = spec.clone();
    adorned.geoms.push(Geom {
        name: "badge".into(),
        friction: [9.0; 3],
        contype: 0,
        conaffinity: 0,
        ..spec.geoms[1].clone()
    });
    assert_eq!(speed_after_sliding(&adorned), speed_after_sliding(&spec));
}

/// Not a rounding error leads out of the plane, contacts included.
#[test]
fn planar_robots_stay_in_their_plane() {
    for spec in
        [robot::hopper, robot::walker2d, robot::halfcheetah].map(|robot| robot(Preset::GymV5))
    {
        let mut physics = Rapier::new(&spec).unwrap();
        let mut rng = Rng::with_stream(1, 96);
        physics.reset_to(&spec.initial_qpos, &vec![0.1; spec.nv()]).unwrap();
        let mut positions = vec![0.0; 3 * spec.bodies.len()];
        let mut velocities = vec![0.0; 6 * spec.bodies.len()];
        for _ in 0..100 {
            let actions: Vec<_> = (0..spec.nu()).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
            physics.step(&controls(&spec, &actions), spec.frame_skip).unwrap();
            physics.read(Field::BodyPosition, &mut positions).unwrap();
            physics.read(Field::Velocity, &mut velocities).unwrap();
            let aside = positions.chunks(3).map(|position| position[1]);
            let turns =
                velocities.chunks(6).flat_map(|velocity| [velocity[0], velocity[2], velocity[4]]);
            assert!(
                aside.chain(turns).all(|value| value == 0.0),
                "{}: {positions:?} {velocities:?}",
                spec.name
            );
        }
    }
}

/// Forward speed (m/s) of a ball without spin that lands on a floor, with the friction of each.
fn speed_of_a_sled(friction: [f64; 2]) -> f64 {
    let slides = [("x", [1.0, 0.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
    let slides = slides.map(|(name, axis)| Joint::slide(name, 0, axis));
    let mut spec = contraption(vec![block("sled", None)], slides.into());
    let rough = |geom, friction| Geom { friction: [friction, 0.0, 0.0], ..geom };
    spec.geoms = vec![rough(ball(Some(0), 0.1), friction[0]), rough(floor(0.0), friction[1])];
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.0, 0.1], &[2.0, 0.0]).unwrap();
    physics.step(&[], 100).unwrap();
    qvel(&physics)[0]
}

#[test]
fn the_rougher_of_two_decides() {
    let [both, one, other, neither] =
        [[0.5, 0.5], [0.5, 0.1], [0.1, 0.5], [0.1, 0.1]].map(speed_of_a_sled);
    assert!(both == one && both == other && both < neither - 0.5, "{both} {one} {other} {neither}");
    // Coulomb's friction: mu g t.
    assert_abs_diff_eq!(neither, 2.0 - 0.1 * 9.81 * 0.2, epsilon = 0.02);
}

/// Joint rates after the torso and the foot are pressed together in the air (rad/s).
fn rates_after_parting(friction: f64, condim: u8) -> Vec<u64> {
    let mut spec = robot::hopper(Preset::GymV5);
    for geom in &mut spec.geoms {
        (geom.condim, geom.friction[0]) = (condim, friction);
    }
    let mut physics = Rapier::new(&spec).unwrap();
    physics
        .reset_to(&[0.0, 21.0, -1.811, -0.875, -2.542, 0.58], &[0.0, 0.0, 0.0, -4.0, -3.0, 0.0])
        .unwrap();
    physics.step(&[0.0; 3], 4).unwrap();
    let mut qvel = [0.0; 6];
    physics.qvel(&mut qvel);
    qvel.iter().map(|value| value.to_bits()).collect()
}

/// MuJoCo's hopper touches itself with condim 1.
#[test]
fn self_contact_of_condim_1_has_no_friction() {
    assert_eq!(rates_after_parting(0.0, 1), rates_after_parting(2.0, 1));
    assert_ne!(rates_after_parting(0.0, 3), rates_after_parting(2.0, 3));
}
