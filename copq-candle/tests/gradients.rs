//! Every gradient against central differences of the same network written in f64.

mod common;

use common::{Case, assert_close, given, given_action, normals, saved};
use copq::State;

/// A multilayer perceptron in f64, straight from its definition.
#[derive(Clone)]
struct Reference {
    layers: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Reference {
    fn read(saved: &State, layers: usize) -> Self {
        let get = |name: String| saved.get::<f32>(&name).unwrap().iter().map(|&x| f64::from(x)).collect();
        let layer = |i| (get(format!("layer.{i}.weight")), get(format!("layer.{i}.bias")));
        Self { layers: (0..layers).map(layer).collect() }
    }

    fn forward(&self, input: &[f64]) -> Vec<f64> {
        let mut x = input.to_vec();
        for (i, (weight, bias)) in self.layers.iter().enumerate() {
            let dot = |row: &[f64]| row.iter().zip(&x).map(|(w, x)| w * x).sum::<f64>();
            let out = weight.chunks_exact(x.len()).zip(bias).map(|(row, b)| dot(row) + b);
            let last = i + 1 == self.layers.len();
            x = out.map(|y| if last { y } else { y.max(0.0) }).collect();
        }
        x
    }

    /// sum(grad * output) over a batch, the function whose gradients are asked for.
    fn loss(&self, rows: &[Vec<f64>], grad: &[f32], squash: fn(f64) -> f64) -> f64 {
        let outputs = rows.iter().flat_map(|row| self.forward(row));
        outputs.zip(grad).map(|(y, &g)| squash(y) * f64::from(g)).sum()
    }

    /// Central differences for every parameter, in the order of the saved arrays.
    fn parameter_gradient(&self, rows: &[Vec<f64>], grad: &[f32], squash: fn(f64) -> f64) -> Vec<Vec<f32>> {
        let mut out = Vec::new();
        for layer in 0..self.layers.len() {
            for bias in [false, true] {
                let len = if bias { self.layers[layer].1.len() } else { self.layers[layer].0.len() };
                let nudged = |i: usize, by: f64| {
                    let mut copy = self.clone();
                    let (weights, biases) = &mut copy.layers[layer];
                    (if bias { biases } else { weights })[i] += by;
                    copy.loss(rows, grad, squash)
                };
                out.push((0..len).map(|i| slope(|by| nudged(i, by))).collect());
            }
        }
        out
    }
}

fn slope(f: impl Fn(f64) -> f64) -> f32 {
    const STEP: f64 = 1e-6;
    ((f(STEP) - f(-STEP)) / (2.0 * STEP)) as f32
}

fn rows(case: &Case, obs: &[f32], act: &[f32]) -> Vec<Vec<f64>> {
    let pairs = obs.chunks_exact(case.observation).zip(act.chunks_exact(case.action));
    pairs.map(|(obs, act)| obs.iter().chain(act).map(|&x| f64::from(x)).collect()).collect()
}

/// Adam's first moment after one step is a tenth of the gradient.
fn assert_moments(what: &str, saved: &State, wanted: &[Vec<f32>]) {
    for (i, wanted) in wanted.iter().enumerate() {
        let name = format!("layer.{}.{}", i / 2, ["weight", "bias"][i % 2]);
        let m: Vec<f32> = saved.child("adam_m").unwrap().get::<f32>(&name).unwrap().iter().map(|m| m * 10.0).collect();
        assert_close(&format!("{what} {name}"), &m, wanted, 1e-5);
    }
}

fn cases() -> [Case; 3] {
    [Case::new(2, 3, &[5], 4), Case::new(3, 2, &[7, 9, 4], 3), Case::new(1, 1, &[16, 16], 9)]
}

#[test]
fn critics_parameters() {
    for case in cases() {
        let (obs, act, dq) = (case.obs(1), case.act(1), normals(2, case.q_len()));
        for mut critic in case.critics(8) {
            let before = saved(critic.as_ref());
            critic.fit(&obs, &act, &mut given(&dq)).unwrap();
            let after = saved(critic.as_ref());
            for (k, dq) in dq.chunks_exact(case.rows * case.objectives).enumerate() {
                let name = format!("critic.{k}");
                let online = before.child(&name).unwrap().child("online").unwrap();
                let wanted = Reference::read(online, case.hidden.len() + 1).parameter_gradient(
                    &rows(&case, &obs, &act),
                    dq,
                    |y| y,
                );
                assert_moments(&format!("{name} of {case:?}"), after.child(&name).unwrap(), &wanted);
            }
        }
    }
}

#[test]
fn critics_actions() {
    for case in cases() {
        let (obs, act, dq) = (case.obs(3), case.act(3), normals(4, case.q_len()));
        for mut critic in case.critics(9) {
            let mut got = vec![0.0; act.len()];
            critic.action_grad(&obs, &act, &mut given(&dq), &mut got).unwrap();
            let state = saved(critic.as_ref());
            let ensemble: Vec<_> = (0..case.critics)
                .map(|k| state.child(&format!("critic.{k}")).unwrap().child("online").unwrap())
                .map(|online| Reference::read(online, case.hidden.len() + 1))
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
        let (obs, da) = (case.obs(5), normals(6, case.rows * case.action));
        let rows: Vec<Vec<f64>> =
            obs.chunks_exact(case.observation).map(|row| row.iter().map(|&x| f64::from(x)).collect()).collect();
        for mut actor in case.actors(10) {
            let before = saved(actor.as_ref());
            actor.improve(&obs, &[], &mut given_action(&da)).unwrap();
            let reference = Reference::read(before.child("online").unwrap(), case.hidden.len() + 1);
            assert_moments(
                &format!("{case:?}"),
                &saved(actor.as_ref()),
                &reference.parameter_gradient(&rows, &da, f64::tanh),
            );
        }
    }
}
