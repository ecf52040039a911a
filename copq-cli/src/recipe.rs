//! A method of either family: off-policy or on-policy.

use std::path::Path;

use copq::on_policy::{self, SauteConfig};
use copq::{Agent, Config, Constraint, Ensemble, EnvSpec, Error, Learner, Method, Result, WarmUp};
use copq_candle::Candle;
use copq_experiments::{Plan, RunFolder, RunSettings, read_policy, with_changes};

/// What a run learns by.
#[derive(Clone, Debug)]
pub enum Recipe {
    /// From replayed experience.
    OffPolicy(Method),
    /// From the policy's own last steps.
    OnPolicy(on_policy::Method),
}

impl Recipe {
    /// The names of all methods.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Method::names().chain(on_policy::Method::names())
    }

    /// The method of a name.
    pub fn by_name(name: &str) -> Result<Self> {
        if is_on_policy(name) {
            return on_policy::Method::by_name(name).map(Self::OnPolicy);
        }
        let names: Vec<_> = Self::names().collect();
        let method = Method::by_name(name).map_err(|_| Error::unknown("method", name, &names))?;
        Ok(Self::OffPolicy(method))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        match self {
            Self::OffPolicy(method) => &method.name,
            Self::OnPolicy(method) => &method.name,
        }
    }

    /// The plan of a run unless its options change it.
    pub fn usual_plan(&self) -> Plan {
        let paper = self.name() == "cop-td3-paper";
        let benchmark = match self {
            _ if self.holds_costs() => "b",
            _ => "a",
        };
        let usual = match self {
            Self::OffPolicy(method) => Plan::new(method),
            Self::OnPolicy(method) => Plan::on_policy(&method.name),
        };
        let run = match self {
            Self::OffPolicy(_) if paper => RunSettings { steps: 1_000_000, ..usual.run },
            Self::OffPolicy(_) => usual.run,
            // 500 whole epochs of 2,048 steps: a row for each, an evaluation every tenth.
            Self::OnPolicy(_) => RunSettings {
                steps: 1_024_000,
                log_every: 2_048,
                eval_every: 20_480,
                checkpoint_every: 102_400,
                ..usual.run
            },
        };
        Plan {
            task: format!("{benchmark}/hopper"),
            preset: if paper { "paper".to_owned() } else { usual.preset.clone() },
            run,
            ..usual
        }
    }

    /// Whether the method holds the limits of costs.
    pub fn holds_costs(&self) -> bool {
        match self {
            Self::OffPolicy(method) => method.config.constraint.is_some(),
            Self::OnPolicy(method) => {
                method.config.constraint.is_some() || method.config.saute.is_some()
            }
        }
    }

    /// A method of its family that holds costs.
    pub fn constrained(&self) -> &'static str {
        match self {
            Self::OffPolicy(_) => "cop-cal",
            Self::OnPolicy(_) => "cppo-pid",
        }
    }

    /// The budgets that its environment must show, if any.
    pub fn saute(&self) -> Option<&SauteConfig> {
        match self {
            Self::OffPolicy(_) => None,
            Self::OnPolicy(method) => method.config.saute.as_ref(),
        }
    }

    /// The same with settings changed as by `--set`; an error for changes that make it a method
    /// different from the one that its name says.
    pub fn with_changes(mut self, changes: &[String]) -> anyhow::Result<Self> {
        match &mut self {
            Self::OffPolicy(method) => {
                let config = with_changes(&method.config, changes)?;
                check_name(&method.name, &method.config, &config)?;
                method.config = config;
            }
            Self::OnPolicy(method) => {
                let config = with_changes(&method.config, changes)?;
                check_on_policy_name(&method.name, &method.config, &config)?;
                method.config = config;
            }
        }
        Ok(self)
    }

    /// For a run that begins with a policy: that policy also acts during its warm-up.
    pub fn by_its_policy(mut self) -> Self {
        if let Self::OffPolicy(method) = &mut self {
            method.config.warm_up = WarmUp::Policy;
        }
        self
    }

    /// For a run of another length: a step size that decays over a whole run still does.
    pub fn stretched(mut self, from: u64, to: u64) -> Self {
        if let Self::OnPolicy(method) = &mut self
            && method.config.anneal_steps == Some(from)
        {
            method.config.anneal_steps = Some(to);
        }
        self
    }

    /// An agent that learns by it, beginning with the policy in a file if there is one.
    pub fn agent(self, spec: &EnvSpec, plan: &Plan, init: Option<&Path>) -> Result<Box<dyn Agent>> {
        let candle = Candle::threads(plan.threads);
        Ok(match self {
            Self::OffPolicy(method) => {
                let mut learner = Learner::new(method, spec, &candle, plan.run.seed)?;
                init.map_or(Ok(()), |file| learner.start_from(&read_policy(file)?))?;
                Box::new(learner)
            }
            Self::OnPolicy(method) => {
                let mut learner = on_policy::Learner::new(method, spec, &candle, plan.run.seed)?;
                init.map_or(Ok(()), |file| learner.start_from(&read_policy(file)?))?;
                Box::new(learner)
            }
        })
    }

    /// Its settings, whatever they are.
    pub fn settings(&self) -> anyhow::Result<toml::Table> {
        Ok(match self {
            Self::OffPolicy(method) => toml::Table::try_from(&method.config)?,
            Self::OnPolicy(method) => toml::Table::try_from(&method.config)?,
        })
    }

    /// Makes a run's folder, with its settings.
    pub fn create(&self, folder: &Path, plan: &Plan) -> Result<RunFolder> {
        match self {
            Self::OffPolicy(method) => RunFolder::create(folder, plan, &method.config),
            Self::OnPolicy(method) => RunFolder::create(folder, plan, &method.config),
        }
    }

    /// Reopens a run's folder.
    pub fn resume(&self, folder: &Path, plan: &Plan) -> Result<RunFolder> {
        match self {
            Self::OffPolicy(method) => RunFolder::resume(folder, plan, &method.config),
            Self::OnPolicy(method) => RunFolder::resume(folder, plan, &method.config),
        }
    }

    /// A row of the table of methods.
    pub fn describe(&self) -> String {
        let [critics, bound, explorer, constraint, source] = match self {
            Self::OffPolicy(method) => [
                critics(method.critics),
                method.bound.name().to_owned(),
                explorer(method),
                constraint(method).to_owned(),
                method.source.clone(),
            ],
            Self::OnPolicy(method) => [
                "V of the reward".to_owned()
                    + if method.config.constraint.is_some() { ", of each cost" } else { "" },
                "none".to_owned(),
                "its own samples".to_owned(),
                on_policy_constraint(&method.config).to_owned(),
                method.source.clone(),
            ],
        };
        let name = self.name();
        format!("| {name} | {critics} | {bound} | {explorer} | {constraint} | {source} |\n")
    }
}

