//! Observation normalisation: OmniSafe's numbers, and what it means to a learner.

mod toy;

use copq::*;
use serde_json::Value;
use toy::Toy;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn omnisafes_numbers() {
    let reference: Value = serde_json::from_str(include_str!("data/normaliser.json")).unwrap();
    let pushes = reference["pushes"].as_array().unwrap();
    let mut normaliser = Normaliser::new(4);
    for (i, (push, after)) in pushes.iter().zip(reference["after"].as_array().unwrap()).enumerate() {
        let mut obs: Vec<f32> = numbers(push).iter().map(|&x| x as f32).collect();
        normaliser.push(&obs);
        normaliser.normalise(&mut obs);
        for (got, wanted) in obs.iter().zip(numbers(&after["out"])) {
            let error = (f64::from(*got) - wanted).abs();
            assert!(error <= 1e-6 * wanted.abs().max(1.0), "push {i}: {got}, not {wanted}");
        }
    }
    assert_eq!(pushes.len(), 40);
}

fn trained(config: Config, steps: u64) -> Trainer {
    let mut trainer = toy::trainer(toy::learner(config, 3, 5), 5);
    (0..steps).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    trainer
}

fn saved(trainer: &Trainer) -> State {
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    state
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
    let mut action = [0.0];
    trainer.agent_mut().act(&[0.7], Mode::Exploit, &mut action).unwrap();
    let s = (0.7 - mean) / variance.sqrt();
    let wanted = f64::from(online[0]) + f64::from(online[1]) * s;
    assert!(wanted.abs() < 1.0 && (f64::from(action[0]) - wanted).abs() < 1e-5, "{action:?}, not {wanted}");
}

/// The policy alone, from the saved state, acts as the agent does; without its normaliser it would not.
#[test]
fn a_saved_policy_takes_its_normaliser_along() {
    let mut trainer = trained(normalised(), 600);
    let state = saved(&trainer);
    let actor = Box::new(toy::LinearActor::new(0.005));
    let mut policy = Policy::load(actor, 1, state.child("agent").unwrap()).unwrap();
    for s in [-0.9, 0.1, 0.7] {
        let (mut wanted, mut got) = ([0.0], [0.0]);
        trainer.agent_mut().act(&[s], Mode::Exploit, &mut wanted).unwrap();
        policy.act(&[s], &mut got).unwrap();
        assert_eq!(got, wanted);
    }
}

#[test]
fn evaluation_moves_nothing() {
    let mut trainer = trained(normalised(), 300);
    let before = saved(&trainer);
    evaluate(trainer.agent_mut(), &mut Toy::new(), 3, 0, 0.5).unwrap();
    assert!(saved(&trainer) == before);
}

#[test]
fn a_normalised_run_resumes_bit_for_bit_and_differs_from_a_raw_one() {
    let whole = saved(&trained(normalised(), 500));
    let mut resumed = toy::trainer(toy::learner(normalised(), 3, 5), 5);
    resumed.load(&saved(&trained(normalised(), 313))).unwrap();
    (313..500).for_each(|_| drop(resumed.step(&mut Silent).unwrap()));
    assert!(saved(&resumed) == whole);
    assert_ne!(saved(&trained(toy::config(), 500)), whole);
}
