//! Ground friction: a planar robot must feel it (frames with rounding noise out of the plane lose all of it).

use copq_envs::robot::Preset;
use copq_envs::{Physics, RobotSpec, robot};
use copq_envs_rapier::Rapier;

/// Forward speed of the centre of mass (m/s) after 0.1 s on the foot, from 1 m/s and upright, measured over one timestep.
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
    assert!((speed - 0.440).abs() < 0.03, "{speed}");
}

#[test]
fn without_friction_it_slides_on() {
    let mut spec = robot::hopper(Preset::GymV5);
    spec.geoms.iter_mut().for_each(|geom| geom.friction = [0.0; 3]);
    let speed = speed_after_sliding(&spec);
    assert!((speed - 1.0).abs() < 1e-3, "{speed}");
}

/// Joint rates after the torso and the foot are pressed together in the air (rad/s).
fn rates_after_parting(friction: f64, condim: u8) -> Vec<u64> {
    let mut spec = robot::hopper(Preset::GymV5);
    for geom in &mut spec.geoms {
        (geom.condim, geom.friction[0]) = (condim, friction);
    }
    let mut physics = Rapier::new(&spec).unwrap();
    physics.reset_to(&[0.0, 21.0, -1.811, -0.875, -2.542, 0.58], &[0.0, 0.0, 0.0, -4.0, -3.0, 0.0]).unwrap();
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
