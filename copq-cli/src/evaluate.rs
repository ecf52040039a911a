//! `copq evaluate`: what a run's policy is worth, in a table or as JSON.

use std::path::PathBuf;

use copq::{Env, EnvSpec, Episode, Outcome, Policy, Rng, Stream};
use copq_experiments::statistics;
use serde::Serialize;

use crate::options::{count, say, whole};
use crate::python::PythonProcess;
use crate::saved::Learned;

/// Plays episodes of a run's last or best policy, without exploration, and reports their returns.
///
/// The folder is only read: the run may continue meanwhile.
#[derive(clap::Args)]
pub struct Evaluate {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Use the policy of the run's best evaluation (costs within their limits first, then the
    /// weighted total) instead of its last one.
    #[arg(long)]
    best: bool,

    /// Episodes to play.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 100,
        value_parser = count,
        allow_negative_numbers = true
    )]
    episodes: usize,

    /// Seed of the episodes; the run's own begins with the episodes of its evaluations. [default:
    /// the run's own]
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    seed: Option<u64>,

    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    process: PythonProcess,
}

/// What is printed.
#[derive(Serialize)]
struct Report {
    method: String,
    task: String,
    engine: String,
    seed: u64,
    episodes: usize,
    /// Steps of an episode, the weighted total, and each objective's return, over the episodes.
    quantities: Vec<Quantity>,
    /// The episodes one by one, in JSON only.
    each: Vec<Played>,
}

/// One episode.
#[derive(Serialize)]
struct Played {
    /// What the environment was reset with; a Python environment with its remainder by 2^31.
    seed: u64,
    steps: u64,
    terminated: bool,
    returns: Vec<f64>,
}

#[derive(Serialize)]
struct Quantity {
    name: String,
    mean: f64,
    std: f64,
    min: f64,
    max: f64,
}

impl Quantity {
    fn new(name: &str, values: &[f64]) -> Self {
        Self {
            name: name.to_owned(),
            mean: statistics::mean(values),
            std: statistics::std(values),
            min: statistics::min(values),
            max: statistics::max(values),
        }
    }
}

impl Evaluate {
    pub fn run(self) -> anyhow::Result<()> {
        let mut learned = Learned::read(&self.run)?;
        self.process.over(&mut learned.plan)?;
        let mut rollout = copq::Rollout::new(learned.env()?)?;
        let spec = rollout.env().spec().clone();
        let mut policy = learned.policy(self.best, &spec)?;
        let plan = learned.plan;
        let seed = self.seed.unwrap_or(plan.run.seed);
        let mut seeds = Rng::new(seed, Stream::Evaluation);
        let mut each = Vec::new();
        for _ in 0..self.episodes {
            each.push(Played::by(&mut policy, &mut rollout, seeds.next_u64())?);
        }
        let report = Report {
            method: plan.method,
            task: plan.task,
            engine: plan.engine,
            seed,
            episodes: self.episodes,
            quantities: quantities(&spec, &each),
            each,
        };
        let text =
            if self.json { serde_json::to_string_pretty(&report)? + "\n" } else { report.table() };
        Ok(say(&text)?)
    }
}

impl Played {
    /// The episode of a seed, played by a policy.
    fn by(
        policy: &mut Policy,
        rollout: &mut copq::Rollout<Box<dyn Env>>,
        seed: u64,
    ) -> copq::Result<Self> {
        let mut action = vec![0.0; policy.action_len()];
        rollout.reset(seed)?;
        while rollout.is_running() {
            policy.act(rollout.obs(), &mut action)?;
            rollout.step(&action)?;
        }
        let Episode { returns, length, outcome } = rollout.episode().clone();
        Ok(Self { seed, steps: length, terminated: outcome == Outcome::Terminated, returns })
    }
}

/// Steps, weighted total, each objective's return and how often it ended early, over the episodes.
fn quantities(spec: &EnvSpec, each: &[Played]) -> Vec<Quantity> {
    let of = |value: &dyn Fn(&Played) -> f64| each.iter().map(value).collect::<Vec<_>>();
    let weights = spec.weights();
    let total = |played: &Played| {
        let weighted = played.returns.iter().zip(&weights);
        weighted.map(|(value, &weight)| value * f64::from(weight)).sum()
    };
    let mut quantities = vec![
        Quantity::new("steps", &of(&|played| played.steps as f64)),
        Quantity::new("weighted total", &of(&total)),
    ];
    for (i, name) in spec.names().into_iter().enumerate() {
        quantities.push(Quantity::new(name, &of(&|played| played.returns[i])));
        if let Some(limit) = spec.limit(i) {
            let is_over = of(&|played| f64::from(played.returns[i] > f64::from(limit)));
            quantities.push(Quantity::new(&format!("{name} over its limit of {limit}"), &is_over));
        }
    }
    let terminated = of(&|played| f64::from(played.terminated));
    quantities.push(Quantity::new("terminated", &terminated));
    quantities
}

impl Report {
    fn table(&self) -> String {
        let Self { method, task, engine, episodes, seed, .. } = self;
        let mut table =
            format!("{method} on {task} ({engine}), {episodes} episodes of seed {seed}\n\n");
        table += "| | mean | std | min | max |\n|---|--:|--:|--:|--:|\n";
        for Quantity { name, mean, std, min, max } in &self.quantities {
            // A share of the episodes, or as small as a share.
            let digits = if *min >= 0.0 && *max <= 1.0 { 2 } else { 1 };
            let cells = [mean, std, min, max].map(|value| format!("{value:.digits$}"));
            table += &format!("| {name} | {} |\n", cells.join(" | "));
        }
        table
    }
}
