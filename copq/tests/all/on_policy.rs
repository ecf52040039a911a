//! The on-policy learner with the smallest networks, in worlds whose numbers are known.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::toy;

use copq::on_policy::{
    Config, Constraint, Descent, GaussianPolicy, Learner, Method, Normal, NormalGrad,
    NormalGradient, Rows, Saute, SauteConfig, StateValue, ValueGrad, update,
};
use copq::*;
use toy::Toy;

/// bias + slope x of an observation's first number x, by plain gradient descent: a critic, and the
/// mean of a policy whose deviation stays at 1.
#[derive(Clone, Debug, PartialEq)]
struct Line {
    obs_len: usize,
    bias: f32,
    slope: f32,
}

impl Line {
    fn new(obs_len: usize) -> Self {
        Self { obs_len, bias: 0.25, slope: -0.5 }
    }

    fn batch(&self, obs: &[f32]) -> Vec<f32> {
        obs.chunks_exact(self.obs_len).map(|row| self.bias + self.slope * row[0]).collect()
    }

    fn step(&mut self, obs: &[f32], lr: f64, grad: &[f32]) {
        for (row, grad) in obs.chunks_exact(self.obs_len).zip(grad) {
            self.bias -= lr as f32 * grad;
            self.slope -= lr as f32 * grad * row[0];
        }
    }

    fn put(&self, state: &mut State) {
        state.put("line", [self.bias, self.slope]);
    }
}

impl Actor for Line {
    fn action_len(&self) -> usize {
        1
    }

    fn mode(&mut self, _: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        action[0] = self.batch(obs)[0].clamp(-1.0, 1.0);
        Ok(())
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        unreachable!()
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        unreachable!()
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.put(state);
        Ok(())
    }
}

impl GaussianPolicy for Line {
    fn log_std(&self) -> &[f32] {
        &[0.0]
    }

    fn means(&mut self, obs: &[f32], mean: &mut [f32]) -> Result<()> {
        mean.copy_from_slice(&self.batch(obs));
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: NormalGrad<'_>) -> Result<()> {
        let mean = self.batch(obs);
        let mut gradient = mean.clone();
        let of = NormalGradient { mean: &mut gradient, log_std: &mut [0.0] };
        grad(Normal { mean: &mean, log_std: &[0.0] }, of)?;
        self.step(obs, step.lr, &gradient);
        Ok(())
    }
}

impl StateValue for Line {
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()> {
        value.copy_from_slice(&self.batch(obs));
        Ok(())
    }

    fn descend(&mut self, obs: &[f32], step: Descent, grad: ValueGrad<'_>) -> Result<()> {
        let value = self.batch(obs);
        let mut gradient = value.clone();
        grad(&value, &mut gradient)?;
        self.step(obs, step.lr, &gradient);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.put(state);
        Ok(())
    }
}

struct Lines;

impl Backend for Lines {
    fn critics(&self, _: &EnvSpec, _: &Networks, _: usize, _: &mut Rng) -> Result<Box<dyn Critic>> {
        unreachable!()
    }

    fn actor(
        &self,
        _: &EnvSpec,
        _: &Networks,
        _: ActorKind,
        _: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        unreachable!()
    }

    fn policy(&self, spec: &EnvSpec, _: &Networks, _: &mut Rng) -> Result<Box<dyn GaussianPolicy>> {
        Ok(Box::new(Line::new(spec.obs_len)))
    }

    fn value(&self, spec: &EnvSpec, _: &Networks, _: &mut Rng) -> Result<Box<dyn StateValue>> {
        Ok(Box::new(Line::new(spec.obs_len)))
    }
}

/// Any settings made small enough for lines: two passes that no divergence ends.
fn small(steps_per_epoch: usize, config: Config) -> Config {
    let networks = Networks { actor_lr: 0.01, critic_lr: 0.01, ..config.networks };
    Config { steps_per_epoch, passes: 2, target_kl: 1e9, normalise: false, networks, ..config }
}

fn learner(config: Config, spec: &EnvSpec) -> Learner {
    Learner::new(Method::new("toy", config), spec, &Lines, 3).unwrap()
}

/// Episodes of three steps that are worth 1 each; of 2.0 that may be spent of the first cost they
/// spend 0.75, and of 1.0 of the second they spend 1.5.
struct TwoCosts {
    spec: EnvSpec,
    time: u8,
}

impl TwoCosts {
    fn new() -> Self {
        let spec = EnvSpec::new("two costs", 1, 1).reward("rest", 1.0);
        Self { spec: spec.cost("time", 2.0).cost("heat", 1.0).horizon(3), time: 0 }
    }
}

