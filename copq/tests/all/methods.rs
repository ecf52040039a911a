//! REDQ, optimistic exploration, SAC and the constrained methods on worlds whose optimum is known.

use crate::toy;
use approx::{abs_diff_eq, assert_abs_diff_eq};

use copq::projection::{Cholesky, Extremum, by_name};
use copq::*;
use toy::{LinearActor, LinearCritics, SLOPE, Toy, act, policy, run};

fn critics(count: usize, seed: u64) -> LinearCritics {
    LinearCritics::new(count, 2, 0.02, seed)
}

/// CAL's critics: 4 of the cost and 2 of the reward.
fn separate(counts: &[usize], seed: u64) -> SeparateCritics {
    let networks = LinearCritics::new(counts.iter().sum(), 1, 0.02, seed);
    SeparateCritics::new(Box::new(networks), counts).unwrap()
}

fn train(env: Toy, learner: Learner, steps: u64) -> (Trainer<Learner>, State) {
    let mut trainer = Trainer::new(env, learner).unwrap();
    let state = run(&mut trainer, steps);
    (trainer, state)
}

/// Noise that remembers: what Ornstein and Uhlenbeck would explore with.
#[derive(Debug)]
struct Drift(f32);

impl Explore for Drift {
    fn act(&mut self, context: &mut Context<'_>, obs: &[f32], action: &mut [f32]) -> Result<()> {
        context.actor.mode(Net::Online, obs, action)?;
        self.0 = 0.9 * self.0 + 0.1 * context.rng.normal() as f32;
        action[0] = (action[0] + self.0).clamp(-1.0, 1.0);
        Ok(())
    }

    fn save(&self, state: &mut State) {
        state.put("drift", [self.0]);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.0 = state.get_one("drift")?;
        Ok(())
    }
}

/// Every method by name, in a world that suits it.
fn methods(seed: u64) -> Vec<(&'static str, Toy, Learner)> {
    let optimistic = Optimistic::default;
    let redq =
        || toy::learner(toy::method(toy::small(Method::cop_td3_paper().redq().config)), 10, seed);
    let small = |mut method: Method| {
        method.config = toy::small(method.config);
        method
    };
    let sac = |config, critic| {
        toy::stochastic(toy::method(toy::small(config)), &Toy::new(), critic, seed)
    };
    let constrained = |method, counts| {
        toy::stochastic(small(method), &Toy::constrained(), separate(counts, seed), seed)
    };
    let cop_cal = |config| {
        toy::stochastic(
            toy::method(toy::small(config)),
            &Toy::constrained(),
            critics(3, seed),
            seed,
        )
    };
    let redq_sac = || sac(Method::sac().redq().config, critics(10, seed));
    let pid =
        Config { constraint: Some(Constraint::Pid(PidConfig::default())), ..Method::sac().config };
    vec![
        ("redq", Toy::new(), redq()),
        ("redq with cop-oac", Toy::new(), redq().explore(optimistic().projection(Cholesky))),
        ("redq with extremum-oac", Toy::new(), redq().explore(optimistic().projection(Extremum))),
        ("redq on sac", Toy::new(), redq_sac()),
        (
            "redq on sac with cop-oac",
            Toy::new(),
            redq_sac().explore(optimistic().projection(Cholesky)),
        ),
        (
            "redq on sac with extremum-oac",
            Toy::new(),
            redq_sac().explore(optimistic().projection(Extremum)),
        ),
        ("sac", Toy::new(), sac(Method::sac().config, critics(3, seed))),
        (
            "oac",
            Toy::new(),
            sac(Method::sac().config, critics(3, seed)).explore(optimistic().projection(Extremum)),
        ),
        ("sac-lagrangian", Toy::constrained(), constrained(Method::sac_lagrangian(), &[1, 2])),
        ("saclag-ucb", Toy::constrained(), constrained(Method::saclag_ucb(), &[2, 2])),
        ("cal", Toy::constrained(), constrained(Method::cal(), &[4, 2])),
        ("cal's own", Toy::constrained(), constrained(Method::cal_original(), &[4, 2])),
        ("cop-q on cal", Toy::constrained(), cop_cal(Method::cop_cal().config)),
        ("pid", Toy::constrained(), cop_cal(pid)),
        (
            "a rule with a memory",
            Toy::new(),
            toy::learner(toy::method(toy::config()), 3, seed).explore(Drift(0.0)),
        ),
    ]
}

