//! The networks of on-policy learning: an unsquashed Gaussian, and critics of observations alone.

use crate::{Actor, Error, Result, State};

/// One step of Adam down the gradient of `L + decay sum(p^2)`, whose norm is clipped to `max_norm`.
///
/// ```
/// use copq::on_policy::Descent;
///
/// let critic = Descent { lr: 3e-4, decay: 0.001, max_norm: 40.0 };
/// assert_eq!(Descent { decay: 0.0, ..critic }.lr, 3e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// Adam's step size.
    pub lr: f64,
    /// c of the penalty c sum(p^2) over all of the network's parameters, including biases.
    pub decay: f64,
    /// The largest norm of the network's whole gradient, penalty included.
    pub max_norm: f64,
}

/// A policy's Gaussians for a batch, as passed to the function that fills their gradient.
#[derive(Clone, Copy, Debug)]
pub struct Normal<'a> {
    /// Means, `rows x action`.
    pub mean: &'a [f32],
    /// log of the deviations, one per action component, the same for all rows.
    pub log_std: &'a [f32],
}

/// dL/dmean (`rows x action`) and dL/dlog_std (`action`), to be filled.
#[derive(Debug)]
pub struct NormalGradient<'a> {
    /// dL/dmean.
    pub mean: &'a mut [f32],
    /// dL/dlog_std.
    pub log_std: &'a mut [f32],
}

/// Given a policy's Gaussians, fills their gradient.
pub type NormalGrad<'a> = &'a mut dyn FnMut(Normal<'_>, NormalGradient<'_>) -> Result<()>;

/// Given a critic's values, fills their gradient.
pub type ValueGrad<'a> = &'a mut dyn FnMut(&[f32], &mut [f32]) -> Result<()>;

/// A policy whose actions are Gaussian: a network gives their means, and their deviations are
/// separate parameters. Actions are not squashed; the caller clamps them to [-1, 1].
///
/// Its [`Actor::mode`] is the mean, clamped. [`Actor::improve`] is for off-policy learning and may
/// return an error. Networks that only learn by clipped steps may leave out what the natural
/// gradient needs ([`GaussianPolicy::gradient`] and the methods after it).
///
/// ```
/// use copq::on_policy::{
///     Config, Descent, GaussianPolicy, Normal, NormalGrad, NormalGradient, Rows, StateValue, ValueGrad,
///     update,
/// };
/// use copq::{ActionGrad, Actor, Error, Net, Result};
///
/// /// One mean for all observations, and a fixed deviation of 1.
/// struct Everywhere(f32);
///
/// impl Actor for Everywhere {
///     fn action_len(&self) -> usize {
///         1
///     }
///     fn mode(&mut self, _: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
///         self.means(obs, action)?;
///         action.iter_mut().for_each(|action| *action = action.clamp(-1.0, 1.0));
///         Ok(())
///     }
///     fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
///         Err(Error::Unsupported { what: "off-policy learning".to_owned() })
///     }
///     fn update_target(&mut self, _: f32) -> Result<()> {
///         Ok(())
///     }
/// }
///
/// impl GaussianPolicy for Everywhere {
///     fn log_std(&self) -> &[f32] {
///         &[0.0]
///     }
///     fn means(&mut self, _: &[f32], mean: &mut [f32]) -> Result<()> {
///         mean.fill(self.0);
///         Ok(())
///     }
///     fn descend(&mut self, obs: &[f32], step: Descent, grad: NormalGrad<'_>) -> Result<()> {
///         let mean = vec![self.0; obs.len()];
///         let mut gradient = vec![0.0; obs.len()];
///         let of = NormalGradient { mean: &mut gradient, log_std: &mut [0.0] };
///         grad(Normal { mean: &mean, log_std: &[0.0] }, of)?;
///         self.0 -= step.lr as f32 * gradient.iter().sum::<f32>();
///         Ok(())
///     }
/// }
///
/// # struct Nothing;
/// # impl StateValue for Nothing {
/// #     fn values(&mut self, _: &[f32], value: &mut [f32]) -> Result<()> {
/// #         value.fill(0.0);
/// #         Ok(())
/// #     }
/// #     fn descend(&mut self, _: &[f32], _: Descent, _: ValueGrad<'_>) -> Result<()> {
/// #         Ok(())
/// #     }
/// # }
/// // Of two steps, the one to the right was better than expected and the other worse.
/// let rows = Rows {
///     obs: vec![0.0; 2],
///     action: vec![0.5, -0.5],
///     log_prob: vec![-1.04; 2], // of N(0, 1) there
///     advantages: vec![vec![1.0, -1.0]],
///     targets: vec![vec![0.0; 2]],
/// };
/// let mut policy = Everywhere(0.0);
/// let critics: &mut [Box<dyn StateValue>] = &mut [Box::new(Nothing)];
/// update(&Config::default(), &rows, &[], 0.1, &mut policy, critics, &mut |_| {})?;
/// assert!(policy.0 > 0.05);
/// # Ok::<(), Error>(())
/// ```
pub trait GaussianPolicy: Actor {
    /// log of the deviations, one per action component.
    fn log_std(&self) -> &[f32];

