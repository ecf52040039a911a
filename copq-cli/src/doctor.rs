//! `copq doctor`: which engines this build has, and whether they work.

use copq_envs_mujoco::doctor;

use crate::options::say;

/// Says which MuJoCo this build has, whether it fits, and the one thing to do next. Fails if there
/// is something to do.
#[derive(clap::Args)]
pub struct Doctor {}

impl Doctor {
    pub fn run(self) -> anyhow::Result<()> {
        let report = doctor();
        let mut lines = vec!["engine rapier: built in".to_owned()];
        lines.extend(report.lines);
        let built = cfg!(any(feature = "mujoco", feature = "system"));
        let next = report.next.filter(|_| built);
        match (&next, built) {
            (None, true) => lines.push("next: nothing, it works".to_owned()),
            (None, false) => lines.push(
                "next: nothing, rapier works; for MuJoCo run scripts/fetch-mujoco.sh, then build \
                 copq with --features mujoco"
                    .to_owned(),
            ),
            (Some(_), _) => {}
        }
        say(&(lines.join("\n") + "\n"))?;
        match next {
            None => Ok(()),
            Some(next) => anyhow::bail!("next: {next}"),
        }
    }
}