#[test]
fn a_resumed_run_of_every_method_is_the_same_bit_for_bit() {
    for ((name, env, whole), (_, _, half)) in methods(7).into_iter().zip(methods(7)) {
        let (_, wanted) = train(env, whole, 290);
        let world = |name: &str| methods(7).into_iter().find(|(other, ..)| *other == name).unwrap();
        let (_, env, other) = world(name);
        let (_, half) = train(env, half, 245);
        let (_, env, _) = world(name);
        let mut resumed = Trainer::new(env, other).unwrap();
        resumed.load(&half).unwrap();
        assert!(run(&mut resumed, 290) == wanted, "{name}");
    }
}

#[test]
fn redq_learns_the_optimum() {
    let learner =
        toy::learner(toy::method(toy::small(Method::cop_td3_paper().redq().config)), 10, 1);
    let (mut trainer, _) = train(Toy::new(), learner, 700);
    assert_abs_diff_eq!(policy(trainer.agent_mut())[..], [0.0, SLOPE][..], epsilon = 0.08);
}

#[test]
fn redq_updates_twenty_times_a_step_and_the_actor_once() {
    let mut learner =
        toy::learner(toy::method(toy::small(Method::cop_td3_paper().redq().config)), 10, 1);
    let mut critic_losses = 0;
    let mut objectives = 0;
    let mut log = |_: u64, name: &str, _: f64| {
        critic_losses += u32::from(name == "critic_loss/track");
        objectives += u32::from(name == "actor/objective");
    };
    for i in 0..203 {
        let outcome = Outcome::Running;
        let t = Transition {
            obs: &[0.1],
            action: &[0.2],
            reward: &[0.3, 0.4],
            next_obs: &[0.1 * i as f32],
            outcome,
        };
        learner.observe(t).unwrap();
        learner.update(&mut log).unwrap();
    }
    assert_eq!((learner.updates(), critic_losses, objectives), (80, 80, 4));
}

#[test]
fn sac_learns_the_optimum_and_holds_its_entropy() {
    // A deterministic optimum: the wanted entropy is low, so that the temperature has to fall.
    let entropy = Entropy { lr: 0.01, target: Some(-1.0), ..Default::default() };
    let config = Config { entropy: Some(entropy), ..toy::small(Method::sac().config) };
    let learner = toy::stochastic(toy::method(config), &Toy::new(), critics(2, 3), 3);
    let mut trainer = Trainer::new(Toy::new(), learner).unwrap();
    let mut entropy = 0.0;
    let mut temperature = 1.0;
    let mut log = |_: u64, name: &str, value: f64| match name {
        "actor/entropy" => entropy = 0.98 * entropy + 0.02 * value,
        "actor/temperature" => temperature = value,
        _ => {}
    };
    (0..5_000).for_each(|_| drop(trainer.step(&mut log).unwrap()));
    assert_abs_diff_eq!(policy(trainer.agent_mut())[..], [0.0, SLOPE][..], epsilon = 0.05);
    assert_abs_diff_eq!(entropy, -1.0, epsilon = 0.1);
    assert!(temperature < 0.2, "temperature {temperature}");
}

