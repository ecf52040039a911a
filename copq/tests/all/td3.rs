//! TD3 written out for one objective and two critics: the learner is the same, bit for bit.

use crate::toy;

use copq::*;
use toy::{LinearActor, LinearCritics, Toy};

const SEED: u64 = 5;

/// Fujimoto et al. (2018), Algorithm 1, with the smaller critic in the actor, too. Of copq it has
/// the generators, the replay and the networks.
struct Td3 {
    config: Config,
    critic: LinearCritics,
    actor: LinearActor,
    replay: Replay,
    batch: Batch,
    explore: Rng,
    smoothing: Rng,
    batches: Rng,
    updates: u64,
}

impl Td3 {
    fn new(config: Config) -> Self {
        let spec = EnvSpec::new("one", 1, 1).reward("one", 1.0);
        Self {
            critic: LinearCritics::new(2, 1, 0.02, SEED),
            actor: LinearActor::new(0.005),
            replay: Replay::new(&spec, config.capacity).unwrap(),
            batch: Batch::default(),
            explore: Rng::new(SEED, Stream::Explore),
            smoothing: Rng::new(SEED, Stream::Smoothing),
            batches: Rng::new(SEED, Stream::Batch),
            updates: 0,
            config,
        }
    }

    fn act(&mut self, step: u64, obs: &[f32]) -> f32 {
        let mut action = [0.0];
        if step < self.config.start_steps {
            return self.explore.uniform_in(-1.0, 1.0) as f32;
        }
        self.actor.mode(Net::Online, obs, &mut action).unwrap();
        (action[0] + self.config.exploration_std as f32 * self.explore.normal() as f32)
            .clamp(-1.0, 1.0)
    }

    fn update(&mut self) {
        let Self { config, critic, actor, batch, .. } = self;
        self.updates += 1;
        let rows = config.batch;
        let gamma = config.discount as f32;
        self.replay.sample(rows, &mut self.batches, batch).unwrap();

        // y = r + gamma (1 - d) min(Q1', Q2')(s', clip(mu'(s') + clip(noise)))
        let mut next = vec![0.0; rows];
        let mut noise = vec![0.0; rows];
        let mut q = vec![0.0; 2 * rows];
        actor.mode(Net::Target, &batch.next_obs, &mut next).unwrap();
        self.smoothing.fill_normal(&mut noise);
        next.iter_mut()
            .zip(&noise)
            .for_each(|(a, z)| *a = (*a + (0.2 * z).clamp(-0.5, 0.5)).clamp(-1.0, 1.0));
        critic.values(Net::Target, &batch.next_obs, &next, &mut q).unwrap();
        let promise = |i: usize| gamma * batch.alive[i] * q[i].min(q[rows + i]);
        let target: Vec<f32> = (0..rows).map(|i| batch.reward[i] + promise(i)).collect();

        // Mean squared errors of both critics; the targets follow, as a rule at every second
        // update.
        let follows = self.updates.is_multiple_of(config.target_period);
        let tau = if follows { 0.005 } else { 0.0 };
        let scale = (2.0 / (2 * rows) as f64) as f32;
        let errors = &mut |q: QView<'_>, grad: &mut [f32]| {
            grad.iter_mut()
                .enumerate()
                .for_each(|(i, grad)| *grad = scale * (q.values()[i] - target[i % rows]));
            Ok(())
        };
        critic.fit(&batch.obs, &batch.action, errors, tau).unwrap();
        if self.updates.is_multiple_of(2) {
            climb(critic, actor, batch);
        }
        if follows {
            actor.update_target(tau).unwrap();
        }
    }
}

/// The actor's step at every second update.
fn climb(critic: &mut LinearCritics, actor: &mut LinearActor, batch: &Batch) {
    let rows = batch.alive.len();
    let up = (-1.0 / rows as f64) as f32;
    let smaller = &mut |q: QView<'_>, grad: &mut [f32]| {
        for i in 0..rows {
            let first = q.values()[i] < q.values()[rows + i];
            (grad[i], grad[rows + i]) = if first { (up, 0.0) } else { (0.0, up) };
        }
        Ok(())
    };
    let improve = &mut |sample: Sample<'_>, grad: SampleGrad<'_>| {
        critic.action_grad(&batch.obs, sample.action, smaller, grad.action)
    };
    actor.improve(&batch.obs, &[], improve).unwrap();
}

