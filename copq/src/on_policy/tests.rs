//! OmniSafe's own numbers: what gathering an epoch must come to.

use serde_json::Value;

use super::advantage::{centre, generalised, standardise};
use super::epoch::{Epoch, Taken};
use super::multiplier::Multiplier;
use super::*;
use crate::{
    ActionGrad, Actor, ActorKind, Agent, Backend, Critic, Env, EnvSpec, Mode, Net, Networks,
    Outcome, PidConfig, Result, Rng, Transition,
};

fn read(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(values) => values.iter().flat_map(numbers).collect(),
        None => vec![number(value)],
    }
}

fn floats(value: &Value) -> Vec<f32> {
    numbers(value).into_iter().map(|x| x as f32).collect()
}

/// Within 1e-5 (1 + |x|), as two ways of adding in f32 are.
fn check(what: &str, got: &[f32], wanted: &Value) {
    let wanted = numbers(wanted);
    assert_eq!(got.len(), wanted.len(), "{what}");
    for (i, (&got, wanted)) in got.iter().zip(wanted).enumerate() {
        let error = (f64::from(got) - wanted).abs();
        assert!(error < 1e-5 * (1.0 + wanted.abs()), "{what} {i}: {got}, not {wanted}");
    }
}

#[test]
fn advantages_of_every_kind_of_path() {
    let reference = read(include_str!("../../tests/data/on_policy/gae.json"));
    for case in reference["cases"].as_array().unwrap() {
        let mut all = [Vec::new(), Vec::new()];
        for env in case["envs"].as_array().unwrap() {
            for (k, (signal, x, lambda)) in
                [("reward", "r", "lam"), ("cost", "c", "lam_c")].into_iter().enumerate()
            {
                let values = floats(&env[format!("value_{x}")]);
                let ends = env["paths"].as_array().unwrap().iter().map(|path| {
                    let last = path["last_row"].as_u64().unwrap() as usize;
                    (last + 1, number(&path[format!("last_value_{x}")]) as f32)
                });
                let mut advantage = vec![0.0; values.len()];
                let mut target = advantage.clone();
                let constants = [number(&case["gamma"]), number(&case[lambda])];
                let signal = floats(&env[signal]);
                generalised(&signal, &values, ends, constants, &mut advantage, &mut target);
                check("advantage", &advantage, &env[format!("adv_{x}")]);
                check("target", &target, &env[format!("target_value_{x}")]);
                all[k].extend(advantage);
            }
        }
        standardise(&mut all[0]);
        centre(&mut all[1]);
        check("standardised", &all[0], &case["standardised"]["adv_r"]);
        check("centred", &all[1], &case["standardised"]["adv_c"]);
    }
}

/// Ends that come in the order of time would end other rows' paths: rows lie world after world.
#[test]
fn advantages_of_two_worlds_that_take_turns() {
    let reference = read(include_str!("../../tests/data/on_policy/gae.json"));
    let of_two = |case: &&Value| case["envs"].as_array().unwrap().len() == 2;
    let case = reference["cases"].as_array().unwrap().iter().find(of_two).unwrap();
    let worlds = case["envs"].as_array().unwrap();
    let mut epoch = Epoch::new(40, 2, [1, 1], 2);
    for row in 0..20 {
        for (i, world) in worlds.iter().enumerate() {
            let at = |names: [&str; 2]| names.map(|name| number(&world[name][row]) as f32).to_vec();
            let values = at(["value_r", "value_c"]);
            let taken = Taken { obs: vec![0.0], action: vec![0.0], log_prob: 0.0, values };
            epoch.push(i, &taken, &at(["reward", "cost"]));
            let mut paths = world["paths"].as_array().unwrap().iter();
            if let Some(path) = paths.find(|path| path["last_row"] == row) {
                let last = ["last_value_r", "last_value_c"];
                epoch.end(i, last.map(|name| number(&path[name]) as f32).to_vec());
            }
        }
    }
    let rows = epoch.finish(0.99, 0.95);
    for (k, x) in ["r", "c"].into_iter().enumerate() {
        check("advantage", &rows.advantages[k], &case["standardised"][format!("adv_{x}")]);
        let targets = worlds.iter().map(|world| &world[format!("target_value_{x}")]);
        check("target", &rows.targets[k], &targets.cloned().collect());
    }
}

