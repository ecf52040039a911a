//! Policies in onnxruntime do what they do in Rust.

use std::path::Path;

use copq::{
    Activation, ActorKind, Backend, EnvSpec, Learner, Method, Net, Networks, Normaliser, Policy,
    Rng, State, on_policy,
};
use copq_candle::Candle;
use copq_experiments::{read_policy, write_onnx};

use crate::python::{python, run};

const OBS: usize = 11;
const ROWS: usize = 10_000;

fn spec() -> EnvSpec {
    let spec = EnvSpec::new("arm", OBS, 3);
    spec.action_bounds(&[-1.0, -0.4, 0.1], &[1.0, 2.0, 0.3]).reward("progress", 1.0)
}

/// The content of a fresh policy's file, its last layer's weights larger, so that actions come to
/// their ends.
fn policy(kind: ActorKind, activation: Activation, hidden: &[usize]) -> State {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy");
    let networks = Networks { hidden: hidden.to_vec(), activation, ..Networks::default() };
    if kind == ActorKind::Normal {
        let mut method = on_policy::Method::ppo();
        method.config.networks = networks;
        let learner = on_policy::Learner::new(method, &spec(), &Candle::default(), 1).unwrap();
        learner.save_policy(&path).unwrap();
    } else {
        let mut method =
            if kind == ActorKind::Gaussian { Method::sac() } else { Method::cop_td3() };
        method.config.networks = networks;
        let learner = Learner::new(method, &spec(), &Candle::default(), 1).unwrap();
        learner.save_policy(&path).unwrap();
    }
    let mut state = State::read_file(path).unwrap();
    state.remove_child("normaliser");
    let name = format!("layer.{}.weight", hidden.len());
    let actor = state.child_mut("actor");
    let weight: Vec<f32> =
        actor.get(&name).unwrap().iter().map(|weight: &f32| 4.0 * weight).collect();
    let dims = actor.shape(&name).unwrap().to_vec();
    actor.put_shaped(&name, &dims, weight);
    if kind == ActorKind::Normal {
        actor.put("log_std", [-0.5f32, 0.0, 0.25]);
    }
    state
}

/// What a normaliser has seen, or is to see: components of different sizes and centres, the first
/// one nearly still.
fn observations(rows: usize, rng: &mut Rng) -> Vec<f32> {
    let mut obs = vec![0.0; rows * OBS];
    rng.fill_normal(&mut obs);
    for row in obs.chunks_exact_mut(OBS) {
        for (i, x) in row.iter_mut().enumerate() {
            let size = if i == 0 { 1e-3 } else { 0.3 * i as f32 };
            *x = *x * size + i as f32 - 5.0;
        }
    }
    obs
}

fn with_normaliser(mut policy: State, seen: usize, raw: usize, rng: &mut Rng) -> State {
    let mut normaliser = Normaliser::new(OBS - raw).and_raw(raw);
    for obs in observations(seen, rng).chunks_exact(OBS) {
        normaliser.push(obs).unwrap();
    }
    normaliser.save(policy.child_mut("normaliser"));
    policy
}

/// Actions in the environment's own units.
fn actions(policy: &mut Policy, obs: &[f32]) -> Vec<f32> {
    let mut actions = vec![0.0; obs.len() / OBS * 3];
    policy.act(obs, &mut actions).unwrap();
    for action in actions.chunks_exact_mut(3) {
        policy.scale(action).unwrap();
    }
    actions
}

