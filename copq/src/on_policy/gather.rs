//! Gathering an epoch: actions, their results, and where paths end.

use super::{Learner, SauteConfig, StateValue};
use crate::loss::check_finite_row;
use crate::{Objective, Outcome, Result};

/// Advice about a critic whose value is not a number.
const CRITIC: &str = "a critic's weights have diverged; lower networks.critic_lr, or scale rewards";

impl Learner {
    /// Chooses an action from its noise, and stores what belongs to the step.
    pub(super) fn explore(&mut self, obs: &[f32], noise: &[f32], action: &mut [f32]) -> Result<()> {
        self.end_what_was_left(obs)?;
        self.see(obs)?;
        self.envs[self.env].taken.obs.copy_from_slice(&self.obs);
        self.sample(noise, action)?;
        self.envs[self.env].is_waiting = true;
        Ok(())
    }

    /// Samples the policy: stores the sample as it is, and writes it clamped to [-1, 1].
    fn sample(&mut self, noise: &[f32], action: &mut [f32]) -> Result<()> {
        let taken = &mut self.envs[self.env].taken;
        values(&mut self.critics, &taken.obs, &mut taken.values, self.steps)?;
        self.deviations.set(self.policy.log_std());
        self.policy.means(&taken.obs, action)?;
        let means = taken.action.iter_mut().zip(&*action);
        for ((sample, mean), (noise, inverse)) in
            means.zip(noise.iter().zip(self.deviations.inverse()))
        {
            *sample = (f64::from(*mean) + f64::from(*noise) / inverse) as f32;
        }
        taken.log_prob = self.deviations.log_prob(action, &taken.action);
        for (action, sample) in action.iter_mut().zip(&taken.action) {
            *action = sample.clamp(-1.0, 1.0);
        }
        Ok(())
    }

    /// The critics' values of the observation that was normalised last.
    pub(super) fn values(&mut self) -> Result<Vec<f32>> {
        let mut expected = vec![0.0; self.critics.len()];
        values(&mut self.critics, &self.obs, &mut expected, self.steps)?;
        Ok(expected)
    }

    /// Shows an observation to the normaliser, and stores it as the networks then see it.
    fn see(&mut self, obs: &[f32]) -> Result<()> {
        if let Some(normaliser) = &mut self.normaliser {
            normaliser.push(obs)?;
        }
        self.normalise(obs)
    }

    /// Stores an observation as the networks see it.
    pub(super) fn normalise(&mut self, obs: &[f32]) -> Result<()> {
        self.obs.clear();
        self.obs.extend_from_slice(obs);
        self.normaliser.as_ref().map_or(Ok(()), |normaliser| normaliser.normalise(&mut self.obs))
    }

    /// Whether an objective counts with its own weight: a reward does, and a cost that neither a
    /// multiplier nor a budget limits.
    pub(super) fn weighs(&self, objective: &Objective) -> bool {
        let holds_costs = !self.multipliers.is_empty() || self.config.saute.is_some();
        !(objective.is_cost() && holds_costs)
    }

    /// Adds a step to the epoch with its signals: the weighted reward, or the reward for a spent
    /// budget, then the costs that multipliers weight.
    pub(super) fn push(&mut self, reward: &[f32], next_obs: &[f32]) {
        // An environment that shows its budgets has them last.
        let is_spent =
            |_: &SauteConfig| next_obs.iter().rev().take(self.costs.len()).any(|&left| left <= 0.0);
        let spent = self.config.saute.filter(is_spent);
        let objectives = self.spec.objectives.iter().zip(reward);
        let weighed = objectives.filter(|(objective, _)| self.weighs(objective));
        let total: f64 = weighed.map(|(o, &reward)| f64::from(o.weight) * f64::from(reward)).sum();
        let earned = spent.map_or(total, |saute| saute.unsafe_reward);
        self.signals.clear();
        self.signals.push(earned as f32);
        self.signals.extend(self.costs.iter().take(self.multipliers.len()).map(|&i| reward[i]));
        self.epoch.push(self.env, &self.envs[self.env].taken, &self.signals);
    }

    /// Ends a path that its environment left without an end, as after an error: it was cut short
    /// after the last observation.
    fn end_what_was_left(&mut self, obs: &[f32]) -> Result<()> {
        let env = self.env;
        let has_begun = std::mem::take(&mut self.envs[env].has_begun);
        let is_elsewhere = has_begun || self.envs[env].obs != obs;
        if is_elsewhere && self.epoch.is_open(env) {
            let last = self.envs[env].obs.clone();
            self.see(&last)?;
            let values = self.values()?;
            self.epoch.end(env, values);
            self.envs[env].costs.fill(0.0);
        }
        Ok(())
    }

    /// Ends a path where an episode or the epoch ends.
    pub(super) fn end_path(&mut self, outcome: Outcome, obs: &[f32]) -> Result<()> {
        self.see(obs)?;
        let mut values = self.values()?;
        if outcome == Outcome::Terminated {
            values.fill(0.0);
        }
        self.epoch.end(self.env, values);
        let episode = &mut self.envs[self.env].costs;
        if outcome != Outcome::Running {
            // A run saved with a longer window has more of them.
            while self.window.len() >= self.config.window {
                self.window.pop_front();
            }
            self.window.push_back(episode.clone());
            self.fresh.add(episode);
        }
        episode.fill(0.0);
        Ok(())
    }
}

/// Writes each critic's value of one observation.
fn values(
    critics: &mut [Box<dyn StateValue>],
    obs: &[f32],
    values: &mut [f32],
    step: u64,
) -> Result<()> {
    for (critic, value) in critics.iter_mut().zip(values.chunks_exact_mut(1)) {
        critic.values(obs, value)?;
    }
    check_finite_row("value", values, step, CRITIC)
}
