//! What a saved learner records about its origin, and whether it matches the learner that loads it.

use crate::{Error, Result, State};

/// What identifies the learner of a checkpoint; a checkpoint of a different one is refused.
pub(crate) struct MadeBy<'a> {
    pub method: &'a str,
    /// Only for learners that have one.
    pub bound: Option<String>,
    pub task: &'a str,
    pub objectives: &'a [String],
    pub seed: u64,
    pub discount: f64,
}

impl MadeBy<'_> {
    pub fn save(&self, state: &mut State) {
        let made = state.child_mut("made_by");
        made.put_text("method", self.method);
        if let Some(bound) = &self.bound {
            made.put_text("bound", bound);
        }
        made.put_text("task", self.task);
        made.put_text("objectives", &self.objectives.join(","));
        made.put("seed", [self.seed]);
        made.put("discount", [self.discount]);
    }

    /// An error unless a saved learner records the same.
    pub fn check(&self, state: &State) -> Result<()> {
        let made = made_by(state)?;
        same("method", self.method, made.get_text("method")?)?;
        if let Some(bound) = &self.bound {
            same("bound", bound.as_str(), made.get_text("bound")?)?;
        }
        check_task(state, self.task)?;
        same("objectives", self.objectives.join(",").as_str(), made.get_text("objectives")?)?;
        same("seed", self.seed, made.get_one("seed")?)?;
        same("discount", self.discount, made.get_one("discount")?)
    }
}

/// An error if a saved learner is of a different task.
pub(crate) fn check_task(state: &State, own: &str) -> Result<()> {
    same("task", own, made_by(state)?.get_text("task")?)
}

/// The method of a saved learner.
pub(crate) fn method_of(state: &State) -> Result<&str> {
    made_by(state)?.get_text("method")
}

fn made_by(state: &State) -> Result<&State> {
    state.child("made_by").map_err(|_| {
        let wanted = "one that says what made it: its method, its task and so on";
        Error::invalid("the saved learner", wanted, "none of these, as before version 0.1")
    })
}

fn same<T: PartialEq + std::fmt::Display>(what: &str, own: T, saved: T) -> Result<()> {
    if saved == own {
        return Ok(());
    }
    Err(Error::invalid(format!("{what} of the saved learner"), own, saved))
}
