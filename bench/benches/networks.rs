//! What the passes of the networks cost, in the fused and in the plain implementation: 4 critics
//! and an actor of walker2d's shapes, batches of 256 rows, and acting on a single row.
//!
//! `cargo bench -p copq-bench --bench networks`; to run only some, add `-- fit`. An item is a
//! floating-point operation of a matrix product, so "Gitem/s" are GFLOP/s.

use copq::{
    Activation, Actor, ActorKind, Backend, Critic, EnvSpec, Net, Networks, Normaliser, Policy,
    QView, Result, Rng, Sample, SampleGrad, State, Stream,
};
use copq_bench::workload::{Inputs, Workload};
use copq_candle::{Candle, Device, fused, plain};
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
        _ => Box::new(fused::Critics::new(&spec, w.critics, &networks, &mut rng).unwrap()),
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
        _ => Box::new(fused::Deterministic::new(&spec, &networks, &mut rng).unwrap()),
    }
}

/// Operations of a forward pass of `rows` through layers of these widths.
fn operations(rows: usize, widths: [usize; 4]) -> usize {
    2 * rows * widths.windows(2).map(|pair| pair[0] * pair[1]).sum::<usize>()
}

/// Operations of the critics' forward pass, which their weights' gradients also take, and of the
/// backward pass to the hidden layers.
fn critics_operations() -> (usize, usize) {
    let Workload { observation, action, width, objectives, rows, critics, .. } = workload();
    let forward = operations(rows, [observation + action, width, width, objectives]);
    let hidden = 2 * rows * width * (width + objectives);
    (critics * forward, critics * hidden)
}

/// The same gradient for every value.
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

/// The fused critics' fit with each activation. A smooth one costs a pass over every hidden layer,
/// forward and backward.
#[divan::bench(args = [Activation::Relu, Activation::Tanh, Activation::Silu])]
fn fit_with(bencher: Bencher<'_, '_>, activation: Activation) {
    let w = workload();
    let mut rng = Rng::new(0, Stream::Init);
    let networks = Networks { activation, ..w.networks() };
    let mut critic = fused::Critics::new(&w.spec(), w.critics, &networks, &mut rng).unwrap();
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

/// A policy of two hidden layers of 256 for the hopper's 11 numbers, with a normaliser.
fn policy(kind: ActorKind) -> Policy {
    let spec = EnvSpec::new("hopper", 11, 3).reward("safety", 1.0);
    let networks = Networks::default();
    let backend = Candle::default();
    let mut rng = Rng::new(0, Stream::Init);
    let mut normaliser = Normaliser::new(11);
    let mut obs = [0.0; 11];
    for _ in 0..100 {
        rng.fill_normal(&mut obs);
        normaliser.push(&obs).unwrap();
    }
    let mut saved = State::default();
    saved.child_mut("made_by").put_text("task", "hopper");
    saved.child_mut("made_by").put_text("method", "none");
    let actor = backend.actor(&spec, &networks, kind, &mut rng).unwrap();
    actor.save(saved.child_mut("actor")).unwrap();
    normaliser.save(saved.child_mut("normaliser"));
    Policy::load(&saved, &spec, &networks, kind, &backend).unwrap()
}

/// What a robot waits for: one action from a whole policy, including normaliser and scaling.
#[divan::bench(args = [ActorKind::Deterministic, ActorKind::Gaussian, ActorKind::Normal])]
fn act_by_policy(bencher: Bencher<'_, '_>, kind: ActorKind) {
    let mut policy = policy(kind);
    let obs = [0.3; 11];
    let mut action = [0.0; 3];
    bencher.counter(ItemsCount::new(operations(1, [11, 256, 256, 3]))).bench_local(|| {
        policy.act(&obs, &mut action).unwrap();
        policy.scale(&mut action).unwrap();
    });
}
