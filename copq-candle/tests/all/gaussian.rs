//! The squashed Gaussian: log-probability and gradients against its definition in f64, fused
//! against plain.

use crate::common;

use common::reference::{Reference, slope};
use common::{Case, arrays, assert_close, normals, saved};
use copq::{Actor, Net, Sample, SampleGrad, State, Value};

fn cases() -> [Case; 4] {
    [
        Case::new(1, 1, &[5], 4),
        Case::new(1, 1, &[7, 9, 4], 3),
        Case::new(1, 1, &[16, 16], 9),
        Case { action: 17, ..Case::new(1, 1, &[7, 18], 3) },
    ]
}

/// Actions and log-probabilities from a network's output for one row, as the definition has them.
fn squashed(output: &[f64], noise: &[f32]) -> (Vec<f64>, f64) {
    let n = noise.len();
    let mut log_prob = 0.0;
    let action = (0..n).map(|j| {
        let std = output[n + j].clamp(-20.0, 2.0).exp();
        let noise = f64::from(noise[j]);
        let x = output[j] + std * noise;
        let density = (-0.5 * noise * noise).exp() / (std * std::f64::consts::TAU.sqrt());
        log_prob += density.ln() - (1.0 - x.tanh().powi(2)).ln();
        x.tanh()
    });
    (action.collect(), log_prob)
}

fn reference(actor: &dyn Actor, case: &Case) -> Reference {
    Reference::read(saved(actor).child("online").unwrap(), case.hidden.len() + 1, case.activation)
}

fn widened(case: &Case, obs: &[f32]) -> Vec<Vec<f64>> {
    obs.chunks_exact(case.observation).map(|row| row.iter().map(|&x| x.into()).collect()).collect()
}

fn sample(actor: &mut dyn Actor, case: &Case, seed: u64) -> (Vec<f32>, Vec<f32>) {
    let mut action = vec![0.0; case.rows * case.action];
    let mut log_prob = vec![0.0; case.rows];
    actor
        .sample(Net::Online, &case.obs(seed), &case.noise(seed), &mut action, &mut log_prob)
        .unwrap();
    (action, log_prob)
}

/// An update whose loss is sum(action * da) + sum(log_prob * dlog).
fn improve(actor: &mut dyn Actor, case: &Case, seed: u64, da: &[f32], dlog: &[f32]) {
    let grad = &mut |_: Sample<'_>, grad: SampleGrad<'_>| {
        grad.action.copy_from_slice(da);
        grad.log_prob.unwrap().copy_from_slice(dlog);
        Ok(())
    };
    actor.improve(&case.obs(seed), &case.noise(seed), grad).unwrap();
}

#[test]
fn samples_and_log_probabilities_are_the_definitions() {
    for case in cases() {
        for mut actor in case.gaussians(3) {
            let reference = reference(actor.as_ref(), &case);
            let (action, log_prob) = sample(actor.as_mut(), &case, 1);
            let noise = case.noise(1);
            let rows = widened(&case, &case.obs(1));
            let rows = rows.iter().zip(noise.chunks_exact(case.action));
            let wanted: Vec<_> =
                rows.map(|(row, noise)| squashed(&reference.forward(row), noise)).collect();
            let actions: Vec<f32> =
                wanted.iter().flat_map(|(action, _)| action).map(|&a| a as f32).collect();
            let log_probs: Vec<f32> = wanted.iter().map(|&(_, log_prob)| log_prob as f32).collect();
            assert_close("actions", &action, &actions, 1e-5);
            assert_close("log-probabilities", &log_prob, &log_probs, 1e-5);
        }
    }
}

#[test]
fn the_gradient_is_that_of_central_differences() {
    for case in cases() {
        let da = normals(6, case.rows * case.action);
        let dlog = normals(7, case.rows);
        for mut actor in case.gaussians(4) {
            let before = reference(actor.as_ref(), &case);
            improve(actor.as_mut(), &case, 2, &da, &dlog);
            let rows = widened(&case, &case.obs(2));
            let noise = case.noise(2);
            let wanted = before.gradient(|network| {
                let mut loss = 0.0;
                for (i, row) in rows.iter().enumerate() {
                    let at = i * case.action..(i + 1) * case.action;
                    let (action, log_prob) = squashed(&network.forward(row), &noise[at.clone()]);
                    loss += action.iter().zip(&da[at]).map(|(a, &d)| a * f64::from(d)).sum::<f64>();
                    loss += log_prob * f64::from(dlog[i]);
                }
                loss
            });
            let state = saved(actor.as_ref());
            for (i, wanted) in wanted.iter().enumerate() {
                let name = format!("layer.{}.{}", i / 2, ["weight", "bias"][i % 2]);
                let m = state.child("adam_m").unwrap().get::<f32>(&name).unwrap();
                // Adam's first moment after one step is a tenth of the gradient.
                let gradient: Vec<f32> = m.iter().map(|m| 10.0 * m).collect();
                assert_close(&format!("{name} of {case:?}"), &gradient, wanted, 2e-5);
            }
        }
    }
}

