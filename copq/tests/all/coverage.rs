//! What a bound promises of critics that err as they disagree.

use crate::toy;

use copq::projection::ScalarisedMin;
use copq::*;
use toy::{LinearActor, Toy};

/// Episodes of one step whose rewards, seen before, are numbers from 0 to 1.
struct Guess {
    spec: EnvSpec,
    luck: Vec<f32>,
}

impl Guess {
    fn new(objectives: usize) -> Self {
        let names = ["first", "second", "third"];
        let spec = EnvSpec::new("guess", objectives, 1);
        let spec = names[..objectives].iter().fold(spec, |spec, name| spec.reward(*name, 1.0));
        Self { spec, luck: vec![0.0; objectives] }
    }
}

impl Env for Guess {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        let mut rng = Rng::new(seed, Stream::Custom);
        self.luck.fill_with(|| rng.uniform_in(0.0, 1.0) as f32);
        obs.copy_from_slice(&self.luck);
        Ok(())
    }

    fn step(&mut self, _: &[f32], _: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        reward.copy_from_slice(&self.luck);
        Ok(Outcome::Terminated)
    }
}

/// Critics whose mean is wrong by normal numbers, a tenth in size, and who differ from it by as
/// much: two for each objective, so that objectives do not go together.
struct Unsure {
    objectives: usize,
}

impl Critic for Unsure {
    fn critics(&self) -> usize {
        2 * self.objectives
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, _: Net, obs: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        let n = self.objectives;
        let mut error = vec![0.0; n];
        Rng::new(obs[0].to_bits().into(), Stream::Init).fill_normal(&mut error);
        let apart = 0.1 * (n as f32).sqrt();
        for (k, q) in q.chunks_exact_mut(n).enumerate() {
            for i in 0..n {
                q[i] = obs[i] + 0.1 * error[i];
            }
            q[k / 2] += if k % 2 == 0 { apart } else { -apart };
        }
        Ok(())
    }

    fn fit(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: f32) -> Result<()> {
        Ok(())
    }

    fn action_grad(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: &mut [f32]) -> Result<()> {
        Ok(())
    }
}

struct Resting;

impl Actor for Resting {
    fn action_len(&self) -> usize {
        1
    }

    fn mode(&mut self, _: Net, _: &[f32], action: &mut [f32]) -> Result<()> {
        action.fill(0.0);
        Ok(())
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        Ok(())
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        Ok(())
    }
}

fn learner(objectives: usize, pessimism: f64) -> Learner {
    let mut method = Method::cop_td3();
    method.config.pessimism = pessimism;
    let (critic, actor) = (Box::new(Unsure { objectives }), Box::new(Resting));
    Learner::with_networks(method, &Guess::new(objectives).spec, critic, actor, 0).unwrap()
}

#[test]
fn a_bound_covers_as_often_as_a_normal_number_is_above_it() {
    let config = CoverageConfig { episodes: 20_000, stride: 1, bare: false };
    for (objectives, pessimism) in [(1, 0.0), (1, 0.92), (1, 2.0), (2, 1.0), (3, 1.5)] {
        let mut learner = learner(objectives, pessimism);
        let all = coverage(&mut learner, Guess::new(objectives), config).unwrap();
        assert_eq!(all.actions, 20_000);
        // Objectives that do not go together: along the weights, an equal share of the step each.
        for (of, step) in all
            .objectives
            .iter()
            .map(|of| (of, pessimism / (objectives as f64).sqrt()))
            .chain([(&all.total, pessimism)])
        {
            let wanted = 0.5 * (1.0 + libm::erf(step / 2f64.sqrt()));
            assert!((of.nominal - wanted).abs() < 1e-3, "{objectives}, {pessimism}: {of:?}");
            assert!((of.coverage - wanted).abs() < 0.012, "{objectives}, {pessimism}: {of:?}");
            assert!((of.rmse / of.q_std - 1.0).abs() < 0.02, "{objectives}, {pessimism}: {of:?}");
            // Independent episodes: a coin's standard error.
            let se = (of.coverage * (1.0 - of.coverage) / 20_000.0).sqrt();
            assert!((of.coverage_se - se).abs() < 1e-6, "{of:?}");
        }
    }
}

/// Falls at step 8 in half of the episodes, and is worth 1 a step.
struct Late {
    spec: EnvSpec,
    step: u32,
    falls: bool,
}

