//! A warm update allocates nothing in the core: counted by the allocator itself.

mod toy;

use copq::projection::{Cholesky, Conservative};
use copq::{Config, Constraint, Learner, Optimistic, PidConfig, SeparateCritics, Silent, Trainer, projection};
use toy::{LinearCritics, Toy};

/// Allocations in steps 301 to 319, one episode's middle: acting, stepping, storing, sampling, updating, all of it warm.
/// The episode's own vector of returns, made at its first step, is the one thing made anew.
fn an_episodes_middle(trainer: &mut Trainer) -> u64 {
    let steps = || (301..=319).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
    allocation_counter::measure(steps).count_total
}

#[test]
fn a_warm_step_allocates_only_the_episode_it_returns() {
    for &name in projection::names() {
        let projection = projection::by_name(name).unwrap();
        let critics = projection.critics(2);
        let mut trainer = toy::trainer(toy::learner(toy::config(), critics, 1).projection(projection), 1);
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        assert_eq!(an_episodes_middle(&mut trainer), 1, "{name}");
    }
}

#[test]
fn warm_steps_of_the_other_methods_allocate_no_more() {
    let networks = || LinearCritics::new(3, 2, 0.02, 1);
    let cal = || SeparateCritics::new(Box::new(LinearCritics::new(6, 1, 0.02, 1)), &[4, 2]).unwrap();
    let pid = Config { constraint: Some(Constraint::Pid(PidConfig::default())), ..Config::sac() };
    let redq = Config { updates_per_step: 2, actor_delay: 2, ..toy::small(Config::cop_td3_paper().redq()) };
    let sac = |config| toy::stochastic(toy::small(config), &Toy::new(), networks(), 1);
    let constrained = |config| toy::stochastic(toy::small(config), &Toy::constrained(), networks(), 1);
    let cal = toy::stochastic(toy::small(Config::cal()), &Toy::constrained(), cal(), 1);
    let methods: Vec<(&str, Toy, Learner)> = vec![
        ("redq", Toy::new(), toy::learner(redq, 10, 1).explore(Optimistic::default().projection(Cholesky))),
        ("cop-td3-oac", Toy::new(), toy::learner(toy::small(Config::cop_td3_oac()), 3, 1)),
        ("normalised", Toy::new(), toy::learner(Config { normalise: true, ..toy::config() }, 3, 1)),
        ("sac", Toy::new(), sac(Config::sac())),
        ("oac", Toy::new(), sac(Config::sac()).explore(Optimistic::default().projection(Cholesky))),
        ("cal", Toy::constrained(), cal.projection(Conservative::cal(0.5, 4))),
        ("cop-q on cal", Toy::constrained(), constrained(Config::cop_cal())),
        ("pid", Toy::constrained(), constrained(pid)),
    ];
    for (name, env, learner) in methods {
        let mut trainer = Trainer::new(Box::new(env), Box::new(learner), 1).unwrap();
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        assert_eq!(an_episodes_middle(&mut trainer), 1, "{name}");
    }
}
