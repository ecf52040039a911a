//! Ten TD3-like updates against the numbers PyTorch got from the same weights and batches
//! (`data/make_reference.py`).

use crate::common;

use std::path::PathBuf;

use common::{Case, assert_close};
use copq::{Activation, Actor, Critic, EnvSpec, Net, Networks, State};
use copq_candle::{Device, fused, plain};
use safetensors::SafeTensors;
use serde_json::Value;

fn data(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/data", name].iter().collect()
}

fn numbers(value: &Value, name: &str) -> Vec<f32> {
    value[name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap() as f32).collect()
}

struct Reference(Value);

impl Reference {
    fn read() -> Self {
        Self(
            serde_json::from_str(&std::fs::read_to_string(data("reference.json")).unwrap())
                .unwrap(),
        )
    }

    fn number(&self, name: &str) -> f64 {
        self.0[name].as_f64().unwrap()
    }

    fn case(&self) -> Case {
        let size = |name| self.number(name) as usize;
        Case {
            observation: size("observation"),
            action: size("action"),
            objectives: size("objectives"),
            critics: size("critics"),
            hidden: vec![size("hidden"); 2],
            rows: 8,
            activation: Activation::Relu,
        }
    }

    fn networks(&self) -> Networks {
        let critic_lr = self.number("critic_lr");
        let actor_lr = self.number("actor_lr");
        Networks { hidden: self.case().hidden, critic_lr, actor_lr, ..Networks::default() }
    }
}

fn fused(spec: &EnvSpec, critics: usize, networks: &Networks) -> (Box<dyn Critic>, Box<dyn Actor>) {
    let critic = fused::Critics::new(spec, critics, networks, &mut common::init(0)).unwrap();
    let actor = fused::Deterministic::new(spec, networks, &mut common::init(0)).unwrap();
    (Box::new(critic), Box::new(actor))
}

fn plain(spec: &EnvSpec, critics: usize, networks: &Networks) -> (Box<dyn Critic>, Box<dyn Actor>) {
    let rng = &mut common::init(0);
    let cpu = Device::Cpu;
    let critic = plain::Critics::new(spec, critics, networks, rng, &cpu).unwrap();
    let actor = plain::Deterministic::new(spec, networks, rng, &cpu).unwrap();
    (Box::new(critic), Box::new(actor))
}

/// Puts PyTorch's weights in a saved network and its target.
fn place(file: &SafeTensors<'_>, prefix: &str, network: &mut State) {
    for (name, tensor) in file.tensors() {
        if let Some(name) = name.strip_prefix(prefix) {
            let bytes = tensor.data().as_chunks::<4>().0.iter();
            let values: Vec<f32> = bytes.map(|bytes| f32::from_le_bytes(*bytes)).collect();
            for part in ["online", "target"] {
                network.child_mut(part).put_shaped(name, tensor.shape(), &values[..]);
            }
        }
    }
}

/// The same networks with PyTorch's weights.
fn begin_with_pytorchs(critic: &mut dyn Critic, actor: &mut dyn Actor) {
    let [critics, policy] = ["reference_critics.safetensors", "reference_actor.safetensors"]
        .map(|name| std::fs::read(data(name)).unwrap());
    let critics = SafeTensors::deserialize(&critics).unwrap();
    let policy = SafeTensors::deserialize(&policy).unwrap();
    let (mut values, mut means) = (common::saved(critic), common::saved(actor));
    for k in 0..critic.critics() {
        let name = format!("critic.{k}");
        place(&critics, &format!("{name}."), values.child_mut(&name));
    }
    place(&policy, "actor.", &mut means);
    critic.load(&values).unwrap();
    actor.load(&means).unwrap();
}

/// reward + discount * mean over critics of the target values.
fn td_target(reward: &[f32], q: &[f32], critics: usize, discount: f32) -> Vec<f32> {
    let mean = |i: usize| q.iter().skip(i).step_by(reward.len()).sum::<f32>() / critics as f32;
    reward.iter().enumerate().map(|(i, r)| r + discount * mean(i)).collect()
}

#[test]
fn ten_updates_agree() {
    let reference = Reference::read();
    let case = reference.case();
    let networks = reference.networks();
    for (mut critic, mut actor) in
        [fused, plain].map(|make| make(&case.spec(), case.critics, &networks))
    {
        begin_with_pytorchs(critic.as_mut(), actor.as_mut());
        for (i, update) in reference.0["updates"].as_array().unwrap().iter().enumerate() {
            follow(&reference, &case, i, update, critic.as_mut(), actor.as_mut());
        }
    }
}

fn follow(
    reference: &Reference,
    case: &Case,
    i: usize,
    update: &Value,
    critic: &mut dyn Critic,
    actor: &mut dyn Actor,
) {
    let close = |name: &str, got: &[f32]| {
        assert_close(&format!("update {i}: {name}"), got, &numbers(update, name), 1e-4)
    };
    let [obs, action, next_obs] = ["obs", "action", "next_obs"].map(|name| numbers(update, name));
    let mut next_action = vec![0.0; action.len()];
    let mut q = vec![0.0; case.q_len()];
    let n = case.objectives;
    let samples = (case.critics * case.rows) as f32;

    actor.mode(Net::Target, &next_obs, &mut next_action).unwrap();
    critic.values(Net::Target, &next_obs, &next_action, &mut q).unwrap();
    let y = td_target(
        &numbers(update, "reward"),
        &q,
        case.critics,
        reference.number("discount") as f32,
    );
    close("target", &y);

    let weights = numbers(&reference.0, "loss_weights");
    let mut losses = vec![0.0; n];
    let fit = &mut |q: copq::QView<'_>, grad: &mut [f32]| {
        close("q", q.values());
        for (i, (grad, q)) in grad.iter_mut().zip(q.values()).enumerate() {
            let error = q - y[i % y.len()];
            losses[i % n] += error * error / samples;
            *grad = weights[i % n] * 2.0 * error / samples;
        }
        Ok(())
    };
    let tau = reference.number("tau") as f32;
    critic.fit(&obs, &action, fit, tau).unwrap();
    close("losses", &losses);

    if let Some(wanted) = update["actor_loss"].as_f64() {
        let direction = numbers(&reference.0, "direction");
        let mut loss = 0.0;
        let lower = &mut |q: copq::QView<'_>, grad: &mut [f32]| {
            for (i, (grad, q)) in grad.iter_mut().zip(q.values()).enumerate() {
                *grad = -direction[i % n] / samples;
                loss += *grad * q;
            }
            Ok(())
        };
        actor
            .improve(&obs, &[], &mut |s, grad| {
                critic.action_grad(&obs, s.action, lower, grad.action)
            })
            .unwrap();
        assert_close(&format!("update {i}: actor's loss"), &[loss], &[wanted as f32], 1e-4);
    }

    actor.update_target(tau).unwrap();
    critic.values(Net::Online, &obs, &action, &mut q).unwrap();
    close("q_after", &q);
    for (net, name) in [(Net::Online, "policy_after"), (Net::Target, "target_policy_after")] {
        actor.mode(net, &obs, &mut next_action).unwrap();
        close(name, &next_action);
    }
}
