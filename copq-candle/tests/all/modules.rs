//! Networks of a user's own architecture: the same as the plain ones where the architecture is, and
//! whole runs where not.

use approx::assert_abs_diff_eq;
use candle_core::{Module, Tensor};
use candle_nn::{VarBuilder, layer_norm_no_bias, linear, rms_norm};
use copq::projection::Cholesky;
use copq::{
    ActionGrad, Actor, ActorKind, Backend, Critic, EnvSpec, Learner, Method, Net, Networks, Policy,
    QView, Result, Rng, Silent, State, Stream,
};
use copq::{Agent, Mode, Outcome, Transition};
use copq_candle::{Candle, Device, Modules, plain};

fn spec() -> EnvSpec {
    EnvSpec::new("test", 3, 2).reward("safety", 1.0).reward("velocity", 1.0)
}

/// The multilayer perceptron of all other backends, written with candle-nn.
fn perceptron(
    vars: VarBuilder<'_>,
    input: usize,
    output: usize,
) -> candle_core::Result<Box<dyn Module + Send>> {
    let first = linear(input, 8, vars.pp("layer.0"))?;
    let last = linear(8, output, vars.pp("layer.1"))?;
    Ok(Box::new(move |x: &Tensor| last.forward(&first.forward(x)?.relu()?)))
}

fn normed(
    vars: VarBuilder<'_>,
    input: usize,
    output: usize,
) -> candle_core::Result<Box<dyn Module + Send>> {
    let first = linear(input, 8, vars.pp("first"))?;
    let norm = layer_norm_no_bias(8, 1e-5, vars.pp("norm"))?;
    let last = linear(8, output, vars.pp("last"))?;
    Ok(Box::new(move |x: &Tensor| last.forward(&norm.forward(&first.forward(x)?)?.relu()?)))
}

fn saved(critic: &dyn Critic) -> State {
    let mut state = State::default();
    critic.save(&mut state).unwrap();
    state
}

#[test]
fn a_module_of_the_same_layers_learns_as_the_plain_networks_do() {
    let networks = Networks { hidden: vec![8], critic_lr: 0.01, ..Networks::default() };
    let mut rng = Rng::new(1, Stream::Init);
    let mut plain = plain::Critics::new(&spec(), 3, &networks, &mut rng, &Device::Cpu).unwrap();
    let mut module =
        Modules::with_critics(perceptron).critics(&spec(), &networks, 3, &mut rng).unwrap();
    module.load(&saved(&plain)).unwrap();
    let obs = [0.1, -0.4, 0.8, 0.3, 0.2, -0.9];
    let act = [0.5, -0.5, 0.7, 0.1];
    let mut to_target = |q: QView<'_>, grad: &mut [f32]| -> Result<()> {
        grad.iter_mut().zip(q.values()).for_each(|(grad, q)| *grad = q - 2.0);
        Ok(())
    };
    for _ in 0..5 {
        plain.fit(&obs, &act, &mut to_target, 0.1).unwrap();
        module.fit(&obs, &act, &mut to_target, 0.1).unwrap();
    }
    for net in [Net::Online, Net::Target] {
        let mut a = [0.0; 12];
        let mut b = [0.0; 12];
        plain.values(net, &obs, &act, &mut a).unwrap();
        module.values(net, &obs, &act, &mut b).unwrap();
        assert_abs_diff_eq!(a[..], b[..], epsilon = 1e-6);
    }
    let mut a = [0.0; 4];
    let mut b = [0.0; 4];
    plain.action_grad(&obs, &act, &mut to_target, &mut a).unwrap();
    module.action_grad(&obs, &act, &mut to_target, &mut b).unwrap();
    assert_abs_diff_eq!(a[..], b[..], epsilon = 1e-6);
}

