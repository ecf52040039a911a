//! A warm update allocates nothing in the core: counted by the allocator itself.

mod toy;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use copq::projection::{Cholesky, Conservative};
use copq::{Config, Constraint, Learner, Optimistic, PidConfig, Separate, Silent, Trainer, projection};
use toy::{LinearCritics, Toy};

struct Counting;

thread_local!(static COUNT: Cell<u64> = const { Cell::new(0) });

// SAFETY: every call goes unchanged to the system allocator, which upholds the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's layout is passed on as it came.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `alloc` above with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the pointer came from `alloc` above with this layout.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_warm_step_allocates_only_the_episode_it_returns() {
    for &name in projection::names() {
        let projection = projection::by_name(name).unwrap();
        let critics = projection.critics(2);
        let mut trainer = toy::trainer(toy::learner(toy::config(), critics, 1).projection(projection), 1);
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        let before = COUNT.get();
        // Steps 301 to 319 are one episode's middle: acting, stepping, storing, sampling, updating, all of it warm.
        (301..=319).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        // The episode's own vector of returns, made at its first step, is the one thing made anew.
        assert_eq!(COUNT.get() - before, 1, "{name}");
    }
}

#[test]
fn warm_steps_of_the_other_methods_allocate_no_more() {
    let networks = || LinearCritics::new(3, 2, 0.02, 1);
    let cal = || Separate::new(Box::new(LinearCritics::new(6, 1, 0.02, 1)), &[4, 2]).unwrap();
    let pid = Config { constraint: Some(Constraint::Pid(PidConfig::default())), ..Config::sac() };
    let redq = Config { updates_per_step: 2, actor_delay: 2, ..toy::small(Config::td3().redq()) };
    let sac = |config| toy::stochastic(toy::small(config), &Toy::new(), networks(), 1);
    let constrained = |config| toy::stochastic(toy::small(config), &Toy::constrained(), networks(), 1);
    let cal = toy::stochastic(toy::small(Config::cal()), &Toy::constrained(), cal(), 1);
    let methods: Vec<(&str, Toy, Learner)> = vec![
        ("redq", Toy::new(), toy::learner(redq, 10, 1).explore(Optimistic::new(Cholesky))),
        ("sac", Toy::new(), sac(Config::sac())),
        ("oac", Toy::new(), sac(Config::sac()).explore(Optimistic::new(Cholesky))),
        ("cal", Toy::constrained(), cal.projection(Conservative::cal(0.5, 4))),
        ("cop-q on cal", Toy::constrained(), constrained(Config::cop_cal())),
        ("pid", Toy::constrained(), constrained(pid)),
    ];
    for (name, env, learner) in methods {
        let mut trainer = Trainer::new(Box::new(env), Box::new(learner), 1).unwrap();
        (0..300).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        let before = COUNT.get();
        (301..=319).for_each(|_| drop(trainer.step(&mut Silent).unwrap()));
        assert_eq!(COUNT.get() - before, 1, "{name}");
    }
}
