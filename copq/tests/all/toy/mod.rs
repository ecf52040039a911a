//! A hand-written world with a known optimum and the smallest networks that can represent it; no
//! tensor crate.
#![allow(dead_code, missing_docs)]

use copq::projection::{Cholesky, ScalarisedMin};
use copq::*;

/// s is uniform on [-1, 1] and drawn anew at every step; the rewards are -(a - s/2)^2 and -a^2.
/// With weights (1, 1) the best action is a = s/4, whatever the discount.
#[derive(Debug)]
pub struct Toy {
    pub spec: EnvSpec,
    pub rng: Rng,
    pub s: f32,
    pub steps: u64,
    /// The step at which a reward (or an observation) is NaN, to see who notices.
    pub nan_reward_at: Option<u64>,
    pub nan_obs_at: Option<u64>,
    pub rewards: fn(f32, f32) -> [f32; 2],
}

pub const SLOPE: f32 = 0.25;

impl Toy {
    pub fn new() -> Self {
        let spec = EnvSpec::new("toy", 1, 1).reward("track", 1.0).reward("rest", 1.0);
        let spec = spec.action_bounds(&[-2.0], &[2.0]).horizon(20);
        let rewards = |s: f32, a: f32| [-(a - 0.5 * s).powi(2), -a * a];
        let rng = Rng::with_stream(0, 0);
        Self { spec, rng, s: 0.0, steps: 0, nan_reward_at: None, nan_obs_at: None, rewards }
    }

    /// A cost of 1 + a and a reward of -(a - 1/2)^2, where 20 steps may cost 20: the best action is
    /// 0 and the multiplier that makes it so is 1, since -(a - 1/2)^2 - lambda a is largest at (1 -
    /// lambda) / 2.
    pub fn constrained() -> Self {
        let mut toy = Self::new();
        toy.spec.objectives =
            vec![Objective::cost("cost", 20.0).weight(-1.0), Objective::reward("reward", 1.0)];
        toy.rewards = |_, a| [1.0 + a, -(a - 0.5).powi(2)];
        toy
    }

    /// The same world told the other way round: minus the cost, as a reward.
    pub fn flipped() -> Self {
        let mut toy = Self::constrained();
        toy.spec.objectives =
            vec![Objective::reward("cost", 1.0), Objective::reward("reward", 1.0)];
        toy.rewards = |_, a| [-(1.0 + a), -(a - 0.5).powi(2)];
        toy
    }
}

impl Env for Toy {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.rng = Rng::with_stream(seed, 9);
        self.s = self.rng.uniform_in(-1.0, 1.0) as f32;
        self.steps = 0;
        obs[0] = self.s;
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        // The bounds are [-2, 2], so that a missing scaling of actions shows.
        let a = action[0] / 2.0;
        reward.copy_from_slice(&(self.rewards)(self.s, a));
        self.steps += 1;
        if self.nan_reward_at == Some(self.steps) {
            reward[1] = f32::NAN;
        }
        self.s = self.rng.uniform_in(-1.0, 1.0) as f32;
        obs[0] = if self.nan_obs_at == Some(self.steps) { f32::NAN } else { self.s };
        Ok(if self.steps == 20 { Outcome::Truncated } else { Outcome::Running })
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.rng.save("rng", state);
        state.put("s", [self.s]);
        state.put("steps", [self.steps]);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.rng.load("rng", state)?;
        self.s = state.get_one("s")?;
        self.steps = state.get_one("steps")?;
        Ok(())
    }
}

const FEATURES: usize = 6;

fn features(s: f32, a: f32) -> [f32; FEATURES] {
    [1.0, s, a, s * s, s * a, a * a]
}

/// Adam on one flat array.
#[derive(Clone, Debug)]
struct Adam {
    m: Vec<f32>,
    v: Vec<f32>,
    t: u64,
}

impl Adam {
    fn new(n: usize) -> Self {
        Self { m: vec![0.0; n], v: vec![0.0; n], t: 0 }
    }

    fn step(&mut self, lr: f32, params: &mut [f32], grad: &[f32]) {
        self.t += 1;
        let c1 = 1.0 - 0.9f32.powi(self.t as i32);
        let c2 = 1.0 - 0.999f32.powi(self.t as i32);
        for (i, p) in params.iter_mut().enumerate() {
            self.m[i] = 0.9 * self.m[i] + 0.1 * grad[i];
            self.v[i] = 0.999 * self.v[i] + 0.001 * grad[i] * grad[i];
            *p -= lr * (self.m[i] / c1) / ((self.v[i] / c2).sqrt() + 1e-8);
        }
    }