/// A gradient without alpha would move a small temperature as if it were 1: only where alpha is far
/// from 1 and the gradients change does Adam tell the two apart.
#[test]
fn the_temperature_takes_adams_steps_by_the_entropies_that_are_logged() {
    let bonus = Entropy { temperature: 0.05, lr: 0.3, ..Default::default() };
    let config = Config { entropy: Some(bonus), ..toy::small(Method::sac().config) };
    let learner = toy::stochastic(toy::method(config), &Toy::new(), critics(2, 3), 3);
    let mut trainer = Trainer::new(Toy::new(), learner).unwrap();
    let [mut entropies, mut temperatures] = [Vec::new(), Vec::new()];
    let mut log = |_: u64, name: &str, value: f64| match name {
        "actor/entropy" => entropies.push(value),
        "actor/temperature" => temperatures.push(value),
        _ => {}
    };
    trainer.run(220, &mut log).unwrap();
    temperatures.push(trainer.agent().temperature().unwrap());
    let mut log_alpha = 0.05f64.ln();
    let [mut m, mut v] = [0.0; 2];
    for (t, (entropy, alpha)) in entropies.iter().zip(&temperatures).enumerate() {
        assert_abs_diff_eq!(alpha.ln(), log_alpha, epsilon = 1e-10);
        // Wanted is -1 for an action of one number.
        let grad = alpha * (entropy + 1.0);
        m = 0.9 * m + 0.1 * grad;
        v = 0.999 * v + 0.001 * grad * grad;
        let [c1, c2] = [0.9f64, 0.999].map(|beta| 1.0 - beta.powi(t as i32 + 1));
        log_alpha -= 0.3 * (m / c1) / ((v / c2).sqrt() + 1e-8);
    }
    assert!(entropies.len() > 8);
    assert_abs_diff_eq!(temperatures[entropies.len()].ln(), log_alpha, epsilon = 1e-10);
}

/// The best Gaussian's variance is known: -(w_1 + w_2) var + alpha w_e log std is largest at alpha
/// w_e / (2 (w_1 + w_2)).
#[test]
fn the_entropy_bonus_is_weighed_like_its_objective() {
    for (e, objective) in ["track", "rest"].into_iter().enumerate() {
        let mut env = Toy::new();
        env.spec.objectives[1].weight = 3.0;
        let bonus = Entropy {
            temperature: 0.08,
            lr: 0.0,
            objective: Some(objective.into()),
            ..Default::default()
        };
        let config = Config {
            entropy: Some(bonus),
            pessimism: 0.0,
            actor_pessimism: 0.0,
            ..toy::small(Method::sac().config)
        };
        let learner = toy::stochastic(toy::method(config), &env, critics(3, 3), 3);
        let variance = 0.08 * f64::from(env.spec.objectives[e].weight) / (2.0 * 4.0);
        let mut trainer = Trainer::new(env, learner).unwrap();
        let mut entropy = 0.0;
        let mut log = |_: u64, name: &str, value: f64| {
            if name == "actor/entropy" {
                entropy = 0.98 * entropy + 0.02 * value;
            }
        };
        (0..5_000).for_each(|_| drop(trainer.step(&mut log).unwrap()));
        // 0.5 ln(2 pi e var), less what the tanh takes.
        let wanted = 0.5 * (std::f64::consts::TAU * std::f64::consts::E * variance).ln() - variance;
        let close = abs_diff_eq!(entropy, wanted, epsilon = 0.08);
        assert!(close, "{objective}: entropy {entropy}, wanted {wanted}");
    }
}

#[test]
fn a_pid_controller_finds_the_known_multiplier() {
    let pid = PidConfig {
        proportional: 0.02,
        integral: 1e-4,
        derivative: 0.02,
        multiplier: 0.3,
        ..Default::default()
    };
    constrained_optimum(Constraint::Pid(pid));
}

/// lambda* = 1, a* = 0: known in closed form, see [`Toy::constrained`].
#[test]
fn primal_and_dual_converge_to_the_known_optimum() {
    let lagrangian =
        LagrangianConfig { multiplier: 0.3, lr: 0.003, augmentation: 1.0, ..Default::default() };
    constrained_optimum(Constraint::Lagrangian(lagrangian));
}

fn constrained_optimum(constraint: Constraint) {
    // The deterministic policy, the critics' mean, no smoothing, no optimism: nothing moves the
    // optimum.
    let config = Config {
        constraint: Some(constraint),
        capacity: 1_000,
        pessimism: 0.0,
        actor_pessimism: 0.0,
        smoothing: None,
        optimism: None,
        famo: None,
        ..toy::config()
    };
    let env = Toy::constrained();
    let actor = Box::new(LinearActor::new(0.005));
    let learner =
        Learner::with_networks(toy::method(config), &env.spec, Box::new(critics(3, 2)), actor, 2);
    let mut trainer = Trainer::new(env, learner.unwrap()).unwrap();
    let mut multiplier = 0.0;
    let mut violation = 0.0;
    let mut log = |step: u64, name: &str, value: f64| match name {
        "multiplier/cost" if step > 6_000 => multiplier += value / 1_000.0,
        "cost_violation/cost" if step > 6_000 => violation += value / 1_000.0,
        _ => {}
    };
    (0..8_000).for_each(|_| drop(trainer.step(&mut log).unwrap()));
    assert_abs_diff_eq!(multiplier, 1.0, epsilon = 0.1);
    assert_abs_diff_eq!(violation, 0.0, epsilon = 0.05);
    assert_abs_diff_eq!(policy(trainer.agent_mut())[..], [0.0, 0.0][..], epsilon = 0.1);
}

