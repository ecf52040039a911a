//! The plain exploration rules: their noise, their range, their memory.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::toy;

use approx::assert_abs_diff_eq;
use copq::*;
use toy::{GaussianActor, LinearActor, LinearCritics, Toy};

const DRAWS: usize = 40_000;

/// Actions of a rule at s = 0.4, where the linear policy says 0.1 and the Gaussian one tanh(0.1).
fn actions(rule: &mut dyn Explore, actor: &mut dyn Actor) -> Vec<f32> {
    let (mut critic, mut rng, mut scratch) =
        (LinearCritics::new(2, 2, 0.02, 1), Rng::new(5, Stream::Explore), Scratch::default());
    let draw = |_| {
        let mut action = [0.0];
        let mut context = Context {
            step: 0,
            actor,
            critic: &mut critic,
            projection: &projection::Cholesky,
            weights: &[1.0, 1.0],
            rng: &mut rng,
            scratch: &mut scratch,
        };
        rule.act(&mut context, &[0.4], &mut action).unwrap();
        action[0]
    };
    (0..DRAWS).map(draw).collect()
}

fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let mean = values.clone().sum::<f64>() / DRAWS as f64;
    [mean, (values.map(|x| (x - mean).powi(2)).sum::<f64>() / DRAWS as f64).sqrt()]
}

/// Within four standard errors of the mean.
fn assert_moments(got: [f64; 2], wanted: [f64; 2]) {
    let error = 4.0 * wanted[1] / (DRAWS as f64).sqrt();
    assert_abs_diff_eq!(got[..], wanted[..], epsilon = error);
}

#[test]
fn gaussian_noise_has_its_width_around_the_policy_and_stays_in_range() {
    let noisy = |std| actions(&mut GaussianNoise { std }, &mut LinearActor::new(0.0));
    assert_moments(moments(noisy(0.1).iter().map(|&a| a.into())), [0.1, 0.1]);
    let wide = noisy(2.0);
    assert!(wide.iter().all(|a| a.abs() <= 1.0));
    // Beyond 0.9 above and 1.1 below the mean, noise of width 2 is cut off: 0.326 and 0.291 of it.
    let share = |end: f32| wide.iter().filter(|&&a| a == end).count() as f64 / DRAWS as f64;
    assert_abs_diff_eq!([share(1.0), share(-1.0)][..], [0.3264, 0.2912][..], epsilon = 0.01);
}

#[test]
fn uniform_actions_fill_the_range() {
    let uniform = actions(&mut UniformActions, &mut LinearActor::new(0.0));
    assert_moments(moments(uniform.iter().map(|&a| a.into())), [0.0, (1.0f64 / 3.0).sqrt()]);
    for tenth in 0..10 {
        let from = -1.0 + 0.2 * tenth as f32;
        let count = uniform.iter().filter(|&&a| (from..from + 0.2).contains(&a)).count();
        assert!(count.abs_diff(DRAWS / 10) < DRAWS / 100, "{count} actions from {from}");
    }
}

#[test]
fn a_stochastic_policy_explores_by_its_own_samples() {
    let sampled = actions(&mut PolicySamples::default(), &mut GaussianActor::new(0.0, 0.2f32.ln()));
    // s = 0.4: 0.3 - 0.5 * 0.4 before the tanh.
    assert_moments(moments(sampled.iter().map(|&a| f64::from(a).atanh())), [0.1, 0.2]);
}

/// Rests, and counts the episodes that begin.
#[derive(Debug)]
struct Counting(Arc<AtomicU32>);

impl Explore for Counting {
    fn act(&mut self, _: &mut Context<'_>, _: &[f32], action: &mut [f32]) -> Result<()> {
        action.fill(0.0);
        Ok(())
    }

    fn begin_episode(&mut self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// A rule whose memory begins anew with an episode would drag it from one into the next.
#[test]
fn a_rule_hears_of_every_episode_that_begins_through_boxes_too() {
    let begun = Arc::default();
    let rule: Box<dyn Explore> = Box::new(Counting(Arc::clone(&begun)));
    let learner = toy::learner(toy::method(toy::config()), 3, 1).explore(rule);
    let boxed: Box<dyn Agent> = Box::new(learner);
    let mut trainer = Trainer::new(Toy::new(), boxed).unwrap();
    // Episodes of 20 steps.
    for (steps, wanted) in [(1, 1), (19, 1), (1, 2), (39, 3), (1, 4)] {
        trainer.run(steps, &mut Silent).unwrap();
        assert_eq!(begun.load(Ordering::Relaxed), wanted);
    }
}