    fn save(&self, state: &mut State) {
        state.put("m", self.m.as_slice());
        state.put("v", self.v.as_slice());
        state.put("t", [self.t]);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("m", &mut self.m)?;
        state.read("v", &mut self.v)?;
        self.t = state.get_one("t")?;
        Ok(())
    }
}

fn update_target(target: &mut [f32], online: &[f32], tau: f32) {
    target.iter_mut().zip(online).for_each(|(t, o)| *t += tau * (o - *t));
}

/// K critics, each linear in six features of (s, a) for each of N objectives.
#[derive(Debug)]
pub struct LinearCritics {
    critics: usize,
    objectives: usize,
    online: Vec<f32>,
    target: Vec<f32>,
    adam: Adam,
    q: Vec<f32>,
    grad_q: Vec<f32>,
    grad: Vec<f32>,
    lr: f32,
}

impl LinearCritics {
    pub fn new(critics: usize, objectives: usize, lr: f32, seed: u64) -> Self {
        let mut rng = Rng::new(seed, Stream::Init);
        let mut online = vec![0.0; critics * objectives * FEATURES];
        rng.fill_normal(&mut online);
        let n = online.len();
        let target = online.clone();
        let q = Vec::new();
        let grad_q = Vec::new();
        let grad = vec![0.0; n];
        Self { critics, objectives, target, online, adam: Adam::new(n), q, grad_q, grad, lr }
    }

    /// Every critic says zero.
    pub fn silent(mut self) -> Self {
        self.online.fill(0.0);
        self.target.fill(0.0);
        self
    }

    /// Every critic says minus what it said of an objective.
    pub fn flipped(mut self, objective: usize) -> Self {
        for parameters in [&mut self.online, &mut self.target] {
            for values in parameters.chunks_exact_mut(self.objectives * FEATURES) {
                values[objective * FEATURES..(objective + 1) * FEATURES]
                    .iter_mut()
                    .for_each(|w| *w = -*w);
            }
        }
        self
    }

    fn forward(&self, params: &[f32], obs: &[f32], act: &[f32], q: &mut [f32]) {
        let rows = obs.len();
        for k in 0..self.critics {
            for b in 0..rows {
                let phi = features(obs[b], act[b]);
                for n in 0..self.objectives {
                    let w = &params[(k * self.objectives + n) * FEATURES..][..FEATURES];
                    q[(k * rows + b) * self.objectives + n] =
                        w.iter().zip(phi).map(|(w, x)| w * x).sum();
                }
            }
        }
    }

    fn values_and_grad(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>) -> Result<()> {
        let len = self.critics * obs.len() * self.objectives;
        let mut q = std::mem::take(&mut self.q);
        let mut grad_q = std::mem::take(&mut self.grad_q);
        q.resize(len, 0.0);
        grad_q.resize(len, 0.0);
        self.forward(&self.online, obs, act, &mut q);
        let result = grad(QView::new(&q, self.critics, self.objectives)?, &mut grad_q);
        (self.q, self.grad_q) = (q, grad_q);
        result
    }
}

impl Critic for LinearCritics {
    fn critics(&self) -> usize {
        self.critics
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        let params = if net == Net::Online { &self.online } else { &self.target };
        self.forward(params, obs, act, q);
        Ok(())
    }

    fn values_of(
        &mut self,
        net: Net,
        chosen: &[usize],
        obs: &[f32],
        act: &[f32],
        q: &mut [f32],
    ) -> Result<()> {
        let mut all = std::mem::take(&mut self.q);
        let share = obs.len() * self.objectives;
        all.resize(self.critics * share, 0.0);
        self.values(net, obs, act, &mut all)?;
        q.chunks_exact_mut(share)
            .zip(chosen)
            .for_each(|(q, &k)| q.copy_from_slice(&all[k * share..][..share]));
        self.q = all;
        Ok(())
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        self.values_and_grad(obs, act, grad)?;
        self.grad.fill(0.0);
        let rows = obs.len();
        for k in 0..self.critics {
            for b in 0..rows {
                let phi = features(obs[b], act[b]);
                for n in 0..self.objectives {
                    let g = self.grad_q[(k * rows + b) * self.objectives + n];
                    let w = &mut self.grad[(k * self.objectives + n) * FEATURES..][..FEATURES];
                    w.iter_mut().zip(phi).for_each(|(w, x)| *w += g * x);
                }
            }
        }
        self.adam.step(self.lr, &mut self.online, &self.grad);
        update_target(&mut self.target, &self.online, tau);
        Ok(())
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        self.values_and_grad(obs, act, grad)?;
        let rows = obs.len();
        out.fill(0.0);
        for k in 0..self.critics {
            for b in 0..rows {
                for n in 0..self.objectives {
                    let w = &self.online[(k * self.objectives + n) * FEATURES..];
                    let dq_da = w[2] + w[4] * obs[b] + 2.0 * w[5] * act[b];
                    out[b] += self.grad_q[(k * rows + b) * self.objectives + n] * dq_da;
                }
            }
        }
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("online", self.online.as_slice());
        state.put("target", self.target.as_slice());
        self.adam.save(state.child_mut("adam"));
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("online", &mut self.online)?;
        state.read("target", &mut self.target)?;
        self.adam.load(state.child("adam")?)
    }
}

