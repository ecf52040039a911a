//! A step allocates nothing: counted by the allocator itself.

mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use copq::Env;
use copq_envs::robot::Preset;
use copq_envs::{Locomotion, Options, task_with};
use support::{Recording, Table};

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
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Benchmark A's humanoid of the paper reads the most; Gymnasium's own prices contacts.
#[test]
fn a_step_allocates_nothing() {
    let runs = [
        ("gym/humanoid", Preset::GymV5, include_str!("data/rollout_gym_humanoid.csv")),
        ("a/humanoid", Preset::Paper, include_str!("data/rollout_paper_humanoid.csv")),
    ];
    for (name, preset, text) in runs {
        let task = task_with(name, &Options { preset, ..Options::default() }).unwrap();
        let physics = Recording::new(&task.robot, &Table::parse(text));
        let mut env = Locomotion::new(task, physics).unwrap();
        let (mut obs, mut reward) = (vec![0.0; env.spec().observation], vec![0.0; env.spec().objectives.len()]);
        env.reset(1, &mut obs).unwrap();
        let before = COUNT.get();
        env.step(&[0.5; 17], &mut obs, &mut reward).unwrap();
        assert_eq!(COUNT.get() - before, 0, "{name}");
    }
}
