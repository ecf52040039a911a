//! What the tests share: small settings, repeatable numbers, both implementations of every network,
//! comparisons.

pub mod reference;

use approx::abs_diff_eq;
use copq::{
    Activation, Actor, Critic, EnvSpec, Networks, QView, Result, Rng, Sample, SampleGrad, State,
    Stream,
};
use copq_candle::{Device, fused, plain};

/// Sizes of a test.
#[derive(Clone, Debug)]
pub struct Case {
    pub observation: usize,
    pub action: usize,
    pub objectives: usize,
    pub critics: usize,
    pub hidden: Vec<usize>,
    pub rows: usize,
    pub activation: Activation,
}

impl Case {
    pub fn new(critics: usize, objectives: usize, hidden: &[usize], rows: usize) -> Self {
        Self {
            observation: 6,
            action: 2,
            objectives,
            critics,
            hidden: hidden.to_vec(),
            rows,
            activation: Activation::Relu,
        }
    }

    /// Odd sizes: every batch, depth and count that a kernel's edges might get wrong.
    pub fn all() -> Vec<Self> {
        let mut cases = Vec::new();
        for (i, rows) in [1, 3, 257].into_iter().enumerate() {
            for (j, hidden) in [&[5][..], &[7, 9, 4], &[33, 64]].into_iter().enumerate() {
                cases.push(Self::new(1 + (i + 2 * j) % 5, 1 + (2 * i + j) % 4, hidden, rows));
            }
        }
        cases.push(Self { observation: 1, action: 1, ..Self::new(5, 4, &[1], 3) });
        for activation in [Activation::Tanh, Activation::Silu] {
            cases.push(Self { activation, ..Self::new(2, 3, &[33, 64], 37) });
            cases.push(Self { activation, ..Self::new(3, 1, &[7, 9, 4], 3) });
        }
        // More outputs than lanes, as a humanoid's policy has.
        cases.push(Self { action: 17, ..Self::new(2, 18, &[33, 64], 37) });
        cases
    }

    pub fn spec(&self) -> EnvSpec {
        let spec = EnvSpec::new("test", self.observation, self.action);
        (0..self.objectives).fold(spec, |spec, i| spec.reward(format!("objective {i}"), 1.0))
    }

    pub fn networks(&self) -> Networks {
        Networks {
            hidden: self.hidden.clone(),
            critic_lr: 1e-3,
            actor_lr: 2e-3,
            activation: self.activation,
            ..Networks::default()
        }
    }

    pub fn obs(&self, seed: u64) -> Vec<f32> {
        normals(seed, self.rows * self.observation)
    }

    pub fn act(&self, seed: u64) -> Vec<f32> {
        normals(seed + 1000, self.rows * self.action).iter().map(|x| x.tanh()).collect()
    }

    pub fn q_len(&self) -> usize {
        self.critics * self.rows * self.objectives
    }

    /// The critics of both implementations, fused first, from the same seed.
    pub fn critics(&self, seed: u64) -> [Box<dyn Critic>; 2] {
        let spec = self.spec();
        let networks = self.networks();
        let fused = fused::Critics::new(&spec, self.critics, &networks, &mut init(seed)).unwrap();
        let plain =
            plain::Critics::new(&spec, self.critics, &networks, &mut init(seed), &Device::Cpu)
                .unwrap();
        [Box::new(fused), Box::new(plain)]
    }

    /// The actors of both implementations, fused first, from the same seed.
    pub fn actors(&self, seed: u64) -> [Box<dyn Actor>; 2] {
        let spec = self.spec();
        let networks = self.networks();
        let fused = fused::Deterministic::new(&spec, &networks, &mut init(seed)).unwrap();
        let plain =
            plain::Deterministic::new(&spec, &networks, &mut init(seed), &Device::Cpu).unwrap();
        [Box::new(fused), Box::new(plain)]
    }

