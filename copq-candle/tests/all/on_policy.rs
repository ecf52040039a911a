//! On-policy updates against OmniSafe's own.

use copq::on_policy::{
    self, Config, Constraint, GaussianPolicy, Method, Rows, SecondStep, StateValue,
};
use copq::{Activation, EnvSpec, Networks, Rng, State, Stream};
use copq_candle::fused;
use serde_json::Value;

use super::common::Case;

type Critics = Vec<Box<dyn StateValue>>;

fn read(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn floats(value: &Value) -> Vec<f32> {
    match value.as_array() {
        Some(values) => values.iter().flat_map(floats).collect(),
        None => vec![number(value) as f32],
    }
}

/// Within 1e-5 (1 + |x|), as two ways of adding in f32 are.
fn check(what: &str, got: &[f32], wanted: &[f32]) {
    assert_eq!(got.len(), wanted.len(), "{what}");
    for (i, (got, wanted)) in got.iter().zip(wanted).enumerate() {
        let close = (got - wanted).abs() < 1e-5 * (1.0 + wanted.abs());
        assert!(close, "{what} {i}: {got}, not {wanted}");
    }
}

/// The networks of the stored updates: 4 numbers seen, 2 moved.
fn spec() -> EnvSpec {
    EnvSpec::new("stored", 4, 2).cost("cost", 25.0).reward("reward", 1.0)
}

fn networks() -> Networks {
    Networks { hidden: vec![8, 8], ..Method::ppo().config.networks }
}

fn policy(seed: u64) -> Box<dyn GaussianPolicy> {
    let rng = &mut Rng::new(seed, Stream::Init);
    Box::new(fused::Normal::new(&spec(), &networks(), rng).unwrap())
}

fn critic(seed: u64) -> Box<dyn StateValue> {
    let rng = &mut Rng::new(seed, Stream::Init);
    Box::new(fused::Value::new(&spec(), &networks(), rng).unwrap())
}

/// Stored layers as a flat buffer, and the deviations after them.
fn flat(network: &Value) -> Vec<f32> {
    let layers = network["layers"].as_array().unwrap();
    let parts = layers.iter().flat_map(|layer| [&layer["weight"], &layer["bias"]]);
    parts.chain(network.get("log_std")).flat_map(floats).collect()
}

/// Stored layers by their names.
fn put_layers(network: &Value, scale: f32, state: &mut State) {
    for (i, layer) in network["layers"].as_array().unwrap().iter().enumerate() {
        let bias = floats(&layer["bias"]);
        let weight = floats(&layer["weight"]);
        let shape = [bias.len(), weight.len() / bias.len()];
        let scaled = |values: Vec<f32>| values.iter().map(|x| scale * x).collect::<Vec<_>>();
        state.put_shaped(&format!("layer.{i}.weight"), &shape, scaled(weight));
        state.put_shaped(&format!("layer.{i}.bias"), &shape[..1], scaled(bias));
    }
}

fn stored_policy(network: &Value) -> Box<dyn GaussianPolicy> {
    let mut state = State::default();
    put_layers(network, 1.0, &mut state);
    state.put("log_std", floats(&network["log_std"]));
    let mut policy = policy(0);
    policy.import(&state).unwrap();
    policy
}

fn stored_critic(network: &Value) -> Box<dyn StateValue> {
    let mut state = State::default();
    for (part, scale) in [("online", 1.0), ("target", 1.0), ("adam_m", 0.0), ("adam_v", 0.0)] {
        put_layers(network, scale, state.child_mut(part));
    }
    state.put("steps", [0u64]);
    let mut critic = critic(0);
    critic.load(&state).unwrap();
    critic
}

fn stored(networks: &Value) -> (Box<dyn GaussianPolicy>, Critics) {
    let critic = |name: &str| stored_critic(&networks[name]);
    (stored_policy(&networks["actor"]), vec![critic("reward_critic"), critic("cost_critic")])
}

fn check_policy(what: &str, policy: &dyn GaussianPolicy, wanted: &Value) {
    let mut state = State::default();
    policy.export(&mut state).unwrap();
    let names = (0..3).flat_map(|i| [format!("layer.{i}.weight"), format!("layer.{i}.bias")]);
    let layers = names.flat_map(|name| state.get::<f32>(&name).unwrap().to_vec());
    let all: Vec<f32> = layers.chain(policy.log_std().to_vec()).collect();
    check(what, &all, &flat(wanted));
}

fn check_critic(what: &str, critic: &dyn StateValue, wanted: &Value) {
    let mut state = State::default();
    critic.save(&mut state).unwrap();
    let online = state.child("online").unwrap();
    let names = (0..3).flat_map(|i| [format!("layer.{i}.weight"), format!("layer.{i}.bias")]);
    let all: Vec<f32> = names.flat_map(|name| online.get::<f32>(&name).unwrap().to_vec()).collect();
    check(what, &all, &flat(wanted));
}

fn check_networks(what: &str, policy: &dyn GaussianPolicy, critics: &Critics, wanted: &Value) {
    check_policy(&format!("{what}, policy"), policy, &wanted["actor"]);
    for (critic, name) in critics.iter().zip(["reward_critic", "cost_critic"]) {
        check_critic(&format!("{what}, {name}"), critic.as_ref(), &wanted[name]);
    }
}

fn rows(batch: &Value, log_prob: &Value) -> Rows {
    Rows {
        obs: floats(&batch["obs"]),
        action: floats(&batch["act"]),
        log_prob: floats(log_prob).into_iter().map(f64::from).collect(),
        advantages: vec![floats(&batch["adv_r"]), floats(&batch["adv_c"])],
        targets: vec![floats(&batch["target_value_r"]), floats(&batch["target_value_c"])],
    }
}

/// What an update reports, with the rows in stored order.
fn updated(
    config: &Config,
    rows: &Rows,
    lambda: f64,
    lr: f64,
    policy: &mut dyn GaussianPolicy,
    critics: &mut [Box<dyn StateValue>],
) -> on_policy::Report {
    on_policy::update(config, rows, &[lambda], lr, policy, critics, &mut |_| ()).unwrap()
}

fn check_kl(what: &str, got: &[f64], wanted: &Value) {
    let got: Vec<f32> = got.iter().map(|&x| x as f32).collect();
    check(what, &got, &floats(wanted));
}

#[test]
fn one_minibatch_of_ppo() {
    let reference = read(include_str!("../data/on_policy/ppo.json"));
    for step in reference["steps"].as_array().unwrap() {
        let name = step["name"].to_string();
        let (mut policy, mut critics) = stored(&reference["networks"]);
        let rows = rows(&reference["batch"], &step["f32"]["behaviour_logp"]);
        let config = Config {
            passes: 1,
            batch: 64,
            entropy: number(&step["entropy_coef"]),
            max_norm: number(&step["max_grad_norm"]),
            ..Config::default()
        };
        let lambda = number(&step["lambda"]);
        let report = updated(&config, &rows, lambda, 3e-4, policy.as_mut(), &mut critics);
        check_networks(&name, policy.as_ref(), &critics, &step["f32"]["after"]);
        check_kl(&name, &report.kl, &serde_json::json!([step["f32"]["kl_after"]]));
        check_report(&name, &report, &step["f32"], &reference["networks"]);
    }
}

/// Losses and cut ratios of one minibatch; the stored losses have the penalty in them, c sum(p^2).
fn check_report(name: &str, report: &on_policy::Report, wanted: &Value, networks: &Value) {
    for (loss, critic) in report.critic_losses.iter().zip(["reward_critic", "cost_critic"]) {
        let squares = flat(&networks[critic]).into_iter().map(|p| f64::from(p * p));
        let loss = loss + 0.001 * squares.sum::<f64>();
        let wanted = number(&wanted[format!("loss_{critic}")]);
        assert!((loss / wanted - 1.0).abs() < 2e-6, "{name}, {critic}: {loss}, not {wanted}");
    }
    let ratios = floats(&wanted["ratio"]).into_iter().zip(floats(&wanted["adv"]));
    let cut = ratios.filter(|&(r, gain)| if gain > 0.0 { r > 1.2 } else { r < 0.8 }).count();
    assert_eq!(report.clip_share, cut as f64 / 64.0, "{name}");
}

#[test]
fn an_update_of_ppo_is_plain_pytorchs() {
    let reference = read(include_str!("../data/on_policy/torch.json"));
    let start = read(include_str!("../data/on_policy/ppo.json"));
    let settings = &reference["settings"];
    let orders: Vec<Vec<usize>> = serde_json::from_value(reference["orders"].clone()).unwrap();
    let (mut policy, mut critics) = stored(&start["networks"]);
    let rows = rows(&start["batch"], &reference["log_prob"]);
    let mut config = Config {
        passes: orders.len(),
        batch: settings["batch"].as_u64().unwrap() as usize,
        clip: number(&settings["clip"]),
        entropy: number(&settings["entropy"]),
        critic_decay: number(&settings["critic_decay"]),
        max_norm: number(&settings["max_norm"]),
        target_kl: f64::MAX,
        ..Config::default()
    };
    let lr = number(&settings["lr"]);
    config.networks.critic_lr = lr;
    let lambda = [number(&settings["lambda"])];
    let mut next = orders.iter();
    let mut in_their_order =
        |rows: &mut [usize]| rows.copy_from_slice(next.next().expect("a pass too many"));
    let report = on_policy::update(
        &config,
        &rows,
        &lambda,
        lr,
        policy.as_mut(),
        &mut critics,
        &mut in_their_order,
    )
    .unwrap();
    check_kl("KL", &report.kl, &reference["kl"]);
    check_networks("PyTorch", policy.as_ref(), &critics, &reference["after"]);
}

#[test]
fn whole_epochs_of_ppo() {
    let reference = read(include_str!("../data/on_policy/ppo.json"));
    for update in reference["updates"].as_array().unwrap() {
        let (mut policy, mut critics) = stored(&reference["networks"]);
        let epochs = update["epochs_of_schedule"].as_u64().unwrap();
        let config = Config {
            steps_per_epoch: 64,
            anneal_steps: Some(64 * epochs),
            batch: update["minibatch"].as_u64().unwrap() as usize,
            ..Config::default()
        };
        let lambda = number(&update["lambda"]);
        for (k, wanted) in update["f32"].as_array().unwrap().iter().enumerate() {
            let name = format!("{}, epoch {k}", update["name"]);
            let rows = rows(&reference["batches"][k], &wanted["logp"]);
            let lr = config.actor_lr(k as u64);
            assert!((lr - number(&wanted["actor_lr"])).abs() < 1e-12);
            let report = updated(&config, &rows, lambda, lr, policy.as_mut(), &mut critics);
            check_kl(&name, &report.kl, &wanted["kl_after_each_pass"]);
            check_networks(&name, policy.as_ref(), &critics, &wanted["after"]);
        }
    }
}

#[test]
fn the_step_size_falls_as_omnisafes() {
    let reference = read(include_str!("../data/on_policy/ppo.json"));
    let mut seen = 0;
    for (epochs, wanted) in reference["schedule"].as_object().unwrap() {
        let epochs: u64 = epochs.parse().unwrap();
        let config = Config { anneal_steps: Some(2_048 * epochs), ..Config::default() };
        for (k, wanted) in wanted.as_object().unwrap() {
            let k: u64 = k.parse().unwrap();
            // After the last epoch a run may go on, with the last one's step.
            if k < epochs {
                assert!((config.actor_lr(k) - number(wanted)).abs() < 1e-12);
                seen += 1;
            }
        }
    }
    assert!(seen > 8);
}

/// The Fisher matrix with its damping times a flat vector, of its parts.
fn fisher_product(
    policy: &mut dyn GaussianPolicy,
    obs: &[f32],
    vector: &[f32],
    damping: f32,
) -> Vec<f32> {
    let action = policy.log_std().len();
    let mut moved = vec![0.0; obs.len() / 4 * action];
    policy.push_forward(obs, vector, &mut moved).unwrap();
    let mut product = vec![0.0; vector.len()];
    let fill = &mut |normal: on_policy::Normal<'_>, grad: on_policy::NormalGradient<'_>| {
        for (at, grad) in grad.mean.iter_mut().enumerate() {
            let variance = (2.0 * normal.log_std[at % action]).exp();
            *grad = moved[at] / variance / moved.len() as f32;
        }
        grad.log_std.fill(0.0);
        Ok(())
    };
    policy.gradient(obs, fill, &mut product).unwrap();
    let first = vector.len() - action;
    product[first..]
        .iter_mut()
        .zip(&vector[first..])
        .for_each(|(p, v)| *p = 2.0 / action as f32 * v);
    product.iter_mut().zip(vector).for_each(|(p, v)| *p += damping * v);
    product
}

#[test]
fn the_natural_gradient_of_rcpo() {
    let reference = read(include_str!("../data/on_policy/rcpo.json"));
    let (mut policy, mut critics) = stored(&reference["networks"]);
    let wanted = &reference["f32"];
    let rows = rows(&reference["batch"], &wanted["logp"]);
    let vector = flat(&reference["vector"]);
    let product = fisher_product(policy.as_mut(), &rows.obs, &vector, 0.1);
    check("product with the Fisher matrix", &product, &flat(&wanted["fvp"]));
    let mut config = Config { batch: 16, ..Method::rcpo().config };
    config.networks.critic_lr = number(&reference["critic_lr"]);
    let lambda = number(&reference["lambda"]);
    let report = updated(&config, &rows, lambda, 0.0, policy.as_mut(), &mut critics);
    check_networks("RCPO", policy.as_ref(), &critics, &wanted["after_whole_update"]);
    check_kl("KL", &report.kl, &serde_json::json!([wanted["kl_summed_over_components"]]));
}

/// KL(policy before || after) of a small step, to second order, is half the step's length in the
/// Fisher matrix: here by differences of the divergence itself.
#[test]
fn the_fisher_matrix_is_the_curvature_of_the_divergence() {
    let mut rng = Rng::new(3, Stream::Custom);
    let mut obs = vec![0.0; 4 * 50];
    rng.fill_normal(&mut obs);
    let mut first = policy(1);
    let mut direction = vec![0.0; first.parameters()];
    rng.fill_normal(&mut direction);
    let mut before = vec![0.0; 2 * 50];
    first.means(&obs, &mut before).unwrap();
    let before_log_std = first.log_std().to_vec();
    let product = fisher_product(first.as_mut(), &obs, &direction, 0.0);
    let curvature: f64 =
        product.iter().zip(&direction).map(|(p, d)| f64::from(*p) * f64::from(*d)).sum();
    let size = 3e-3f32;
    let step: Vec<f32> = direction.iter().map(|d| size * d).collect();
    first.shift(&step).unwrap();
    let mut after = vec![0.0; 2 * 50];
    first.means(&obs, &mut after).unwrap();
    let mut divergence = 0.0;
    for at in 0..after.len() {
        let [p, q] = [before_log_std[at % 2], first.log_std()[at % 2]].map(f64::from);
        let shift = f64::from(before[at]) - f64::from(after[at]);
        divergence += q - p + ((2.0 * p).exp() + shift * shift) / (2.0 * (2.0 * q).exp()) - 0.5;
    }
    let measured = 2.0 * divergence / after.len() as f64 / f64::from(size).powi(2);
    assert!((measured / curvature - 1.0).abs() < 0.03, "{measured}, not {curvature}");
}

/// How means move along a direction, by differences; more components than a vector has lanes.
#[test]
fn means_move_as_pushed() {
    let case = Case { action: 17, ..Case::new(1, 1, &[7, 18], 5) };
    for activation in [Activation::Tanh, Activation::Relu] {
        let networks = Networks { activation, ..case.networks() };
        let rng = &mut Rng::new(5, Stream::Init);
        let mut policy = fused::Normal::new(&case.spec(), &networks, rng).unwrap();
        let mut direction = vec![0.0; policy.parameters()];
        rng.fill_normal(&mut direction);
        let obs = case.obs(6);
        let [mut pushed, mut before, mut after] = [(); 3].map(|()| vec![0.0; case.rows * 17]);
        policy.push_forward(&obs, &direction, &mut pushed).unwrap();
        let half = 2e-4f32;
        policy.shift(&direction.iter().map(|d| -half * d).collect::<Vec<_>>()).unwrap();
        policy.means(&obs, &mut before).unwrap();
        policy.shift(&direction.iter().map(|d| 2.0 * half * d).collect::<Vec<_>>()).unwrap();
        policy.means(&obs, &mut after).unwrap();
        for ((before, after), pushed) in before.iter().zip(&after).zip(&pushed) {
            let slope = (after - before) / (2.0 * half);
            assert!((slope - pushed).abs() < 2e-2 * (1.0 + pushed.abs()), "{slope}, not {pushed}");
        }
    }
}

#[test]
fn both_steps_of_cup() {
    let reference = read(include_str!("../data/on_policy/cup.json"));
    let (mut policy, mut critics) = stored(&reference["networks"]);
    let wanted = &reference["whole"]["f32"];
    let rows = rows(&reference["batch"], &wanted["logp"]);
    let config = Config { batch: 16, ..Method::cup().config };
    assert!(matches!(config.constraint, Some(Constraint::Adam(_))));
    assert_eq!(config.second, Some(SecondStep { passes: 40 }));
    let lambda = number(&wanted["lambda_after_its_update"]);
    let report = updated(&config, &rows, lambda, 3e-4, policy.as_mut(), &mut critics);
    check_kl("first step", &report.kl, &wanted["first_kl_after_each_pass"]);
    check_kl("second step", &report.second_kl, &wanted["second_kl_after_each_pass"]);
    check_networks("CUP", policy.as_ref(), &critics, &wanted["after_second"]);
}
