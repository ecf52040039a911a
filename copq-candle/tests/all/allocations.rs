//! A warm fused update allocates nothing.

use crate::common;

use common::{Case, given, given_action, init};
use copq::{Activation, Actor, Critic, Net, Networks, Precision};
use copq_candle::fused;

fn allocations(work: impl FnMut()) -> u64 {
    allocation_counter::measure(work).count_total
}

#[test]
fn warm_updates() {
    let usual = || Case::new(2, 2, &[64, 64], 37);
    let smooth = |activation| Case { activation, ..usual() };
    for (case, precision) in [
        (Case::new(4, 3, &[64, 64], 1), Precision::F32),
        (Case::new(4, 3, &[256, 256], 256), Precision::F32),
        (Case::new(3, 2, &[7, 9, 4], 37), Precision::F32),
        (smooth(Activation::Tanh), Precision::F32),
        (smooth(Activation::Silu), Precision::F32),
        (usual(), Precision::Backward),
        (usual(), Precision::Careful),
        // What weights make of so many observations is kept.
        (Case { observation: 100, ..usual() }, Precision::F32),
    ] {
        let networks = Networks { precision, ..case.networks() };
        let mut critic =
            fused::Critics::new(&case.spec(), case.critics, &networks, &mut init(1)).unwrap();
        let mut actor = fused::Deterministic::new(&case.spec(), &networks, &mut init(1)).unwrap();
        let obs = case.obs(1);
        let act = case.act(1);
        let dq = vec![0.1; case.q_len()];
        let mut next = act.clone();
        let mut q = vec![0.0; case.q_len()];
        let mut gradient = act.clone();
        let mut update = || {
            actor.mode(Net::Target, &obs, &mut next).unwrap();
            critic.values(Net::Target, &obs, &next, &mut q).unwrap();
            let one = &mut q[..case.q_len() / case.critics];
            critic.values_of(Net::Target, &[0], &obs, &next, one).unwrap();
            critic.fit(&obs, &act, &mut given(&dq), 0.005).unwrap();
            critic.action_grad(&obs, &next, &mut given(&dq), &mut gradient).unwrap();
            actor.improve(&obs, &[], &mut given_action(&gradient)).unwrap();
            actor.update_target(0.005).unwrap();
        };
        update();
        assert_eq!(allocations(&mut update), 0, "{case:?} {precision:?}");
    }
}

#[test]
fn warm_gaussian_updates() {
    for case in [
        Case::new(1, 1, &[64, 64], 1),
        Case::new(1, 1, &[256, 256], 256),
        Case::new(1, 1, &[7, 9, 4], 37),
    ] {
        let mut actor = fused::Gaussian::new(&case.spec(), &case.networks(), &mut init(1)).unwrap();
        let obs = case.obs(1);
        let noise = case.noise(1);
        let mut action = case.act(1);
        let mut log_prob = vec![0.0; case.rows];
        let mut update = || {
            actor.sample(Net::Online, &obs, &noise, &mut action, &mut log_prob).unwrap();
            actor.improve(&obs, &noise, &mut given_action(&noise)).unwrap();
            actor.noise_grad(&obs, &noise, &noise, &mut action).unwrap();
            actor.update_target(0.005).unwrap();
        };
        update();
        assert_eq!(allocations(&mut update), 0, "{case:?}");
    }
}