/// Whether a name is an on-policy method's.
pub fn is_on_policy(name: &str) -> bool {
    on_policy::Method::names().any(|known| known == name)
}

/// An error for settings that make it a method different from the one that its name says.
fn check_name(name: &str, before: &Config, after: &Config) -> anyhow::Result<()> {
    let has_oac = Method::names().any(|known| known == format!("{name}-oac"));
    if (has_oac || name.ends_with("-oac")) && before.optimism.is_some() != after.optimism.is_some()
    {
        let other = match name.strip_suffix("-oac") {
            Some(plain) => format!("{plain}, which explores by noise alone"),
            None => format!("{name}-oac, which explores towards the upper bound"),
        };
        anyhow::bail!("--set optimism: {name} would be another method; choose {other}");
    }
    for (key, before, after) in [
        ("constraint", before.constraint.is_some(), after.constraint.is_some()),
        ("subset", before.subset.is_some(), after.subset.is_some()),
    ] {
        let other = if after { "one that has it" } else { "one without" };
        anyhow::ensure!(
            before == after,
            "--set {key}: {name} would be another method; choose {other} (copq methods)"
        );
    }
    Ok(())
}

/// The same for on-policy methods.
fn check_on_policy_name(
    name: &str,
    before: &on_policy::Config,
    after: &on_policy::Config,
) -> anyhow::Result<()> {
    let constraint = |config: &on_policy::Config| {
        config.constraint.map_or("none", |constraint| match constraint {
            on_policy::Constraint::Pid(_) => "pid",
            on_policy::Constraint::Adam(_) => "adam",
            _ => "another",
        })
    };
    let is = |there: bool| if there { "one" } else { "none" };
    let parts = |config: &on_policy::Config| {
        [
            ("constraint", constraint(config)),
            ("natural", is(config.natural.is_some())),
            ("second", is(config.second.is_some())),
            ("saute", is(config.saute.is_some())),
        ]
    };
    for ((key, before), (_, after)) in parts(before).into_iter().zip(parts(after)) {
        anyhow::ensure!(
            before == after,
            "--set {key}: wanted {before} in {name}, got {after}; that is another method (copq \
             methods)"
        );
    }
    Ok(())
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
            format!("{noise}, shifted towards the upper {bound} bound")
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
        Some(_) => "a multiplier",
    }
}

fn on_policy_constraint(config: &on_policy::Config) -> &'static str {
    match &config.constraint {
        _ if config.saute.is_some() => "a budget in the observation",
        None => "nothing",
        Some(_) if config.second.is_some() => "a second step by a Lagrange multiplier",
        Some(_) if config.natural.is_some() => "a Lagrange multiplier, natural steps",
        Some(on_policy::Constraint::Adam(_)) => "a Lagrange multiplier",
        Some(on_policy::Constraint::Pid(_)) => "a PID controller",
        Some(_) => "a multiplier",
    }
}