/// The multipliers of a cost that is told as a reward of the opposite sign.
#[derive(Debug)]
struct Flipped {
    of_cost: Lagrangian,
    weights: Vec<f32>,
    actor_weights: Vec<f64>,
}

impl Flipped {
    fn new(config: &Config) -> Self {
        let Some(Constraint::Lagrangian(lagrangian)) = config.constraint else {
            panic!("a Lagrangian")
        };
        let of_cost =
            Lagrangian::new(lagrangian, &Toy::constrained().spec, config.discount).unwrap();
        let mut new = Self { of_cost, weights: vec![], actor_weights: vec![] };
        new.flip();
        new
    }

    fn flip(&mut self) {
        self.weights = self.of_cost.weights().to_vec();
        self.actor_weights = self.of_cost.actor_weights().to_vec();
        self.weights[0] *= -1.0;
        self.actor_weights[0] *= -1.0;
    }
}

impl Multiplier for Flipped {
    fn weights(&self) -> &[f32] {
        &self.weights
    }

    fn actor_weights(&self) -> &[f64] {
        &self.actor_weights
    }

    fn observe(&mut self, bound: &[f32]) {
        self.of_cost.observe(&[-bound[0], bound[1]]);
        self.flip();
    }

    fn update(&mut self) {
        self.of_cost.update();
        self.flip();
    }

    fn log(&self, step: u64, log: &mut dyn Observer) {
        self.of_cost.log(step, log);
    }

    fn save(&self, state: &mut State) {
        self.of_cost.save(state);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.of_cost.load(state)
    }
}

/// Positive cost under a negative weight, or the cost as a negative reward under a positive one:
/// the same run.
#[test]
fn cop_q_on_cal_does_not_depend_on_the_sign_of_its_cost() {
    // A weak augmentation: with CAL's the cost would weigh nothing as long as it is far below its
    // limit.
    let lagrangian = LagrangianConfig { augmentation: 0.1, ..Default::default() };
    let config = Config {
        constraint: Some(Constraint::Lagrangian(lagrangian)),
        ..toy::small(Method::cop_cal().config)
    };
    let learner =
        toy::stochastic(toy::method(config.clone()), &Toy::constrained(), critics(3, 4), 4);
    let mut trainer = Trainer::new(Toy::constrained(), learner).unwrap();
    let mut clips = 0.0f64;
    let mut effective = 0.0f64;
    let mut log = |_: u64, name: &str, value: f64| match name {
        "clip_rate" => clips = clips.max(value),
        "multiplier_effective/cost" => effective = effective.max(value),
        _ => {}
    };
    (0..600).for_each(|_| drop(trainer.step(&mut log).unwrap()));
    assert!(
        clips > 0.0 && effective > 0.0,
        "the clip fired at most {clips}, the cost weighed at most {effective}"
    );
    let state = run(&mut trainer, 600);

    let plain = Config { constraint: None, ..config.clone() };
    let learner = toy::stochastic(toy::method(plain), &Toy::flipped(), critics(3, 4).flipped(0), 4);
    let (_, flipped) =
        train(Toy::flipped(), learner.multiplier(Flipped::new(&config)).unwrap(), 600);

    let [state, flipped] = [state, flipped].map(|state| state.child("agent").unwrap().clone());
    for part in ["actor", "multiplier", "temperature"] {
        assert!(state.child(part).unwrap() == flipped.child(part).unwrap(), "{part}");
    }
    let values =
        |state: &State| state.child("critic").unwrap().get::<f32>("online").unwrap().to_vec();
    let flipped = values(&flipped);
    let values = values(&state);
    for (i, (value, flipped)) in values.iter().zip(&flipped).enumerate() {
        // Six features of the cost, six of the reward, for each critic.
        assert_eq!(*value, if i % 12 < 6 { -flipped } else { *flipped }, "parameter {i}");
    }
}