#[test]
fn the_noises_gradient_is_that_of_central_differences() {
    for case in cases() {
        let noise = case.noise(5);
        let da = normals(8, case.rows * case.action);
        for mut actor in case.gaussians(5) {
            let reference = reference(actor.as_ref(), &case);
            let rows = widened(&case, &case.obs(5));
            let mut got = vec![0.0; noise.len()];
            actor.noise_grad(&case.obs(5), &noise, &da, &mut got).unwrap();
            let action = |at: usize, by: f64| {
                let output = reference.forward(&rows[at / case.action]);
                let j = at % case.action;
                (output[j] + output[case.action + j].exp() * (f64::from(noise[at]) + by)).tanh()
            };
            let wanted: Vec<_> =
                (0..noise.len()).map(|at| da[at] * slope(|by| action(at, by))).collect();
            assert_close(&format!("{case:?}"), &got, &wanted, 1e-5);
        }
    }
}

#[test]
fn without_noise_it_acts_by_its_mode() {
    for case in cases() {
        for mut actor in case.gaussians(1) {
            let mut mode = vec![9.0; case.rows * case.action];
            let mut zero = vec![9.0; case.rows * case.action];
            let quiet = vec![0.0; mode.len()];
            let log_prob = &mut vec![0.0; case.rows];
            actor.mode(Net::Online, &case.obs(1), &mut mode).unwrap();
            actor.sample(Net::Online, &case.obs(1), &quiet, &mut zero, log_prob).unwrap();
            assert_close("mode", &mode, &zero, 1e-7);
            assert_eq!(actor.noise_len(), case.action);
        }
    }
}

/// Every number of a saved state, one after another.
fn numbers(state: &State) -> Vec<f32> {
    let values = arrays(state).into_iter();
    values
        .flat_map(|(_, value)| if let Value::F32(values) = value { values } else { vec![] })
        .collect()
}

#[test]
fn fused_equals_plain() {
    for case in Case::all() {
        let [mut fused, mut plain] = case.gaussians(2);
        assert_eq!(saved(fused.as_ref()), saved(plain.as_ref()));
        for i in 0..10 {
            let da = normals(60 + i, case.rows * case.action);
            let dlog = normals(90 + i, case.rows);
            for actor in [&mut fused, &mut plain] {
                improve(actor.as_mut(), &case, i, &da, &dlog);
                actor.update_target(0.1).unwrap();
            }
        }
        let [(action, log_prob), (wanted, wanted_log_prob)] =
            [sample(fused.as_mut(), &case, 9), sample(plain.as_mut(), &case, 9)];
        assert_close(&format!("actions of {case:?}"), &action, &wanted, 1e-4);
        assert_close(&format!("log-probabilities of {case:?}"), &log_prob, &wanted_log_prob, 1e-4);
        let [got, wanted] =
            [saved(fused.as_ref()), saved(plain.as_ref())].map(|state| numbers(&state));
        assert_close(&format!("state of {case:?}"), &got, &wanted, 1e-4);
    }
}

#[test]
fn a_checkpoint_goes_on_bit_for_bit_and_crosses_over() {
    let case = Case::new(1, 1, &[33, 17], 37);
    let da = normals(1, case.rows * case.action);
    let dlog = normals(2, case.rows);
    for (i, mut actor) in case.gaussians(1).into_iter().enumerate() {
        improve(actor.as_mut(), &case, 0, &da, &dlog);
        let half = saved(actor.as_ref());
        improve(actor.as_mut(), &case, 1, &da, &dlog);
        let mut others = case.gaussians(77);
        others[i].load(&half).unwrap();
        improve(others[i].as_mut(), &case, 1, &da, &dlog);
        assert_eq!(saved(others[i].as_ref()), saved(actor.as_ref()));
        others[1 - i].load(&half).unwrap();
        assert_eq!(saved(others[1 - i].as_ref()), half);
    }
}

#[test]
fn slices_are_checked() {
    let case = Case::new(1, 1, &[5], 7);
    let obs = case.obs(1);
    let noise = case.noise(1);
    let mut action = vec![0.0; 14];
    let mut log_prob = vec![0.0; 7];
    for mut actor in case.gaussians(1) {
        let mut sample = |noise: &[f32], log_prob: &mut [f32]| {
            actor.sample(Net::Online, &obs, noise, &mut action, log_prob).unwrap_err().to_string()
        };
        assert_eq!(sample(&noise[1..], &mut log_prob), "noise: wanted 14 values, got 13");
        assert_eq!(sample(&noise, &mut log_prob[1..]), "log-probabilities: wanted 7 values, got 6");
        assert_eq!(sample(&[], &mut log_prob), "noise: wanted 14 values, got 0");
        let refused = actor.improve(&obs, &[], &mut |_, _| Ok(()));
        assert_eq!(refused.unwrap_err().to_string(), "noise: wanted 14 values, got 0");
        let short = actor.noise_grad(&obs, &noise, &noise, &mut [0.0; 3]).unwrap_err().to_string();
        assert_eq!(short, "noise gradients: wanted 14 values, got 3");
    }
}
