//! `copq tasks` and `copq methods`: what there is to choose from.

use copq::{Constraint, Ensemble, Method};
use copq_envs::{Options, list_tasks};

use crate::options::say;

const HEADING: &str = "\
N is the number of objectives; critics value all of them, unless some are for costs and some for rewards.

| method | critics | bound | explores by | holds costs by | source |
|---|---|---|---|---|---|
";

/// Lists the tasks: what each sees and moves, its objectives by priority with their weights, its
/// costs with their limits.
#[derive(clap::Args)]
pub struct Tasks {
    /// Whose robots: gym-v5 (Gymnasium's) or paper (Brax's, as in the paper).
    #[arg(long, value_name = "NAME", default_value = "gym-v5")]
    preset: String,
}

impl Tasks {
    pub fn run(self) -> anyhow::Result<()> {
        Ok(say(&list_tasks(&Options { preset: self.preset.parse()?, ..Options::default() })?)?)
    }
}

/// Lists the methods: critics, bound, explorer, constraint, and where each is from.
#[derive(clap::Args)]
pub struct Methods {}

impl Methods {
    pub fn run(self) -> anyhow::Result<()> {
        let mut table = HEADING.to_owned();
        for name in Method::names() {
            let method = Method::by_name(name)?;
            table += &format!(
                "| {name} | {} | {} | {} | {} | {} |\n",
                critics(method.critics),
                method.bound.name(),
                explorer(&method),
                constraint(&method),
                method.source
            );
        }
        Ok(say(&table)?)
    }
}

fn critics(ensemble: Ensemble) -> String {
    match ensemble {
        Ensemble::Spanning => "N + 1".to_owned(),
        Ensemble::Joint(count) => count.to_string(),
        Ensemble::Separate { cost, reward } => format!("{cost} a cost, {reward} a reward"),
        other => format!("{other:?}"),
    }
}

fn explorer(method: &Method) -> String {
    let noise = match method.config.entropy {
        Some(_) => "its own samples".to_owned(),
        None => format!("noise of {}", method.config.exploration_std),
    };
    match &method.config.optimism {
        None => noise,
        Some(optimism) => {
            let bound = optimism.projection.as_deref().unwrap_or(method.bound.name());
            format!("{noise}, shifted up the {bound} bound")
        }
    }
}

fn constraint(method: &Method) -> &'static str {
    match &method.config.constraint {
        None => "nothing",
        Some(Constraint::Lagrangian(lagrangian)) if lagrangian.augmentation > 0.0 => {
            "an augmented Lagrangian"
        }
        Some(Constraint::Lagrangian(_)) => "a Lagrange multiplier",
        Some(Constraint::Pid(_)) => "a PID controller",
    }
}
