//! Lists the tasks: what each sees and moves, its objectives by priority with their weights, its costs with their limits.
//!
//! `cargo run --example tasks` is for Gymnasium's robots, `cargo run --example tasks -- paper` for the paper's.

use copq_envs::{Options, list_tasks};

fn main() -> copq::Result<()> {
    let preset = std::env::args().nth(1).unwrap_or("gym-v5".into()).parse()?;
    print!("{}", list_tasks(&Options { preset, ..Options::default() })?);
    Ok(())
}