/// a = clip(bias + slope s).
#[derive(Debug)]
pub struct LinearActor {
    pub online: [f32; 2],
    target: [f32; 2],
    adam: Adam,
    action: Vec<f32>,
    grad: Vec<f32>,
    lr: f32,
}

impl LinearActor {
    pub fn new(lr: f32) -> Self {
        let start = [0.3, -0.5];
        Self {
            online: start,
            target: start,
            adam: Adam::new(2),
            action: Vec::new(),
            grad: Vec::new(),
            lr,
        }
    }
}

impl Actor for LinearActor {
    fn action_len(&self) -> usize {
        1
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let [bias, slope] = if net == Net::Online { self.online } else { self.target };
        action.iter_mut().zip(obs).for_each(|(a, s)| *a = (bias + slope * s).clamp(-1.0, 1.0));
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], _noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let mut action = std::mem::take(&mut self.action);
        let mut grad_action = std::mem::take(&mut self.grad);
        action.resize(obs.len(), 0.0);
        grad_action.resize(obs.len(), 0.0);
        self.mode(Net::Online, obs, &mut action)?;
        grad(
            Sample { action: &action, log_prob: None },
            SampleGrad { action: &mut grad_action, log_prob: None },
        )?;
        let mut g = [0.0; 2];
        for ((&s, &a), &da) in obs.iter().zip(&action).zip(&grad_action) {
            if a.abs() < 1.0 {
                g[0] += da;
                g[1] += da * s;
            }
        }
        self.adam.step(self.lr, &mut self.online, &g);
        (self.action, self.grad) = (action, grad_action);
        Ok(())
    }

    fn update_target(&mut self, tau: f32) -> Result<()> {
        update_target(&mut self.target, &self.online, tau);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("online", self.online);
        state.put("target", self.target);
        self.adam.save(state.child_mut("adam"));
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("online", &mut self.online)?;
        state.read("target", &mut self.target)?;
        self.adam.load(state.child("adam")?)
    }
}

/// a = tanh(bias + slope s + exp(log_std) noise): parameters bias, slope and log_std.
#[derive(Debug)]
pub struct GaussianActor {
    pub online: [f32; 3],
    adam: Adam,
    sample: [Vec<f32>; 4],
    lr: f32,
}

impl GaussianActor {
    pub fn new(lr: f32, log_std: f32) -> Self {
        Self { online: [0.3, -0.5, log_std], adam: Adam::new(3), sample: Default::default(), lr }
    }
}

impl Actor for GaussianActor {
    fn action_len(&self) -> usize {
        1
    }

    fn noise_len(&self) -> usize {
        1
    }

    fn mode(&mut self, _: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let [bias, slope, _] = self.online;
        action.iter_mut().zip(obs).for_each(|(a, s)| *a = (bias + slope * s).tanh());
        Ok(())
    }

    fn sample(
        &mut self,
        _: Net,
        obs: &[f32],
        noise: &[f32],
        action: &mut [f32],
        log_prob: &mut [f32],
    ) -> Result<()> {
        let [bias, slope, log_std] = self.online;
        for (i, (s, noise)) in obs.iter().zip(noise).enumerate() {
            let x = f64::from(bias + slope * s + log_std.exp() * noise);
            action[i] = x.tanh() as f32;
            let half_log_two_pi = 0.5 * std::f64::consts::TAU.ln();
            let gaussian = -0.5 * f64::from(*noise).powi(2) - f64::from(log_std) - half_log_two_pi;
            log_prob[i] = (gaussian + 2.0 * x.abs()
                - 2.0 * (2.0 / (1.0 + (-2.0 * x.abs()).exp())).ln())
                as f32;
        }
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], noise: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let mut sample = std::mem::take(&mut self.sample);
        sample.iter_mut().for_each(|values| values.resize(obs.len(), 0.0));
        let [action, log_prob, grad_action, grad_log_prob] = &mut sample;
        self.sample(Net::Online, obs, noise, action, log_prob)?;
        grad(
            Sample { action, log_prob: Some(log_prob) },
            SampleGrad { action: grad_action, log_prob: Some(grad_log_prob) },
        )?;
        let mut g = [0.0; 3];
        for (i, (s, noise)) in obs.iter().zip(noise).enumerate() {
            let dx =
                grad_action[i] * (1.0 - action[i] * action[i]) + grad_log_prob[i] * 2.0 * action[i];
            g[0] += dx;
            g[1] += dx * s;
            g[2] += dx * self.online[2].exp() * noise - grad_log_prob[i];
        }
        self.adam.step(self.lr, &mut self.online, &g);
        self.sample = sample;
        Ok(())
    }

    fn noise_grad(
        &mut self,
        obs: &[f32],
        noise: &[f32],
        grad_action: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let [bias, slope, log_std] = self.online;
        for i in 0..obs.len() {
            let a = (bias + slope * obs[i] + log_std.exp() * noise[i]).tanh();
            out[i] = grad_action[i] * (1.0 - a * a) * log_std.exp();
        }
        Ok(())
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("online", self.online);
        self.adam.save(state.child_mut("adam"));
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("online", &mut self.online)?;
        self.adam.load(state.child("adam")?)
    }
}

