//! What is written comes back, and nothing else is believed.

use std::path::Path;

use candle_nn::{Module, VarBuilder, linear};
use copq::{
    Activation, ActorKind, EnvSpec, Learner, Method, Networks, Normaliser, Policy, Result, Rng,
    State, Stream, on_policy,
};
use copq_candle::{Candle, Modules};

use super::*;

fn spec() -> EnvSpec {
    let bounds: [&[f32]; 2] = [&[-1.0, -0.25], &[1.0, 3.0]];
    let spec = EnvSpec::new("arm", 3, 2).action_bounds(bounds[0], bounds[1]);
    spec.cost("heat", 5.0).reward("progress", 1.0)
}

/// The content of a small policy's file.
fn policy(kind: ActorKind, activation: Activation) -> State {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    let networks = Networks { hidden: vec![5, 4], activation, ..Networks::default() };
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
    State::read_file(path).unwrap()
}

/// The same with a normaliser that has seen so many observations, and leaves the last components.
fn with_normaliser(mut policy: State, seen: usize, raw: usize) -> State {
    let mut rng = Rng::new(0, Stream::Evaluation);
    let mut normaliser = Normaliser::new(3 - raw).and_raw(raw);
    for _ in 0..seen {
        let noise = [(); 3].map(|()| (rng.next_u64() % 1_000) as f32 / 7.0);
        normaliser.push(&noise).unwrap();
    }
    policy.remove_child("normaliser");
    normaliser.save(policy.child_mut("normaliser"));
    policy
}

/// Policies of every kind, activation and normaliser.
fn policies() -> Vec<State> {
    let mut policies = Vec::new();
    for kind in [ActorKind::Deterministic, ActorKind::Gaussian, ActorKind::Normal] {
        for activation in [Activation::Relu, Activation::Tanh, Activation::Silu] {
            let policy = policy(kind, activation);
            policies.push(with_normaliser(policy.clone(), 0, 0));
            policies.push(with_normaliser(policy.clone(), 1, 0));
            policies.push(with_normaliser(policy.clone(), 40, 1));
            policies.push(with_normaliser(policy.clone(), 40, 0));
            policies.push(policy);
        }
    }
    policies
}

fn decoded(bytes: &[u8]) -> Result<State> {
    read::decode(Path::new("a.onnx"), bytes)
}

#[test]
fn everything_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.ONNX");
    for state in policies() {
        let policy = Policy::from_state(&state, &Candle::default()).unwrap();
        assert_eq!(policy.to_state().unwrap(), state);
        write_onnx(&policy, &path).unwrap();
        let read = read_policy(&path).unwrap();
        assert_eq!(read, state);
        // Bits, not values: a -0 is not a 0 here.
        let files = ["a", "b"].map(|name| folder.path().join(name));
        read.write_file(&files[0]).unwrap();
        state.write_file(&files[1]).unwrap();
        assert!(std::fs::read(&files[0]).unwrap() == std::fs::read(&files[1]).unwrap());
    }
}

#[test]
fn a_policy_of_an_older_version_comes_back_too() {
    let mut state = policy(ActorKind::Deterministic, Activation::Relu);
    let about = state.remove_child("policy").unwrap();
    for (name, value) in about.values().filter(|(name, _)| !["method", "objectives"].contains(name))
    {
        state.child_mut("policy").put_value(name, &[], value.clone());
    }
    assert_eq!(decoded(&encode(&state).unwrap()).unwrap(), state);
    let policy = Policy::from_state(&state, &Candle::default()).unwrap();
    assert_eq!((policy.method(), policy.objectives()), (None, [].as_slice()));
    assert_eq!(policy.to_state().unwrap(), state);
}

/// Every bit turned and every beginning of a file: each is an error that names the file.
#[test]
fn no_damage_is_believed() {
    let state = with_normaliser(policy(ActorKind::Normal, Activation::Tanh), 40, 1);
    let sound = encode(&state).unwrap();
    for length in 0..sound.len() {
        let error = decoded(&sound[..length]).unwrap_err().to_string();
        assert!(error.contains("a.onnx"), "{length}: {error}");
    }
    for bit in 0..8 * sound.len() {
        let mut damaged = sound.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let error = decoded(&damaged).unwrap_err().to_string();
        assert!(error.contains("a.onnx"), "{bit}: {error}");
    }
}

/// Whoever gives a damaged file a new checksum gets an error, or some other policy, but no panic.
#[test]
fn what_is_signed_anew_is_an_error_or_a_policy() {
    let state = with_normaliser(policy(ActorKind::Gaussian, Activation::Silu), 40, 1);
    let sound = encode(&state).unwrap();
    let body = &sound[..sound.len() - with_checksum(Vec::new()).len()];
    let mut policies = 0;
    for bit in 0..8 * body.len() {
        let mut damaged = body.to_vec();
        damaged[bit / 8] ^= 1 << (bit % 8);
        let read = decoded(&with_checksum(damaged));
        policies += usize::from(
            read.and_then(|state| Policy::from_state(&state, &Candle::default())).is_ok(),
        );
    }
    assert!(policies > 0, "weights may be any numbers");
}

#[test]
fn what_is_not_ours_is_named() {
    let said = |bytes: &[u8]| decoded(bytes).unwrap_err().to_string();
    let foreign = Model {
        ir_version: 9,
        producer_name: "pytorch".to_owned(),
        graph: Some(messages::Graph { name: "main_graph".to_owned(), ..Default::default() }),
        ..Model::default()
    };
    let wanted = "producer of the ONNX file 'a.onnx': wanted copq (only its own policies can \
                  be read back), got";
    assert_eq!(said(&foreign.encode_to_vec()), format!("{wanted} pytorch"));
    assert_eq!(said(&[]), format!("{wanted} none"));
    let empty = Model { producer_name: PRODUCER.to_owned(), ..Model::default() };
    let error = said(&with_checksum(empty.encode_to_vec()));
    assert!(error.starts_with("the ONNX file 'a.onnx': unknown entry"), "{error}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("renamed.onnx");
    policy(ActorKind::Gaussian, Activation::Relu).write_file(&path).unwrap();
    let error = read_policy(&path).unwrap_err().to_string();
    assert!(error.contains("as ONNX (is it damaged?)"), "{error}");
    let error = read_policy(folder.path().join("none.onnx")).unwrap_err().to_string();
    assert!(error.contains("reading '"), "{error}");
}

/// A network of someone's own.
fn module(
    vars: VarBuilder<'_>,
    input: usize,
    output: usize,
) -> candle_core::Result<Box<dyn Module + Send>> {
    Ok(Box::new(linear(input, output, vars.pp("only"))?))
}

#[test]
fn modules_of_ones_own_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy");
    let backend = Modules::with_critics(module).with_actor(module);
    let mut method = Method::cop_td3();
    method.config.networks.hidden = vec![5];
    Learner::new(method, &spec(), &backend, 0).unwrap().save_policy(&path).unwrap();
    let policy = Policy::read(&path, &backend).unwrap();
    let onnx = folder.path().join("policy.onnx");
    let error = write_onnx(&policy, &onnx).unwrap_err().to_string();
    assert_eq!(
        error,
        "the policy's network, for export to ONNX: wanted copq's own layers, layer.0.bias [5], \
         layer.0.weight [5, 3], layer.1.bias [2], layer.1.weight [2, 5], got different arrays, \
         only.bias [2], only.weight [2, 3] (are they from your own modules?)"
    );
    assert!(!onnx.exists());
}
