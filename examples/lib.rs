//! What the examples share: a world by the names of its task, engine and preset, and ways to draw it.

mod view;

use copq::{Config, Env, EnvSpec, Error, OrderedEnv, Result};
use copq_envs::{Locomotion, Options, Physics, RobotSpec};
use copq_experiments::Plan;
pub use view::{VIEWS, make_view};

/// The engines that [`make_env`] knows.
pub const ENGINES: [&str; 3] = ["rapier", "mujoco", "system"];

/// A robot and its task, on an engine chosen at run time.
pub type World = Locomotion<Box<dyn Physics>>;

/// A plan's task on its engine, its objectives in the plan's order.
pub fn make_env(plan: &Plan) -> Result<Box<dyn Env>> {
    let world = Box::new(make_world(plan)?);
    Ok(match &plan.order {
        Some(order) => Box::new(OrderedEnv::parse(world, order)?),
        None => world,
    })
}

/// The number of steps that the command line asks for, its only argument.
pub fn steps(default: u64) -> Result<u64> {
    let Some(given) = std::env::args().nth(1) else { return Ok(default) };
    given.parse().map_err(|_| Error::invalid("the argument", format!("steps to train for, such as {default}"), given))
}

/// Says so if a task limits a cost and the method takes no notice of it.
pub fn warn_of_limits(spec: &EnvSpec, config: &Config) {
    let ignored = |&i: &usize| spec.limit(i).is_some() && config.constraint.is_none();
    for i in (0..spec.objectives.len()).filter(ignored) {
        let (cost, weight) = (&spec.objectives[i], spec.weights[i]);
        eprintln!("note: nothing holds the {cost}'s limit here, its weight is {weight}; sac_lagrangian holds it");
    }
}

/// A plan's task on its engine, whose robot can be looked at.
pub fn make_world(plan: &Plan) -> Result<World> {
    let options = Options { preset: plan.preset.parse()?, ..Options::default() };
    let task = copq_envs::task_with(&plan.task, &options)?;
    let physics = make_physics(&plan.engine, &task.robot)?;
    Locomotion::new(task, physics)
}

fn make_physics(engine: &str, robot: &RobotSpec) -> Result<Box<dyn Physics>> {
    match engine {
        "rapier" => Ok(Box::new(copq_envs_rapier::Rapier::new(robot)?)),
        #[cfg(feature = "mujoco")]
        "mujoco" => Ok(Box::new(copq_envs_mujoco::mujoco_rs::physics(robot)?)),
        #[cfg(feature = "system")]
        "system" => Ok(Box::new(copq_envs_mujoco::system::physics(robot)?)),
        known if ENGINES.contains(&known) => {
            let wanted =
                format!("a build with it: cargo run --release --features copq-examples/{engine} --example ...");
            Err(Error::invalid(format!("engine {engine}"), wanted, "one without"))
        }
        _ => Err(Error::unknown("engine", engine, &ENGINES)),
    }
}
