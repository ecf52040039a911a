//! Scalar critics, as many as each objective needs, behind the interface of one vector-valued
//! ensemble.

use crate::critic::values_by_copy;
use crate::error::check_len;
use crate::{Critic, Error, Net, QGrad, QView, Result, State};

/// Separate scalar networks for every objective: 2 for the reward and 4 for the cost (CAL), or a
/// pair each (independent double-Q, "N pairs of critics").
///
/// To projections and losses, it is an ensemble of K critics of N values. K is the least common
/// multiple of the counts: an objective with fewer networks shows each of them equally often. This
/// changes no mean, no smallest value and no standard deviation (over K), and the gradients of a
/// network's copies add up. Covariances between objectives mean nothing here, so a method whose
/// bound reads them (Cholesky, Eigen, Extremum) is refused.
///
/// With unequal counts, a drawn subset (REDQ) could hold one network twice, so it is refused.
///
/// Separate critics learn best without FAMO, which is off here unless
/// [`FamoConfig::separate`](crate::FamoConfig::separate) is set. Adam undoes the scale of a loss,
/// so weights of losses that share no network balance nothing. Under a decoupled decay they drift,
/// until an objective's gradients are as small as Adam's epsilon and its networks hardly move.
///
/// [`Ensemble::Separate`](crate::Ensemble::Separate) makes one:
///
/// ```
/// # use copq::{QGrad, Result, State};
/// # struct Scalars;
/// # impl Critic for Scalars {
/// #     fn critics(&self) -> usize { 3 }
/// #     fn objectives(&self) -> usize { 1 }
/// #     fn values(&mut self, _: Net, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
/// #         q.copy_from_slice(&[1.0, 2.0, 3.0]); Ok(())
/// #     }
/// #     fn fit(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: f32) -> Result<()> { Ok(()) }
/// #     fn action_grad(
/// #         &mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: &mut [f32],
/// #     ) -> Result<()> { Ok(()) }
/// #     fn save(&self, _: &mut State) -> Result<()> { Ok(()) }
/// #     fn load(&mut self, _: &State) -> Result<()> { Ok(()) }
/// # }
/// # let networks = Box::new(Scalars);
/// use copq::{Critic, Net, SeparateCritics};
///
/// // Three networks that say 1, 2 and 3: one for a cost, two for a reward.
/// let mut critics = SeparateCritics::new(networks, &[1, 2])?;
/// let mut q = [0.0; 4]; // 2 critics of 2 objectives
/// critics.values(Net::Online, &[0.0], &[0.0], &mut q)?;
/// assert_eq!(q, [1.0, 2.0, 1.0, 3.0]);
/// # Ok::<(), copq::Error>(())
/// ```
pub struct SeparateCritics {
    networks: Box<dyn Critic>,
    /// The number of networks of each objective. The networks lie one objective after another.
    counts: Vec<usize>,
    critics: usize,
    /// Values and gradients, `networks x rows` and `critics x rows x objectives`.
    values: Vec<f32>,
    q: Vec<f32>,
    grad: Vec<f32>,
}

impl std::fmt::Debug for SeparateCritics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SeparateCritics").field("counts", &self.counts).finish_non_exhaustive()
    }
}

impl SeparateCritics {
    /// `counts[i]` of the scalar critics in `networks` for objective i, in order.
    pub fn new(networks: Box<dyn Critic>, counts: &[usize]) -> Result<Self> {
        if counts.is_empty() || counts.contains(&0) {
            return Err(Error::invalid(
                "critics of each objective",
                "at least 1",
                format!("{counts:?}"),
            ));
        }
        check_len("a separate critic's objectives", networks.objectives(), 1)?;
        let wanted = counts.iter().sum::<usize>();
        if networks.critics() != wanted {
            return Err(Error::invalid(
                "scalar critics",
                format!("{wanted} for {counts:?}"),
                networks.critics(),
            ));
        }
        let critics = counts.iter().copied().fold(1, least_common_multiple);
        let (values, q, grad) = Default::default();
        Ok(Self { networks, counts: counts.to_vec(), critics, values, q, grad })
    }

