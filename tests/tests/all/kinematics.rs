//! A robot's kinematics against an engine's own, and an engine in a box against the engine itself.

use copq::{Env, Outcome, Rng, Stream};
use copq_envs::{Locomotion, Physics, task};
use copq_envs_rapier::Rapier;

#[test]
fn rapier_and_the_robots_kinematics_agree_on_the_centre_of_mass() {
    let task = task("a/hopper").unwrap();
    let boxed: Box<dyn Physics> = Box::new(Rapier::new(&task.robot).unwrap());
    let mut world = Locomotion::new(task, boxed).unwrap();
    let mut bare = copq_envs_rapier::make("a/hopper").unwrap();
    let mut obs = [vec![0.0; 11], vec![0.0; 11]];
    let mut reward = [vec![0.0; 3], vec![0.0; 3]];
    let mut action = [0.0; 3];
    let mut rng = Rng::new(0, Stream::Explore);
    world.reset(0, &mut obs[0]).unwrap();
    bare.reset(0, &mut obs[1]).unwrap();
    loop {
        action.iter_mut().for_each(|action| *action = rng.uniform_in(-1.0, 1.0) as f32);
        let outcome = world.step(&action, &mut obs[0], &mut reward[0]).unwrap();
        assert_eq!(bare.step(&action, &mut obs[1], &mut reward[1]).unwrap(), outcome);
        assert_eq!((&obs[0], &reward[0]), (&obs[1], &reward[1]), "in a box and without");
        let robot = &world.task().robot;
        let own = robot.centre_of_mass(&robot.body_poses(world.qpos()));
        let engines = world.physics().centre_of_mass().unwrap();
        for (own, engines) in own.iter().zip(engines) {
            assert!((own - engines).abs() < 1e-9, "{own} against {engines}");
        }
        if outcome != Outcome::Running {
            break;
        }
    }
}