#[test]
fn the_limit_is_compared_in_the_units_of_q() {
    // An episode of 20 steps may cost 20; the discounted sum of 1 a step is 2 for gamma = 0.5.
    let spec = Toy::constrained().spec;
    let config = LagrangianConfig { augmentation: 3.0, ..Default::default() };
    let mut lagrangian = Lagrangian::new(config, &spec, 0.5).unwrap();
    lagrangian.observe(&[2.5, 7.0]);
    let mut seen = std::collections::BTreeMap::new();
    lagrangian.log(0, &mut |_: u64, name: &str, value: f64| {
        seen.insert(name.to_owned(), value);
    });
    assert_abs_diff_eq!(seen["cost_violation/cost"], 0.5, epsilon = 1e-5);
    assert_eq!(seen["cost_estimate/cost"], 2.5);
    // lambda + c (Q - d) = 1 + 3 * 0.5; the projection still sees lambda itself.
    assert_abs_diff_eq!(seen["multiplier_effective/cost"], 2.5, epsilon = 1e-4);
    assert_eq!((lagrangian.weights(), seen["multiplier/cost"]), (&[-1.0, 1.0][..], 1.0));
    assert_eq!(lagrangian.actor_weights()[1], 1.0);
    // Far below the limit the augmented multiplier is cut off at zero, not negative.
    lagrangian.observe(&[-9.0, 7.0]);
    assert_eq!(lagrangian.actor_weights()[0], -0.0);
    lagrangian.update();
    assert!(lagrangian.weights()[0] > -1.0, "a cost below its limit lowers the multiplier");
    assert_eq!(discounted_limit(740.2, 1.0, 1000), 740.2);
}

/// A cost that nothing can lower far enough: the multiplier grows to its cap and stays there, a
/// number still.
#[test]
fn a_multiplier_has_a_cap() {
    let config = LagrangianConfig { lr: 0.5, cap: 50.0, ..Default::default() };
    let mut lagrangian = Lagrangian::new(config, &Toy::constrained().spec, 0.5).unwrap();
    lagrangian.observe(&[9.0, 0.0]);
    (0..100).for_each(|_| lagrangian.update());
    assert_abs_diff_eq!(lagrangian.weights()[0], -50.0, epsilon = 1e-4);
    lagrangian.observe(&[-9.0, 0.0]);
    (0..20).for_each(|_| lagrangian.update());
    assert!(lagrangian.weights()[0] > -50.0, "{:?}", lagrangian.weights());
    let error =
        Lagrangian::new(LagrangianConfig { cap: 0.5, ..config }, &Toy::constrained().spec, 0.5)
            .unwrap_err();
    assert_eq!(error.to_string(), "lagrangian.multiplier: wanted at most the cap, 0.5, got 1");
}

#[test]
fn what_would_go_wrong_in_silence_is_refused() {
    let sac = || {
        toy::stochastic(
            toy::method(toy::small(Method::sac().config)),
            &Toy::new(),
            critics(3, 0),
            0,
        )
    };
    let error = |weights: &[f32]| {
        sac().multiplier(FixedWeights::new(weights).unwrap()).unwrap_err().to_string()
    };
    let wanted = "the multiplier's weight of 'rest': wanted more than 0, because the entropy \
         bonus is added to it, got 0";
    assert_eq!(error(&[1.0, 0.0]), wanted);
    assert_eq!(error(&[1.0]), "the multiplier's weights: wanted 2 values, got 1");
    let both = Config { entropy: Some(Entropy::default()), ..Method::cop_td3().config }
        .check()
        .unwrap_err()
        .to_string();
    assert!(both.starts_with("smoothing: wanted none with entropy"), "{both}");

    // Two of four critics can be the same network of the reward twice.
    let mut q = [0.0; 4];
    let drawn = separate(&[4, 2], 0)
        .values_of(Net::Target, &[0, 2], &[0.1], &[0.2], &mut q)
        .unwrap_err()
        .to_string();
    assert!(
        drawn.starts_with("a subset of the critics: wanted the same number of separate critics"),
        "{drawn}"
    );
    assert!(separate(&[2, 2], 0).values_of(Net::Target, &[1], &[0.1], &[0.2], &mut q[..2]).is_ok());

    let nan = Transition {
        obs: &[0.1],
        action: &[f32::NAN],
        reward: &[0.3, 0.4],
        next_obs: &[0.5],
        outcome: Outcome::Running,
    };
    assert!(
        sac()
            .observe(nan)
            .unwrap_err()
            .to_string()
            .starts_with("action, component 0 is not finite")
    );
}

