//! A deterministic actor in the fast implementation.

use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::body::Body;
use super::passes::{room, tanh, tanh_backward};
use crate::check;

/// TD3's policy: observation -> hidden layers -> tanh. It needs no noise and has no
/// log-probability.
///
/// ```
/// use copq::{Actor, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::fused::Deterministic;
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks { hidden: vec![16, 16], actor_lr: 0.01, ..Networks::default() };
/// let mut actor = Deterministic::new(&spec, &networks, &mut Rng::new(0, Stream::Init))?;
///
/// // Train it to do 0.5 at this observation: the gradient of (a - 0.5)^2 / 2.
/// for _ in 0..300 {
///     actor.improve(&[0.1, 0.2], &[], &mut |sample, grad| {
///         grad.action[0] = sample.action[0] - 0.5;
///         Ok(())
///     })?;
/// }
/// let mut action = [0.0];
/// actor.mode(Net::Online, &[0.1, 0.2], &mut action)?;
/// assert!((action[0] - 0.5).abs() < 0.02);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Deterministic {
    policy: Body,
    output: Vec<f32>,
    grad: Vec<f32>,
}

impl Deterministic {
    /// An actor for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        let policy = Body::new(spec, networks, spec.action_len(), rng)?;
        Ok(Self { policy, output: Vec::new(), grad: Vec::new() })
    }

    /// Spreads large products over this many threads (1 unless set), except bf16 products with the
    /// processor's own instruction. The results are the same, bit for bit.
    pub fn threads(self, threads: usize) -> Result<Self> {
        Ok(Self { policy: self.policy.threads(threads)?, ..self })
    }
}

impl Actor for Deterministic {
    fn action_len(&self) -> usize {
        self.policy.action
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        check::batch("actions", action, rows, self.policy.action)?;
        self.policy.values(net, obs, rows, action);
        tanh(action);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        check::deterministic(noise)?;
        let len = rows * self.policy.action;
        let action = room(&mut self.output, len);
        let dl = room(&mut self.grad, len);
        self.policy.forward(obs, rows, action);
        tanh(action);
        grad(Sample { action, log_prob: None }, SampleGrad { action: dl, log_prob: None })?;
        tanh_backward(dl, action);
        self.policy.learn(dl);
        Ok(())
    }

    fn update_target(&mut self, tau: f32) -> Result<()> {
        self.policy.update_target(tau)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.policy.save(state)
    }

    fn export(&self, state: &mut State) -> Result<()> {
        self.policy.export(state)
    }

    fn import(&mut self, state: &State) -> Result<()> {
        self.policy.import(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.policy.load(state)
    }
}
