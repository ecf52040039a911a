//! The replay buffer against a plain list of transitions.

use copq::{Batch, EnvSpec, Outcome, Replay, Rng, State, Stream, Transition};
use proptest::prelude::*;

/// One transition as a test remembers it: everything in it follows from its number.
#[derive(Clone, Debug, PartialEq)]
struct Stored {
    obs: [f32; 2],
    action: [f32; 1],
    reward: [f32; 3],
    next_obs: [f32; 2],
    alive: f32,
}

/// With three objectives.
fn spec(obs_len: usize, action_len: usize) -> EnvSpec {
    let spec = EnvSpec::new("stored", obs_len, action_len);
    ["safety", "velocity", "control"].iter().fold(spec, |spec, name| spec.reward(*name, 1.0))
}

/// Episodes of the given lengths and endings, as a list. `Running` at an episode's end means that
/// it was broken off.
fn history(episodes: &[(usize, Outcome)]) -> Vec<(Stored, Outcome)> {
    let mut number = 0.0;
    let mut all = Vec::new();
    for &(length, ending) in episodes {
        let observations: Vec<f32> = (0..=length).map(|i| number + i as f32).collect();
        for pair in 0..length {
            let outcome = if pair + 1 == length { ending } else { Outcome::Running };
            let here = observations[pair];
            let next = observations[pair + 1];
            let alive = if outcome == Outcome::Terminated { 0.0 } else { 1.0 };
            let stored = Stored {
                obs: [here, -here],
                action: [here + 0.25],
                reward: [here, 2.0 * here, 0.5],
                next_obs: [next, -next],
                alive,
            };
            all.push((stored, outcome));
        }
        number += length as f32 + 1.0;
    }
    all
}

fn push(replay: &mut Replay, (t, outcome): &(Stored, Outcome)) {
    let obs = &t.obs;
    let next_obs = &t.next_obs;
    replay
        .push(Transition { obs, action: &t.action, reward: &t.reward, next_obs, outcome: *outcome })
        .unwrap();
}

/// Draws until every stored transition must have been seen, and returns the distinct ones in order.
fn contents(replay: &Replay, seed: u64) -> Vec<Stored> {
    let mut batch = Batch::default();
    let rows = 40 * replay.len();
    replay.sample(rows, &mut Rng::new(seed, Stream::Batch), &mut batch).unwrap();
    let mut seen: Vec<Stored> = (0..rows)
        .map(|i| Stored {
            obs: batch.obs[2 * i..][..2].try_into().unwrap(),
            action: [batch.action[i]],
            reward: batch.reward[3 * i..][..3].try_into().unwrap(),
            next_obs: batch.next_obs[2 * i..][..2].try_into().unwrap(),
            alive: batch.alive[i],
        })
        .collect();
    seen.sort_by(|a, b| a.obs[0].total_cmp(&b.obs[0]));
    seen.dedup();
    seen
}

fn outcome() -> impl Strategy<Value = Outcome> {
    prop_oneof![Just(Outcome::Terminated), Just(Outcome::Truncated), Just(Outcome::Running)]
}

proptest! {
    /// Whatever the episodes and the capacity, exactly the newest transitions are there, each with
    /// its own successor.
    #[test]
    fn holds_exactly_the_newest_transitions(
        episodes in prop::collection::vec((1usize..6, outcome()), 1..30),
        capacity in 1usize..40,
        saved_after in 0usize..60,
    ) {
        let all = history(&episodes);
        let mut replay = Replay::new(&spec(2, 1), capacity).unwrap();
        for (i, t) in all.iter().enumerate() {
            if i == saved_after {
                let mut state = State::default();
                replay.save(&mut state);
                replay = Replay::new(&spec(2, 1), capacity).unwrap();
                replay.load(&state).unwrap();
            }
            push(&mut replay, t);
        }
        let newest: Vec<_> =
            all[all.len().saturating_sub(capacity)..].iter().map(|(t, _)| t.clone()).collect();
        prop_assert_eq!(replay.len(), newest.len());
        prop_assert_eq!(contents(&replay, 1), newest);
    }
}

