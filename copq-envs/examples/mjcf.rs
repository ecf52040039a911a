//! Prints a robot as MJCF for MuJoCo 3.17.0:
//! `cargo run -p copq-envs --example mjcf a/hopper gym-v5 > hopper.xml`.

use copq_envs::{Options, task_with};

fn main() -> copq::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or("a/hopper".into());
    let preset = arguments.next().unwrap_or("gym-v5".into()).parse()?;
    let task = task_with(&name, &Options { preset, ..Options::default() })?;
    print!("{}", task.robot.mjcf(3017000));
    Ok(())
}