#[test]
fn multipliers_of_both_rules() {
    let reference = read(include_str!("../../tests/data/on_policy/multipliers.json"));
    let run = |mut multiplier: Multiplier, case: &Value| {
        let limit = number(&case["config"]["cost_limit"]);
        for (i, update) in case["updates"].as_array().unwrap().iter().enumerate() {
            multiplier.update(number(&update["cost"]), limit);
            let wanted = number(&update["lambda"]);
            let error = (multiplier.value() - wanted).abs();
            let name = &case["name"];
            assert!(error < 1e-5 * (1.0 + wanted), "{name}, {i}: {multiplier:?}, not {wanted}");
        }
    };
    for case in reference["pid"].as_array().unwrap() {
        let config = &case["config"];
        let is = |name: &str| config[name].as_bool().unwrap();
        let pid = PidConfig {
            proportional: number(&config["pid_kp"]),
            integral: number(&config["pid_ki"]),
            derivative: number(&config["pid_kd"]),
            multiplier: number(&config["lagrangian_multiplier_init"]),
            delay: config["pid_d_delay"].as_u64().unwrap() as usize,
            cap: match (is("diff_norm"), is("sum_norm")) {
                (true, _) => 1.0,
                (false, true) => f64::INFINITY,
                (false, false) => number(&config["penalty_max"]),
            },
            integral_cap: if is("diff_norm") { 1.0 } else { f64::INFINITY },
        };
        run(Multiplier::new(Constraint::Pid(pid)).unwrap(), case);
    }
    for case in reference["adam"].as_array().unwrap() {
        let config = &case["config"];
        let ascent = Ascent {
            lr: number(&config["lambda_lr"]),
            // CUP's is stored from there on.
            multiplier: number(&config["lagrangian_multiplier_init"]),
            cap: config["lagrangian_upper_bound"].as_f64().unwrap_or(f64::INFINITY),
        };
        run(Multiplier::new(Constraint::Adam(ascent)).unwrap(), case);
    }
}

/// Layers of stored weights, by plain loops: policy and critic that do not learn.
struct Layers {
    layers: Vec<(Vec<f32>, Vec<f32>)>,
    log_std: Vec<f32>,
}

impl Layers {
    fn new(network: &Value) -> Self {
        let layers = network["layers"].as_array().unwrap();
        let layers = layers.iter().map(|l| (floats(&l["weight"]), floats(&l["bias"]))).collect();
        let log_std = network.get("log_std").map(floats).unwrap_or_default();
        Self { layers, log_std }
    }

    fn forward(&self, input: &[f32]) -> Vec<f32> {
        let mut x: Vec<f64> = input.iter().map(|&x| f64::from(x)).collect();
        for (i, (weight, bias)) in self.layers.iter().enumerate() {
            let rows = weight.chunks_exact(x.len()).zip(bias);
            let y = rows.map(|(row, &bias)| {
                let sum: f64 = row.iter().zip(&x).map(|(&w, x)| f64::from(w) * x).sum();
                let y = sum + f64::from(bias);
                if i + 1 < self.layers.len() { y.tanh() } else { y }
            });
            x = y.collect();
        }
        x.into_iter().map(|x| x as f32).collect()
    }
}

impl Actor for Layers {
    fn action_len(&self) -> usize {
        self.log_std.len()
    }

    fn mode(&mut self, _: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.means(obs, action)
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        unreachable!()
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        unreachable!()
    }
}

impl GaussianPolicy for Layers {
    fn log_std(&self) -> &[f32] {
        &self.log_std
    }

