//! Optimistic exploration against its definition in f64: the policy's mean moves by
//! `shift Sigma g / sqrt(g' Sigma g)`, with g by central differences of the critics' scalarised
//! upper bound.

use crate::common;

use approx::assert_abs_diff_eq;
use common::reference::{Reference, slope};
use common::{Case, assert_close, saved};
use copq::projection::{Cholesky, Extremum, ScalarisedMin};
use copq::{
    Actor, Context, Critic, Explore, Net, Optimism, Optimistic, Projection, Rng, Scratch, Stream,
};
use proptest::prelude::*;

const WEIGHTS: [f32; 3] = [1.0, 0.5, 2.0];

fn case() -> Case {
    Case { action: 3, ..Case::new(5, 3, &[12, 9], 1) }
}

fn ensemble(critic: &dyn Critic, case: &Case) -> Vec<Reference> {
    let state = saved(critic);
    let online = |k| state.child(&format!("critic.{k}")).unwrap().child("online").unwrap();
    (0..case.critics)
        .map(|k| Reference::read(online(k), case.hidden.len() + 1, case.activation))
        .collect()
}

/// u . mean + beta max(0, u . L u) for Cholesky (paper eq. 15), u . mean + beta sqrt(u . Sigma u)
/// for Extremum.
fn upper_bound(ensemble: &[Reference], name: &str, beta: f64, obs: &[f32], action: &[f64]) -> f64 {
    let input: Vec<f64> = obs.iter().map(|&x| x.into()).chain(action.iter().copied()).collect();
    let q: Vec<Vec<f64>> = ensemble.iter().map(|critic| critic.forward(&input)).collect();
    let norm = WEIGHTS.iter().map(|&w| f64::from(w).powi(2)).sum::<f64>().sqrt();
    let u = WEIGHTS.map(|w| f64::from(w) / norm);
    let mean = [0, 1, 2].map(|i| q.iter().map(|q| q[i]).sum::<f64>() / q.len() as f64);
    let covariance = |i: usize, j: usize| {
        q.iter().map(|q| (q[i] - mean[i]) * (q[j] - mean[j])).sum::<f64>() / q.len() as f64
    };
    let dot = |a: [f64; 3]| (0..3).map(|i| u[i] * a[i]).sum::<f64>();
    let bonus = match name {
        "cholesky" => {
            let mut low = [[0.0; 3]; 3];
            for i in 0..3 {
                for j in 0..=i {
                    let rest =
                        covariance(i, j) - (0..j).map(|m| low[i][m] * low[j][m]).sum::<f64>();
                    low[i][j] = if i == j { rest.sqrt() } else { rest / low[j][j] };
                }
            }
            dot([0, 1, 2].map(|i| (0..3).map(|j| low[i][j] * u[j]).sum())).max(0.0)
        }
        _ => dot([0, 1, 2].map(|i| (0..3).map(|j| covariance(i, j) * u[j]).sum())).sqrt(),
    };
    dot(mean) + beta * bonus
}

/// One exploring action, and the noise that went into it.
fn explore(
    rule: &mut Optimistic,
    (actor, critic): (&mut dyn Actor, &mut dyn Critic),
    obs: &[f32],
    seed: u64,
) -> (Vec<f32>, Vec<f32>) {
    let mut action = vec![0.0; actor.action_len()];
    let mut noise = vec![0.0; actor.action_len()];
    let mut rng = Rng::new(seed, Stream::Explore);
    let mut scratch = Scratch::default();
    rng.clone().fill_normal(&mut noise);
    // The learner's own projection is another one, to see whose bound is climbed.
    let own: &dyn Projection = &ScalarisedMin;
    let mut context = Context {
        step: 0,
        actor,
        critic,
        projection: own,
        weights: &WEIGHTS,
        rng: &mut rng,
        scratch: &mut scratch,
    };
    rule.act(&mut context, obs, &mut action).unwrap();
    (action, noise)
}

