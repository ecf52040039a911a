//! A warm fused update allocates nothing but the packing buffers that the `gemm` crate makes inside its products.

mod common;

use common::{Case, given, given_action, init};
use copq::{Actor, Critic, Net};

fn allocations(work: impl FnMut()) -> u64 {
    allocation_counter::measure(work).count_total
}

/// Layer sizes of a network.
fn layers(input: usize, hidden: &[usize], output: usize) -> Vec<(usize, usize)> {
    let widths: Vec<_> = [input].iter().chain(hidden).chain([&output]).copied().collect();
    widths.windows(2).map(|pair| (pair[0], pair[1])).collect()
}

/// What `gemm` alone allocates for `out (m x n) = left (m x k) * right (k x n)`, called as the crate calls it.
fn product(m: usize, n: usize, k: usize, left_t: bool, right_t: bool) -> u64 {
    let (left, right, mut out) = (vec![0f32; m * k], vec![0f32; k * n], vec![0f32; m * n]);
    let steps = |rows: usize, cols: usize, t: bool| if t { (1, rows as isize) } else { (cols as isize, 1) };
    let ((left_row, left_col), (right_row, right_col)) = (steps(m, k, left_t), steps(k, n, right_t));
    let mut call = || {
        // SAFETY: three buffers of exactly the sizes and steps given.
        unsafe {
            let (left, right, out) = (left.as_ptr(), right.as_ptr(), out.as_mut_ptr());
            let (none, n_step) = (gemm::Parallelism::None, n as isize);
            gemm::gemm(
                m, n, k, out, 1, n_step, false, left, left_col, left_row, right, right_col, right_row, 0.0, 1.0, false,
                false, false, none,
            );
        }
    };
    call();
    allocations(call)
}

fn forward(rows: usize, layers: &[(usize, usize)]) -> u64 {
    layers.iter().map(|&(input, output)| product(rows, output, input, false, true)).sum()
}

fn backward(rows: usize, layers: &[(usize, usize)]) -> u64 {
    let weights = layers.iter().map(|&(input, output)| product(output, input, rows, true, false)).sum::<u64>();
    weights + down(rows, &layers[1..])
}

fn down(rows: usize, layers: &[(usize, usize)]) -> u64 {
    layers.iter().map(|&(input, output)| product(rows, input, output, false, false)).sum()
}

#[test]
fn warm_updates() {
    for case in [Case::new(4, 3, &[64, 64], 1), Case::new(4, 3, &[256, 256], 256), Case::new(3, 2, &[7, 9, 4], 37)] {
        let mut critic = copq_candle::critic(&case.spec(), case.critics, &case.networks(), &mut init(1)).unwrap();
        let mut actor = copq_candle::actor(&case.spec(), &case.networks(), &mut init(1)).unwrap();
        let (obs, act, dq) = (case.obs(1), case.act(1), vec![0.1; case.q_len()]);
        let (mut next, mut q, mut gradient) = (act.clone(), vec![0.0; case.q_len()], act.clone());
        let mut update = || {
            actor.sample(Net::Target, &obs, &[], &mut next, &mut []).unwrap();
            critic.values(Net::Target, &obs, &next, &mut q).unwrap();
            critic.fit(&obs, &act, &mut given(&dq)).unwrap();
            critic.action_grad(&obs, &next, &mut given(&dq), &mut gradient).unwrap();
            actor.improve(&obs, &[], &mut given_action(&gradient)).unwrap();
            critic.track(0.005).unwrap();
            actor.track(0.005).unwrap();
        };
        update();
        let ours = allocations(&mut update);

        let of_critic = layers(case.observation + case.action, &case.hidden, case.objectives);
        let of_actor = layers(case.observation, &case.hidden, case.action);
        let to_action = product(case.rows, case.action, case.hidden[0], false, false);
        let critics = 3 * forward(case.rows, &of_critic)
            + backward(case.rows, &of_critic)
            + down(case.rows, &of_critic[1..])
            + to_action;
        let gemms = case.critics as u64 * critics + 2 * forward(case.rows, &of_actor) + backward(case.rows, &of_actor);
        println!("{case:?}: {ours} allocations, {gemms} of them in gemm");
        assert_eq!(ours, gemms, "{case:?}");
    }
}

#[test]
fn warm_gaussian_updates() {
    for case in [Case::new(1, 1, &[64, 64], 1), Case::new(1, 1, &[256, 256], 256), Case::new(1, 1, &[7, 9, 4], 37)] {
        let mut actor = copq_candle::gaussian_actor(&case.spec(), &case.networks(), &mut init(1)).unwrap();
        let (obs, noise, mut action, mut log_prob) = (case.obs(1), case.noise(1), case.act(1), vec![0.0; case.rows]);
        let mut update = || {
            actor.sample(Net::Online, &obs, &noise, &mut action, &mut log_prob).unwrap();
            actor.improve(&obs, &noise, &mut given_action(&noise)).unwrap();
            actor.noise_grad(&obs, &noise, &noise, &mut action).unwrap();
            actor.track(0.005).unwrap();
        };
        update();
        let ours = allocations(&mut update);
        let layers = layers(case.observation, &case.hidden, 2 * case.action);
        assert_eq!(ours, 3 * forward(case.rows, &layers) + backward(case.rows, &layers), "{case:?}");
    }
}