    fn means(&mut self, obs: &[f32], mean: &mut [f32]) -> Result<()> {
        mean.copy_from_slice(&self.forward(obs));
        Ok(())
    }

    fn descend(&mut self, _: &[f32], _: Descent, _: NormalGrad<'_>) -> Result<()> {
        unreachable!()
    }
}

impl StateValue for Layers {
    fn values(&mut self, obs: &[f32], value: &mut [f32]) -> Result<()> {
        value.copy_from_slice(&self.forward(obs));
        Ok(())
    }

    fn descend(&mut self, _: &[f32], _: Descent, _: ValueGrad<'_>) -> Result<()> {
        unreachable!()
    }
}

/// Gives out the stored networks: the critics are the reward's, then the cost's.
struct Stored<'a>(&'a Value, std::cell::Cell<usize>);

impl Backend for Stored<'_> {
    fn critics(&self, _: &EnvSpec, _: &Networks, _: usize, _: &mut Rng) -> Result<Box<dyn Critic>> {
        unreachable!()
    }

    fn actor(
        &self,
        _: &EnvSpec,
        _: &Networks,
        _: ActorKind,
        _: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        unreachable!()
    }

    fn policy(&self, _: &EnvSpec, _: &Networks, _: &mut Rng) -> Result<Box<dyn GaussianPolicy>> {
        Ok(Box::new(Layers::new(&self.0["actor"])))
    }

    fn value(&self, _: &EnvSpec, _: &Networks, _: &mut Rng) -> Result<Box<dyn StateValue>> {
        let name = ["reward_critic", "cost_critic"][self.1.replace(1)];
        Ok(Box::new(Layers::new(&self.0[name])))
    }
}

/// Plays what was recorded, whatever the actions.
struct Script {
    spec: EnvSpec,
    script: Value,
    resets: usize,
    steps: usize,
}

impl Env for Script {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, _: u64, obs: &mut [f32]) -> Result<()> {
        obs.copy_from_slice(&floats(&self.script["reset_obs"][self.resets]));
        self.resets += 1;
        Ok(())
    }

    fn step(&mut self, _: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        let at = self.steps;
        self.steps += 1;
        let now = |name: &str| number(&self.script[name][at]) as f32;
        obs.copy_from_slice(&floats(&self.script["obs"][at]));
        reward.copy_from_slice(&[now("cost"), now("reward")]);
        Ok(if now("terminated") == 1.0 {
            Outcome::Terminated
        } else if now("truncated") == 1.0 {
            Outcome::Truncated
        } else {
            Outcome::Running
        })
    }
}

fn script(script: &Value, horizon: usize, limit: f32) -> Script {
    let spec = EnvSpec::new("script", 4, 2)
        .cost("cost", limit)
        .reward("reward", 1.0)
        .action_bounds(&[-0.4, -2.0], &[0.4, 1.0])
        .horizon(horizon);
    Script { spec, script: script.clone(), resets: 0, steps: 0 }
}

/// Gathers one recorded epoch after another by the recorded noise, without learning; calls with
/// each as it is complete.
fn gather(
    env: &mut dyn Env,
    learner: &mut Learner,
    noise: &Value,
    mut complete: impl FnMut(&mut Learner, usize),
) {
    let spec = env.spec().clone();
    let mut obs = vec![0.0; spec.obs_len];
    let mut next = obs.clone();
    let mut action = [0.0; 2];
    let mut reward = [0.0; 2];
    for epoch in 0..2 {
        let mut running = false;
        for step in 0..40 {
            if !running {
                env.reset(0, &mut obs).unwrap();
            }
            let noise = floats(&noise[40 * epoch + step]);
            learner.explore(&obs, &noise, &mut action).unwrap();
            let outcome = env.step(&action, &mut next, &mut reward).unwrap();
            let (obs_now, action, reward) = (&obs, &action, &reward);
            let transition = Transition { obs: obs_now, action, reward, next_obs: &next, outcome };
            learner.observe(transition).unwrap();
            obs.copy_from_slice(&next);
            running = outcome == Outcome::Running;
        }
        complete(learner, epoch);
        learner.epoch.clear();
    }
}