impl Env for TwoCosts {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        self.time = 0;
        obs[0] = 0.0;
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.time += 1;
        obs[0] = self.time.into();
        reward.copy_from_slice(&[1.0, 0.25, 0.5]);
        Ok(if self.time < 3 { Outcome::Running } else { Outcome::Truncated })
    }
}

/// Two rules that see the same mean, or the same limit, would hold one cost by the other's.
#[test]
fn each_cost_has_a_multiplier_by_its_own_mean_and_limit() {
    let pid = PidConfig { proportional: 0.0, derivative: 0.0, ..PidConfig::cppo_pid() };
    let pid = PidConfig { integral: 0.5, multiplier: 2.0, ..pid };
    let config = Config { constraint: Some(Constraint::Pid(pid)), ..Config::default() };
    let env = TwoCosts::new();
    let learner = learner(small(6, config), env.spec());
    let mut trainer = Trainer::new(env, learner).unwrap();
    trainer.run(6, &mut Silent).unwrap();
    // 2 + (0.75 - 2) / 2, and 2 + (1.5 - 1) / 2.
    assert_eq!(trainer.agent().multipliers(), [1.375, 2.25]);
}

/// A budget that counts another cost would be spent too late, or never.
#[test]
fn each_cost_spends_its_own_budget() {
    let undiscounted = SauteConfig { discount: 1.0, ..SauteConfig::default() };
    let mut env = Saute::new(TwoCosts::new(), &undiscounted).unwrap();
    let mut obs = [0.0; 3];
    env.reset(0, &mut obs).unwrap();
    assert_eq!(obs, [0.0, 1.0, 1.0]);
    for wanted in [[1.0, 0.875, 0.5], [2.0, 0.75, 0.0], [3.0, 0.625, -0.5]] {
        env.step(&[0.0], &mut obs, &mut [0.0; 3]).unwrap();
        assert_eq!(obs, wanted);
    }
}

/// A step would count as safe because another cost has some of its budget left.
#[test]
fn a_step_after_any_budget_is_spent_has_the_unsafe_reward() {
    let saute = SauteConfig { discount: 1.0, unsafe_reward: -5.0 };
    let env = Saute::new(TwoCosts::new(), &saute).unwrap();
    let config = Config { saute: Some(saute), ..Config::default() };
    let learner = learner(small(6, config), env.spec());
    let mut trainer = Trainer::new(env, learner).unwrap();
    trainer.run(5, &mut Silent).unwrap();
    let mut state = State::default();
    trainer.agent().save(&mut state).unwrap();
    let signal = state.child("epoch").unwrap().get::<f32>("signal.0").unwrap();
    assert_eq!(signal[..5], [1.0, -5.0, -5.0, 1.0, -5.0]);
}

/// What comes late in an episode would never be learned from, and nobody would know.
#[test]
fn an_epoch_shorter_than_an_episode_is_a_warning() {
    let saute = SauteConfig { discount: 1.0, ..SauteConfig::default() };
    let pid = Constraint::Pid(PidConfig::cppo_pid());
    let limited = Config { constraint: Some(pid), ..Config::default() };
    let warned = |steps: usize, config: Config| {
        let mut env: Box<dyn Env> = Box::new(TwoCosts::new());
        if let Some(saute) = &config.saute {
            env = Box::new(Saute::new(env, saute).unwrap());
        }
        let learner = learner(small(steps, config), env.spec());
        let mut words = toy::Words::default();
        Trainer::new(env, learner).unwrap().run(4 * steps as u64, &mut words).unwrap();
        words.0
    };
    assert!(warned(3, limited.clone()).is_empty());
    let [costs, rest, budget] =
        [limited, Config::default(), Config { saute: Some(saute), ..Config::default() }]
            .map(|config| warned(2, config));
    let begins = "an epoch has 2 steps of each environment, and an episode of 'two costs";
    for (words, wanted) in [
        (costs, "costs of longer episodes are never seen"),
        (rest, "later states are never seen"),
        (budget, "a budget lasts an epoch at 1.5 times the rate that the limit allows"),
    ] {
        assert_eq!(words.len(), 1, "{words:?}");
        assert!(words[0].starts_with(begins) && words[0].contains(wanted), "{words:?}");
    }
}

/// Four steps of one number each; the reward is the first signal.
fn rows(signals: &[[f32; 4]]) -> Rows {
    Rows {
        obs: vec![0.5, -1.0, 0.25, 2.0],
        action: vec![0.5, -0.5, 1.0, -2.0],
        log_prob: vec![-1.0; 4],
        advantages: signals.iter().map(|signal| signal.to_vec()).collect(),
        targets: vec![vec![1.0, 2.0, -1.0, 0.5]; signals.len()],
    }
}

