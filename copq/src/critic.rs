//! The interface of critics: an ensemble of vector-valued Q-networks, used through slices and
//! vector-Jacobian products.

use crate::error::{check_chosen, check_len};
use crate::{Error, QView, Result, State};

/// Which copy of a network.
///
/// ```
/// use copq::{Actor, Net, Result};
///
/// /// How far a policy has moved from its slow copy, at one observation.
/// fn lead(actor: &mut dyn Actor, obs: &[f32]) -> Result<f32> {
///     let mut online = vec![0.0; actor.action_len()];
///     let mut target = online.clone();
///     actor.mode(Net::Online, obs, &mut online)?;
///     actor.mode(Net::Target, obs, &mut target)?;
///     Ok(online.iter().zip(&target).map(|(online, target)| (online - target).abs()).sum())
/// }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # assert_eq!(lead(&mut still::Still, &[0.1])?, 0.0);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Net {
    /// The one that is trained.
    Online,
    /// Its slow copy, for targets.
    Target,
}

/// Given the critics' values, fills dL/dq (the same layout, critic x row x objective).
pub type QGrad<'a> = &'a mut dyn FnMut(QView<'_>, &mut [f32]) -> Result<()>;

/// K critics that each map (observation, action) to N values.
///
/// Batches are row-major: observations `rows x observation`, actions `rows x action` in [-1, 1],
/// values `critics x rows x objectives`. The number of rows is free, and may change from call to
/// call.
///
/// ```
/// use copq::{Critic, Net, QGrad, QView, Result};
///
/// /// Two critics of one objective: Q(s, a) = w a, for an action of one number.
/// struct Linear {
///     online: [f32; 2],
///     target: [f32; 2],
/// }
///
/// impl Critic for Linear {
///     fn critics(&self) -> usize { 2 }
///     fn objectives(&self) -> usize { 1 }
///
///     fn values(&mut self, net: Net, _obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
///         let weights = if net == Net::Online { self.online } else { self.target };
///         for (q, w) in q.chunks_exact_mut(act.len()).zip(weights) {
///             q.iter_mut().zip(act).for_each(|(q, a)| *q = w * a);
///         }
///         Ok(())
///     }
///
///     fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
///         let mut q = vec![0.0; 2 * act.len()];
///         let mut grad_q = q.clone();
///         self.values(Net::Online, obs, act, &mut q)?;
///         grad(QView::new(&q, 2, 1)?, &mut grad_q)?;
///         for (k, grad_q) in grad_q.chunks_exact(act.len()).enumerate() {
///             let grad_w: f32 = grad_q.iter().zip(act).map(|(dq, a)| dq * a).sum();
///             self.online[k] -= 0.5 * grad_w;
///             self.target[k] += tau * (self.online[k] - self.target[k]);
///         }
///         Ok(())
///     }
/// #     fn action_grad(
/// #         &mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: &mut [f32],
/// #     ) -> Result<()> { Ok(()) }
///
///     // action_grad is left out here; a run that is to be saved also needs save and load.
/// }
///
/// // A step towards Q = 2, down the gradient q - 2; the targets follow at once.
/// let mut critic = Linear { online: [1.0, 4.0], target: [1.0, 4.0] };
/// let towards_2 = &mut |q: QView<'_>, grad: &mut [f32]| {
///     grad.iter_mut().zip(q.values()).for_each(|(grad, q)| *grad = q - 2.0);
///     Ok(())
/// };
/// critic.fit(&[0.0], &[1.0], towards_2, 1.0)?;
///
/// let mut q = [0.0; 2];
/// critic.values(Net::Target, &[0.0], &[1.0], &mut q)?;
/// assert_eq!(q, [1.5, 3.0]);
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Critic: Send {
    /// K, the number of critics.
    fn critics(&self) -> usize;

    /// N, the number of objectives.
    fn objectives(&self) -> usize;

    /// Whether the objectives share networks, so that their losses compete for the same weights.
    fn shared(&self) -> bool {
        true
    }

    /// Writes Q(s, a) of every critic into `q`.
    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()>;

    /// Writes Q(s, a) of the `chosen` critics, each at most once, into `q`
    /// (`chosen x rows x objectives`, in that order).
    ///
    /// The default evaluates all critics and copies. Override it to avoid evaluating the others,
    /// which are four fifths of the work in REDQ.
    fn values_of(
        &mut self,
        net: Net,
        chosen: &[usize],
        obs: &[f32],
        act: &[f32],
        q: &mut [f32],
    ) -> Result<()> {
        values_by_copy(self, net, chosen, obs, act, q)
    }

    /// One optimiser step of the online critics: forward, `grad` fills dL/dq, backward, step. Then
    /// the targets follow by Polyak averaging, target <- (1 - tau) target + tau online. Both happen
    /// in the same call, so that they can be one pass.
    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()>;

    /// dL/da at the online critics, which stay as they are: forward, `grad` fills dL/dq, backward
    /// to the actions.
    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()>;

    /// Writes the online values in f32 if [`Critic::values`] has fewer bits
    /// ([`Precision`](crate::Precision)). Otherwise returns false and writes nothing.
    fn exact_values(&mut self, _obs: &[f32], _act: &[f32], _q: &mut [f32]) -> Result<bool> {
        Ok(false)
    }

    /// Writes parameters, targets and optimiser state.
    fn save(&self, _state: &mut State) -> Result<()> {
        Err(Error::cannot_be_saved("this critic", "Critic"))
    }

    /// Restores what [`Critic::save`] wrote.
    fn load(&mut self, _state: &State) -> Result<()> {
        Err(Error::cannot_be_saved("this critic", "Critic"))
    }
}

/// [`Critic::values_of`] by way of [`Critic::values`].
pub(crate) fn values_by_copy<C: Critic + ?Sized>(
    critic: &mut C,
    net: Net,
    chosen: &[usize],
    obs: &[f32],
    act: &[f32],
    q: &mut [f32],
) -> Result<()> {
    check_chosen(chosen, critic.critics())?;
    let share = q.len() / chosen.len();
    check_len("critic values", q.len(), share * chosen.len())?;
    let mut all = vec![0.0; share * critic.critics()];
    critic.values(net, obs, act, &mut all)?;
    for (q, &k) in q.chunks_exact_mut(share).zip(chosen) {
        q.copy_from_slice(&all[k * share..(k + 1) * share]);
    }
    Ok(())
}