#[test]
fn a_method_that_does_not_suit_the_task_is_a_readable_error() {
    let build = |config: Config, critic: Box<dyn Critic>, actor: Box<dyn Actor>| {
        Learner::with_networks(toy::method(toy::small(config)), &Toy::new().spec, critic, actor, 0)
            .map(drop)
            .unwrap_err()
            .to_string()
    };
    let gaussian = || Box::new(toy::GaussianActor::new(0.005, -1.0));
    assert_eq!(
        build(Method::cop_cal().config, Box::new(critics(3, 0)), gaussian()),
        "a constraint on 'toy': wanted a task with a cost under a limit, such as b/hopper, got none"
    );
    assert!(
        build(Method::cal().config, Box::new(separate(&[4, 2, 2], 0)), gaussian())
            .starts_with("a constraint on 'toy'")
    );
    assert_eq!(
        build(Method::sac().config, Box::new(critics(3, 0)), Box::new(LinearActor::new(0.005))),
        "the actor: wanted a stochastic policy, for the entropy bonus, got a deterministic one"
    );
    assert_eq!(
        build(
            Config { subset: Some(11), ..Method::cop_td3().config },
            Box::new(critics(10, 0)),
            Box::new(LinearActor::new(0.005))
        ),
        "subset: wanted at most 10 critics, got 11"
    );
}

/// Covariances between objectives of separate networks follow from how these are numbered.
#[test]
fn bounds_of_covariances_want_critics_of_all_objectives() {
    let build = |config: Config, bound: &str| {
        let method = Method::new("toy", toy::small(config), by_name(bound).unwrap());
        let actor = Box::new(LinearActor::new(0.005));
        Learner::with_networks(method, &Toy::new().spec, Box::new(separate(&[2, 2], 0)), actor, 0)
            .map(drop)
            .map_err(|error| error.to_string())
    };
    let config = Method::cop_td3().config;
    let upper = Config { optimism: Some(Optimism::by("extremum")), ..Method::cop_td3_oac().config };
    let refused = |name| {
        Err(format!(
            "the bound: wanted one that does not read covariances, for objectives with separate \
             critics, got {name}"
        ))
    };
    for name in ["cholesky", "eigen", "extremum"] {
        assert_eq!(build(config.clone(), name), refused(name));
    }
    assert_eq!(build(upper, "independent-min"), refused("extremum"));
    for name in ["diagonal", "mean-std", "independent-min", "scalarised-min"] {
        assert_eq!(build(config.clone(), name), Ok(()));
    }
}

/// The mean that exploration adds to the policy's own noise, in units of that noise: same seed,
/// with and without.
fn shift(learner: impl Fn() -> Learner, std: f32, pre_tanh: bool) -> f32 {
    shift_of(
        learner,
        |learner| learner.explore(Optimistic::new(Optimism::default(), std).unwrap()),
        std,
        pre_tanh,
    )
}

/// The same of any rule that `explore` gives a learner.
fn shift_of(
    learner: impl Fn() -> Learner,
    explore: impl FnOnce(Learner) -> Learner,
    std: f32,
    pre_tanh: bool,
) -> f32 {
    let noisy = |mut learner: Learner| {
        let t = Transition {
            obs: &[0.1],
            action: &[0.2],
            reward: &[0.3, 0.4],
            next_obs: &[0.5],
            outcome: Outcome::Running,
        };
        (0..200).for_each(|_| learner.observe(t).unwrap());
        let action = act(&mut learner, 0.4, Mode::Explore);
        if pre_tanh { action.atanh() } else { action }
    };
    (noisy(explore(learner())) - noisy(learner())) / std
}

