//! The fused implementation against candle's tensors and autograd: values, gradients and whole
//! updates.

use crate::common;

use common::{Case, arrays, assert_close, fit, given, given_action, improve, normals, saved};
use copq::{Actor, Critic, Net, State, Value};

/// The arrays of a part of the saved state (`online`, `target`, `adam_m`, ...), one after another.
fn part(state: &State, part: &str) -> Vec<f32> {
    let of_part =
        arrays(state).into_iter().filter(|(path, _)| path.split('/').any(|name| name == part));
    of_part
        .flat_map(|(_, value)| if let Value::F32(values) = value { values } else { vec![] })
        .collect()
}

fn values(critic: &mut dyn Critic, net: Net, case: &Case, seed: u64) -> Vec<f32> {
    let mut q = vec![0.0; case.q_len()];
    critic.values(net, &case.obs(seed), &case.act(seed), &mut q).unwrap();
    q
}

fn actions(actor: &mut dyn Actor, net: Net, case: &Case, seed: u64) -> Vec<f32> {
    let mut action = vec![0.0; case.rows * case.action];
    actor.mode(net, &case.obs(seed), &mut action).unwrap();
    action
}

#[test]
fn same_initial_state_bit_for_bit() {
    for case in Case::all() {
        let [fused, plain] = case.critics(3);
        assert_eq!(saved(fused.as_ref()), saved(plain.as_ref()));
        let [fused, plain] = case.actors(3);
        assert_eq!(saved(fused.as_ref()), saved(plain.as_ref()));
    }
}

#[test]
fn values_and_actions() {
    for case in Case::all() {
        let [mut fused, mut plain] = case.critics(1);
        let [q, wanted] = [
            values(fused.as_mut(), Net::Online, &case, 1),
            values(plain.as_mut(), Net::Online, &case, 1),
        ];
        assert_close(&format!("q of {case:?}"), &q, &wanted, 1e-5);
        let [mut fused, mut plain] = case.actors(1);
        let [a, wanted] = [
            actions(fused.as_mut(), Net::Target, &case, 1),
            actions(plain.as_mut(), Net::Target, &case, 1),
        ];
        assert_close(&format!("actions of {case:?}"), &a, &wanted, 1e-5);
    }
}

#[test]
fn chosen_critics_answer_as_among_all() {
    for case in Case::all() {
        let rows = case.rows;
        let n = case.objectives;
        for mut critic in case.critics(1) {
            let all = values(critic.as_mut(), Net::Target, &case, 1);
            let chosen: Vec<_> = (0..critic.critics()).rev().step_by(2).collect();
            let mut q = vec![0.0; chosen.len() * rows * n];
            critic.values_of(Net::Target, &chosen, &case.obs(1), &case.act(1), &mut q).unwrap();
            for (q, k) in q.chunks_exact(rows * n).zip(chosen) {
                assert_eq!(q, &all[k * rows * n..][..rows * n], "critic {k} of {case:?}");
            }
        }
    }
}

/// Adam's first moment after one step is a tenth of the gradient.
#[test]
fn single_gradients() {
    for case in Case::all() {
        let dq = normals(9, case.q_len());
        let gradient = |critic: &mut dyn Critic| {
            let mut out = vec![0.0; case.rows * case.action];
            critic.action_grad(&case.obs(2), &case.act(2), &mut given(&dq), &mut out).unwrap();
            critic.fit(&case.obs(2), &case.act(2), &mut given(&dq), 0.1).unwrap();
            (out, part(&saved(critic), "adam_m"))
        };
        let [mut fused, mut plain] = case.critics(2);
        let [(action, m), (wanted_action, wanted_m)] =
            [gradient(fused.as_mut()), gradient(plain.as_mut())];
        assert_close(&format!("action gradient of {case:?}"), &action, &wanted_action, 1e-5);
        assert_close(&format!("parameter gradient of {case:?}"), &m, &wanted_m, 1e-5);

        let da = normals(10, case.rows * case.action);
        let gradient = |actor: &mut dyn Actor| {
            actor.improve(&case.obs(2), &[], &mut given_action(&da)).unwrap();
            part(&saved(actor), "adam_m")
        };
        let [mut fused, mut plain] = case.actors(2);
        let [m, wanted_m] = [gradient(fused.as_mut()), gradient(plain.as_mut())];
        assert_close(&format!("actor's gradient of {case:?}"), &m, &wanted_m, 1e-5);
    }
}

#[test]
fn a_hundred_updates() {
    for case in Case::all() {
        let [mut fused, mut plain] = case.critics(4);
        let [mut fused_actor, mut plain_actor] = case.actors(5);
        let [losses, wanted] = [(&mut fused, &mut fused_actor), (&mut plain, &mut plain_actor)]
            .map(|(critic, actor)| {
                let update = |i| {
                    let target = normals(50 + i, case.rows * case.objectives);
                    let loss = fit(critic.as_mut(), &case.obs(i), &case.act(i), &target);
                    improve(actor.as_mut(), critic.as_mut(), &case.obs(i));
                    actor.update_target(0.1).unwrap();
                    loss
                };
                (0..100).map(update).collect::<Vec<_>>()
            });
        assert_close(&format!("losses of {case:?}"), &losses, &wanted, 1e-4);
        for net in [Net::Online, Net::Target] {
            let [q, wanted] =
                [values(fused.as_mut(), net, &case, 7), values(plain.as_mut(), net, &case, 7)];
            assert_close(&format!("q of {case:?}"), &q, &wanted, 1e-4);
            let [a, wanted] = [
                actions(fused_actor.as_mut(), net, &case, 7),
                actions(plain_actor.as_mut(), net, &case, 7),
            ];
            assert_close(&format!("actions of {case:?}"), &a, &wanted, 1e-4);
        }
        for name in ["online", "target", "adam_m", "adam_v"] {
            let [got, wanted] =
                [saved(fused.as_ref()), saved(plain.as_ref())].map(|state| part(&state, name));
            assert_close(&format!("critics' {name} of {case:?}"), &got, &wanted, 1e-4);
            let [got, wanted] = [saved(fused_actor.as_ref()), saved(plain_actor.as_ref())]
                .map(|state| part(&state, name));
            assert_close(&format!("actor's {name} of {case:?}"), &got, &wanted, 1e-4);
        }
    }
}

/// Where a ReLU's input is exactly 0 its derivative is 0, as in PyTorch.
#[test]
fn nothing_flows_through_a_relu_at_zero() {
    let case = Case::new(2, 2, &[5], 3);
    for mut critic in case.critics(1) {
        let mut state = saved(critic.as_ref());
        for k in 0..2 {
            let online = state.child_mut(&format!("critic.{k}")).child_mut("online");
            online.put("layer.0.weight", vec![0f32; 5 * 8]);
            online.put("layer.0.bias", vec![0f32; 5]);
        }
        critic.load(&state).unwrap();
        fit(critic.as_mut(), &case.obs(1), &case.act(1), &normals(2, 3 * 2));
        let fitted = saved(critic.as_ref());
        let m = fitted.child("critic.0").unwrap().child("adam_m").unwrap();
        assert!(m.get::<f32>("layer.0.bias").unwrap().iter().all(|&m| m == 0.0));
    }
}