fn check_epoch(learner: &mut Learner, wanted: &Value, signals: &[&str]) {
    let mean = learner.mean_costs().unwrap();
    check("mean cost", &[mean[0] as f32], &wanted["mean_episode_cost"]);
    let rows = learner.epoch.finish(0.99, 0.95);
    let buffer = &wanted["buffer"];
    check("observation", &rows.obs, &buffer["obs"]);
    check("action", &rows.action, &buffer["act"]);
    let log_prob: Vec<f32> = rows.log_prob.iter().map(|&x| x as f32).collect();
    check("log-probability", &log_prob, &buffer["logp"]);
    for (k, x) in signals.iter().enumerate() {
        check("advantage", &rows.advantages[k], &wanted["standardised"][format!("adv_{x}")]);
        check("target", &rows.targets[k], &buffer[format!("target_value_{x}")]);
    }
}

#[test]
fn two_epochs_gathered() {
    let reference = read(include_str!("../../tests/data/on_policy/rollout.json"));
    let mut env = script(&reference["script"], 12, 1.0);
    let mut method = Method::ppo_lag();
    method.config.steps_per_epoch = 40;
    method.config.window = 6;
    let backend = Stored(&reference["networks"], 0.into());
    let mut learner = Learner::new(method, env.spec(), &backend, 0).unwrap();
    let mut seen = 0;
    gather(&mut env, &mut learner, &reference["noise"], |learner, epoch| {
        check_epoch(learner, &reference["epochs"][epoch], &["r", "c"]);
        seen += 1;
    });
    assert_eq!(seen, 2);
}

/// OmniSafe fills a spent episode's budget before it asks for the value of its last observation;
/// these are the numbers with that put right.
#[test]
fn two_epochs_gathered_under_a_budget() {
    let reference = read(include_str!("../../tests/data/on_policy/saute.json"));
    for case in reference["cases"].as_array().unwrap() {
        let config = &case["config"];
        let limit = number(&config["safety_budget"]) as f32;
        let saute = SauteConfig {
            discount: number(&config["saute_gamma"]),
            unsafe_reward: number(&config["unsafe_reward"]),
        };
        let horizon = config["max_ep_len"].as_u64().unwrap() as usize;
        let mut env = Saute::new(script(&case["script"], horizon, limit), &saute).unwrap();
        let mut method = Method::ppo_saute();
        method.config.saute = Some(saute);
        method.config.steps_per_epoch = 40;
        method.config.window = 6;
        let backend = Stored(&case["networks"], 0.into());
        let mut learner = Learner::new(method, env.spec(), &backend, 0).unwrap();
        gather(&mut env, &mut learner, &case["noise"], |learner, epoch| {
            let wanted = &case["epochs"][epoch];
            let mut kept = wanted.clone();
            kept["standardised"] = wanted["safety_kept"]["standardised"].clone();
            kept["buffer"]["target_value_r"] = wanted["safety_kept"]["target_value_r"].clone();
            check_epoch(learner, &kept, &["r"]);
        });
    }
}

#[test]
fn deterministic_actions_are_means_and_move_nothing() {
    let reference = read(include_str!("../../tests/data/on_policy/rollout.json"));
    let env = script(&reference["script"], 12, 1.0);
    let backend = Stored(&reference["networks"], 0.into());
    let mut learner = Learner::new(Method::cppo_pid(), env.spec(), &backend, 0).unwrap();
    let mut first = [0.0; 2];
    let mut second = [0.0; 2];
    learner.act(&[1.0, 2.0, 3.0, 4.0], Mode::Exploit, &mut first).unwrap();
    learner.act(&[9.0, 9.0, 9.0, 9.0], Mode::Exploit, &mut second).unwrap();
    learner.act(&[1.0, 2.0, 3.0, 4.0], Mode::Exploit, &mut second).unwrap();
    assert_eq!(first, second);
    let mut values = [0.0; 2];
    learner.value(&[1.0, 2.0, 3.0, 4.0], &first, &mut values).unwrap();
    assert!(values.iter().all(|value| value.is_finite()));
}