/// Settings with every part, FAMO's too, small enough for the toy: a batch of 64, 200 uniform
/// steps.
pub fn config() -> Config {
    small(Method::cop_td3_paper().warm_up(200).config)
}

/// Any settings made small enough for the toy.
pub fn small(config: Config) -> Config {
    Config { discount: 0.5, batch: 64, capacity: 5_000, start_steps: 200, ..config }
}

/// A method with these settings: the Cholesky bound, or ScalarisedMin's where targets draw a subset
/// of the critics.
pub fn method(config: Config) -> Method {
    match config.subset {
        Some(_) => Method::new("toy", config, ScalarisedMin),
        None => Method::new("toy", config, Cholesky),
    }
}

/// A learner with a squashed Gaussian policy and the given critics, in any toy world.
pub fn stochastic(method: Method, env: &Toy, critic: impl Critic + 'static, seed: u64) -> Learner {
    let actor = Box::new(GaussianActor::new(0.005, -1.0));
    Learner::with_networks(method, &env.spec, Box::new(critic), actor, seed).unwrap()
}

/// Builds these networks.
#[derive(Debug)]
pub struct Linear;

impl Backend for Linear {
    fn critics(
        &self,
        spec: &EnvSpec,
        _: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        Ok(Box::new(LinearCritics::new(count, spec.objectives.len(), 0.02, rng.next_u64())))
    }

    fn actor(
        &self,
        _: &EnvSpec,
        _: &Networks,
        kind: ActorKind,
        _: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        Ok(match kind {
            ActorKind::Deterministic => Box::new(LinearActor::new(0.005)),
            ActorKind::Gaussian => Box::new(GaussianActor::new(0.005, -1.0)),
            ActorKind::Normal => unreachable!(),
        })
    }
}

/// How many critics of both objectives stand for a projection's ensemble here.
pub fn critics_of(projection: &dyn Projection) -> usize {
    match projection.ensemble() {
        Ensemble::Joint(count) => count,
        Ensemble::Separate { .. } => 2,
        _ => 3,
    }
}

pub fn learner(method: Method, critics: usize, seed: u64) -> Learner {
    let critic = Box::new(LinearCritics::new(critics, 2, 0.02, seed));
    Learner::with_networks(
        method,
        &Toy::new().spec,
        critic,
        Box::new(LinearActor::new(0.005)),
        seed,
    )
    .unwrap()
}

/// What the agent does in state s.
pub fn act(agent: &mut dyn Agent, s: f32, mode: Mode) -> f32 {
    let mut action = [0.0];
    agent.act(&[s], mode, &mut action).unwrap();
    action[0]
}

/// The policy a = bias + slope s, read off by asking the agent.
pub fn policy(agent: &mut dyn Agent) -> [f32; 2] {
    let low = act(agent, -1.0, Mode::Exploit);
    let high = act(agent, 1.0, Mode::Exploit);
    [(low + high) / 2.0, (high - low) / 2.0]
}

/// Trains up to that many steps.
pub fn run(trainer: &mut Trainer<Learner>, steps: u64) -> State {
    while trainer.steps() < steps {
        trainer.step(&mut Silent).unwrap();
    }
    saved(trainer)
}

pub fn saved(trainer: &Trainer<Learner>) -> State {
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    state
}

pub fn trainer(learner: Learner) -> Trainer<Learner> {
    Trainer::new(Toy::new(), learner).unwrap()
}

/// Keeps the warnings.
#[derive(Default)]
pub struct Words(pub Vec<String>);

impl Observer for Words {
    fn scalar(&mut self, _: u64, _: &str, _: f64) {}
    fn warn(&mut self, _: u64, text: &str) {
        self.0.push(text.to_owned());
    }
}
