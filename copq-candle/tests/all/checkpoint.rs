//! Saving, loading, seeds and threads: the same bits.

use crate::common;

use common::{Case, fit, given, given_action, improve, init, normals, saved};
use copq::{Actor, Critic, Error, State};
use copq_candle::fused;

fn case() -> Case {
    Case::new(4, 3, &[33, 17], 37)
}

/// Updates number `from..to` of a little training run.
fn train(critic: &mut dyn Critic, actor: &mut dyn Actor, from: u64, to: u64) {
    let case = case();
    for i in from..to {
        fit(critic, &case.obs(i), &case.act(i), &normals(90 + i, case.rows * case.objectives));
        improve(actor, critic, &case.obs(i));
        actor.update_target(0.1).unwrap();
    }
}

fn both(critic: &dyn Critic, actor: &dyn Actor) -> [State; 2] {
    [saved(critic), saved(actor)]
}

#[test]
fn same_seed_same_bits_and_another_seed_others() {
    for i in 0..2 {
        let run = |seed| {
            let mut critics = case().critics(seed);
            let mut actors = case().actors(seed);
            train(critics[i].as_mut(), actors[i].as_mut(), 0, 5);
            both(critics[i].as_ref(), actors[i].as_ref())
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }
}

#[test]
fn a_resumed_run_is_the_unbroken_run() {
    for i in 0..2 {
        let mut critics = case().critics(1);
        let mut actors = case().actors(1);
        train(critics[i].as_mut(), actors[i].as_mut(), 0, 4);
        let [critic_state, actor_state] = both(critics[i].as_ref(), actors[i].as_ref());
        train(critics[i].as_mut(), actors[i].as_mut(), 4, 8);

        let mut resumed = case().critics(77);
        let mut resumed_actors = case().actors(78);
        resumed[i].load(&critic_state).unwrap();
        resumed_actors[i].load(&actor_state).unwrap();
        train(resumed[i].as_mut(), resumed_actors[i].as_mut(), 4, 8);
        assert_eq!(
            both(critics[i].as_ref(), actors[i].as_ref()),
            both(resumed[i].as_ref(), resumed_actors[i].as_ref())
        );
    }
}

#[test]
fn a_checkpoint_crosses_between_the_implementations_unchanged() {
    for (from, to) in [(0, 1), (1, 0)] {
        let mut critics = case().critics(1);
        let mut actors = case().actors(1);
        train(critics[from].as_mut(), actors[from].as_mut(), 0, 4);
        let [critic_state, actor_state] = both(critics[from].as_ref(), actors[from].as_ref());
        critics[to].load(&critic_state).unwrap();
        actors[to].load(&actor_state).unwrap();
        assert_eq!(both(critics[to].as_ref(), actors[to].as_ref()), [critic_state, actor_state]);
    }
}

#[test]
fn more_threads_change_no_bit() {
    // A product of the second hidden layer is large enough to be shared.
    let wide = Case { critics: 5, hidden: vec![64, 144], rows: 257, ..case() };
    let run = |threads| {
        let mut critic =
            fused::Critics::new(&wide.spec(), 5, &wide.networks(), &mut init(1)).unwrap();
        critic = critic.threads(threads).unwrap();
        let actor =
            fused::Deterministic::new(&wide.spec(), &wide.networks(), &mut init(1)).unwrap();
        let mut actor = actor.threads(threads).unwrap();
        let gaussian = fused::Gaussian::new(&wide.spec(), &wide.networks(), &mut init(1)).unwrap();
        let mut gaussian = gaussian.threads(threads).unwrap();
        let mut gradient = vec![0.0; wide.rows * wide.action];
        for i in 0..5 {
            fit(&mut critic, &wide.obs(i), &wide.act(i), &normals(i, wide.rows * wide.objectives));
            let dq = vec![-0.1; wide.q_len()];
            critic.action_grad(&wide.obs(i), &wide.act(i), &mut given(&dq), &mut gradient).unwrap();
            improve(&mut actor, &mut critic, &wide.obs(i));
            gaussian.improve(&wide.obs(i), &wide.noise(i), &mut given_action(&gradient)).unwrap();
        }
        (
            saved(&critic as &dyn Critic),
            saved(&actor as &dyn Actor),
            saved(&gaussian as &dyn Actor),
            gradient,
        )
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
}

#[test]
fn a_gradient_that_fails_changes_nothing() {
    for mut critic in case().critics(1) {
        let before = saved(critic.as_ref());
        let refuse =
            &mut |_: copq::QView<'_>, _: &mut [f32]| Err(Error::invalid("loss", "a number", "NaN"));
        assert!(critic.fit(&case().obs(1), &case().act(1), refuse, 0.1).is_err());
        assert_eq!(saved(critic.as_ref()), before);
    }
}

#[test]
fn other_tools_read_saved_matrices_as_matrices() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("critics.safetensors");
    let case = case();
    let critic = fused::Critics::new(&case.spec(), 4, &case.networks(), &mut init(3)).unwrap();
    saved(&critic as &dyn Critic).write_file(&path).unwrap();
    let bytes = std::fs::read(path).unwrap();
    let tensors = safetensors::SafeTensors::deserialize(&bytes).unwrap();
    let shape = |name: &str| tensors.tensor(name).unwrap().shape().to_vec();
    assert_eq!(shape("critic.3/online/layer.2.weight"), [3, 17]);
    assert_eq!(shape("critic.0/target/layer.0.bias"), [33]);
}
