//! What a bound promises of critics that err as they disagree.

use copq::*;

/// Episodes of one step whose reward, seen before, is a number from 0 to 1.
struct Guess {
    spec: EnvSpec,
    luck: f32,
}

impl Guess {
    fn new() -> Self {
        Self { spec: EnvSpec::new("guess", 1, 1).reward("luck", 1.0), luck: 0.0 }
    }
}

impl Env for Guess {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.luck = Rng::new(seed, Stream::Init).uniform_in(0.0, 1.0) as f32;
        obs[0] = self.luck;
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        (obs[0], reward[0]) = (0.0, self.luck);
        Ok(Outcome::Terminated)
    }
}

/// Two critics whose mean is wrong by a normal number, a tenth in size, and who differ from it by a
/// tenth.
struct Unsure;

impl Critic for Unsure {
    fn critics(&self) -> usize {
        2
    }

    fn objectives(&self) -> usize {
        1
    }

    fn values(&mut self, _: Net, obs: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        let mut error = [0.0];
        Rng::new(obs[0].to_bits().into(), Stream::Init).fill_normal(&mut error);
        let mean = obs[0] + 0.1 * error[0];
        q.copy_from_slice(&[mean - 0.1, mean + 0.1]);
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

fn coverage_at(pessimism: f64) -> Coverage {
    let env = Guess::new();
    let mut method = Method::cop_td3();
    method.config.pessimism = pessimism;
    let (critic, actor) = (Box::new(Unsure), Box::new(Resting));
    let mut learner = Learner::with_networks(method, env.spec(), critic, actor, 0).unwrap();
    Coverage::of(&mut learner, env, Looks { episodes: 20_000, every: 1, smoothed: false }).unwrap()
}

#[test]
fn a_bound_is_kept_as_often_as_a_normal_number_is_above_it() {
    for pessimism in [0.0, 0.92, 2.0] {
        let coverage = coverage_at(pessimism);
        let luck = &coverage.objectives[0];
        // One objective: the bound is `pessimism` standard deviations below the mean.
        let wanted = 0.5 * (1.0 + libm::erf(pessimism / 2f64.sqrt()));
        assert!((luck.kept - wanted).abs() < 0.01, "{pessimism}: {} is not {wanted}", luck.kept);
        assert!((luck.std - 0.1).abs() < 1e-6 && (luck.error - 0.1).abs() < 2e-3, "{luck:?}");
        assert_eq!(coverage.actions, 20_000);
    }
}

#[test]
fn what_nobody_can_know_is_an_error() {
    let (critic, actor) = (Box::new(Unsure), Box::new(Resting));
    let mut method = Method::cop_td3();
    method.config.smoothing = None;
    let spec = Guess::new().spec;
    let mut learner = Learner::with_networks(method, &spec, critic, actor, 0).unwrap();
    let mut said = |looks| Coverage::of(&mut learner, Guess::new(), looks).unwrap_err().to_string();
    let none = Looks { episodes: 0, ..Looks::default() };
    assert_eq!(said(none), "episodes: wanted at least 1, got 0");
    let smoothed = Looks { smoothed: true, ..Looks::default() };
    let words = "episodes with the targets' noise: wanted a method with target smoothing, got none";
    assert_eq!(said(smoothed), words);
}
