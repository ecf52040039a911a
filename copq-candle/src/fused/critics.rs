//! K critics in the fast implementation.

use copq::error::{check_chosen, check_count, check_len};
use copq::{Critic, EnvSpec, Net, Networks, Precision, QGrad, QView, Result, Rng, State};

use super::network::Network;
use super::panels::Panels;
use super::passes::room;
use super::workers::Workers;
use crate::check;
use crate::learned::{Learned, load_critics, save_critics};
use crate::shape::Shape;

/// For observations of fewer values, adding them up again is faster than storing and reading their
/// sums.
const WORTH_KEEPING: usize = 64;

/// An ensemble of separately initialised multilayer perceptrons (observation and action in, N
/// values out).
///
/// ```
/// use copq::{Critic, EnvSpec, Net, Networks, QView, Rng, Stream};
/// use copq_candle::fused::Critics;
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks { hidden: vec![16, 16], critic_lr: 0.01, ..Networks::default() };
/// let mut critics = Critics::new(&spec, 3, &networks, &mut Rng::new(0, Stream::Init))?;
///
/// // Fit all three to 5 at this observation and action: the gradient of (q - 5)^2 / 2.
/// for _ in 0..300 {
///     let towards_5 = &mut |q: QView<'_>, grad: &mut [f32]| {
///         grad.iter_mut().zip(q.values()).for_each(|(grad, q)| *grad = q - 5.0);
///         Ok(())
///     };
///     critics.fit(&[0.1, 0.2], &[0.5], towards_5, 1.0)?;
/// }
/// let mut q = [0.0; 3];
/// critics.values(Net::Target, &[0.1, 0.2], &[0.5], &mut q)?;
/// assert!(q.iter().all(|q| (q - 5.0).abs() < 0.1));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Critics {
    networks: Vec<Network>,
    observation: usize,
    action: usize,
    objectives: usize,
    lr: f64,
    /// Whether values are in bf16 between hidden layers.
    is_careful: bool,
    workers: Workers,
    input: Panels,
    /// The critics chosen in `values_of`.
    chosen: Vec<usize>,
    q: Vec<f32>,
    grad: Vec<f32>,
}

impl Critics {
    /// `critics` networks for an environment, with fresh weights drawn from `rng` one critic after
    /// another.
    pub fn new(spec: &EnvSpec, critics: usize, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        check::settings(spec, networks)?;
        check_count("critics", critics)?;
        let input = spec.obs_len + spec.action_len();
        let shape = Shape::new(input, &networks.hidden, spec.objectives.len());
        let fresh =
            |_| Network::new(shape.clone(), networks, &Learned::new(&shape, networks.init, rng));
        Ok(Self {
            networks: (0..critics).map(fresh).collect(),
            observation: spec.obs_len,
            action: spec.action_len(),
            objectives: spec.objectives.len(),
            lr: networks.critic_lr,
            is_careful: networks.precision == Precision::Careful && networks.hidden.len() > 1,
            workers: Workers::new(1)?,
            input: Panels::default(),
            chosen: Vec::new(),
            q: Vec::new(),
            grad: Vec::new(),
        })
    }

    /// Spreads the critics over this many threads (1 unless set). The results are the same, bit for
    /// bit.
    pub fn threads(mut self, threads: usize) -> Result<Self> {
        self.workers = Workers::new(threads)?;
        Ok(self)
    }

    fn shape(&self) -> &Shape {
        self.networks[0].shape() // There is at least one critic.
    }

    fn set_learned(&mut self, learned: impl Iterator<Item = Learned>) {
        for (network, learned) in self.networks.iter_mut().zip(learned) {
            network.set_learned(&learned);
        }
    }

    /// Checks a batch and takes its observations and actions, side by side, as the input. Returns
    /// the number of rows.
    fn gather(&mut self, obs: &[f32], act: &[f32]) -> Result<usize> {
        let rows = check::rows(obs, self.observation)?;
        check::batch("actions", act, rows, self.action)?;
        check::finite("actions", act, self.action)?;
        if self.observation >= WORTH_KEEPING && !self.input.begins_with(rows, obs) {
            self.networks.iter_mut().for_each(Network::forget);
        }
        self.input.set(rows, &[obs, act]);
        Ok(rows)
    }

    fn values_in(
        &mut self,
        in_half: bool,
        net: Net,
        obs: &[f32],
        act: &[f32],
        q: &mut [f32],
    ) -> Result<()> {
        let rows = self.gather(obs, act)?;
        check_len("critic values", q.len(), self.networks.len() * rows * self.objectives)?;
        let Self { networks, workers, input, observation, .. } = self;
        workers.each(networks, q, |_, network, q, workspace| {
            // The next call may have other actions at the same observations.
            if net == Net::Online && *observation >= WORTH_KEEPING {
                network.begin(input, *observation, workspace);
            }
            network.values(net, input, in_half, q, workspace);
        });
        Ok(())
    }

    /// Writes online values of the gathered batch to `self.q`, and the gradient that `grad` fills
    /// from them to `self.grad`.
    fn forward(&mut self, rows: usize, in_half: bool, grad: QGrad<'_>) -> Result<()> {
        let Self { networks, workers, input, .. } = self;
        let len = networks.len() * rows * self.objectives;
        let q = room(&mut self.q, len);
        let dq = room(&mut self.grad, len);
        workers.each(networks, q, |_, network, q, workspace| {
            network.forward(input, in_half, q, workspace);
        });
        grad(QView::new(q, networks.len(), self.objectives)?, dq)
    }
}

impl Critic for Critics {
    fn critics(&self) -> usize {
        self.networks.len()
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        self.values_in(self.is_careful, net, obs, act, q)
    }

