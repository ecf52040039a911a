//! Trains a plan: its environments, its agent, its folder, and how the program exits at the end.

use std::path::{Path, PathBuf};

use anyhow::Context;
use copq::{EnvSpec, Method, Objective};
use copq_experiments::{Ending, Plan, Run, RunFolder, read_policy};

use crate::options::{note, say};
use crate::recipe::Recipe;
use crate::saved;
use crate::train::Prepared;
use crate::world::make_env;

/// Exit code of a run that was stopped and can be resumed (EX_TEMPFAIL).
pub const STOPPED: i32 = 75;

/// Exits as the run has ended, so that nothing continues with half of it.
pub fn leave(ending: &Ending) -> anyhow::Result<()> {
    match ending {
        Ending::Finished { .. } => Ok(()),
        _ => std::process::exit(STOPPED),
    }
}

/// Trains to the end of a plan, in the folder that `open` makes or reopens once everything else has
/// proved to fit. A run that begins with the policy in a file keeps a copy of it.
pub fn train(
    recipe: Recipe,
    mut plan: Plan,
    init: Option<PathBuf>,
    run: Option<&Path>,
    open: impl FnOnce(&Recipe, &Plan) -> anyhow::Result<RunFolder>,
) -> anyhow::Result<Ending> {
    plan.check()?;
    init.as_deref().map_or(Ok(()), |file| saved::check_init(file, &plan))?;
    // The environments to learn in; the one for evaluations is made below.
    let env = make_env(&plan, recipe.saute(), run)?;
    note_unheeded(&recipe, env.spec());
    note_no_update(&recipe, &plan);
    note_last_step_size(&recipe, &plan);
    match run {
        Some(_) => saved::note_other_versions(&plan, env.spec()),
        // Those of its own environment, even if it is like a run with others.
        None => plan.versions.clone_from(&env.spec().versions),
    }
    let mut agent = recipe.clone().agent(env.spec(), &plan, init.as_deref())?;
    // Before the other environments are made.
    agent.prepare(plan.envs)?;
    let mut envs = vec![env];
    for _ in 1..plan.envs {
        envs.push(make_env(&plan, recipe.saute(), run)?);
    }
    let trainer = copq::Trainer::with_envs(envs, agent)?.threads(plan.threads);
    let eval_env = match plan.run.eval_every {
        0 => None,
        _ => Some(
            make_env(&plan, recipe.saute(), run)
                .context("a second environment, for evaluations (--eval-every 0 needs none)")?,
        ),
    };
    let folder = open(&recipe, &plan)?;
    if let Some(file) = init {
        read_policy(file)?.write_file(folder.file(saved::INIT))?;
    }
    let ending = Run::new(trainer, eval_env, folder, plan.run)?.train()?;
    // The run is done and its log also says so; that nobody reads it here is no failure.
    say(&format!("{ending}\n")).unwrap_or_default();
    Ok(ending)
}

/// Notes a step size that reaches the end of its decay before the run is over.
fn note_last_step_size(recipe: &Recipe, plan: &Plan) {
    if let Recipe::OnPolicy(method) = recipe
        && let Some(steps) = method.config.anneal_steps
        && steps < plan.run.steps
        && method.config.natural.is_none()
    {
        note(&format!("after step {steps} the policy's step size stays at its last, small value"));
    }
}

/// Notes a run that is over before it learns anything.
fn note_no_update(recipe: &Recipe, plan: &Plan) {
    let (name, first) = match recipe {
        Recipe::OffPolicy(method) => ("start_steps", method.config.start_steps),
        Recipe::OnPolicy(method) => ("steps_per_epoch", method.config.steps_per_epoch as u64),
    };
    if plan.run.steps < first {
        note(&format!("nothing is learned before step {first} ({name}), and this run ends first"));
    }
}

/// Makes a run's environment and agent and drops them: an error for a run that could not begin.
pub fn try_out(prepared: &Prepared) -> anyhow::Result<()> {
    let Prepared { plan, recipe, .. } = prepared;
    plan.check()?;
    let env = make_env(plan, recipe.saute(), None)?;
    let init = plan.init_from.as_deref().map(saved::policy_file).transpose()?;
    let mut agent = recipe.clone().agent(env.spec(), plan, init.as_deref())?;
    Ok(agent.prepare(plan.envs)?)
}