#[test]
fn what_is_observed_was_chosen_just_before() {
    let reference = read(include_str!("../../tests/data/on_policy/rollout.json"));
    let env = script(&reference["script"], 12, 1.0);
    let backend = Stored(&reference["networks"], 0.into());
    let mut learner = Learner::new(Method::ppo_lag(), env.spec(), &backend, 0).unwrap();
    let obs = [1.0, 2.0, 3.0, 4.0];
    let mut observe = |mode: &[Mode]| {
        let mut action = [0.0; 2];
        mode.iter().for_each(|&mode| learner.act(&obs, mode, &mut action).unwrap());
        let (outcome, action) = (Outcome::Running, &action);
        learner.observe(Transition {
            obs: &obs,
            action,
            reward: &[0.0; 2],
            next_obs: &obs,
            outcome,
        })
    };
    let error = observe(&[]).unwrap_err().to_string();
    assert_eq!(
        error,
        "transition that an on-policy learner observes: wanted one for each action that Agent::act \
         chose in Mode::Explore, got an extra one"
    );
    observe(&[Mode::Exploit]).unwrap_err();
    observe(&[Mode::Explore, Mode::Exploit]).unwrap();
    observe(&[]).unwrap_err();
}

#[test]
fn an_update_without_what_it_needs_is_an_error() {
    let rows =
        Rows { log_prob: vec![0.0; 4], obs: vec![0.0; 4], action: vec![0.0; 4], ..Rows::default() };
    let mut policy = Layers { layers: Vec::new(), log_std: vec![0.0] };
    let mut update = |config: &Config, rows: &Rows| {
        update(config, rows, &[], 1e-3, &mut policy, &mut [], &mut |_| {}).unwrap_err().to_string()
    };
    let config = Config::default();
    assert_eq!(update(&config, &rows), "critics: wanted at least the reward's, got none");
    let none = Config { batch: 0, ..config };
    assert_eq!(update(&none, &rows), "batch: wanted at least 1, got 0");
    let both = Config { natural: Some(NaturalStep::default()), ..Method::cup().config };
    let error = update(&both, &rows);
    assert_eq!(error, "second: wanted none with a natural step, got one");
}

/// A world that always looks the same, left in mid-episode: its costs so far are no episode's.
#[test]
fn an_episode_that_begins_ends_the_path_before_whatever_it_looks_like() {
    let reference = read(include_str!("../../tests/data/on_policy/rollout.json"));
    let env = script(&reference["script"], 12, 1.0);
    let backend = Stored(&reference["networks"], 0.into());
    let mut learner = Learner::new(Method::ppo_lag(), env.spec(), &backend, 0).unwrap();
    let obs = [1.0, 2.0, 3.0, 4.0];
    let mut step = |outcome| {
        let mut action = [0.0; 2];
        learner.act(&obs, Mode::Explore, &mut action).unwrap();
        let (action, reward) = (&action, &[1.0, 0.0]);
        learner.observe(Transition { obs: &obs, action, reward, next_obs: &obs, outcome }).unwrap();
        if outcome == Outcome::Truncated {
            learner.begin_episode();
        }
    };
    for outcome in [Outcome::Running, Outcome::Running, Outcome::Truncated, Outcome::Running] {
        step(outcome);
    }
    // An error: the next episode begins without an end of this one.
    learner.begin_episode();
    let mut action = [0.0; 2];
    learner.act(&obs, Mode::Explore, &mut action).unwrap();
    let (action, reward) = (&action, &[1.0, 0.0]);
    let outcome = Outcome::Truncated;
    learner.observe(Transition { obs: &obs, action, reward, next_obs: &obs, outcome }).unwrap();
    assert_eq!(learner.window, [vec![3.0], vec![1.0]]);
}