    fn values_of(
        &mut self,
        net: Net,
        chosen: &[usize],
        obs: &[f32],
        act: &[f32],
        q: &mut [f32],
    ) -> Result<()> {
        let rows = self.gather(obs, act)?;
        check_chosen(chosen, self.networks.len())?;
        check_len("critic values", q.len(), chosen.len() * rows * self.objectives)?;
        let in_half = self.is_careful;
        let Self { networks, workers, input, chosen: own, .. } = self;
        own.clear();
        own.extend(chosen);
        workers.each(own, q, |_, &mut k, q, workspace| {
            networks[k].values(net, input, in_half, q, workspace);
        });
        Ok(())
    }

    fn exact_values(&mut self, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<bool> {
        if self.is_careful {
            self.values_in(false, Net::Online, obs, act, q)?;
        }
        Ok(self.is_careful)
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        check::tau(tau)?;
        let rows = self.gather(obs, act)?;
        self.forward(rows, self.is_careful, grad)?;
        let Self { networks, workers, input, lr, .. } = self;
        let dq = &mut self.grad[..networks.len() * rows * self.objectives];
        let lr = *lr;
        workers.each(networks, dq, |_, network, dq, workspace| {
            network.learn(input, dq, lr, tau, workspace);
        });
        Ok(())
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        let rows = self.gather(obs, act)?;
        check::batch("action gradients", out, rows, self.action)?;
        // A bound's derivative divides by the critics' deviations, which bf16 would blur.
        self.forward(rows, false, grad)?;
        let Self { networks, workers, observation, .. } = self;
        let share = rows * self.objectives;
        let dq = &self.grad[..networks.len() * share];
        // The values are no longer needed. Their buffer, enlarged if necessary, takes each critic's
        // share of the gradient.
        let parts = room(&mut self.q, networks.len() * out.len());
        workers.each(networks, parts, |k, network, part, workspace| {
            network.input_grad(
                rows,
                &dq[k * share..(k + 1) * share],
                *observation,
                part,
                workspace,
            );
        });
        sum_parts(parts, out);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        save_critics(self.networks.iter().map(Network::learned), &self.shape().arrays(), state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let learned = load_critics(self.networks.len(), &self.shape().arrays(), state)?;
        self.set_learned(learned.into_iter());
        Ok(())
    }
}

/// Adds up equally long parts, in order.
fn sum_parts(parts: &[f32], out: &mut [f32]) {
    out.fill(0.0);
    for part in parts.chunks_exact(out.len()) {
        out.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
    }
}

#[cfg(test)]
mod tests {
    use copq::Stream;

    use super::*;

    const ROWS: usize = 20;
    const OBSERVATION: usize = WORTH_KEEPING + 5;

    fn critics() -> Critics {
        let spec = EnvSpec::new("test", OBSERVATION, 6).reward("safety", 1.0).reward("speed", 1.0);
        let networks = Networks { hidden: vec![40, 24], ..Networks::default() };
        Critics::new(&spec, 3, &networks, &mut Rng::new(0, Stream::Init)).unwrap()
    }

    fn batch(seed: u64) -> (Vec<f32>, Vec<f32>) {
        let mut rng = Rng::with_stream(seed, 0);
        let mut draw = |len: usize| (0..len).map(|_| rng.normal() as f32).collect();
        (draw(ROWS * OBSERVATION), draw(ROWS * 6))
    }

    /// dL/da of the sum of all values, and the values.
    fn action_grad(critics: &mut Critics, obs: &[f32], act: &[f32]) -> [Vec<f32>; 2] {
        let mut values = Vec::new();
        let mut out = vec![0.0; act.len()];
        let sum = &mut |q: QView<'_>, grad: &mut [f32]| {
            values = q.values().to_vec();
            grad.fill(1.0);
            Ok(())
        };
        critics.action_grad(obs, act, sum, &mut out).unwrap();
        [out, values]
    }

    /// Sums that were begun for the same observations serve as long as they and the weights stay.
    #[test]
    fn what_was_begun_changes_no_bit() {
        let (obs, act) = batch(1);
        let (other, elsewhere) = batch(2);
        let plain = |critics: &Critics, obs: &[f32], act: &[f32]| {
            let mut state = State::default();
            critics.save(&mut state).unwrap();
            let mut fresh = self::critics();
            fresh.load(&state).unwrap();
            action_grad(&mut fresh, obs, act)
        };
        let mut critics = critics();
        let mut q = vec![0.0; 3 * ROWS * 2];
        let begin = |critics: &mut Critics, q: &mut [f32]| {
            critics.values(Net::Online, &obs, &act, q).unwrap();
        };
        begin(&mut critics, &mut q);
        assert_eq!(action_grad(&mut critics, &obs, &act)[1], q);
        for (obs, act) in [(&obs, &elsewhere), (&other, &act), (&obs, &act)] {
            assert_eq!(action_grad(&mut critics, obs, act), plain(&critics, obs, act));
        }
        begin(&mut critics, &mut q);
        let step = &mut |q: QView<'_>, grad: &mut [f32]| {
            grad.copy_from_slice(q.values());
            Ok(())
        };
        critics.fit(&obs, &act, step, 0.5).unwrap();
        assert_eq!(action_grad(&mut critics, &obs, &act), plain(&critics, &obs, &act));
        begin(&mut critics, &mut q);
        let mut state = State::default();
        self::critics().save(&mut state).unwrap();
        critics.load(&state).unwrap();
        assert_eq!(action_grad(&mut critics, &obs, &act), plain(&self::critics(), &obs, &act));
    }
}
