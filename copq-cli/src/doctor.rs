//! `copq doctor`: which engines this build has, and whether they work.

use copq_envs_mujoco::doctor;

/// Says which MuJoCo this build has, whether it fits, and the one thing to do next. Fails if there is something to do.
#[derive(clap::Args)]
pub struct Doctor {}

impl Doctor {
    pub fn run(self) -> anyhow::Result<()> {
        println!("engine rapier: built in");
        let report = doctor();
        for line in &report.lines {
            println!("{line}");
        }
        match report.next {
            None => println!("next: nothing, it works"),
            Some(next) => anyhow::bail!("next: {next}"),
        }
        Ok(())
    }
}