    /// Writes the means for a batch of observations, `rows x action`.
    fn means(&mut self, obs: &[f32], mean: &mut [f32]) -> Result<()>;

    /// One optimiser step that lowers L: forward, `grad` fills dL/dmean and dL/dlog_std, backward,
    /// step.
    fn descend(&mut self, obs: &[f32], step: Descent, grad: NormalGrad<'_>) -> Result<()>;

    /// The number of parameters, including the deviations, which come last.
    fn parameters(&self) -> usize {
        0
    }

    /// Writes dL/dparameters, [`GaussianPolicy::parameters`] numbers; an error if the policy does
    /// not support it.
    fn gradient(&mut self, _obs: &[f32], _grad: NormalGrad<'_>, _out: &mut [f32]) -> Result<()> {
        Err(missing("gradient"))
    }

    /// Writes how the means move (`rows x action`) as the parameters move along `direction`: the
    /// product of the means' Jacobian with it.
    fn push_forward(&mut self, _obs: &[f32], _direction: &[f32], _out: &mut [f32]) -> Result<()> {
        Err(missing("push_forward"))
    }

    /// Adds `step` to the parameters.
    fn shift(&mut self, _step: &[f32]) -> Result<()> {
        Err(missing("shift"))
    }
}

fn missing(method: &str) -> Error {
    let what =
        format!("natural gradients need GaussianPolicy::{method}, which this policy does not have");
    Error::Unsupported { what }
}

/// A critic of observations: one number for each, the value of following the policy from there.
///
/// ```
/// use copq::on_policy::{Descent, StateValue, ValueGrad};
/// use copq::Result;
///
/// /// The same value everywhere.
/// struct Constant(f32);
///
/// impl StateValue for Constant {
///     fn values(&mut self, _: &[f32], value: &mut [f32]) -> Result<()> {
///         value.fill(self.0);
///         Ok(())
///     }
///
///     fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()> {
///         let value = vec![self.0; obs.len()];
///         let mut gradient = value.clone();
///         grad(&value, &mut gradient)?;
///         self.0 -= step.lr as f32 * gradient.iter().sum::<f32>();
///         Ok(())
///     }
/// }
///
/// // Two observations of one number each: one step down the gradient of (V - 3)^2 / 2 of both.
/// let mut critic = Constant(1.0);
/// let step = Descent { lr: 0.25, decay: 0.0, max_norm: f64::INFINITY };
/// critic.descend(&[0.1, 0.2], step, &mut |value, grad| {
///     grad.iter_mut().zip(value).for_each(|(grad, v)| *grad = v - 3.0);
///     Ok(())
/// })?;
/// assert_eq!(critic.0, 2.0);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait StateValue: Send {
    /// Writes the values of a batch of observations (`rows x observation`), one number per row.
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()>;

    /// One optimiser step that lowers L: forward, `grad` fills dL/dvalue, backward, step.
    fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()>;

    /// Writes parameters and optimiser state.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(Error::cannot_be_saved("this critic", "StateValue"))
    }

    /// Restores what [`StateValue::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Err(Error::cannot_be_saved("this critic", "StateValue"))
    }
}
