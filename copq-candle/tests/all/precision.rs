//! What fewer bits change, and what they do not.

use crate::common;

use common::{Case, fit, given, init, normals, saved};
use copq::projection::{BoundQuery, Cholesky, Projection, QView, Scratch};
use copq::{Critic, Net, Networks, Precision, State};
use copq_candle::fused;

fn case() -> Case {
    Case { observation: 17, action: 6, ..Case::new(4, 3, &[64, 48], 101) }
}

fn networks(precision: Precision) -> Networks {
    Networks { precision, ..case().networks() }
}

fn critics(precision: Precision) -> fused::Critics {
    fused::Critics::new(&case().spec(), 4, &networks(precision), &mut init(1)).unwrap()
}

/// Critics of several ages, which have learned a function of observations and actions.
fn ages() -> Vec<State> {
    let case = case();
    let mut critics = critics(Precision::F32);
    let mut ages = Vec::new();
    for i in 0..=300 {
        if [0, 30, 300].contains(&i) {
            ages.push(saved(&critics as &dyn Critic));
        }
        let (obs, act) = (case.obs(i), case.act(i));
        let target: Vec<f32> = obs
            .chunks(case.observation)
            .zip(act.chunks(case.action))
            .flat_map(|(obs, act)| [obs[0] * act[0], obs[1].sin() + act[1], 3.0 + obs[2]])
            .collect();
        fit(&mut critics, &obs, &act, &target);
    }
    ages
}

fn at_age(precision: Precision, age: &State) -> fused::Critics {
    let mut critics = critics(precision);
    critics.load(age).unwrap();
    critics
}

fn values(critics: &mut fused::Critics, net: Net) -> Vec<f32> {
    let mut q = vec![0.0; case().q_len()];
    critics.values(net, &case().obs(900), &case().act(900), &mut q).unwrap();
    q
}

/// Adam's first moments of so many critics.
fn moments(critics: &fused::Critics, count: usize) -> Vec<f32> {
    let state = saved(critics as &dyn Critic);
    let mut all = Vec::new();
    for k in 0..count {
        let m = state.child(&format!("critic.{k}")).unwrap().child("adam_m").unwrap();
        m.values().for_each(|(name, _)| all.extend_from_slice(m.get::<f32>(name).unwrap()));
    }
    all
}

/// dL/dparameters of all critics, for a given dL/dq: what one step adds to Adam's first moment.
fn gradient(critics: &mut fused::Critics) -> Vec<f32> {
    let before = moments(critics, 4);
    let dq = normals(7, case().q_len());
    critics.fit(&case().obs(900), &case().act(900), &mut given(&dq), 0.0).unwrap();
    let after = moments(critics, 4);
    after.iter().zip(before).map(|(after, before)| (after - 0.9 * before) / 0.1).collect()
}

/// The gradient of the mean lower bound to the actions.
fn bound_to_actions(critics: &mut fused::Critics) -> Vec<f32> {
    let case = case();
    let mut scratch = Scratch::default();
    let mut out = vec![0.0; case.rows * case.action];
    let up = vec![1.0; case.rows * case.objectives];
    let bound = &mut |q: QView<'_>, grad: &mut [f32]| {
        let query = BoundQuery { q, weights: &[1.0, 1.0, 1.0], step: -1.0 };
        Cholesky.vjp(query, &mut scratch, &up, grad)
    };
    critics.action_grad(&case.obs(900), &case.act(900), bound, &mut out).unwrap();
    out
}

/// By how much the lower bound is below the critics' mean, row by row.
fn margins(q: &[f32]) -> Vec<f32> {
    let case = case();
    let q = QView::new(q, case.critics, case.objectives).unwrap();
    let weights = vec![1.0; case.objectives];
    let bound = |step| {
        let mut out = vec![0.0; case.rows * case.objectives];
        let asked = BoundQuery { q, weights: &weights, step };
        Cholesky.project(asked, &mut Scratch::default(), &mut out).unwrap();
        out
    };
    bound(0.0).iter().zip(bound(-1.0)).map(|(mean, bound)| mean - bound).collect()
}

/// The root mean square of a difference, in that of what is wanted.
fn error(got: &[f32], wanted: &[f32]) -> f64 {
    let square = |x: f32| f64::from(x).powi(2);
    let difference: f64 = got.iter().zip(wanted).map(|(got, wanted)| square(got - wanted)).sum();
    (difference / wanted.iter().map(|&x| square(x)).sum::<f64>()).sqrt()
}

