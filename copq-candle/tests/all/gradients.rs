//! Every gradient against central differences of the same network written in f64.

use crate::common;

use common::reference::{Reference, slope};
use common::{Case, assert_close, given, given_action, normals, saved};
use copq::{Activation, State};

fn rows(case: &Case, obs: &[f32], act: &[f32]) -> Vec<Vec<f64>> {
    let pairs = obs.chunks_exact(case.observation).zip(act.chunks_exact(case.action));
    pairs.map(|(obs, act)| obs.iter().chain(act).map(|&x| f64::from(x)).collect()).collect()
}

/// Adam's first moment after one step is a tenth of the gradient.
fn assert_moments(what: &str, saved: &State, wanted: &[Vec<f32>]) {
    for (i, wanted) in wanted.iter().enumerate() {
        let name = format!("layer.{}.{}", i / 2, ["weight", "bias"][i % 2]);
        let m: Vec<f32> = saved
            .child("adam_m")
            .unwrap()
            .get::<f32>(&name)
            .unwrap()
            .iter()
            .map(|m| m * 10.0)
            .collect();
        assert_close(&format!("{what} {name}"), &m, wanted, 1e-5);
    }
}

fn cases() -> [Case; 6] {
    [
        Case::new(2, 3, &[5], 4),
        Case::new(3, 2, &[7, 9, 4], 3),
        Case::new(1, 1, &[16, 16], 9),
        Case { action: 17, ..Case::new(1, 17, &[7, 18], 5) },
        Case { activation: Activation::Tanh, ..Case::new(2, 2, &[7, 18], 5) },
        Case { activation: Activation::Silu, ..Case::new(2, 2, &[7, 18], 5) },
    ]
}

#[test]
fn critics_parameters() {
    for case in cases() {
        let obs = case.obs(1);
        let act = case.act(1);
        let dq = normals(2, case.q_len());
        for mut critic in case.critics(8) {
            let before = saved(critic.as_ref());
            critic.fit(&obs, &act, &mut given(&dq), 0.0).unwrap();
            let after = saved(critic.as_ref());
            for (k, dq) in dq.chunks_exact(case.rows * case.objectives).enumerate() {
                let name = format!("critic.{k}");
                let online = before.child(&name).unwrap().child("online").unwrap();
                let wanted = Reference::read(online, case.hidden.len() + 1, case.activation)
                    .parameter_gradient(&rows(&case, &obs, &act), dq, |y| y);
                assert_moments(
                    &format!("{name} of {case:?}"),
                    after.child(&name).unwrap(),
                    &wanted,
                );
            }
        }
    }
}

#[test]
fn critics_actions() {
    for case in cases() {
        let obs = case.obs(3);
        let act = case.act(3);
        let dq = normals(4, case.q_len());
        for mut critic in case.critics(9) {
            let mut got = vec![0.0; act.len()];
            critic.action_grad(&obs, &act, &mut given(&dq), &mut got).unwrap();
            let state = saved(critic.as_ref());
            let ensemble: Vec<_> = (0..case.critics)
                .map(|k| state.child(&format!("critic.{k}")).unwrap().child("online").unwrap())
                .map(|online| Reference::read(online, case.hidden.len() + 1, case.activation))
                .collect();
            let loss = |i: usize, by: f64| {
                let mut rows = rows(&case, &obs, &act);
                rows[i / case.action][case.observation + i % case.action] += by;
                let shares = dq.chunks_exact(case.rows * case.objectives);
                ensemble.iter().zip(shares).map(|(critic, dq)| critic.loss(&rows, dq, |y| y)).sum()
            };
            let wanted: Vec<_> = (0..act.len()).map(|i| slope(|by| loss(i, by))).collect();
            assert_close(&format!("{case:?}"), &got, &wanted, 1e-5);
        }
    }
}

#[test]
fn actors_parameters() {
    for case in cases() {
        let obs = case.obs(5);
        let da = normals(6, case.rows * case.action);
        let rows: Vec<Vec<f64>> = obs
            .chunks_exact(case.observation)
            .map(|row| row.iter().map(|&x| f64::from(x)).collect())
            .collect();
        for mut actor in case.actors(10) {
            let before = saved(actor.as_ref());
            actor.improve(&obs, &[], &mut given_action(&da)).unwrap();
            let reference = Reference::read(
                before.child("online").unwrap(),
                case.hidden.len() + 1,
                case.activation,
            );
            assert_moments(
                &format!("{case:?}"),
                &saved(actor.as_ref()),
                &reference.parameter_gradient(&rows, &da, f64::tanh),
            );
        }
    }
}