    /// The squashed Gaussian actors of both implementations, fused first, from the same seed.
    pub fn gaussians(&self, seed: u64) -> [Box<dyn Actor>; 2] {
        let spec = self.spec();
        let networks = self.networks();
        let fused = fused::Gaussian::new(&spec, &networks, &mut init(seed)).unwrap();
        let plain = plain::Gaussian::new(&spec, &networks, &mut init(seed), &Device::Cpu).unwrap();
        [Box::new(fused), Box::new(plain)]
    }

    pub fn noise(&self, seed: u64) -> Vec<f32> {
        normals(seed + 2000, self.rows * self.action)
    }
}

pub fn init(seed: u64) -> Rng {
    Rng::new(seed, Stream::Init)
}

/// Repeatable standard normals.
pub fn normals(seed: u64, len: usize) -> Vec<f32> {
    let mut out = vec![0.0; len];
    Rng::new(seed, Stream::Batch).fill_normal(&mut out);
    out
}

/// Asserts that two arrays differ by at most `tolerance` of the second one's largest entry.
pub fn assert_close(what: &str, got: &[f32], wanted: &[f32], tolerance: f32) {
    assert_eq!(got.len(), wanted.len(), "{what}");
    let scale = wanted.iter().fold(0.0f32, |max, x| max.max(x.abs()));
    for (i, (g, w)) in got.iter().zip(wanted).enumerate() {
        assert!(
            abs_diff_eq!(g, w, epsilon = tolerance * scale + 1e-12),
            "{what}[{i}]: {g} is not {w} (scale {scale})"
        );
    }
}

pub fn saved(part: &(impl Saved + ?Sized)) -> State {
    part.saved()
}

/// Critics and actors write the same kind of state.
pub trait Saved {
    fn saved(&self) -> State;
}

impl Saved for dyn Critic + '_ {
    fn saved(&self) -> State {
        let mut state = State::default();
        self.save(&mut state).unwrap();
        state
    }
}

impl Saved for dyn Actor + '_ {
    fn saved(&self) -> State {
        let mut state = State::default();
        self.save(&mut state).unwrap();
        state
    }
}

/// A gradient that does not look at the values.
pub fn given(dq: &[f32]) -> impl FnMut(QView<'_>, &mut [f32]) -> Result<()> + '_ {
    |_, grad| {
        grad.copy_from_slice(dq);
        Ok(())
    }
}

/// A gradient that does not look at the actions.
pub fn given_action(da: &[f32]) -> impl FnMut(Sample<'_>, SampleGrad<'_>) -> Result<()> + '_ {
    |_, grad| {
        grad.action.copy_from_slice(da);
        Ok(())
    }
}

/// One squared-error step of critics towards `target` (`rows x objectives`), a tenth of which their
/// targets follow; the loss before it.
pub fn fit(critic: &mut dyn Critic, obs: &[f32], act: &[f32], target: &[f32]) -> f32 {
    let mut loss = 0.0;
    let grad = &mut |q: QView<'_>, grad: &mut [f32]| {
        let scale = 2.0 / (q.critics() * q.rows()) as f32;
        let targets = target.iter().cycle();
        for ((g, q), y) in grad.iter_mut().zip(q.values()).zip(targets) {
            *g = scale * (q - y);
            loss += *g * (q - y) / 2.0;
        }
        Ok(())
    };
    critic.fit(obs, act, grad, 0.1).unwrap();
    loss
}

/// One step of an actor that raises the critics' mean, as TD3 does.
pub fn improve(actor: &mut dyn Actor, critic: &mut dyn Critic, obs: &[f32]) {
    let lower = &mut |q: QView<'_>, grad: &mut [f32]| {
        grad.fill(-1.0 / (q.critics() * q.rows()) as f32);
        Ok(())
    };
    actor
        .improve(obs, &[], &mut |sample, grad| {
            critic.action_grad(obs, sample.action, lower, grad.action)
        })
        .unwrap();
}

/// Every array of a state with its path, in order.
pub fn arrays(state: &State) -> Vec<(String, copq::Value)> {
    let mut out: Vec<_> =
        state.values().map(|(name, value)| (name.to_owned(), value.clone())).collect();
    for (name, child) in state.children() {
        out.extend(
            arrays(child).into_iter().map(|(path, value)| (format!("{name}/{path}"), value)),
        );
    }
    out
}