#[test]
fn backward_leaves_all_values_as_they_are_and_blurs_gradients_little() {
    for age in ages() {
        let [mut exact, mut half] =
            [Precision::F32, Precision::Backward].map(|precision| at_age(precision, &age));
        for net in [Net::Online, Net::Target] {
            assert_eq!(values(&mut exact, net), values(&mut half, net));
        }
        let errors = [
            error(&bound_to_actions(&mut half), &bound_to_actions(&mut exact)),
            error(&gradient(&mut half), &gradient(&mut exact)),
        ];
        assert!(errors.iter().all(|&error| error > 0.0 && error < 0.005), "{errors:?}");
        assert!(!half.exact_values(&case().obs(1), &case().act(1), &mut []).unwrap());
    }
}

#[test]
fn careful_blurs_values_and_margins_little() {
    // Fresh critics say little, so that the same rounding is more of it.
    for (age, most) in ages().into_iter().zip([2e-3, 1e-3, 1e-3]) {
        let [mut exact, mut half] =
            [Precision::F32, Precision::Careful].map(|precision| at_age(precision, &age));
        for net in [Net::Online, Net::Target] {
            let [half, exact] = [&mut half, &mut exact].map(|critics| values(critics, net));
            let errors = [error(&half, &exact), error(&margins(&half), &margins(&exact))];
            println!("{net:?}: values {:.1e}, margins {:.1e}", errors[0], errors[1]);
            assert!(errors[0] > 0.0 && errors[0] < most && errors[1] < 0.02, "{errors:?}");
        }
        let wanted = values(&mut exact, Net::Online);
        let mut q = vec![0.0; wanted.len()];
        assert!(half.exact_values(&case().obs(900), &case().act(900), &mut q).unwrap());
        assert_eq!(q, wanted);
        let bound = error(&bound_to_actions(&mut half), &bound_to_actions(&mut exact));
        assert!(bound > 0.0 && bound < 0.01, "{bound}");
        let loss = error(&gradient(&mut half), &gradient(&mut exact));
        assert!(loss > 0.0 && loss < 0.1, "{loss}");
    }
}

/// Odd sizes, one row, one hidden layer, smooth activations: a first step's moments.
#[test]
fn every_shape_and_activation_steps_as_f32_does() {
    for case in Case::all() {
        let step = |precision| {
            let networks = Networks { precision, ..case.networks() };
            let mut critics =
                fused::Critics::new(&case.spec(), case.critics, &networks, &mut init(1)).unwrap();
            let mut grad = vec![0.0; case.rows * case.action];
            let (obs, act, dq) = (case.obs(1), case.act(1), normals(7, case.q_len()));
            critics.action_grad(&obs, &act, &mut given(&dq), &mut grad).unwrap();
            critics.fit(&obs, &act, &mut given(&dq), 0.0).unwrap();
            [moments(&critics, case.critics), grad]
        };
        let wanted = step(Precision::F32);
        // Careful's activations may open a ReLU that is shut in f32.
        for (precision, limit) in [(Precision::Backward, 0.01), (Precision::Careful, 0.1)] {
            for (got, wanted) in step(precision).iter().zip(&wanted) {
                let error = error(got, wanted);
                assert!(error < limit, "{case:?}, {precision}: {error}");
            }
        }
    }
}

#[test]
fn the_same_bits_again_and_on_more_threads() {
    let case = case();
    let run = |precision, threads| {
        let mut critics = critics(precision).threads(threads).unwrap();
        for i in 0..4 {
            fit(&mut critics, &case.obs(i), &case.act(i), &normals(i, case.rows * 3));
            bound_to_actions(&mut critics);
        }
        saved(&critics as &dyn Critic)
    };
    let all = [Precision::F32, Precision::Backward, Precision::Careful];
    let once = all.map(|precision| run(precision, 1));
    assert!(once[0] != once[1] && once[1] != once[2]);
    for (precision, once) in all.into_iter().zip(&once) {
        assert_eq!(run(precision, 3), *once);
        assert_eq!(once_in(precision), once_in(Precision::F32), "a state says no precision");
    }
}

fn once_in(precision: Precision) -> State {
    saved(&critics(precision) as &dyn Critic)
}

#[test]
fn networks_by_autograd_have_f32_alone() {
    let networks = networks(Precision::Backward);
    let device = copq_candle::Device::Cpu;
    let made =
        copq_candle::plain::Critics::new(&case().spec(), 2, &networks, &mut init(1), &device);
    assert_eq!(
        made.unwrap_err().to_string(),
        "networks.precision: wanted f32 for networks by autograd, got backward"
    );
}