impl Env for Late {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        (self.step, self.falls) = (0, seed.is_multiple_of(2));
        obs.fill(0.0);
        Ok(())
    }

    fn step(&mut self, _: &[f32], _: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.step += 1;
        reward.fill(1.0);
        Ok(match self.step {
            8 if self.falls => Outcome::Terminated,
            10 => Outcome::Truncated,
            _ => Outcome::Running,
        })
    }
}

/// How many actions of 40 such episodes are looked at, under a time limit.
fn looked_at(horizon: usize) -> usize {
    let spec = EnvSpec::new("late", 1, 1).reward("time", 1.0).horizon(horizon);
    let mut method = Method::cop_td3();
    method.config.discount = 0.5;
    let (critic, actor) = (Box::new(Unsure { objectives: 1 }), Box::new(Resting));
    let mut learner = Learner::with_networks(method, &spec, critic, actor, 0).unwrap();
    let config = CoverageConfig { episodes: 40, stride: 1, bare: true };
    let late = Late { spec, step: 0, falls: false };
    coverage(&mut learner, late, config).unwrap().actions
}

#[test]
fn how_an_episode_ends_does_not_decide_what_is_looked_at() {
    // 0.5^4 is less than a tenth: the first seven actions of every episode.
    assert_eq!(looked_at(10), 7 * 40);
}

/// What a world cuts off before its time has no return of its own near its end.
#[test]
fn an_episode_that_is_cut_short_is_known_up_to_there() {
    let actions = looked_at(1_000);
    // Seven of ten steps where it is cut off, all eight where it falls.
    assert!(actions > 7 * 40 && actions < 8 * 40, "{actions}");
}

/// A policy that rests, and says -2 of the action's log-probability.
struct Sampled;

impl Actor for Sampled {
    fn action_len(&self) -> usize {
        1
    }

    fn noise_len(&self) -> usize {
        1
    }

    fn mode(&mut self, _: Net, _: &[f32], action: &mut [f32]) -> Result<()> {
        action.fill(0.0);
        Ok(())
    }

    fn sample(
        &mut self,
        _: Net,
        _: &[f32],
        _: &[f32],
        action: &mut [f32],
        log_prob: &mut [f32],
    ) -> Result<()> {
        action.fill(0.0);
        log_prob.fill(-2.0);
        Ok(())
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        Ok(())
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        Ok(())
    }
}

/// 1 for each of three steps.
struct Three(EnvSpec, u32);

impl Env for Three {
    fn spec(&self) -> &EnvSpec {
        &self.0
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        self.1 = 0;
        obs.fill(0.0);
        Ok(())
    }

    fn step(&mut self, _: &[f32], _: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.1 += 1;
        reward.fill(1.0);
        Ok(if self.1 == 3 { Outcome::Terminated } else { Outcome::Running })
    }
}

#[test]
fn an_entropy_bonus_counts_from_the_next_action_on() {
    let spec = EnvSpec::new("three", 1, 1).reward("time", 1.0);
    let mut method = Method::sac();
    method.config.discount = 0.5;
    let (critic, actor) = (Box::new(Unsure { objectives: 1 }), Box::new(Sampled));
    let mut learner = Learner::with_networks(method, &spec, critic, actor, 0).unwrap();
    // A temperature of 1 and a log-probability of -2: 2 an action.
    for (bare, wanted) in [
        (false, 1.0 + (1.0 + 0.5 * (2.0 + 1.0)) + (1.0 + 0.5 * (2.0 + 2.5))),
        (true, 1.0 + (1.0 + 0.5) + (1.0 + 0.5 * 1.5)),
    ] {
        let config = CoverageConfig { episodes: 2, stride: 1, bare };
        let all = coverage(&mut learner, Three(spec.clone(), 0), config).unwrap();
        assert_eq!((all.actions, all.objectives[0].discounted), (6, wanted / 3.0));
    }
}