/// Samples of a stochastic policy for given noise: squashed, or as they are stored.
fn samples(state: &State, kind: ActorKind, obs: &[f32], noise: &[f32]) -> Vec<f32> {
    let mut seen = obs.to_vec();
    if let Ok(saved) = state.child("normaliser") {
        let raw = saved.get_one::<u64>("raw").unwrap_or(0) as usize;
        let mut normaliser = Normaliser::new(OBS - raw).and_raw(raw);
        normaliser.load(saved).unwrap();
        normaliser.normalise(&mut seen).unwrap();
    }
    let about = state.child("policy").unwrap();
    let networks = Networks {
        hidden: about.get::<u64>("hidden").unwrap().iter().map(|&width| width as usize).collect(),
        activation: match about.get_text("activation").unwrap() {
            "tanh" => Activation::Tanh,
            "silu" => Activation::Silu,
            _ => Activation::Relu,
        },
        ..Networks::default()
    };
    let mut rng = Rng::with_stream(0, 101);
    let mut samples = vec![0.0; noise.len()];
    if kind == ActorKind::Gaussian {
        let mut actor = Candle::default().actor(&spec(), &networks, kind, &mut rng).unwrap();
        actor.import(state.child("actor").unwrap()).unwrap();
        let mut log_prob = vec![0.0; noise.len() / 3];
        actor.sample(Net::Online, &seen, noise, &mut samples, &mut log_prob).unwrap();
        return samples;
    }
    let mut actor = Candle::default().policy(&spec(), &networks, &mut rng).unwrap();
    actor.import(state.child("actor").unwrap()).unwrap();
    actor.means(&seen, &mut samples).unwrap();
    for (row, noise) in samples.chunks_exact_mut(3).zip(noise.chunks_exact(3)) {
        for ((x, noise), log_std) in row.iter_mut().zip(noise).zip(actor.log_std()) {
            *x += log_std.exp() * noise;
        }
    }
    samples
}

/// Leaves a policy's ONNX file, and what Rust makes of some observations.
fn write(folder: &Path, name: &str, state: &State, kind: ActorKind, rng: &mut Rng) {
    let path = folder.join(name).with_extension("onnx");
    let mut policy = Policy::from_state(state, &Candle::default()).unwrap();
    write_onnx(&policy, &path).unwrap();
    assert_eq!(read_policy(&path).unwrap(), *state);

    let mut obs = vec![0.0; ROWS * OBS];
    rng.fill_normal(&mut obs);
    let count = state.child("normaliser").and_then(|saved| saved.get_one::<u64>("count"));
    if count.unwrap_or(0) > 1 {
        obs = observations(ROWS, rng);
    }
    let far_obs: Vec<f32> = obs[..200 * OBS].iter().map(|x| 100.0 * x).collect();
    let mut rust = State::default();
    rust.put_shaped("action", &[ROWS, 3], actions(&mut policy, &obs));
    rust.put_shaped("far_action", &[200, 3], actions(&mut policy, &far_obs));
    rust.put("low", spec().action_low);
    rust.put("high", spec().action_high);
    if kind != ActorKind::Deterministic {
        let mut noise = vec![0.0; 3 * ROWS];
        rng.fill_normal(&mut noise);
        rust.put_shaped("sample", &[ROWS, 3], samples(state, kind, &obs, &noise));
        rust.put_shaped("noise", &[ROWS, 3], noise);
        rust.put("is_squashed", [u8::from(kind == ActorKind::Gaussian)]);
    }
    rust.put_shaped("obs", &[ROWS, OBS], obs);
    rust.put_shaped("far_obs", &[200, OBS], far_obs);
    rust.write_file(path.with_extension("safetensors")).unwrap();
}

#[test]
fn onnxruntime_does_what_rust_does() {
    let Some(python) = python("ONNX against Rust") else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut rng = Rng::with_stream(7, 101);
    for (kind, name) in [
        (ActorKind::Deterministic, "deterministic"),
        (ActorKind::Gaussian, "gaussian"),
        (ActorKind::Normal, "normal"),
    ] {
        for activation in [Activation::Relu, Activation::Tanh, Activation::Silu] {
            let plain = policy(kind, activation, &[32, 24]);
            let normalised = with_normaliser(plain.clone(), 300, 0, &mut rng);
            let with_raw = with_normaliser(plain.clone(), 300, 2, &mut rng);
            for (state, words) in [(plain, "plain"), (normalised, "normed"), (with_raw, "raw")] {
                let name = format!("{name}-{activation:?}-{words}");
                write(folder.path(), &name, &state, kind, &mut rng);
            }
        }
        // What a run begins with, and the usual widths.
        let fresh = with_normaliser(policy(kind, Activation::Relu, &[8]), 1, 0, &mut rng);
        write(folder.path(), &format!("{name}-fresh"), &fresh, kind, &mut rng);
        let wide = with_normaliser(policy(kind, Activation::Relu, &[256, 256]), 300, 0, &mut rng);
        write(folder.path(), &format!("{name}-wide"), &wide, kind, &mut rng);
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/onnx/compare.py");
    let said = run(&python, &script, folder.path());
    assert!(said.ends_with("33 policies agree\n"), "{said}");
}
