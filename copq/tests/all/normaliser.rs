//! Observation normalisation: OmniSafe's numbers, and what it means to a learner.

use crate::toy;

use std::sync::{Arc, Mutex};

use approx::{abs_diff_eq, assert_abs_diff_eq};
use copq::*;
use serde_json::Value;
use toy::{Toy, act, saved};

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(values) => values.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

/// OmniSafe's normaliser takes in several rows at once; here they come one by one, to the same end.
#[test]
fn omnisafes_numbers() {
    let reference: Value =
        serde_json::from_str(include_str!("../data/on_policy/normaliser.json")).unwrap();
    let mut seen = 0;
    for case in reference["cases"].as_array().unwrap() {
        let pushes = case["pushes"].as_array().unwrap();
        let is_scalar = pushes[0].is_number();
        let width = if is_scalar { 1 } else { 4 };
        let mut normaliser = Normaliser::new(width);
        for (push, after) in pushes.iter().zip(case["f64"].as_array().unwrap()) {
            let mut obs: Vec<f32> = numbers(push).iter().map(|&x| x as f32).collect();
            obs.chunks(width).for_each(|row| normaliser.push(row).unwrap());
            normaliser.normalise(&mut obs).unwrap();
            let wanted = numbers(&after["out"]);
            assert_eq!(obs.len(), wanted.len());
            for (&got, wanted) in obs.iter().zip(wanted) {
                let epsilon = 1e-5 * (1.0 + wanted.abs());
                let close = abs_diff_eq!(f64::from(got), wanted, epsilon = epsilon);
                assert!(close, "{}, push {seen}: {got}, not {wanted}", case["name"]);
            }
            let mut state = State::default();
            normaliser.save(&mut state);
            let mean = state.get::<f64>("mean").unwrap();
            let wanted = numbers(&after["mean"]);
            for (got, wanted) in mean.iter().zip(wanted) {
                assert_abs_diff_eq!(*got, wanted, epsilon = 1e-5 * (1.0 + wanted.abs()));
            }
            assert_eq!(state.get_one::<u64>("count").unwrap(), after["count"].as_u64().unwrap());
            seen += 1;
        }
    }
    assert_eq!(seen, 40 + 13 + 5 + 35);
}

fn trained(config: Config, steps: u64) -> Trainer<Learner> {
    let mut trainer = toy::trainer(toy::learner(toy::method(config), 3, 5));
    (0..steps).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    trainer
}

fn normalised() -> Config {
    Config { normalise: true, ..toy::config() }
}

/// What the policy does in a state, found in its saved parts: the networks see (s - mean) / std.
#[test]
fn networks_see_normalised_observations_and_the_replay_raw_ones() {
    let mut trainer = trained(normalised(), 600);
    let state = saved(&trainer);
    let agent = state.child("agent").unwrap();

    let replayed = agent.child("replay").unwrap().get::<f32>("obs").unwrap();
    let ends = agent.child("replay").unwrap().get::<f32>("finals").unwrap();
    let seen = agent.child("normaliser").unwrap();
    let count: u64 = seen.get_one("count").unwrap();
    assert_eq!(count as usize, replayed.len() + ends.len(), "every observation once, ends too");
    let all: Vec<f64> = replayed.iter().chain(ends).map(|&s| f64::from(s)).collect();
    let mean = all.iter().sum::<f64>() / count as f64;
    let variance = all.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1) as f64;

    let online = agent.child("actor").unwrap().get::<f32>("online").unwrap().to_vec();
    let action = act(trainer.agent_mut(), 0.7, Mode::Exploit);
    let s = (0.7 - mean) / variance.sqrt();
    let wanted = f64::from(online[0]) + f64::from(online[1]) * s;
    assert!(wanted.abs() < 1.0, "{wanted}");
    assert_abs_diff_eq!(f64::from(action), wanted, epsilon = 1e-5);
}

