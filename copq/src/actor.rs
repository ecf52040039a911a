//! The policy's seam: actions from observations and noise, and one gradient step on them.

use crate::{Error, Net, Result, State};

/// A batch of sampled actions, as an actor shows it to the function that fills the gradient.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Actions in [-1, 1], `rows x action`.
    pub action: &'a [f32],
    /// log pi(a|s), one per row; empty for a deterministic policy.
    pub log_prob: &'a [f32],
}

/// dL/daction (`rows x action`) and dL/dlog_prob (`rows`, empty for a deterministic policy), to be
/// filled.
#[derive(Debug)]
pub struct SampleGrad<'a> {
    /// dL/daction.
    pub action: &'a mut [f32],
    /// dL/dlog_prob.
    pub log_prob: &'a mut [f32],
}

/// Given sampled actions, fills their gradients.
pub type ActionGrad<'a> = &'a mut dyn FnMut(Sample<'_>, SampleGrad<'_>) -> Result<()>;

/// A policy. Deterministic ones need no noise and have no log-probability; stochastic ones are
/// reparameterised: the noise comes from outside, as standard normals.
pub trait Actor: Send {
    /// Length of an action.
    fn action_len(&self) -> usize;

    /// Standard normals that one row needs: 0 for a deterministic policy.
    fn noise_len(&self) -> usize;

    /// Writes actions for a batch of observations. With empty `noise` the action is the policy's
    /// mode, and `log_prob` must be empty; otherwise `noise` is `rows x noise_len()` and `log_prob`
    /// has one entry a row.
    fn sample(
        &mut self,
        net: Net,
        obs: &[f32],
        noise: &[f32],
        action: &mut [f32],
        log_prob: &mut [f32],
    ) -> Result<()>;

    /// One optimiser step that lowers L: forward, `grad` fills dL/daction and dL/dlog_prob,
    /// backward, step.
    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()>;

    /// Writes d(grad_action . action)/dnoise of the online policy, `rows x noise_len()`: which way
    /// of the noise moves the actions along `grad_action`. There is nothing to write for a
    /// deterministic policy.
    fn noise_grad(
        &mut self,
        obs: &[f32],
        noise: &[f32],
        grad_action: &[f32],
        out: &mut [f32],
    ) -> Result<()>;

    /// Polyak averaging: target <- (1 - tau) target + tau online.
    fn update_target(&mut self, tau: f32) -> Result<()>;

    /// Writes the online parameters alone, as a policy's file has them: `layer.0.weight` (output x
    /// input) and so on.
    fn export(&self, _state: &mut State) -> Result<()> {
        Err(Error::Unsupported { what: "this actor has no Actor::export".to_owned() })
    }

    /// Takes what [`Actor::export`] wrote; targets become equal to it and the optimiser begins
    /// anew.
    fn import(&mut self, _state: &State) -> Result<()> {
        Err(Error::Unsupported { what: "this actor has no Actor::import".to_owned() })
    }

    /// Writes parameters, targets and optimiser state.
    fn save(&self, state: &mut State) -> Result<()>;

    /// Restores what [`Actor::save`] wrote.
    fn load(&mut self, state: &State) -> Result<()>;
}