/// Notes what a method does not heed in its task.
fn note_unheeded(recipe: &Recipe, spec: &EnvSpec) {
    for objective in spec.objectives.iter().filter(|objective| objective.is_cost()) {
        let Objective { name: cost, weight, .. } = objective;
        if !recipe.holds_costs() {
            let other = recipe.constrained();
            note(&format!(
                "nothing holds the {cost}'s limit here (its weight is {weight}); {other} does"
            ));
        } else if *weight != 0.0 {
            note(&format!(
                "the {cost}'s weight of {weight} counts only in the weighted total: the method \
                 weighs the {cost} by its limit"
            ));
        }
    }
    if let Recipe::OffPolicy(method) = recipe {
        late_cost(method, spec).into_iter().chain(idle_first(method, spec)).for_each(|s| note(&s));
    }
}

/// What to say if a bound that uses priorities puts an objective that counts for nothing before one
/// that counts.
fn idle_first(method: &Method, spec: &EnvSpec) -> Option<String> {
    let is_weighed = |objective: &&Objective| {
        objective.weight != 0.0 || (objective.is_cost() && method.config.constraint.is_some())
    };
    let idle = spec.objectives.iter().position(|objective| !is_weighed(&objective))?;
    let after = spec.objectives[idle..].iter().find(is_weighed)?;
    (method.bound.name() == "cholesky").then(|| {
        let (idle, after) = (&spec.objectives[idle].name, &after.name);
        format!(
            "{idle} has weight 0 and comes before {after}, whose bound is then lowered only by what \
             {idle}'s disagreement does not explain; see --order"
        )
    })
}

/// What to say if a bound that uses priorities puts a reward before a cost that is to be held.
fn late_cost(method: &Method, spec: &EnvSpec) -> Option<String> {
    let knows_order = method.config.constraint.is_some() && method.bound.name() == "cholesky";
    let reward = spec.objectives.iter().position(|objective| !objective.is_cost())?;
    let cost = spec.costs().into_iter().find(|&cost| cost > reward).filter(|_| knows_order)?;
    let [reward, cost] = [reward, cost].map(|i| &spec.objectives[i].name);
    Some(format!("the bound puts {reward} before {cost}, which is to be held; see --order"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_that_is_not_first_is_remarked() {
        let first = EnvSpec::new("x", 1, 1).cost("cost", 1.0).reward("speed", 1.0);
        let late = EnvSpec::new("x", 1, 1).reward("speed", 1.0).cost("cost", 1.0);
        let words = "the bound puts speed before cost, which is to be held; see --order";
        assert_eq!(late_cost(&Method::cop_cal(), &late).unwrap(), words);
        assert_eq!(late_cost(&Method::cop_cal(), &first), None);
        assert_eq!(late_cost(&Method::cal(), &late), None);
        assert_eq!(late_cost(&Method::cop_td3(), &late), None);
    }

    #[test]
    fn what_counts_for_nothing_belongs_last() {
        let first = EnvSpec::new("x", 1, 1).cost("cost", 1.0).reward("speed", 1.0);
        let words = "cost has weight 0 and comes before speed, whose bound is then lowered only by what \
                     cost's disagreement does not explain; see --order";
        assert_eq!(idle_first(&Method::cop_td3(), &first).unwrap(), words);
        let extremum = Method::cop_td3().bound(copq::projection::Extremum);
        let last = EnvSpec::new("x", 1, 1).reward("speed", 1.0).cost("cost", 1.0);
        let weighed = EnvSpec::new("x", 1, 1).reward("safety", 1.0).reward("speed", 1.0);
        assert_eq!(idle_first(&extremum, &first), None);
        assert_eq!(idle_first(&Method::cop_cal(), &first), None);
        assert_eq!(idle_first(&Method::cop_td3(), &last), None);
        assert_eq!(idle_first(&Method::cop_td3(), &weighed), None);
    }
}
