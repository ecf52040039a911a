//! Environments by the names of their task, engine and preset, or from Python.

use std::path::Path;

use copq::on_policy::{Saute, SauteConfig};
use copq::{AdjustedEnv, Env, Error, Result};
use copq_envs::{Locomotion, Options, Physics, RobotSpec};
use copq_envs_python::{PACKAGES, is_task};
use copq_experiments::Plan;

use crate::python::make_python;

/// The engines that [`make_env`] knows.
pub const ENGINES: [&str; 3] = ["rapier", "mujoco", "system"];

/// A robot and its task, on an engine chosen at run time.
pub type World = Locomotion<Box<dyn Physics>>;

/// A plan's task on its engine, its objectives in the plan's order, its budgets in the observation
/// if there are settings for them. `run` is its folder, if it already exists.
pub fn make_env(
    plan: &Plan,
    saute: Option<&SauteConfig>,
    run: Option<&Path>,
) -> Result<Box<dyn Env>> {
    let world = adjusted(make_any(plan, run)?, plan)?;
    // Budgets are shown in the task's own order, whatever the priorities.
    let shown: Box<dyn Env> = match saute {
        Some(saute) => Box::new(Saute::new(world, saute)?),
        None => Box::new(world),
    };
    Ok(match &plan.order {
        Some(order) => Box::new(AdjustedEnv::new(shown).order(order)?),
        None => shown,
    })
}

/// An environment with the plan's limits and weights.
pub fn adjusted<E: Env>(world: E, plan: &Plan) -> Result<AdjustedEnv<E>> {
    let limits = plan.limits.iter().map(|(cost, &limit)| (cost.as_str(), limit));
    let world = AdjustedEnv::new(world).limits(limits)?;
    match &plan.weights {
        Some(weights) => world.weights(weights),
        None => Ok(world),
    }
}

fn make_any(plan: &Plan, run: Option<&Path>) -> Result<Box<dyn Env>> {
    let task = &plan.task;
    if is_task(task) {
        return Ok(Box::new(make_python(plan, run, false)?));
    }
    if task.contains(':') || task.contains("-v") {
        let wanted = format!(
            "one that copq tasks lists, or PACKAGE:ID of Python's packages {}",
            PACKAGES.join(", ")
        );
        return Err(Error::invalid("task", wanted, format!("'{task}'")));
    }
    Ok(Box::new(make_world(plan)?))
}

/// A plan's task on its engine, with access to its robot.
pub fn make_world(plan: &Plan) -> Result<World> {
    let options = Options { preset: plan.preset.parse()?, ..Options::default() };
    Locomotion::make(&plan.task, &options, |robot| make_physics(&plan.engine, robot))
}

fn make_physics(engine: &str, robot: &RobotSpec) -> Result<Box<dyn Physics>> {
    match engine {
        "rapier" => Ok(Box::new(copq_envs_rapier::Rapier::new(robot)?)),
        #[cfg(feature = "mujoco")]
        "mujoco" => Ok(Box::new(copq_envs_mujoco::mujoco_rs::physics(robot)?)),
        #[cfg(feature = "system")]
        "system" => Ok(Box::new(copq_envs_mujoco::system::physics(robot)?)),
        known if ENGINES.contains(&known) => {
            let first = if engine == "mujoco" { "scripts/fetch-mujoco.sh, then " } else { "" };
            let wanted =
                format!("a build with it: {first}cargo run --release --features {engine} -- ...");
            Err(Error::invalid(format!("engine {engine}"), wanted, "one without"))
        }
        _ => Err(Error::unknown("engine", engine, &ENGINES)),
    }
}