#[test]
fn less_of_a_cost_is_better_whatever_it_weighs() {
    let spec = EnvSpec::new("guess", 2, 1).cost("first", 1.0).reward("second", 1.0);
    let config = CoverageConfig { episodes: 200, stride: 1, bare: false };
    let [nothing, minus_nothing, little] = [0.0, -0.0, -1e-30].map(|weight| {
        let mut spec = spec.clone();
        spec.objectives[0].weight = weight;
        let (critic, actor) = (Box::new(Unsure { objectives: 2 }), Box::new(Resting));
        let mut learner =
            Learner::with_networks(Method::cop_td3(), &spec, critic, actor, 0).unwrap();
        let guess = Guess { spec, luck: vec![0.0; 2] };
        coverage(&mut learner, guess, config).unwrap().objectives.swap_remove(0)
    });
    assert_eq!((&nothing, &minus_nothing), (&little, &little));
    let share_above = 1.0 - little.coverage;
    assert!((0.3..0.7).contains(&share_above) && share_above != little.coverage, "{little:?}");
}

#[test]
fn what_cannot_be_looked_at_is_an_error() {
    let said = |episodes, stride, env| {
        let config = CoverageConfig { episodes, stride, bare: false };
        coverage(&mut learner(1, 1.0), env, config).unwrap_err().to_string()
    };
    assert_eq!(said(0, 1, Guess::new(1)), "episodes: wanted at least 1, got 0");
    assert_eq!(said(1, 0, Guess::new(1)), "stride: wanted at least 1, got 0");
    assert!(said(1, 1, Guess::new(2)).contains("another"), "{}", said(1, 1, Guess::new(2)));
    let short = Guess { spec: Guess::new(1).spec.horizon(10), luck: vec![0.0] };
    let mut method = Method::cop_td3();
    method.config.discount = 0.999;
    let (critic, actor) = (Box::new(Unsure { objectives: 1 }), Box::new(Resting));
    let mut far = Learner::with_networks(method, &short.spec, critic, actor, 0).unwrap();
    let error = coverage(&mut far, short, CoverageConfig::default()).unwrap_err().to_string();
    assert!(error.contains("those of at most 10 steps"), "{error}");
}

/// An action chosen by raw observations would be valued as the policy's, and is not.
#[test]
fn without_smoothing_the_policy_that_is_valued_is_the_one_that_is_evaluated() {
    // No update comes, so that the target network is the online one.
    let config = Config { smoothing: None, normalise: true, start_steps: 1_000, ..toy::config() };
    let mut trainer = toy::trainer(toy::learner(toy::method(config), 3, 5));
    trainer.run(300, &mut Silent).unwrap();
    let [valued, evaluated] = [false, true].map(|bare| {
        let config = CoverageConfig { episodes: 5, stride: 1, bare };
        coverage(trainer.agent_mut(), Toy::new(), config).unwrap()
    });
    assert_eq!(valued, evaluated);
}

/// Says the same of everything, `critics x objectives`.
struct Says {
    objectives: usize,
    values: Vec<f32>,
}

impl Critic for Says {
    fn critics(&self) -> usize {
        self.values.len() / self.objectives
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, _: Net, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        q.copy_from_slice(&self.values);
        Ok(())
    }

    fn fit(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: f32) -> Result<()> {
        Ok(())
    }

    fn action_grad(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: &mut [f32]) -> Result<()> {
        Ok(())
    }
}

/// How separate networks are numbered would decide how sure their total is.
#[test]
fn the_totals_deviation_is_of_totals_or_of_objectives_that_err_independently() {
    let mut spec = Toy::new().spec;
    (spec.objectives[0].weight, spec.objectives[1].weight) = (3.0, 4.0);
    let estimate = |critic: Box<dyn Critic>| {
        let method = Method::new("toy", toy::config(), ScalarisedMin);
        let actor = Box::new(LinearActor::new(0.0));
        let mut learner = Learner::with_networks(method, &spec, critic, actor, 0).unwrap();
        learner.estimate(&[0.1], &[0.2]).unwrap()
    };
    // Totals of 3 + 20 and 9 + 12.
    let joint = estimate(Box::new(Says { objectives: 2, values: vec![1.0, 5.0, 3.0, 3.0] }));
    assert_eq!((&joint.std[..], joint.total_std), (&[1.0, 1.0][..], 1.0));
    // The same numbers in either order: the root of 3^2 + 4^2.
    for values in [[1.0, 3.0, 5.0, 3.0], [1.0, 3.0, 3.0, 5.0]] {
        let networks = Says { objectives: 1, values: values.to_vec() };
        let critics = SeparateCritics::new(Box::new(networks), &[2, 2]).unwrap();
        let separate = estimate(Box::new(critics));
        assert_eq!((&separate.std[..], separate.total_std), (&[1.0, 1.0][..], 5.0));
    }
}
