//! Wrong shapes and settings are errors that a person can read: the thing, what was wanted, what
//! came.

use crate::common;

use common::{Case, init, saved};
use copq::on_policy::GaussianPolicy;
use copq::{Actor, Net, Networks, Precision, Result};
use copq_candle::fused;

fn case() -> Case {
    Case::new(2, 3, &[5, 4], 7)
}

/// Asserts that a result is an error that contains all these words.
fn assert_says<T>(result: Result<T>, words: &[&str]) {
    let Err(error) = result else { panic!("no error; wanted one with {words:?}") };
    let text = error.to_string();
    assert!(words.iter().all(|word| text.contains(word)), "'{text}' lacks one of {words:?}");
}

#[test]
fn critics_check_every_slice() {
    let case = case();
    let nothing = &mut |_: copq::QView<'_>, _: &mut [f32]| Ok(());
    let obs = case.obs(1);
    let act = case.act(1);
    let mut q = vec![0.0; case.q_len()];
    for mut critic in case.critics(1) {
        let short = &obs[1..];
        assert_says(
            critic.values(Net::Online, short, &act, &mut q),
            &["observations", "multiple of 6", "41"],
        );
        assert_says(
            critic.values(Net::Online, &[], &[], &mut q),
            &["observations", "positive", "0"],
        );
        assert_says(
            critic.values(Net::Target, &obs, &act[2..], &mut q),
            &["actions", "14 values", "12"],
        );
        assert_says(
            critic.values(Net::Online, &obs, &act, &mut q[1..]),
            &["critic values", "42 values", "41"],
        );
        for chosen in [&[][..], &[0, 0], &[0, 2]] {
            let error = critic.values_of(Net::Target, chosen, &obs, &act, &mut q);
            assert_says(
                error,
                &["chosen critics", "different ones below 2", &format!("{chosen:?}")],
            );
        }
        let error = critic.values_of(Net::Target, &[1], &obs, &act, &mut q[..20]);
        assert_says(error, &["critic values", "values, got"]);
        assert_says(critic.fit(short, &act, nothing, 0.0), &["observations", "41"]);
        assert_says(critic.fit(&obs, &act[1..], nothing, 0.0), &["actions", "13"]);
        assert_says(
            critic.action_grad(&obs, &act, nothing, &mut [0.0; 3]),
            &["action gradients", "14 values", "3"],
        );
        for tau in [-0.1, 1.5, f32::NAN] {
            assert_says(critic.fit(&obs, &act, nothing, tau), &["tau", "[0, 1]", &tau.to_string()]);
        }
    }
}

#[test]
fn actors_check_every_slice_and_refuse_noise() {
    let case = case();
    let nothing = &mut |_: copq::Sample<'_>, _: copq::SampleGrad<'_>| Ok(());
    let obs = case.obs(1);
    let mut action = vec![0.0; 14];
    for mut actor in case.actors(1) {
        assert_says(actor.mode(Net::Online, &obs[1..], &mut action), &["observations", "41"]);
        assert_says(
            actor.mode(Net::Online, &obs, &mut action[1..]),
            &["actions", "14 values", "13"],
        );
        assert_says(
            actor.sample(Net::Online, &obs, &[0.5; 14], &mut action, &mut [0.0; 7]),
            &["deterministic", "Actor::mode"],
        );
        assert_says(actor.improve(&obs[1..], &[], nothing), &["observations", "41"]);
        assert_says(actor.improve(&obs, &[0.5], nothing), &["noise", "deterministic", "1"]);
        assert_says(actor.update_target(2.0), &["tau", "2"]);
    }
}

#[test]
fn networks_of_f32_alone_refuse_other_precisions() {
    let spec = case().spec();
    let networks = Networks { precision: Precision::Backward, ..case().networks() };
    let words = ["networks.precision", "f32", "backward"];
    assert_says(fused::Normal::new(&spec, &networks, &mut init(1)), &words);
    assert_says(fused::Value::new(&spec, &networks, &mut init(1)), &words);
}

#[test]
fn settings_are_checked() {
    let spec = case().spec();
    let good = case().networks();
    let critic =
        |critics, networks: &Networks| fused::Critics::new(&spec, critics, networks, &mut init(1));
    assert_says(critic(0, &good), &["critics", "at least 1", "0"]);
    assert_says(critic(2, &Networks { hidden: vec![], ..good.clone() }), &["networks.hidden"]);
    assert_says(critic(2, &good).unwrap().threads(0), &["threads", "at least 1", "0"]);
    let actor = fused::Deterministic::new(&spec, &good, &mut init(1)).unwrap();
    assert_says(actor.threads(0), &["threads", "at least 1", "0"]);
    let mut spec = spec.clone();
    spec.obs_len = 0;
    assert_says(fused::Deterministic::new(&spec, &good, &mut init(1)), &["observation"]);
}

#[test]
fn states_of_other_networks_are_refused_and_change_nothing() {
    for (other, words) in [
        (Case { critics: 3, ..case() }, &["saved critics", "2", "3"]),
        (Case { hidden: vec![5, 6], ..case() }, &["layer.1.weight", "[4, 5]", "[6, 5]"]),
        (Case { objectives: 2, ..case() }, &["layer.2.weight", "[3, 4]", "[2, 4]"]),
    ] {
        let state = saved(other.critics(1)[0].as_ref());
        for mut critic in case().critics(2) {
            let before = saved(critic.as_ref());
            assert_says(critic.load(&state), words);
            assert_eq!(saved(critic.as_ref()), before);
        }
    }
    for mut actor in case().actors(1) {
        assert_says(actor.load(&copq::State::default()), &["online"]);
    }
    let normal = |case: &Case, seed| {
        fused::Normal::new(&case.spec(), &case.networks(), &mut init(seed)).unwrap()
    };
    let (mut policy, other) =
        (normal(&case(), 1), normal(&Case { hidden: vec![5, 6], ..case() }, 2));
    policy.shift(&vec![0.5; policy.parameters()]).unwrap();
    let before = saved(&policy as &dyn Actor);
    assert_says(policy.load(&saved(&other as &dyn Actor)), &["layer.1.weight", "[6, 5]"]);
    assert_eq!(saved(&policy as &dyn Actor), before);
}