/// Every projection, optimism and observation that the policies are tried with.
fn trials(shift: f64) -> impl Iterator<Item = (&'static str, Optimism, u64)> {
    let rules = [("cholesky", 4.66), ("extremum", 4.66), ("cholesky", 0.0), ("extremum", 50.0)];
    rules.into_iter().flat_map(move |(name, beta)| {
        let optimism = Optimism { beta, shift, projection: Some(name.to_owned()), until: None };
        (0..6).map(move |seed| (name, optimism.clone(), seed))
    })
}

#[test]
fn a_deterministic_policy_moves_along_the_bounds_gradient() {
    let case = case();
    let std = 0.02;
    for (name, optimism, seed) in trials(6.86) {
        let [mut critic, _] = case.critics(3);
        let [mut actor, _] = case.actors(4);
        let obs = case.obs(seed);
        let critics = ensemble(critic.as_ref(), &case);
        let mode: Vec<f64> = {
            let mut mode = vec![0.0; 3];
            actor.mode(Net::Online, &obs, &mut mode).unwrap();
            mode.iter().map(|&a| a.into()).collect()
        };
        let beta = optimism.beta;
        let g = [0, 1, 2].map(|i| {
            let at = |by: f64| {
                let mut action = mode.clone();
                action[i] += by;
                upper_bound(&critics, name, beta, &obs, &action)
            };
            f64::from(slope(at))
        });
        let length = g.iter().map(|g| g * g).sum::<f64>().sqrt();
        let mut rule = Optimistic::new(optimism, std).unwrap();
        let (action, noise) = explore(&mut rule, (actor.as_mut(), critic.as_mut()), &obs, seed);
        let moved =
            |i: usize| mode[i] + f64::from(std) * (f64::from(noise[i]) + 6.86 * g[i] / length);
        let wanted: Vec<f32> = (0..3).map(|i| moved(i).clamp(-1.0, 1.0) as f32).collect();
        assert_close(&format!("{name}, beta {beta}, state {seed}"), &action, &wanted, 2e-4);
    }
}

#[test]
fn a_gaussian_policy_moves_in_the_units_of_its_own_covariance() {
    let case = case();
    for (name, optimism, seed) in trials(0.8) {
        let [mut critic, _] = case.critics(3);
        let [mut actor, _] = case.gaussians(4);
        let obs = case.obs(seed);
        let critics = ensemble(critic.as_ref(), &case);
        let policy = Reference::read(
            saved(actor.as_ref()).child("online").unwrap(),
            case.hidden.len() + 1,
            case.activation,
        );
        let output = policy.forward(&obs.iter().map(|&x| x.into()).collect::<Vec<_>>());
        let mean = &output[..3];
        let std = [0, 1, 2].map(|i| output[3 + i].exp());
        let beta = optimism.beta;
        // The gradient before the tanh.
        let g = [0, 1, 2].map(|i| {
            let at = |by: f64| {
                let nudged = |j: usize| (mean[j] + if i == j { by } else { 0.0 }).tanh();
                upper_bound(&critics, name, beta, &obs, &[nudged(0), nudged(1), nudged(2)])
            };
            f64::from(slope(at))
        });
        let length = (0..3).map(|i| (std[i] * g[i]).powi(2)).sum::<f64>().sqrt();
        let mut rule = Optimistic::new(optimism, 0.1).unwrap();
        let (action, noise) = explore(&mut rule, (actor.as_mut(), critic.as_mut()), &obs, seed);
        let moved = |i: usize| {
            mean[i] + 0.8 * std[i].powi(2) * g[i] / length + std[i] * f64::from(noise[i])
        };
        let wanted: Vec<f32> = (0..3).map(|i| moved(i).tanh() as f32).collect();
        assert_close(&format!("{name}, beta {beta}, state {seed}"), &action, &wanted, 2e-4);
        assert!(
            std[0] != std[1] && std[1] != std[2],
            "a covariance of equal entries would hide its absence"
        );
    }
}