/// The policy alone, from the saved state, acts as the agent does.
#[test]
fn a_saved_policy_takes_its_normaliser_along() {
    let mut trainer = trained(normalised(), 600);
    let state = saved(&trainer);
    let networks = normalised().networks;
    let spec = Toy::new().spec;
    let agent = state.child("agent").unwrap();
    let kind = ActorKind::Deterministic;
    let mut policy = Policy::load(agent, &spec, &networks, kind, &toy::Linear).unwrap();
    for s in [-0.9, 0.1, 0.7] {
        let mut got = [0.0];
        policy.act(&[s], &mut got).unwrap();
        assert_eq!(got, [act(trainer.agent_mut(), s, Mode::Exploit)]);
    }
}

/// A call of a critic, and the observations it was shown.
type Shown = (&'static str, Vec<f32>);

/// A critic that keeps what it is shown.
struct Spy {
    critic: toy::LinearCritics,
    shown: Arc<Mutex<Vec<Shown>>>,
}

impl Spy {
    fn note(&self, call: &'static str, obs: &[f32]) {
        self.shown.lock().unwrap().push((call, obs.to_vec()));
    }
}

impl Critic for Spy {
    fn critics(&self) -> usize {
        self.critic.critics()
    }

    fn objectives(&self) -> usize {
        self.critic.objectives()
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        self.note(if net == Net::Target { "target" } else { "values" }, obs);
        self.critic.values(net, obs, act, q)
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        self.note("fit", obs);
        self.critic.fit(obs, act, grad, tau)
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        self.note("action_grad", obs);
        self.critic.action_grad(obs, act, grad, out)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.critic.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.critic.load(state)
    }
}

/// Observations of 1,000 to 1,063, next ones of 2,000 to 2,063: raw ones would be found by their
/// size, and s by s'.
#[test]
fn updates_see_normalised_batches() {
    let shown = Arc::default();
    let spy = Spy { critic: toy::LinearCritics::new(3, 2, 0.02, 0), shown: Arc::clone(&shown) };
    let config = Config { start_steps: 64, actor_delay: 1, ..normalised() };
    let actor = Box::new(toy::LinearActor::new(0.005));
    let mut learner =
        Learner::with_networks(toy::method(config), &Toy::new().spec, Box::new(spy), actor, 0)
            .unwrap();
    for i in 0..64 {
        let obs = [1_000.0 + i as f32];
        let next_obs = [2_000.0 + i as f32];
        let outcome = Outcome::Terminated;
        learner
            .observe(Transition {
                obs: &obs,
                action: &[0.0],
                reward: &[0.0; 2],
                next_obs: &next_obs,
                outcome,
            })
            .unwrap();
    }
    learner.update(&mut Silent).unwrap();
    learner.value(&[1_031.0], &[0.0], &mut [0.0; 2]).unwrap();
    // Half at 1,031.5, half at 2,031.5, each with a deviation of 18.5: s lies near -1, s' near 1.
    let shown = shown.lock().unwrap();
    for call in ["target", "fit", "values", "action_grad"] {
        let rows: Vec<f32> = shown
            .iter()
            .filter(|(name, _)| *name == call)
            .flat_map(|(_, obs)| obs.clone())
            .collect();
        let wanted = if call == "target" { 1.0 } else { -1.0 };
        assert!(
            !rows.is_empty() && rows.iter().all(|s| abs_diff_eq!(*s, wanted, epsilon = 0.1)),
            "{call}: {rows:?}"
        );
    }
}

#[test]
fn evaluation_moves_nothing() {
    let mut trainer = trained(normalised(), 300);
    let before = saved(&trainer);
    evaluate(trainer.agent_mut(), Toy::new(), 3).unwrap();
    assert!(saved(&trainer) == before);
}

#[test]
fn a_normalised_run_resumes_bit_for_bit_and_differs_from_a_raw_one() {
    let whole = saved(&trained(normalised(), 500));
    let mut resumed = toy::trainer(toy::learner(toy::method(normalised()), 3, 5));
    resumed.load(&saved(&trained(normalised(), 313))).unwrap();
    (313..500).for_each(|_| drop(resumed.step(&mut Silent).unwrap()));
    assert!(saved(&resumed) == whole);
    assert_ne!(saved(&trained(toy::config(), 500)), whole);
}