/// Cost advantages that are weighed by another's multiplier would hold one cost by the other's.
#[test]
fn two_costs_count_as_their_weighed_sum() {
    let reward = [1.0, -1.0, 2.0, 0.5];
    let costs = [[1.0, -2.0, 0.5, 3.0], [-4.0, 1.0, 2.0, -0.5]];
    let sum = [0, 1, 2, 3].map(|i| 0.25 * costs[0][i] + 0.75 * costs[1][i]);
    for method in [Method::ppo_lag(), Method::cup()] {
        let config = Config { batch: 2, ..small(4, method.config) };
        let learned = |signals: &[[f32; 4]], multipliers: &[f64]| {
            let mut policy = Line::new(1);
            let critic = |_| Box::new(Line::new(1)) as Box<dyn StateValue>;
            let mut critics: Vec<_> = signals.iter().map(critic).collect();
            let rows = rows(signals);
            let lr = 0.01;
            let report =
                update(&config, &rows, multipliers, lr, &mut policy, &mut critics, &mut |_| {});
            let report = report.unwrap();
            (policy, report.kl, report.second_kl)
        };
        let both = learned(&[reward, costs[0], costs[1]], &[0.25, 0.75]);
        assert_eq!(both, learned(&[reward, sum], &[1.0]), "{}", method.name);
        assert_ne!(both, learned(&[reward, costs[0], costs[1]], &[0.75, 0.25]), "{}", method.name);
    }
}

/// Numbers of another pass, or added up over passes, would not say where the critics have come to.
#[test]
fn a_report_is_of_the_last_pass() {
    let rows = rows(&[[1.0, -1.0, 2.0, 0.0]]);
    let config = Config { batch: 2, ..small(4, Config::default()) };
    let mut policy = Line::new(1);
    let critics: &mut [Box<dyn StateValue>] = &mut [Box::new(Line::new(1))];
    let wide = Rows { log_prob: vec![-9.0; 4], ..rows.clone() };
    // Ratios far above 1 are cut where the advantage is positive; the policy stays.
    let report = update(&config, &wide, &[], 0.0, &mut policy, critics, &mut |_| {});
    let report = report.unwrap();
    assert_eq!((report.clip_share, report.kl), (0.5, vec![0.0; 2]));

    let mut critic = Line::new(1);
    let mut losses = [0.0; 2];
    for loss in &mut losses {
        for (obs, target) in rows.obs.chunks(2).zip(rows.targets[0].chunks(2)) {
            let values = critic.batch(obs);
            let errors: Vec<f32> = values.iter().zip(target).map(|(v, y)| v - y).collect();
            *loss += errors.iter().map(|e| f64::from(e * e)).sum::<f64>() / 4.0;
            critic.step(obs, 0.01, &errors);
        }
    }
    assert!((report.critic_losses[0] - losses[1]).abs() < 1e-12 && losses[1] < losses[0]);
}

/// A step size that did not fall would go unnoticed until a long run does not settle.
#[test]
fn the_policys_step_is_smaller_from_the_second_epoch_on() {
    let policies = |anneal_steps| {
        let config = Config { anneal_steps, ..small(60, Config::default()) };
        let env = Toy::new();
        let learner = learner(config, env.spec());
        let mut trainer = Trainer::new(env, learner).unwrap();
        [0; 2].map(|_| {
            trainer.run(60, &mut Silent).unwrap();
            toy::policy(trainer.agent_mut())
        })
    };
    let [[first, second], [constant_first, constant_second]] = [Some(120), None].map(policies);
    assert!(first == constant_first && first != second);
    assert_ne!(second, constant_second);
}

/// Runs on for longer than an epoch, and counts its episodes.
struct Endless {
    spec: EnvSpec,
    resets: Arc<AtomicU32>,
}

impl Env for Endless {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        self.resets.fetch_add(1, Ordering::Relaxed);
        obs.fill(0.0);
        Ok(())
    }

    fn step(&mut self, _: &[f32], _: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        reward.fill(1.0);
        Ok(Outcome::Running)
    }
}

fn begins_anew<A: Agent>(agent: impl FnOnce(Learner) -> A) {
    let resets = Arc::default();
    let spec = EnvSpec::new("endless", 1, 1).reward("time", 1.0);
    let agent = agent(learner(small(8, Config::default()), &spec));
    let mut trainer = Trainer::new(Endless { spec, resets: Arc::clone(&resets) }, agent).unwrap();
    let mut at = |steps| {
        trainer.run(steps, &mut Silent).unwrap();
        (resets.load(Ordering::Relaxed), trainer.episode().length)
    };
    assert_eq!((at(8), at(1)), ((1, 8), (2, 1)));
}

/// An episode that went on over the end of an epoch would begin the next one in its middle.
#[test]
fn an_epoch_begins_with_a_new_episode_also_of_a_boxed_learner() {
    begins_anew(|learner| learner);
    begins_anew(|learner| Box::new(learner) as Box<dyn Agent>);
}
