//! What the passes of the networks cost, with the fused implementation and with the plain one: 4
//! critics and an actor of walker2d's shapes, batches of 256 rows, and acting on one.
//!
//! `cargo bench -p copq-bench --bench networks`; a filter picks some: `-- fit`. An item is a
//! floating-point operation of a matrix product, so "Gitem/s" are GFLOP/s.

use copq::{
    Activation, Actor, Critic, Net, Networks, QView, Result, Rng, Sample, SampleGrad, Stream,
};
use copq_bench::workload::{Inputs, Workload};
use copq_candle::{Device, plain};
use divan::Bencher;
use divan::counter::ItemsCount;

const IMPLEMENTATIONS: [&str; 2] = ["fused", "plain"];

fn main() {
    divan::main();
}

fn workload() -> Workload {
    Workload::named("walker2d", 1).unwrap()
}

fn critic(implementation: &str) -> Box<dyn Critic> {
    let w = workload();
    let mut rng = Rng::new(0, Stream::Init);
    let spec = w.spec();
    let networks = w.networks();
    match implementation {
        "plain" => Box::new(
            plain::Critics::new(&spec, w.critics, &networks, &mut rng, &Device::Cpu).unwrap(),
        ),
        _ => Box::new(copq_candle::critic(&spec, w.critics, &networks, &mut rng).unwrap()),
    }
}

fn actor(implementation: &str) -> Box<dyn Actor> {
    let w = workload();
    let mut rng = Rng::new(0, Stream::Init);
    let spec = w.spec();
    let networks = w.networks();
    match implementation {
        "plain" => {
            Box::new(plain::Deterministic::new(&spec, &networks, &mut rng, &Device::Cpu).unwrap())
        }
        _ => Box::new(copq_candle::actor(&spec, &networks, &mut rng).unwrap()),
    }
}

/// Operations of `rows` going forward through layers of these widths.
fn operations(rows: usize, widths: [usize; 4]) -> usize {
    2 * rows * widths.windows(2).map(|pair| pair[0] * pair[1]).sum::<usize>()
}

/// Operations of the critics going forward, which their weights' gradients take as well, and going
/// back to the hidden layers.
fn critics_operations() -> (usize, usize) {
    let Workload { observation, action, width, objectives, rows, critics, .. } = workload();
    let forward = operations(rows, [observation + action, width, width, objectives]);
    let hidden = 2 * rows * width * (width + objectives);
    (critics * forward, critics * hidden)
}

/// As large a gradient for every value.
fn fill(_: QView<'_>, grad: &mut [f32]) -> Result<()> {
    grad.fill(1e-3);
    Ok(())
}

#[divan::bench(args = IMPLEMENTATIONS)]
fn values(bencher: Bencher<'_, '_>, implementation: &str) {
    let w = workload();
    let mut critic = critic(implementation);
    let Inputs { obs, action, .. } = w.batch();
    let mut q = vec![0.0; w.critics * w.rows * w.objectives];
    bencher
        .counter(ItemsCount::new(critics_operations().0))
        .bench_local(|| critic.values(Net::Target, &obs, &action, &mut q).unwrap());
}

#[divan::bench(args = IMPLEMENTATIONS)]
fn fit(bencher: Bencher<'_, '_>, implementation: &str) {
    let Inputs { obs, action, .. } = workload().batch();
    let mut critic = critic(implementation);
    let (forward, hidden) = critics_operations();
    bencher
        .counter(ItemsCount::new(2 * forward + hidden))
        .bench_local(|| critic.fit(&obs, &action, &mut fill, 0.005).unwrap());
}

/// The fused critics' fit with another activation; a smooth one costs a pass over every hidden
/// layer, forward and back.
#[divan::bench(args = [Activation::Relu, Activation::Tanh, Activation::Silu])]
fn fit_with(bencher: Bencher<'_, '_>, activation: Activation) {
    let w = workload();
    let mut rng = Rng::new(0, Stream::Init);
    let networks = Networks { activation, ..w.networks() };
    let mut critic = copq_candle::critic(&w.spec(), w.critics, &networks, &mut rng).unwrap();
    let Inputs { obs, action, .. } = w.batch();
    let (forward, hidden) = critics_operations();
    bencher
        .counter(ItemsCount::new(2 * forward + hidden))
        .bench_local(|| critic.fit(&obs, &action, &mut fill, 0.005).unwrap());
}

#[divan::bench(args = IMPLEMENTATIONS)]
fn action_grad(bencher: Bencher<'_, '_>, implementation: &str) {
    let w = workload();
    let mut critic = critic(implementation);
    let Inputs { obs, action, .. } = w.batch();
    let (forward, hidden) = critics_operations();
    let to_actions = 2 * w.critics * w.rows * w.width * w.action;
    let mut out = action.clone();
    bencher
        .counter(ItemsCount::new(forward + hidden + to_actions))
        .bench_local(|| critic.action_grad(&obs, &action, &mut fill, &mut out).unwrap());
}

#[divan::bench(args = IMPLEMENTATIONS)]
fn improve(bencher: Bencher<'_, '_>, implementation: &str) {
    let w = workload();
    let mut actor = actor(implementation);
    let forward = operations(w.rows, [w.observation, w.width, w.width, w.action]);
    let hidden = 2 * w.rows * w.width * (w.width + w.action);
    let batch = w.batch();
    let grad = &mut |_: Sample<'_>, grad: SampleGrad<'_>| {
        grad.action.fill(1e-3);
        Ok(())
    };
    bencher
        .counter(ItemsCount::new(2 * forward + hidden))
        .bench_local(|| actor.improve(&batch.obs, &[], grad).unwrap());
}

#[divan::bench(args = IMPLEMENTATIONS)]
fn act(bencher: Bencher<'_, '_>, implementation: &str) {
    let w = workload();
    let mut actor = actor(implementation);
    let batch = w.batch();
    let mut action = vec![0.0; w.action];
    let obs = &batch.obs[..w.observation];
    bencher
        .counter(ItemsCount::new(operations(1, [w.observation, w.width, w.width, w.action])))
        .bench_local(|| actor.mode(Net::Online, obs, &mut action).unwrap());
}