#[test]
fn a_stochastic_policy_of_a_module_is_the_plain_one_of_the_same_layers() {
    let networks = Networks { hidden: vec![8], actor_lr: 0.01, ..Networks::default() };
    let mut rng = Rng::new(2, Stream::Init);
    let mut plain = plain::Gaussian::new(&spec(), &networks, &mut rng, &Device::Cpu).unwrap();
    let backend = Modules::with_critics(normed).with_actor(perceptron);
    let kind = ActorKind::Gaussian;
    let mut module = Backend::actor(&backend, &spec(), &networks, kind, &mut rng).unwrap();
    let mut state = State::default();
    plain.save(&mut state).unwrap();
    module.load(&state).unwrap();
    let obs = [0.1, -0.4, 0.8, 0.3, 0.2, -0.9];
    let noise = [0.5, -0.5, 0.7, 0.1];
    let uphill: ActionGrad<'_> = &mut |sample, grad| {
        grad.action.copy_from_slice(sample.action);
        grad.log_prob.unwrap().fill(0.1);
        Ok(())
    };
    let mut sampled = [[0.0; 4]; 2];
    let mut log_prob = [[0.0; 2]; 2];
    let actors: [&mut dyn Actor; 2] = [&mut plain, module.as_mut()];
    for (i, actor) in actors.into_iter().enumerate() {
        for _ in 0..5 {
            actor.improve(&obs, &noise, uphill).unwrap();
        }
        actor.sample(Net::Online, &obs, &noise, &mut sampled[i], &mut log_prob[i]).unwrap();
    }
    assert_abs_diff_eq!(sampled[0][..], sampled[1][..], epsilon = 1e-6);
    assert_abs_diff_eq!(log_prob[0][..], log_prob[1][..], epsilon = 1e-5);
}

fn learner(seed: u64) -> Learner {
    let mut config = Method::cop_td3().warm_up(10).config;
    config.batch = 16;
    config.networks.actor_lr = 0.01;
    let method = Method::new("modules", config, Cholesky);
    Learner::new(method, &spec(), &Modules::with_critics(normed).with_actor(normed), seed).unwrap()
}

fn experience(learner: &mut Learner, steps: std::ops::Range<u32>) {
    for i in steps {
        let obs = [0.01 * i as f32; 3];
        let next_obs = [0.01 * (i + 1) as f32; 3];
        let mut action = [0.0; 2];
        learner.act(&obs, Mode::Explore, &mut action).unwrap();
        let outcome = Outcome::Running;
        let reward = [1.0 - action[0], -action[1]];
        learner
            .observe(Transition {
                obs: &obs,
                action: &action,
                reward: &reward,
                next_obs: &next_obs,
                outcome,
            })
            .unwrap();
        learner.update(&mut Silent).unwrap();
    }
}

fn state(learner: &Learner) -> State {
    let mut state = State::default();
    learner.save(&mut state).unwrap();
    state
}

#[test]
fn a_learner_of_modules_repeats_resumes_and_leaves_its_policy() {
    let whole = |seed| {
        let mut learner = learner(seed);
        experience(&mut learner, 0..40);
        learner
    };
    let one = whole(3);
    assert!(state(&one) == state(&whole(3)), "the same seed");
    assert!(state(&one) != state(&whole(4)), "another seed");

    let mut half = learner(3);
    experience(&mut half, 0..25);
    let mut resumed = learner(3);
    experience(&mut resumed, 0..13);
    resumed.load(&state(&half)).unwrap();
    experience(&mut resumed, 25..40);
    assert!(state(&resumed) == state(&one), "resumed");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("policy.safetensors");
    one.save_policy(&path).unwrap();
    let mut policy =
        Policy::read(&path, &Modules::with_critics(normed).with_actor(normed)).unwrap();
    let mut acted = [[0.0; 2]; 2];
    policy.act(&[0.3; 3], &mut acted[0]).unwrap();
    let mut one = one;
    one.act(&[0.3; 3], Mode::Exploit, &mut acted[1]).unwrap();
    assert_eq!(acted[0], acted[1]);
    let error = Policy::read(&path, &Candle::default()).unwrap_err().to_string();
    assert!(error.contains("layer.0.weight"), "{error}");
}

#[test]
fn what_a_module_cannot_be_is_a_readable_error() {
    let mut rng = Rng::new(0, Stream::Init);
    let networks = Networks::default();
    let wide = Modules::with_critics(|vars, input, output| {
        Ok(Box::new(linear(input, output + 1, vars)?) as _)
    });
    let mut critic = wide.critics(&spec(), &networks, 2, &mut rng).unwrap();
    let error =
        critic.values(Net::Online, &[0.0; 3], &[0.0; 2], &mut [0.0; 4]).unwrap_err().to_string();
    assert_eq!(error, "a critic module's values: wanted dimensions [1, 2], got [1, 3]");
    let twice = Modules::with_critics(|vars, input, output| {
        linear(input, output, vars.clone())?;
        Ok(Box::new(linear(input, output, vars)?) as _)
    });
    let error = twice.critics(&spec(), &networks, 2, &mut rng).err().unwrap().to_string();
    assert!(error.contains("candle"), "{error}");
    let narrow = wide.with_actor(|vars, input, _| Ok(Box::new(linear(input, 2, vars)?) as _));
    let kind = ActorKind::Gaussian;
    let mut actor = Backend::actor(&narrow, &spec(), &networks, kind, &mut rng).unwrap();
    let error = actor.mode(Net::Online, &[0.0; 3], &mut [0.0; 2]).unwrap_err().to_string();
    let wanted = "a module's output for observations: wanted dimensions [1, 4], got [1, 2]";
    assert_eq!(error, wanted);
}

