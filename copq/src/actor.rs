//! The interface of policies: actions from observations and noise, and one gradient step on them.

use crate::{Error, Net, Result, State};

/// A batch of sampled actions, as an actor shows it to the function that fills the gradient.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Actions in [-1, 1], `rows x action`.
    pub action: &'a [f32],
    /// log pi(a|s), one per row; a deterministic policy has none.
    pub log_prob: Option<&'a [f32]>,
}

/// dL/daction (`rows x action`) and, for a stochastic policy, dL/dlog_prob (`rows`), to be filled.
#[derive(Debug)]
pub struct SampleGrad<'a> {
    /// dL/daction.
    pub action: &'a mut [f32],
    /// dL/dlog_prob.
    pub log_prob: Option<&'a mut [f32]>,
}

/// Given sampled actions, fills their gradients.
pub type ActionGrad<'a> = &'a mut dyn FnMut(Sample<'_>, SampleGrad<'_>) -> Result<()>;

/// A policy. Deterministic policies have only a mode. Stochastic policies are reparameterised:
/// their noise comes from outside, as standard normals.
///
/// ```
/// use copq::{ActionGrad, Actor, Net, Result, Sample, SampleGrad};
///
/// /// A deterministic policy: a = w s, for one observed number and one action.
/// struct Proportional {
///     online: f32,
///     target: f32,
/// }
///
/// impl Actor for Proportional {
///     fn action_len(&self) -> usize {
///         1
///     }
///
///     fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
///         let w = if net == Net::Online { self.online } else { self.target };
///         action.iter_mut().zip(obs).for_each(|(a, s)| *a = (w * s).clamp(-1.0, 1.0));
///         Ok(())
///     }
///
///     fn improve(&mut self, obs: &[f32], _: &[f32], grad: ActionGrad<'_>) -> Result<()> {
///         let mut action = vec![0.0; obs.len()];
///         let mut grad_a = action.clone();
///         self.mode(Net::Online, obs, &mut action)?;
///         grad(
///             Sample { action: &action, log_prob: None },
///             SampleGrad { action: &mut grad_a, log_prob: None },
///         )?;
///         self.online -= 0.5 * obs.iter().zip(&grad_a).map(|(s, grad)| s * grad).sum::<f32>();
///         Ok(())
///     }
/// #     fn update_target(&mut self, _: f32) -> Result<()> { Ok(()) }
///
///     // Left out here: update_target; save and load, for runs; export and import, for policies.
/// }
///
/// // A step towards a = 0.5 for the observation 1, down the gradient a - 0.5.
/// let mut actor = Proportional { online: 0.0, target: 0.0 };
/// actor.improve(&[1.0], &[], &mut |sample, grad| {
///     grad.action[0] = sample.action[0] - 0.5;
///     Ok(())
/// })?;
/// let mut action = [0.0];
/// actor.mode(Net::Online, &[1.0], &mut action)?;
/// assert_eq!(action, [0.25]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Actor: Send {
    /// Length of an action.
    fn action_len(&self) -> usize;

    /// The number of standard normals that one row needs: 0 for a deterministic policy.
    fn noise_len(&self) -> usize {
        0
    }

    /// Writes the policy's mode for a batch of observations: a deterministic policy's action, or a
    /// Gaussian policy's action at zero noise.
    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()>;

    /// Writes a stochastic policy's actions (`rows x action`) and log pi(a|s) (`rows`) for a batch
    /// of observations and the `rows x noise_len()` normals that decide them.
    fn sample(
        &mut self,
        _net: Net,
        _obs: &[f32],
        _noise: &[f32],
        _action: &mut [f32],
        _log_prob: &mut [f32],
    ) -> Result<()> {
        Err(deterministic("sample"))
    }

    /// One optimiser step that lowers L: forward, `grad` fills dL/daction and dL/dlog_prob,
    /// backward, step. `noise` is `rows x noise_len()`, so a deterministic policy has none.
    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()>;

    /// Writes d(grad_action . action)/dnoise of a stochastic online policy, `rows x noise_len()`:
    /// the direction of the noise that moves the actions along `grad_action`.
    fn noise_grad(
        &mut self,
        _obs: &[f32],
        _noise: &[f32],
        _grad_action: &[f32],
        _out: &mut [f32],
    ) -> Result<()> {
        Err(deterministic("noise_grad"))
    }

    /// Polyak averaging: target <- (1 - tau) target + tau online.
    fn update_target(&mut self, tau: f32) -> Result<()>;

    /// Writes only the online parameters, named as in a policy's file: `layer.0.weight` (output x
    /// input) and so on.
    fn export(&self, _state: &mut State) -> Result<()> {
        Err(Error::Unsupported { what: "this actor has no Actor::export".to_owned() })
    }

    /// Restores what [`Actor::export`] wrote. The targets become equal to it, and the optimiser
    /// starts afresh.
    fn import(&mut self, _state: &State) -> Result<()> {
        Err(Error::Unsupported { what: "this actor has no Actor::import".to_owned() })
    }

    /// Writes parameters, targets and optimiser state.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(Error::cannot_be_saved("this actor", "Actor"))
    }

    /// Restores what [`Actor::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Err(Error::cannot_be_saved("this actor", "Actor"))
    }
}

fn deterministic(method: &str) -> Error {
    Error::Unsupported {
        what: format!("this policy is deterministic: it has Actor::mode and no Actor::{method}"),
    }
}
