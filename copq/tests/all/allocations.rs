//! A warm update allocates nothing in the core: counted by the allocator itself.

use crate::toy;

use copq::projection::Cholesky;
use copq::{
    Config, Constraint, Learner, Method, Optimism, Optimistic, PidConfig, SeparateCritics, Silent,
    Trainer, projection,
};
use toy::{LinearCritics, Toy};

/// Allocations in steps 301 to 319, one episode's middle: acting, stepping, storing, sampling,
/// updating, all of it warm.
fn an_episodes_middle(trainer: &mut Trainer<Learner>) -> u64 {
    let steps = || (301..=319).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    allocation_counter::measure(steps).count_total
}

#[test]
fn a_warm_step_allocates_nothing() {
    for &name in projection::names() {
        let projection = projection::by_name(name).unwrap();
        let critics = toy::critics_of(projection.as_ref());
        let mut trainer =
            toy::trainer(toy::learner(Method::new("toy", toy::config(), projection), critics, 1));
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        assert_eq!(an_episodes_middle(&mut trainer), 0, "{name}");
    }
}

#[test]
fn nor_does_one_of_the_other_methods() {
    let networks = || LinearCritics::new(3, 2, 0.02, 1);
    let cal =
        || SeparateCritics::new(Box::new(LinearCritics::new(6, 1, 0.02, 1)), &[4, 2]).unwrap();
    let pid =
        Config { constraint: Some(Constraint::Pid(PidConfig::default())), ..Method::sac().config };
    let redq = Config {
        updates_per_step: 2,
        actor_delay: 2,
        ..toy::small(Method::cop_td3_paper().redq().config)
    };
    let sac = |config| toy::stochastic(toy::method(toy::small(config)), &Toy::new(), networks(), 1);
    let constrained = |config| {
        toy::stochastic(toy::method(toy::small(config)), &Toy::constrained(), networks(), 1)
    };
    let cal_method = Method::new("cal", toy::small(Method::cal().config), Method::cal().bound);
    let cal = toy::stochastic(cal_method, &Toy::constrained(), cal(), 1);
    let methods: Vec<(&str, Toy, Learner)> = vec![
        (
            "redq",
            Toy::new(),
            toy::learner(toy::method(redq), 10, 1)
                .explore(Optimistic::new(Optimism::by("cholesky"), 0.1).unwrap()),
        ),
        (
            "cop-td3-oac",
            Toy::new(),
            toy::learner(toy::method(toy::small(Method::cop_td3_oac().config)), 3, 1),
        ),
        (
            "normalised",
            Toy::new(),
            toy::learner(toy::method(Config { normalise: true, ..toy::config() }), 3, 1),
        ),
        ("sac", Toy::new(), sac(Method::sac().config)),
        (
            "oac",
            Toy::new(),
            sac(Method::sac().config).explore(Optimistic::default().projection(Cholesky)),
        ),
        ("cal", Toy::constrained(), cal),
        ("cop-q on cal", Toy::constrained(), constrained(Method::cop_cal().config)),
        ("pid", Toy::constrained(), constrained(pid)),
    ];
    for (name, env, learner) in methods {
        let mut trainer = Trainer::new(env, learner).unwrap();
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        assert_eq!(an_episodes_middle(&mut trainer), 0, "{name}");
    }
}
