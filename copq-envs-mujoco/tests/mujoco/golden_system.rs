//! The installed MuJoCo against what 3.17.0 recorded: within what was measured between 2.2.2 and
//! 3.17.0.

use crate::support::{
    ROBOTS, close, golden, observation, one_step_errors, one_steps, rollout_errors, task,
};
use copq_envs::robot::Preset;
use copq_envs_mujoco::system::{physics, version};

/// The humanoid's solvers stop before they have converged: versions between the two that were
/// measured stop elsewhere.
fn is_measured(robot: &str) -> bool {
    robot != "humanoid" || [222, 3_017_000].contains(&version().unwrap())
}

/// Contacts are chaotic: after so many steps the state may be off by so much.
fn bounds(robot: &str) -> [(usize, f64); 3] {
    match robot {
        "hopper" => [(1, 1e-14), (10, 1e-13), (50, 1e-12)],
        "walker2d" => [(1, 1e-13), (10, 1e-12), (50, 1e-11)],
        "halfcheetah" => [(1, 1e-13), (10, 1e-11), (50, 1e-7)],
        "ant" => [(1, 1e-13), (10, 1e-12), (50, 1e-9)],
        _ => [(1, 1e-6), (10, 1e-6), (50, 1e-2)],
    }
}

#[test]
fn rollouts_of_gymnasium() {
    for robot in ROBOTS {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_rollout"));
        let errors = rollout_errors(physics, &task.robot, &table);
        report(robot, &errors);
        for (step, bound) in bounds(robot) {
            assert!(
                errors[step] <= bound || !is_measured(robot),
                "{robot}, step {step}: {errors:?}"
            );
        }
    }
}

#[test]
fn single_steps_of_gymnasium() {
    for robot in ROBOTS {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_onestep"));
        let worst = one_step_errors(physics, &task.robot, &table).into_iter().fold(0.0, f64::max);
        println!("{robot}, single steps: off by at most {worst:.1e}");
        let bound = if robot == "humanoid" { 1e-2 } else { 1e-12 };
        assert!(worst <= bound || !is_measured(robot), "{robot}: {worst}");
    }
}

/// Contact forces too.
#[test]
fn observations_of_gymnasium() {
    for robot in ROBOTS.into_iter().filter(|robot| is_measured(robot)) {
        let task = task(&format!("gym/{robot}"), Preset::GymV5);
        let table = golden(&format!("{robot}_onestep"));
        let tolerance = if robot == "humanoid" { 1e-2 } else { 1e-9 };
        one_steps(physics, &task.robot, &table, |physics, row| {
            let seen: Vec<f32> =
                observation(physics, &task).iter().map(|&value| value as f32).collect();
            let wanted: Vec<f32> =
                table.vector(row, "obs").iter().map(|&value| value as f32).collect();
            close(&seen, &wanted, tolerance, robot);
        });
    }
}

#[test]
fn rollouts_of_the_papers_preset() {
    for robot in ROBOTS {
        let task = task(&format!("a/{robot}"), Preset::Paper);
        let table = golden(&format!("paper_{robot}_rollout"));
        let errors = rollout_errors(physics, &task.robot, &table);
        report(&format!("{robot} of the paper"), &errors);
        // 2.2.2 cannot limit line searches, so that its humanoid leaves ours at the first contact.
        let (steps, bound) = if robot == "humanoid" { (10, 1e-12) } else { (20, 1e-8) };
        assert!(
            errors[..=steps].iter().all(|&error| error <= bound) || !is_measured(robot),
            "{robot}: {errors:?}"
        );
    }
}

fn report(robot: &str, errors: &[f64]) {
    let errors: Vec<_> = [1, 10, 20, 50, 100, 200]
        .iter()
        .filter_map(|&step| Some((step, *errors.get(step)?)))
        .collect();
    let text: Vec<_> =
        errors.iter().map(|(step, error)| format!("{error:.0e} after {step}")).collect();
    println!("{robot}, off by {}", text.join(", "));
}