/// delta, and an upper bound to move along.
fn optimism() -> impl Strategy<Value = (f64, Optimism)> {
    let name = prop::sample::select(copq::projection::names());
    (0.001..0.5f64, 0.0..10.0f64, name).prop_map(|(delta, beta, name)| {
        (
            delta,
            Optimism {
                beta,
                shift: (2.0 * delta).sqrt(),
                projection: Some(name.to_owned()),
                until: None,
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// KL(N(m + D, S) || N(m, S)) = D' S^-1 D / 2, whatever the policy, its covariance, the bound
    /// and the gradient.
    #[test]
    fn the_shifted_policys_divergence_is_the_bound(
        (delta, optimism) in optimism(),
        action in 1..=6usize,
        seed in 0..1000u64,
    ) {
        let case = Case { action, ..Case::new(5, 3, &[12, 9], 1) };
        let [mut critic, _] = case.critics(seed);
        let obs = case.obs(seed);
        let divergence = |moved: &mut dyn Iterator<Item = (f64, f64)>| {
            moved.map(|(by, std)| (by / std).powi(2)).sum::<f64>() / 2.0
        };

        let [mut actor, _] = case.actors(seed);
        let std = 0.05;
        let mut mode = vec![0.0; action];
        actor.mode(Net::Online, &obs, &mut mode).unwrap();
        let mut rule = Optimistic::new(optimism.clone(), std).unwrap();
        let (moved, noise) = explore(&mut rule, (actor.as_mut(), critic.as_mut()), &obs, seed);
        prop_assume!(moved.iter().all(|a| a.abs() < 1.0));
        let mut shifts =
            (0..action).map(|i| (f64::from(moved[i] - mode[i] - std * noise[i]), f64::from(std)));
        let got = divergence(&mut shifts);
        assert_abs_diff_eq!(got, delta, epsilon = 1e-3 * (delta + 0.01));

        let [mut actor, _] = case.gaussians(seed);
        let policy = Reference::read(
            saved(actor.as_ref()).child("online").unwrap(),
            case.hidden.len() + 1,
            case.activation,
        );
        let output = policy.forward(&obs.iter().map(|&x| x.into()).collect::<Vec<_>>());
        let mut rule = Optimistic::new(optimism, 0.1).unwrap();
        let (moved, noise) = explore(&mut rule, (actor.as_mut(), critic.as_mut()), &obs, seed);
        // Where the tanh is flat, single precision has forgotten what was before it.
        prop_assume!(moved.iter().all(|a| a.abs() < 0.98));
        let mut shifts = (0..action).map(|i| {
            let std = output[action + i].exp();
            (f64::from(moved[i]).atanh() - output[i] - std * f64::from(noise[i]), std)
        });
        let got = divergence(&mut shifts);
        assert_abs_diff_eq!(got, delta, epsilon = 1e-3 * (delta + 0.01));
    }
}

#[test]
fn a_projection_given_by_value_is_the_one_given_by_name() {
    let case = case();
    let [mut critic, _] = case.critics(3);
    let [mut actor, _] = case.actors(4);
    let mut act = |mut rule: Optimistic| {
        explore(&mut rule, (actor.as_mut(), critic.as_mut()), &case.obs(1), 1).0
    };
    let named = |name: &str| Optimism { projection: Some(name.to_owned()), ..Optimism::default() };
    let by_name = act(Optimistic::new(named("extremum"), 0.1).unwrap());
    assert_eq!(act(Optimistic::default().projection(Extremum)), by_name);
    assert_ne!(act(Optimistic::default().projection(Cholesky)), by_name);
    let error = Optimistic::new(named("extremun"), 0.1).unwrap_err().to_string();
    assert!(error.starts_with("unknown projection 'extremun'; known: extremum"), "{error}");
}
