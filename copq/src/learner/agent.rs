//! The learner as an [`Agent`]: acting, observing, and everything that a checkpoint holds.

use std::path::Path;

use super::Learner;
use crate::error::check_len;
use crate::loss::{check_finite, check_finite_obs, check_finite_row, check_unit};
use crate::made_by::MadeBy;
use crate::{
    Agent, Context, EnvSpec, Error, Mode, Net, Normaliser, Observer, Outcome, Replay, Result,
    State, Transition,
};

impl Learner {
    fn made_by(&self) -> MadeBy<'_> {
        MadeBy {
            method: &self.name,
            bound: Some(format!("{:?}", self.projection)),
            task: &self.spec.name,
            objectives: &self.objectives,
            seed: self.seed,
            discount: self.config.discount,
        }
    }

    /// Empties the replay, for a checkpoint without one. The current policy then gathers as many
    /// steps again as there were before the first update.
    fn forget_replay(&mut self) -> Result<()> {
        self.replay = Replay::new(&self.spec, self.config.capacity)?;
        self.first_update = self.steps + self.config.start_steps;
        self.has_lost_replay = true;
        Ok(())
    }

    /// Stores one observation as the networks see it.
    pub(super) fn normalise(&mut self, obs: &[f32]) -> Result<()> {
        check_len("observation", obs.len(), self.obs.len())?;
        self.obs.copy_from_slice(obs);
        self.normaliser.as_ref().map_or(Ok(()), |normaliser| normaliser.normalise(&mut self.obs))
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

    fn begin_episode(&mut self) {
        self.warm_up.begin_episode();
        self.explore.begin_episode();
    }

    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()> {
        check_len("action", action.len(), self.spec.action_len())?;
        check_finite_obs(obs, self.steps)?;
        self.normalise(obs)?;
        let Self {
            config,
            actor,
            critic,
            projection,
            multiplier,
            explore,
            warm_up,
            streams,
            buffers,
            steps,
            ..
        } = self;
        let obs = self.obs.as_slice();
        if mode == Mode::Exploit {
            actor.mode(Net::Online, obs, action)?;
        } else {
            let mut context = Context {
                step: *steps,
                actor: actor.as_mut(),
                critic: critic.as_mut(),
                projection: projection.as_ref(),
                weights: multiplier.weights(),
                rng: &mut streams.explore,
                scratch: &mut buffers.scratch,
            };
            let explore = if *steps < config.start_steps { warm_up } else { explore };
            explore.act(&mut context, obs, action)?;
        }
        let hint = "the actor's weights have diverged (lower its step size), or the exploration \
                    rule wrote it";
        check_finite_row("action", action, self.steps, hint)?;
        check_unit("a chosen action", action)
    }

    fn observe(&mut self, t: Transition<'_>) -> Result<()> {
        check_len("transition's reward", t.reward.len(), self.objectives.len())?;
        check_finite("reward", t.reward, &self.objectives, self.steps)?;
        check_finite_obs(t.next_obs, self.steps)?;
        check_finite_obs(t.obs, self.steps)?;
        check_finite_row("action", t.action, self.steps, "the caller passed NaN or infinity")?;
        check_unit("a transition's action, before EnvSpec::scale_action", t.action)?;
        self.scales.observe(t.next_obs, t.reward)?;
        self.replay.push(t)?;
        if let Some(normaliser) = &mut self.normaliser {
            normaliser.push(t.obs)?;
            if t.outcome != Outcome::Running {
                normaliser.push(t.next_obs)?;
            }
        }
        self.steps += 1;
        Ok(())
    }

    fn update(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.scales.warn(self.steps, self.normaliser.is_some(), log);
        if std::mem::take(&mut self.has_lost_replay) {
            let text = format!(
                "the checkpoint has no replay: learning resumes at step {}, and the results differ \
                 from an unbroken run's",
                self.first_update
            );
            log.warn(self.steps, &text);
        }
        if self.steps < self.first_update {
            return Ok(());
        }
        (0..self.config.updates_per_step).try_for_each(|_| self.update_once(log))
    }

    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()> {
        check_len("values", q.len(), self.objectives.len())?;
        self.online_values(obs, action)?;
        let critics = self.critic.critics();
        let n = self.objectives.len();
        let values = &self.buffers.q[..critics * n];
        for (i, q) in q.iter_mut().enumerate() {
            *q = (0..critics).map(|k| values[k * n + i]).sum::<f32>() / critics as f32;
        }
        Ok(())
    }

    fn save_policy(&self, path: &Path) -> Result<()> {
        self.save_policy(path)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.made_by().save(state);
        state.put("steps", [self.steps]);
        state.put("updates", [self.updates]);
        if self.first_update != self.config.start_steps {
            state.put("first_update", [self.first_update]);
        }
        self.streams.save(state);
        self.replay.save(state.child_mut("replay"));
        self.multiplier.save(state.child_mut("multiplier"));
        let mut explore = State::default();
        self.explore.save(&mut explore);
        if explore != State::default() {
            *state.child_mut("explore") = explore;
        }
        if let Some(normaliser) = &self.normaliser {
            normaliser.save(state.child_mut("normaliser"));
        }
        if let Some(temperature) = &self.temperature {
            temperature.save(state.child_mut("temperature"));
        }
        if let Some(famo) = &self.famo {
            famo.save(state.child_mut("famo"));
        }
        self.actor.save(state.child_mut("actor"))?;
        self.critic.save(state.child_mut("critic"))
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.made_by().check(state)?;
        self.steps = state.get_one("steps")?;
        self.updates = state.get_one("updates")?;
        self.streams.load(state)?;
        self.first_update = self.config.start_steps;
        match state.child("replay") {
            Ok(replay) => {
                self.replay.load(replay)?;
                if let Ok(step) = state.get_one("first_update") {
                    self.first_update = step;
                }
            }
            Err(_) => self.forget_replay()?,
        }
        self.multiplier.load(state.child("multiplier")?)?;
        // A rule without a memory has written nothing.
        self.explore.load(state.child("explore").unwrap_or(&State::default()))?;
        Normaliser::restore(&mut self.normaliser, state)?;
        for (part, wanted) in
            [("temperature", self.temperature.is_some()), ("famo", self.famo.is_some())]
        {
            if state.child(part).is_ok() != wanted {
                let [own, saved] = if wanted { ["one", "none"] } else { ["none", "one"] };
                return Err(Error::invalid(format!("{part} of the saved learner"), own, saved));
            }
        }
        if let Some(temperature) = &mut self.temperature {
            temperature.load(state.child("temperature")?)?;
        }
        if let Some(famo) = &mut self.famo {
            famo.load(state.child("famo")?)?;
        }
        self.actor.load(state.child("actor")?)?;
        self.critic.load(state.child("critic")?)
    }
}
