//! The on-policy learner as an agent.

use std::path::Path;

use super::learner::Learner;
use crate::error::check_len;
use crate::loss::{check_finite, check_finite_obs, check_finite_row};
use crate::made_by::MadeBy;
use crate::{
    Agent, EnvSpec, Error, Mode, Net, Normaliser, Objective, Observer, Outcome, Result, State,
    Transition,
};

impl Learner {
    fn check_env(&self) -> Result<()> {
        if self.env < self.envs.len() {
            return Ok(());
        }
        let wanted = format!("one of {}, counted from 0 (Agent::prepare)", self.envs.len());
        Err(Error::invalid("environment attended to", wanted, self.env))
    }

    /// An error unless an action is waiting for its transition: the learner learns from the sample
    /// that it drew for that action.
    fn take_up_choice(&mut self) -> Result<()> {
        if std::mem::take(&mut self.envs[self.env].is_waiting) {
            return Ok(());
        }
        let wanted = "one for each action that Agent::act chose in Mode::Explore";
        Err(Error::invalid("transition that an on-policy learner observes", wanted, "an extra one"))
    }

    fn made_by(&self) -> MadeBy<'_> {
        MadeBy {
            method: &self.name,
            bound: None,
            task: &self.spec.name,
            objectives: &self.objectives,
            seed: self.seed,
            discount: self.config.discount,
        }
    }
}

impl Agent for Learner {
    fn seed(&self) -> u64 {
        self.seed
    }

    fn discount(&self) -> f64 {
        self.config.discount
    }

    fn check_spec(&self, spec: &EnvSpec) -> Result<()> {
        self.spec.check_same("the environment of a learner made for another", spec)
    }

    fn prepare(&mut self, envs: usize) -> Result<()> {
        self.spread(envs)
    }

    fn attend(&mut self, env: usize) {
        self.env = env;
    }

    fn begin_episode(&mut self) {
        if let Some(env) = self.envs.get_mut(self.env) {
            env.has_begun = true;
        }
    }

    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()> {
        check_len("observation", obs.len(), self.spec.obs_len)?;
        check_len("action", action.len(), self.spec.action_len())?;
        self.check_env()?;
        check_finite_obs(obs, self.steps)?;
        if mode == Mode::Exploit {
            self.normalise(obs)?;
            self.policy.mode(Net::Online, &self.obs, action)?;
        } else {
            let mut noise = vec![0.0; action.len()];
            self.noise.fill_normal(&mut noise);
            self.explore(obs, &noise, action)?;
        }
        let advice = "the policy's weights have diverged; lower its step size";
        check_finite_row("action", action, self.steps, advice)
    }

    fn observe(&mut self, t: Transition<'_>) -> Result<()> {
        check_len("transition's reward", t.reward.len(), self.objectives.len())?;
        check_len("observation", t.next_obs.len(), self.spec.obs_len)?;
        check_finite("reward", t.reward, &self.objectives, self.steps)?;
        check_finite_obs(t.next_obs, self.steps)?;
        self.check_env()?;
        self.take_up_choice()?;
        self.scales.observe(t.next_obs, t.reward)?;
        self.steps += 1;
        if self.epoch.is_full(self.env) {
            // It waits for environments that have lost steps to errors.
            return Ok(());
        }
        self.push(t.reward, t.next_obs);
        let env = &mut self.envs[self.env];
        env.obs.copy_from_slice(t.next_obs);
        for (sum, cost) in env.costs.iter_mut().zip(&self.costs) {
            *sum += f64::from(t.reward[*cost]);
        }
        if t.outcome != Outcome::Running || self.epoch.is_full(self.env) {
            self.end_path(t.outcome, t.next_obs)?;
        }
        Ok(())
    }

    fn update(&mut self, log: &mut dyn Observer) -> Result<()> {
        if !self.epoch.is_complete() {
            return Ok(());
        }
        self.scales.warn(self.steps, self.normaliser.is_some(), log);
        self.learn(log)
    }

    fn ends_episode(&self) -> bool {
        // The last path of a complete epoch has just been learned from.
        self.epoch.is_empty()
    }

    fn value(&mut self, obs: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        check_len("values", q.len(), self.spec.objectives.len())?;
        self.normalise(obs)?;
        let values = self.values()?;
        // The one critic of the weighted signal gives the value of a reward that is alone in it,
        // unless spent budgets can replace the reward.
        let weighed = |o: &&Objective| !o.is_cost() || self.weighs(o) && o.weight != 0.0;
        let weighed = self.spec.objectives.iter().filter(weighed).count();
        let is_reward = weighed == 1 && self.config.saute.is_none();
        let mut costs = values[1..].iter();
        for (q, objective) in q.iter_mut().zip(&self.spec.objectives) {
            *q = match objective.limit {
                Some(_) => costs.next().copied().unwrap_or(f32::NAN),
                None if is_reward && objective.weight != 0.0 => values[0] / objective.weight,
                None => f32::NAN,
            };
        }
        Ok(())
    }

    fn save_policy(&self, path: &Path) -> Result<()> {
        self.save_policy(path)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.made_by().save(state);
        state.put("steps", [self.steps]);
        state.put("epochs", [self.epochs]);
        state.put("fresh", [self.fresh.episodes]);
        state.put("fresh_costs", self.fresh.costs.as_slice());
        state.put("window", self.window.iter().flatten().copied().collect::<Vec<f64>>());
        self.noise.save("rng_explore", state);
        self.order.save("rng_order", state);
        self.epoch.save(state.child_mut("epoch"));
        for (i, env) in self.envs.iter().enumerate() {
            let state = state.child_mut(&format!("world.{i}"));
            state.put("obs", env.obs.as_slice());
            state.put("costs", env.costs.as_slice());
        }
        for (i, multiplier) in self.multipliers.iter().enumerate() {
            multiplier.save(state.child_mut(&format!("multiplier.{i}")));
        }
        if let Some(normaliser) = &self.normaliser {
            normaliser.save(state.child_mut("normaliser"));
        }
        self.policy.save(state.child_mut("actor"))?;
        for (i, critic) in self.critics.iter().enumerate() {
            critic.save(state.child_mut(&format!("critic.{i}")))?;
        }
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.made_by().check(state)?;
        self.steps = state.get_one("steps")?;
        self.epochs = state.get_one("epochs")?;
        self.fresh.episodes = state.get_one("fresh")?;
        state.read("fresh_costs", &mut self.fresh.costs)?;
        let window = state.get::<f64>("window")?;
        let costs = self.costs.len();
        if !window.len().is_multiple_of(costs.max(1)) {
            let wanted = format!("{costs} numbers for each episode");
            return Err(Error::invalid("window of the saved learner", wanted, window.len()));
        }
        self.window = window.chunks_exact(costs.max(1)).map(<[f64]>::to_vec).collect();
        self.noise.load("rng_explore", state)?;
        self.order.load("rng_order", state)?;
        self.epoch.load(state.child("epoch")?)?;
        for (i, env) in self.envs.iter_mut().enumerate() {
            let state = state.child(&format!("world.{i}"))?;
            state.read("obs", &mut env.obs)?;
            state.read("costs", &mut env.costs)?;
        }
        for (i, multiplier) in self.multipliers.iter_mut().enumerate() {
            multiplier.load(state.child(&format!("multiplier.{i}"))?)?;
        }
        Normaliser::restore(&mut self.normaliser, state)?;
        self.policy.load(state.child("actor")?)?;
        for (i, critic) in self.critics.iter_mut().enumerate() {
            critic.load(state.child(&format!("critic.{i}"))?)?;
        }
        Ok(())
    }
}
