//! A squashed Gaussian actor in the fast implementation.

use copq::{ActionGrad, Actor, EnvSpec, Net, Networks, Result, Rng, Sample, SampleGrad, State};

use super::body::Body;
use super::passes::room;
use crate::check;
use crate::squash::Component;

/// SAC's policy: observation -> hidden layers -> mean and log std, clamped to [-20, 2], of a
/// Gaussian squashed by tanh. It needs one standard normal per action component. Without noise, its
/// action is the squashed mean.
///
/// ```
/// use copq::{Actor, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::fused::Gaussian;
///
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let networks = Networks::default();
/// let mut actor = Gaussian::new(&spec, &networks, &mut Rng::new(0, Stream::Init))?;
///
/// let mut mode = [0.0];
/// actor.mode(Net::Online, &[0.1, 0.2], &mut mode)?;
/// let mut sample = [0.0];
/// let mut log_prob = [0.0];
/// actor.sample(Net::Online, &[0.1, 0.2], &[1.5], &mut sample, &mut log_prob)?;
/// assert!(mode[0] < sample[0] && sample[0] < 1.0); // 1.5 standard deviations above
/// assert!(log_prob[0].is_finite());
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Gaussian {
    policy: Body,
    /// Means and log stds, `rows x (2 action)`, and their gradients.
    output: Vec<f32>,
    grad: Vec<f32>,
    sample: Vec<f32>,
    log_prob: Vec<f32>,
    grad_action: Vec<f32>,
    grad_log_prob: Vec<f32>,
}

impl Gaussian {
    /// An actor for an environment, with fresh weights drawn from `rng`.
    pub fn new(spec: &EnvSpec, networks: &Networks, rng: &mut Rng) -> Result<Self> {
        Ok(Self {
            policy: Body::new(spec, networks, 2 * spec.action_len(), rng)?,
            output: Vec::new(),
            grad: Vec::new(),
            sample: Vec::new(),
            log_prob: Vec::new(),
            grad_action: Vec::new(),
            grad_log_prob: Vec::new(),
        })
    }

    /// Spreads large products over this many threads (1 unless set), except bf16 products with the
    /// processor's own instruction. The results are the same, bit for bit.
    pub fn threads(self, threads: usize) -> Result<Self> {
        Ok(Self { policy: self.policy.threads(threads)?, ..self })
    }

    /// Writes means and log stds of a batch to `self.output`.
    fn values(&mut self, net: Net, obs: &[f32], rows: usize) {
        self.policy.values(net, obs, rows, room(&mut self.output, rows * 2 * self.policy.action));
    }
}

/// The component at a position of a `rows x action` array.
fn component(output: &[f32], action: usize, at: usize, noise: f32) -> Component {
    let mean = at / action * 2 * action + at % action;
    Component::new(output[mean], output[mean + action], noise)
}

/// Writes actions and log-probabilities for outputs and noise.
fn squash(output: &[f32], noise: &[f32], action: &mut [f32], log_prob: &mut [f32]) {
    let width = action.len() / log_prob.len();
    for (row, (action, log_prob)) in action.chunks_exact_mut(width).zip(log_prob).enumerate() {
        let mut sum = 0.0;
        for (j, action) in action.iter_mut().enumerate() {
            let at = row * width + j;
            let sample = component(output, width, at, noise[at]);
            *action = sample.action;
            sum += sample.log_prob();
        }
        *log_prob = sum as f32;
    }
}

impl Actor for Gaussian {
    fn action_len(&self) -> usize {
        self.policy.action
    }

    fn noise_len(&self) -> usize {
        self.policy.action
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        check::batch("actions", action, rows, self.policy.action)?;
        self.values(net, obs, rows);
        for (at, action) in action.iter_mut().enumerate() {
            *action = component(&self.output, self.policy.action, at, 0.0).action;
        }
        Ok(())
    }

    fn sample(
        &mut self,
        net: Net,
        obs: &[f32],
        noise: &[f32],
        action: &mut [f32],
        log_prob: &mut [f32],
    ) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        check::sample(noise, action, log_prob, rows, self.policy.action)?;
        self.values(net, obs, rows);
        squash(&self.output, noise, action, log_prob);
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        check::batch("noise", noise, rows, self.policy.action)?;
        self.policy.forward(obs, rows, room(&mut self.output, rows * 2 * self.policy.action));
        let action = room(&mut self.sample, noise.len());
        let log_prob = room(&mut self.log_prob, rows);
        squash(&self.output, noise, action, log_prob);
        let grad_action = room(&mut self.grad_action, noise.len());
        let grad_log_prob = room(&mut self.grad_log_prob, rows);
        grad(
            Sample { action, log_prob: Some(log_prob) },
            SampleGrad { action: grad_action, log_prob: Some(grad_log_prob) },
        )?;
        let out = room(&mut self.grad, rows * 2 * self.policy.action);
        for (at, &noise) in noise.iter().enumerate() {
            let (row, mean) = (
                at / self.policy.action,
                at / self.policy.action * 2 * self.policy.action + at % self.policy.action,
            );
            let sample = component(&self.output, self.policy.action, at, noise);
            (out[mean], out[mean + self.policy.action]) =
                sample.backward(grad_action[at], grad_log_prob[row]);
        }
        self.policy.learn(out);
        Ok(())
    }

    fn noise_grad(
        &mut self,
        obs: &[f32],
        noise: &[f32],
        grad_action: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let rows = self.policy.rows(obs)?;
        for (what, values) in
            [("noise", noise), ("action gradients", grad_action), ("noise gradients", &*out)]
        {
            check::batch(what, values, rows, self.policy.action)?;
        }
        self.values(Net::Online, obs, rows);
        for (at, (out, grad)) in out.iter_mut().zip(grad_action).enumerate() {
            *out = grad * component(&self.output, self.policy.action, at, noise[at]).noise_slope();
        }
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
