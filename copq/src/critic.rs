//! The critics' seam: an ensemble of vector-valued Q-networks, spoken to in slices and
//! vector-Jacobian products.

use crate::error::{check_chosen, check_len};
use crate::{QView, Result, State};

/// Which copy of a network.
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
    /// The default evaluates all critics and copies; override it to save the others' work, four
    /// fifths of it in REDQ.
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
    /// the targets follow by Polyak averaging, target <- (1 - tau) target + tau online: in the same
    /// call, so that both can be one pass.
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

    /// Writes parameters, targets and optimiser state.
    fn save(&self, state: &mut State) -> Result<()>;

    /// Restores what [`Critic::save`] wrote.
    fn load(&mut self, state: &State) -> Result<()>;
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
