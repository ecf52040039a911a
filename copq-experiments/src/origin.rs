//! What made a checkpoint's steps, so that a run can say if its settings have been edited since.

use copq::{Result, State};
use serde::Serialize;

use crate::config::{complete, difference};
use crate::fingerprint::table;
use crate::plan::Plan;

/// Plan and settings, as far as they can change a run's numbers, without its length.
#[derive(Debug)]
pub(crate) struct Origin {
    plan: Plan,
    settings: toml::Table,
}

impl Origin {
    pub(crate) fn new<S: Serialize>(plan: &Plan, settings: &S) -> Result<Self> {
        // What its first policy was matters, not which file it came from.
        let plan = Plan { init_from: None, ..plan.without_length() };
        Ok(Self { plan, settings: table(settings)? })
    }

    /// Writes it into a checkpoint.
    pub(crate) fn save(&self, state: &mut State) -> Result<()> {
        state.put_text("plan", &table(&self.plan)?.to_string());
        state.put_text("settings", &self.settings.to_string());
        Ok(())
    }

    /// A sentence about the first setting that has changed since a checkpoint was saved; `None` if
    /// none has, or if the checkpoint does not say.
    pub(crate) fn change(&self, saved: &State) -> Option<String> {
        let then = |name: &str| saved.get_text(name).ok()?.parse::<toml::Table>().ok();
        let plan: Plan = then("plan")?.try_into().ok()?;
        let settings = complete(&then("settings")?);
        let plans = [table(&plan).ok()?.into(), table(&self.plan).ok()?.into()];
        let [before, now] = &plans;
        let (key, before, now) = difference("plan", before, now)
            .or_else(|| difference("settings", &settings.into(), &self.settings.clone().into()))?;
        Some(format!("config.toml was edited: {key} was {before} and is {now} from here on"))
    }
}
