//! `copq tasks` and `copq methods`: what there is to choose from.

use copq_envs::{Options, list_tasks};

use crate::options::say;
use crate::recipe::Recipe;

const HEADING: &str = "\
N is the number of objectives. Critics value all of them, unless some are for costs and some for rewards.

| method | critics | bound | explores by | holds costs by | source |
|---|---|---|---|---|---|
";

const PYTHONS: &str = "\
PACKAGE:ID      any Python environment with boxes of numbers, such as gymnasium:Pendulum-v1, \
mo-gymnasium:mo-hopper-v5 or safety-gymnasium:SafetyHopperVelocity-v1 (copq doctor lists the packages)
";

/// Lists the tasks: what each sees and moves, its objectives by priority with their weights, and
/// its costs with their limits.
#[derive(clap::Args)]
pub struct Tasks {
    /// Which version of the robots: gym-v5 (Gymnasium's) or paper (Brax's, which the paper uses).
    #[arg(long, value_name = "NAME", default_value = "gym-v5")]
    preset: String,
}

impl Tasks {
    pub fn run(self) -> anyhow::Result<()> {
        let tasks = list_tasks(&Options { preset: self.preset.parse()?, ..Options::default() })?;
        Ok(say(&format!("{tasks}{PYTHONS}"))?)
    }
}

/// Lists the methods: critics, bound, exploration, constraint and source of each.
#[derive(clap::Args)]
pub struct Methods {}

impl Methods {
    pub fn run(self) -> anyhow::Result<()> {
        let mut table = HEADING.to_owned();
        for name in Recipe::names() {
            table += &Recipe::by_name(name)?.describe();
        }
        Ok(say(&table)?)
    }
}