#[test]
fn the_shifted_policy_is_as_far_away_as_the_kl_bound_allows() {
    let deterministic = || {
        let config = Config { exploration_std: 0.02, optimism: None, ..toy::config() };
        toy::learner(toy::method(config), 3, 5)
    };
    let gaussian = || {
        let actor = Box::new(toy::GaussianActor::new(0.005, 0.02f32.ln()));
        let sac = toy::method(toy::small(Method::sac().config));
        Learner::with_networks(sac, &Toy::new().spec, Box::new(critics(3, 5)), actor, 5).unwrap()
    };
    for shift in [shift(deterministic, 0.02, false), shift(gaussian, 0.02, true)] {
        // KL(N(m + D, S) || N(m, S)) = D' S^-1 D / 2
        assert_abs_diff_eq!(0.5 * shift * shift, 23.53, epsilon = 0.01);
    }
}

/// Noise of another width than a method's own would explore as no setting says.
#[test]
fn optimism_by_settings_is_that_by_hand() {
    let explored = |optimism: Option<Optimism>, by_hand: bool| {
        let config = Config { exploration_std: 0.02, optimism, ..toy::config() };
        let learner = toy::learner(toy::method(config), 3, 5);
        let rule = Optimistic::new(Optimism::default(), 0.02).unwrap();
        train(Toy::new(), if by_hand { learner.explore(rule) } else { learner }, 260).1
    };
    let by_settings = explored(Some(Optimism::default()), false);
    assert!(by_settings == explored(None, true));
    assert!(by_settings != explored(None, false));
}

/// Half of the way the shift is half as long, from the end on there is none. 200 steps have been
/// observed.
#[test]
fn the_shift_shrinks_to_nothing_where_it_should() {
    let learner =
        || toy::learner(toy::method(Config { exploration_std: 0.02, ..toy::config() }), 3, 5);
    let length = |until| {
        let optimism = Optimism { until, ..Optimism::default() };
        shift_of(
            learner,
            |learner| learner.explore(Optimistic::new(optimism, 0.02).unwrap()),
            0.02,
            false,
        )
        .abs()
    };
    let [whole, half, none] = [None, Some(400), Some(200)].map(length);
    assert_abs_diff_eq!([whole, half][..], [6.86, 3.43][..], epsilon = 1e-3);
    assert_eq!(none, 0.0);
}

#[test]
fn critics_that_say_nothing_shift_nothing() {
    let silent = || {
        let actor = Box::new(LinearActor::new(0.005));
        let config = Config { optimism: None, ..toy::config() };
        Learner::with_networks(
            toy::method(config),
            &Toy::new().spec,
            Box::new(critics(3, 5).silent()),
            actor,
            5,
        )
        .unwrap()
    };
    assert_eq!(shift(silent, 0.1, false), 0.0);
}

#[test]
fn separate_networks_are_an_ensemble() {
    let obs = [0.1, -0.4, 0.8];
    let act = [0.3, 0.2, -0.9];
    // The same scalar networks, seen plainly: 4 of the cost, then 2 of the reward.
    let mut scalars = LinearCritics::new(6, 1, 0.02, 3);
    let mut separate = separate(&[4, 2], 3);
    let mut scalar = [0.0; 18];
    let mut q = [0.0; 24];
    scalars.values(Net::Online, &obs, &act, &mut scalar).unwrap();
    separate.values(Net::Online, &obs, &act, &mut q).unwrap();
    assert_eq!((separate.critics(), separate.objectives()), (4, 2));
    let q = QView::new(&q, 4, 2).unwrap();
    for (k, row) in (0..4).flat_map(|k| (0..3).map(move |row| (k, row))) {
        assert_eq!(q.get(k, row), [scalar[k * 3 + row], scalar[(4 + k % 2) * 3 + row]]);
    }
    // Every reward network appears twice, so its gradient is the sum of two.
    let mut grad = [0.0; 3];
    let mut wanted = [0.0; 3];
    separate
        .action_grad(
            &obs,
            &act,
            &mut |_, grad| {
                grad.fill(1.0);
                Ok(())
            },
            &mut grad,
        )
        .unwrap();
    let doubled = &mut |_: QView<'_>, grad: &mut [f32]| {
        grad.iter_mut().enumerate().for_each(|(i, grad)| *grad = if i < 12 { 1.0 } else { 2.0 });
        Ok(())
    };
    scalars.action_grad(&obs, &act, doubled, &mut wanted).unwrap();
    assert_eq!(grad, wanted);
    let wrong = |counts: &[usize]| {
        SeparateCritics::new(Box::new(LinearCritics::new(6, 1, 0.02, 3)), counts)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(wrong(&[2, 2]), "scalar critics: wanted 4 for [2, 2], got 6");
    assert_eq!(wrong(&[6, 0]), "critics of each objective: wanted at least 1, got [6, 0]");
}

