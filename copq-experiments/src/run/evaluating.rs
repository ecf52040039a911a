//! A run's evaluations: when, how, and what happens when one fails.

use std::time::Instant;

use copq::{Error, Result, evaluate_while};

use super::Run;
use crate::evaluations;
use crate::figure;
use crate::numbers::grouped;
use crate::settings::OnEnvError;
use crate::stop::Stop;

impl Run {
    pub(super) fn is_evaluation_due(&self) -> bool {
        let step = self.trainer.steps();
        self.settings.eval_every > 0
            && self.records.pace.is_due(step, self.settings.eval_every)
            && self.records.evaluations.last() != Some(step)
    }

    /// Evaluates, unless a signal comes meanwhile; then the resumed run does it.
    pub(super) fn evaluate(&mut self, stop: &Stop) -> Result<()> {
        let began = Instant::now();
        let episodes = self.settings.eval_episodes;
        let may_go_on = || stop.check();
        let evaluation = match &mut self.eval_env {
            None => self.trainer.evaluate_while(episodes, may_go_on),
            Some(env) => evaluate_while(self.trainer.agent_mut(), env, episodes, may_go_on),
        };
        let evaluation = match evaluation {
            Err(_) if stop.is_asked() => return Ok(()),
            Err(error) => return self.evaluation_failed(error),
            Ok(evaluation) => evaluation,
        };
        let is_best = self.records.is_best(&evaluation, self.trainer.spec());
        self.save_policy("policy.safetensors")?;
        if is_best {
            self.save_policy("policy-best.safetensors")?;
        }
        // The row comes last: it says that the evaluation is done, so that it is not repeated.
        let step = self.trainer.steps();
        let spec = self.trainer.spec();
        self.records.evaluated(step, &evaluation, spec)?;
        self.progress.line(&evaluations::describe(step, &evaluation, spec));
        self.evaluation_time += began.elapsed();
        self.records.timings.evaluated(began.elapsed());
        // A failed picture is no reason to end a run.
        if let Err(error) = figure::draw_run(self.folder.path(), self.trainer.spec()) {
            self.progress.line(&format!("the curves could not be drawn: {error}"));
        }
        Ok(())
    }

    /// Continues the run, if the settings say so; otherwise saves it and returns the error.
    fn evaluation_failed(&mut self, error: Error) -> Result<()> {
        let what = format!("the evaluation after step {}", grouped(self.trainer.steps()));
        if self.settings.on_env_error == OnEnvError::Reset {
            self.progress.line(&format!("{what} failed: {error}"));
            return Ok(());
        }
        if self.saved_step != Some(self.trainer.steps()) {
            self.checkpoint()?;
        }
        let what = format!(
            "{what} failed; the run is saved (--on-env-error reset continues without this row)"
        );
        Err(Error::other(what, error))
    }
}