/// Acts, stores and updates for 600 steps: each of the two has its own say in what comes next.
fn run(mut act: impl FnMut(u64, &[f32]) -> f32, mut learn: impl FnMut(u64, Transition<'_>)) {
    let mut env = Toy::new();
    let mut obs = [0.0];
    let mut next = [0.0];
    let mut reward = [0.0; 2];
    env.reset(1, &mut obs).unwrap();
    for step in 0..600 {
        let action = [act(step, &obs)];
        let mut outcome = env.step(&[2.0 * action[0]], &mut next, &mut reward).unwrap();
        if step % 7 == 3 {
            outcome = Outcome::Terminated;
        }
        learn(
            step,
            Transition {
                obs: &obs,
                action: &action,
                reward: &reward[..1],
                next_obs: &next,
                outcome,
            },
        );
        obs = next;
        if outcome != Outcome::Running {
            env.reset(step, &mut obs).unwrap();
        }
    }
}

fn parameters(critic: &State, actor: &State) -> Vec<Vec<f32>> {
    let of = |state: &State, name| state.get::<f32>(name).unwrap().to_vec();
    vec![of(critic, "online"), of(critic, "target"), of(actor, "online"), of(actor, "target")]
}

/// The parameters that TD3 comes to.
fn td3(config: &Config) -> Vec<Vec<f32>> {
    let td3 = std::cell::RefCell::new(Td3::new(config.clone()));
    run(
        |step, obs| td3.borrow_mut().act(step, obs),
        |step, transition| {
            let mut td3 = td3.borrow_mut();
            td3.replay.push(transition).unwrap();
            if step + 1 >= td3.config.start_steps {
                td3.update();
            }
        },
    );
    let td3 = td3.into_inner();
    let mut critic = State::default();
    let mut actor = State::default();
    td3.critic.save(&mut critic).unwrap();
    td3.actor.save(&mut actor).unwrap();
    let parameters = parameters(&critic, &actor);
    assert!(td3.updates > 400 && parameters[2] != [0.3, -0.5], "it has learned something");
    parameters
}

/// Those that the learner of a method comes to.
fn learned(method: Method) -> Vec<Vec<f32>> {
    let mut spec = Toy::new().spec;
    spec.objectives.truncate(1);
    let critic = LinearCritics::new(2, 1, 0.02, SEED);
    let actor = LinearActor::new(0.005);
    let learner = Learner::with_networks(method, &spec, Box::new(critic), Box::new(actor), SEED);
    let learner = std::cell::RefCell::new(learner.unwrap());
    run(
        |_, obs| {
            let mut action = [0.0];
            learner.borrow_mut().act(obs, Mode::Explore, &mut action).unwrap();
            action[0]
        },
        |_, transition| {
            learner.borrow_mut().observe(transition).unwrap();
            learner.borrow_mut().update(&mut Silent).unwrap();
        },
    );
    let mut state = State::default();
    learner.borrow().save(&mut state).unwrap();
    parameters(state.child("critic").unwrap(), state.child("actor").unwrap())
}

#[test]
fn one_objective_under_every_projection_is_td3_bit_for_bit() {
    let config = toy::small(Method::td3().config);
    let wanted = td3(&config);
    // One objective has all of FAMO's weight.
    let famo = [None, Some(FamoConfig::default())];
    for (&name, famo) in projection::names().iter().flat_map(|name| famo.map(|famo| (name, famo))) {
        let config = Config { famo, ..config.clone() };
        let method = Method::new("td3", config, projection::by_name(name).unwrap());
        assert!(learned(method) == wanted, "{name}");
    }
}

/// A target actor that waited for the actor's own step would lag behind the target critics.
#[test]
fn targets_may_follow_at_every_update_though_the_actor_climbs_at_every_second() {
    let config = Config { target_period: 1, ..toy::small(Method::td3().config) };
    let wanted = td3(&config);
    assert!(learned(toy::method(config)) == wanted);
}