#[test]
fn another_order_moves_names_weights_limits_and_rewards_together() {
    let mut plain = Toy::constrained();
    let mut ordered = AdjustedEnv::new(Toy::constrained()).order("reward,cost").unwrap();
    let spec = ordered.spec().clone();
    assert_eq!(
        spec.objectives,
        [Objective::reward("reward", 1.0), Objective::cost("cost", 20.0).weight(-1.0)]
    );
    assert_eq!(
        spec.entropy.as_deref(),
        Some("reward"),
        "the entropy bonus stays with its objective"
    );
    let unnamed = AdjustedEnv::new(Toy::new()).order("rest,track").unwrap();
    assert_eq!(
        unnamed.spec().entropy.as_deref(),
        Some("rest"),
        "the last reward of the task, not of the order"
    );
    let mut obs = [0.0];
    let mut reward = [0.0; 2];
    let mut turned = [0.0; 2];
    plain.reset(1, &mut obs).unwrap();
    ordered.reset(1, &mut obs).unwrap();
    plain.step(&[0.7], &mut obs, &mut reward).unwrap();
    ordered.step(&[0.7], &mut obs, &mut turned).unwrap();
    assert_eq!([turned[1], turned[0]], reward);
    check_env(&mut ordered).unwrap();
    let error =
        |order: &str| AdjustedEnv::new(Toy::constrained()).order(order).unwrap_err().to_string();
    assert_eq!(
        error("cost,cost"),
        "order of objectives: wanted each of cost, reward once, got cost, cost"
    );
    assert!(error("reward,costs").starts_with("unknown objective 'costs'; known: cost, "));
    // An order of an order.
    let mut back = ordered.order("cr").unwrap();
    assert_eq!(back.spec().objectives, plain.spec().objectives);
    back.reset(1, &mut obs).unwrap();
    back.step(&[0.7], &mut obs, &mut turned).unwrap();
    assert_eq!(turned, reward);
}

#[test]
fn an_order_is_written_in_letters_or_names() {
    let parse = |order: &str| AdjustedEnv::new(Toy::constrained()).order(order);
    for order in ["rc", "reward,cost", "reward, cost"] {
        assert_eq!(parse(order).unwrap().spec().names(), ["reward", "cost"]);
    }
    let error = |order: &str| parse(order).unwrap_err().to_string();
    assert!(
        error("rx")
            .ends_with("one objective each, or names with commas between: cost,reward, got 'x'")
    );
    assert!(
        error("r").starts_with("order of objectives: wanted each of cost, reward once, got reward")
    );
}

/// Extremum knows no priorities: turned round, it is the same run with its objectives exchanged.
/// Cholesky does.
#[test]
fn the_order_matters_to_cholesky_alone() {
    let q = [0.5, 2.0, 1.5, -1.0, 3.0, 0.0];
    let turned: Vec<f32> = q.chunks_exact(2).flat_map(|pair| [pair[1], pair[0]]).collect();
    let bound = |method: &dyn Projection, q: &[f32]| {
        let mut out = [0.0; 2];
        let q = QView::new(q, 3, 2).unwrap();
        method
            .project(
                BoundQuery { q, weights: &[1.0, 1.0], step: -1.0 },
                &mut Scratch::default(),
                &mut out,
            )
            .unwrap();
        out
    };
    for (method, same) in [(&Cholesky as &dyn Projection, false), (&Extremum, true)] {
        let mut back = bound(method, &turned);
        back.reverse();
        let close = abs_diff_eq!(bound(method, &q)[..], back[..], epsilon = 1e-6);
        assert_eq!(close, same, "{}", method.name());
    }
}
