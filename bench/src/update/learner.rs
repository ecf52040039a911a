//! The whole update of copq's learner, including replay, FAMO, checks and reports.

use anyhow::Result;
use copq::{Agent, Ensemble, Learner, Method, Outcome, Silent, Transition};
use copq_candle::Candle;

use super::{Losses, Update};
use crate::workload::{Inputs, Workload};

/// A learner whose replay holds the benchmark's batches.
pub struct Full(Learner);

impl Full {
    /// COP-Q on TD3, as in the paper.
    pub fn new(workload: &Workload) -> Result<Self> {
        let mut method =
            Method::cop_td3_paper().critics(Ensemble::Joint(workload.critics)).warm_up(1);
        method.config.batch = workload.rows;
        method.config.actor_delay = workload.actor_delay as u64;
        method.config.networks = workload.networks();
        let mut learner =
            Learner::new(method, &workload.spec(), &Candle::threads(workload.threads), 0)?;
        for batch in workload.batches() {
            for row in 0..workload.rows {
                learner.observe(transition(&batch, row, workload))?;
            }
        }
        Ok(Self(learner))
    }
}

impl Update for Full {
    fn update(&mut self, _number: usize, _batch: &Inputs) -> Result<Losses> {
        self.0.update(&mut Silent)?;
        Ok(Losses::default())
    }
}

fn transition<'a>(batch: &'a Inputs, row: usize, workload: &Workload) -> Transition<'a> {
    let cut = |values: &'a [f32], width: usize| &values[row * width..(row + 1) * width];
    Transition {
        obs: cut(&batch.obs, workload.observation),
        action: cut(&batch.action, workload.action),
        reward: cut(&batch.reward, workload.objectives),
        next_obs: cut(&batch.next_obs, workload.observation),
        outcome: if batch.alive[row] == 0.0 { Outcome::Terminated } else { Outcome::Truncated },
    }
}