#[test]
fn a_million_hopper_transitions_take_at_most_90_megabytes() {
    let mut replay = Replay::new(&spec(11, 3), 1_000_000).unwrap();
    let mut obs = [0.0f32; 11];
    for i in 0..1_000_000u32 {
        let mut next_obs = obs;
        next_obs[0] = i as f32;
        // A random policy's episode on the hopper lasts about 20 steps: as many final observations
        // as there will be.
        let outcome = if i % 20 == 19 { Outcome::Terminated } else { Outcome::Running };
        let t = Transition {
            obs: &obs,
            action: &[0.0; 3],
            reward: &[1.0; 3],
            next_obs: &next_obs,
            outcome,
        };
        replay.push(t).unwrap();
        obs = next_obs;
    }
    assert_eq!(replay.len(), 1_000_000);
    assert!(replay.bytes() <= 90_000_000, "{} bytes", replay.bytes());
}

#[test]
fn memory_grows_as_it_fills() {
    let mut replay = Replay::new(&spec(11, 3), 1_000_000).unwrap();
    let t = Transition {
        obs: &[0.0; 11],
        action: &[0.0; 3],
        reward: &[0.0; 3],
        next_obs: &[0.0; 11],
        outcome: Outcome::Running,
    };
    replay.push(t).unwrap();
    assert!(replay.bytes() < 6_000_000, "{} bytes", replay.bytes());
}

#[test]
fn long_rows_grow_by_fewer() {
    const LONG: usize = 300_000;
    let mut replay = Replay::new(&spec(LONG, 1), 1_000_000).unwrap();
    for i in 0..60 {
        let obs = vec![i as f32; LONG];
        let next_obs = vec![i as f32 + 1.0; LONG];
        let (action, reward) = (&[0.0], &[0.0; 3]);
        let outcome = Outcome::Running;
        replay
            .push(Transition { obs: &obs, action, reward, next_obs: &next_obs, outcome })
            .unwrap();
    }
    assert!(replay.bytes() < 140 << 20, "{} bytes", replay.bytes());
    let mut batch = Batch::default();
    replay.sample(8, &mut Rng::new(0, Stream::Batch), &mut batch).unwrap();
    assert!(batch.obs.iter().zip(&batch.next_obs).all(|(here, next)| here + 1.0 == *next));
}

#[test]
fn sampling_is_uniform() {
    let mut replay = Replay::new(&spec(2, 1), 10).unwrap();
    history(&[(7, Outcome::Terminated), (6, Outcome::Truncated)])
        .iter()
        .for_each(|t| push(&mut replay, t));
    let mut batch = Batch::default();
    replay.sample(100_000, &mut Rng::new(0, Stream::Batch), &mut batch).unwrap();
    let mut counts = std::collections::BTreeMap::new();
    batch.obs.chunks(2).for_each(|obs| *counts.entry(obs[0] as u32).or_insert(0) += 1);
    assert_eq!(counts.len(), 10);
    assert!(counts.values().all(|&count| (9_600..10_400).contains(&count)), "{counts:?}");
}

#[test]
fn mistakes_are_readable_errors() {
    let mut replay = Replay::new(&spec(2, 1), 10).unwrap();
    let empty =
        replay.sample(1, &mut Rng::new(0, Stream::Batch), &mut Batch::default()).unwrap_err();
    assert_eq!(
        empty.to_string(),
        "replay buffer: wanted at least 1 transition to sample from, got 0"
    );
    let t = Transition {
        obs: &[0.0; 2],
        action: &[0.0; 2],
        reward: &[0.0; 3],
        next_obs: &[0.0; 2],
        outcome: Outcome::Running,
    };
    assert_eq!(
        replay.push(t).unwrap_err().to_string(),
        "transition's action: wanted 1 values, got 2"
    );
    assert_eq!(
        Replay::new(&spec(0, 1), 10).unwrap_err().to_string(),
        "stored: observation length: wanted at least 1, got 0"
    );
}

#[test]
fn a_damaged_checkpoint_is_a_readable_error() {
    let mut replay = Replay::new(&spec(2, 1), 10).unwrap();
    history(&[(3, Outcome::Terminated), (2, Outcome::Truncated)])
        .iter()
        .for_each(|t| push(&mut replay, t));
    let error = |change: &dyn Fn(&mut State)| {
        let mut state = State::default();
        replay.save(&mut state);
        change(&mut state);
        Replay::new(&spec(2, 1), 10).unwrap().load(&state).unwrap_err().to_string()
    };
    let cursor = error(&|state| state.put("cursor", [3u64]));
    assert_eq!(cursor, "saved replay's cursor: wanted a place among 5 transitions, got 3");
    let end = error(&|state| state.put("end", vec![0u64, 0, 2, 0, 1 + 2 * 7]));
    assert_eq!(end, "saved replay's last observation: wanted one of 2 last observations, got 7");
}