    /// Makes room for the scalar critics' values that become `len` values of the ensemble.
    fn make_room(&mut self, len: usize) -> Result<()> {
        let share = self.critics * self.counts.len();
        if !len.is_multiple_of(share) {
            return Err(Error::invalid("critic values", format!("a multiple of {share}"), len));
        }
        self.values.resize(len / share * self.networks.critics(), 0.0);
        Ok(())
    }

    /// Runs `call` on the scalar critics, with `grad` translated to what they see.
    fn through(
        &mut self,
        grad: QGrad<'_>,
        call: impl FnOnce(&mut dyn Critic, QGrad<'_>) -> Result<()>,
    ) -> Result<()> {
        let Self { networks, counts, critics, q, grad: grad_q, .. } = self;
        let counts = counts.as_slice();
        let critics = *critics;
        let n = counts.len();
        call(networks.as_mut(), &mut |scalar, grad_scalar| {
            let len = critics * scalar.rows() * n;
            q.resize(len, 0.0);
            grad_q.resize(len, 0.0);
            copy_to_critics(counts, scalar.values(), q);
            grad(QView::new(q, critics, n)?, grad_q)?;
            gather(counts, grad_q, grad_scalar);
            Ok(())
        })
    }
}

impl Critic for SeparateCritics {
    fn critics(&self) -> usize {
        self.critics
    }

    fn objectives(&self) -> usize {
        self.counts.len()
    }

    fn shared(&self) -> bool {
        false
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        self.make_room(q.len())?;
        self.networks.values(net, obs, act, &mut self.values)?;
        copy_to_critics(&self.counts, &self.values, q);
        Ok(())
    }

    fn exact_values(&mut self, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<bool> {
        self.make_room(q.len())?;
        let are_others = self.networks.exact_values(obs, act, &mut self.values)?;
        if are_others {
            copy_to_critics(&self.counts, &self.values, q);
        }
        Ok(are_others)
    }

    fn values_of(
        &mut self,
        net: Net,
        chosen: &[usize],
        obs: &[f32],
        act: &[f32],
        q: &mut [f32],
    ) -> Result<()> {
        if chosen.len() < self.critics {
            equal_counts(&self.counts)?;
        }
        values_by_copy(self, net, chosen, obs, act, q)
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        self.through(grad, |networks, grad| networks.fit(obs, act, grad, tau))
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        self.through(grad, |networks, grad| networks.action_grad(obs, act, grad, out))
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.networks.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.networks.load(state)
    }
}

/// An error if objectives have different numbers of critics: a drawn subset (REDQ) could then hold
/// one network twice.
pub(crate) fn equal_counts(counts: &[usize]) -> Result<()> {
    if counts.windows(2).any(|pair| pair[0] != pair[1]) {
        let wanted = "the same number of separate critics for every objective";
        return Err(Error::invalid("a subset of the critics", wanted, format!("{counts:?}")));
    }
    Ok(())
}

/// Calls `pair` with every (position in `critics x rows x objectives`, position in
/// `networks x rows`) that belong together.
fn pairs(counts: &[usize], len: usize, mut pair: impl FnMut(usize, usize)) {
    let n = counts.len();
    let rows = len / n / counts.iter().copied().fold(1, least_common_multiple);
    let mut first = 0;
    for (i, &count) in counts.iter().enumerate() {
        for position in 0..len / n {
            let critic = position / rows;
            let row = position % rows;
            pair(position * n + i, (first + critic % count) * rows + row);
        }
        first += count;
    }
}

fn copy_to_critics(counts: &[usize], values: &[f32], q: &mut [f32]) {
    pairs(counts, q.len(), |at, from| q[at] = values[from]);
}

fn gather(counts: &[usize], grad_q: &[f32], grad: &mut [f32]) {
    grad.fill(0.0);
    pairs(counts, grad_q.len(), |at, to| grad[to] += grad_q[at]);
}

fn least_common_multiple(a: usize, b: usize) -> usize {
    let mut x = a;
    let mut y = b;
    while y > 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