/// As many numbers as there should be, but the wrong way round, would be taken for others' values.
#[test]
fn a_module_that_answers_with_columns_is_refused() {
    let mut rng = Rng::new(0, Stream::Init);
    let networks = Networks::default();
    let turned = |vars: VarBuilder<'_>, input, output| {
        let linear = linear(input, output, vars)?;
        Ok(Box::new(move |x: &Tensor| linear.forward(x)?.t()) as _)
    };
    let turned = Modules::with_critics(turned).with_actor(turned);
    let mut critic = turned.critics(&spec(), &networks, 2, &mut rng).unwrap();
    let (obs, act) = ([0.0; 9], [0.0; 6]);
    let error = critic.values(Net::Online, &obs, &act, &mut [0.0; 12]).unwrap_err().to_string();
    assert_eq!(error, "a critic module's values: wanted dimensions [3, 2], got [2, 3]");
    let kind = ActorKind::Deterministic;
    let mut actor = Backend::actor(&turned, &spec(), &networks, kind, &mut rng).unwrap();
    let error = actor.mode(Net::Online, &obs, &mut [0.0; 6]).unwrap_err().to_string();
    assert!(error.ends_with("wanted dimensions [3, 2], got [2, 3]"), "{error}");
}

#[test]
fn a_module_that_is_another_each_time_is_refused() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    let made = AtomicUsize::new(0);
    let changing = move |vars: VarBuilder<'_>, input: usize, output: usize| {
        let name = format!("layer.{}", made.fetch_add(1, Ordering::Relaxed));
        let layer = linear(input, output, vars.pp(name))?;
        Ok(Box::new(layer) as Box<dyn Module + Send>)
    };
    let critics = Modules::with_critics(changing).critics(
        &spec(),
        &Networks::default(),
        3,
        &mut Rng::new(1, Stream::Init),
    );
    let error = critics.err().unwrap().to_string();
    assert!(error.contains("variables of a module made again"), "{error}");
}

/// What lies below would never learn, nor an actor by such critics.
#[test]
fn a_module_with_a_part_that_has_no_gradient_is_refused() {
    let normed = |vars: VarBuilder<'_>, input: usize, output: usize| {
        let first = linear(input, 8, vars.pp("first"))?;
        let norm = rms_norm(8, 1e-5, vars.pp("norm"))?;
        let last = linear(8, output, vars.pp("last"))?;
        Ok(Box::new(move |x: &Tensor| last.forward(&norm.forward(&first.forward(x)?)?)) as _)
    };
    let backend = Modules::with_critics(normed).with_actor(normed);
    let mut rng = Rng::new(0, Stream::Init);
    let networks = Networks::default();
    let critics = backend.critics(&spec(), &networks, 3, &mut rng).err().unwrap().to_string();
    let kind = ActorKind::Deterministic;
    let actor = Backend::actor(&backend, &spec(), &networks, kind, &mut rng).err().unwrap();
    for error in [critics, actor.to_string()] {
        assert!(error.starts_with("a module's 'first."), "{error}");
        assert!(error.contains("RmsNorm"), "{error}");
    }
    // A way around does not help what is passed by.
    let skipping = |vars: VarBuilder<'_>, input: usize, output: usize| {
        let first = linear(input, input, vars.pp("first"))?;
        let norm = rms_norm(input, 1e-5, vars.pp("norm"))?;
        let last = linear(input, output, vars.pp("last"))?;
        Ok(Box::new(move |x: &Tensor| last.forward(&(x + norm.forward(&first.forward(x)?)?)?)) as _)
    };
    let skipping = Modules::with_critics(skipping);
    let error = skipping.critics(&spec(), &networks, 3, &mut rng).err().unwrap().to_string();
    assert!(error.starts_with("a module's 'first."), "{error}");
}
