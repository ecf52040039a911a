//! What fewer bits do to what is learned, without the noise of acting: learners go on from one run's
//! checkpoint with the same batches of its replay, in every precision, and are compared with f32's.
//!
//! Learning magnifies any difference, so two others tell what one means. `autograd` adds the same
//! numbers up in another order: what is not farther from f32 than it is, harms nothing that could be
//! seen. `bf16 throughout` has inputs and values in bf16 as well: it must be farther.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Parser;
use copq::{
    Actor, ActorKind, Agent, Backend, Batch, Config, Critic, Env, EnvSpec, Learner, Method,
};
use copq::{Mode, Networks, Precision, Rng, State, Stream};
use copq_bench::coarse::Coarse;
use copq_candle::{Candle, Device, plain};
use copq_envs::{Locomotion, Options};
use copq_experiments::{Plan, RunConfig, read_checkpoint, read_config};

/// Compares learners of all precisions on one run's experience.
#[derive(Parser)]
struct Cli {
    /// A run's folder whose checkpoint has its replay.
    run: PathBuf,

    /// Updates that every learner does.
    #[arg(long, default_value_t = 3_000)]
    updates: u64,

    /// Transitions of the replay at which they are compared.
    #[arg(long, default_value_t = 1_000)]
    rows: usize,
}

/// A learner and what was logged of its last thousand updates, by name.
struct Twin {
    name: &'static str,
    learner: Learner,
    logged: BTreeMap<String, Vec<f64>>,
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    let config = read_config(&cli.run)?;
    let spec = spec(&config.plan)?;
    let mut twins = twins(&cli.run, &config, &spec)?;
    let first = twins[0].learner.updates();
    for twin in &mut twins {
        twin.learn(first + cli.updates)?;
        eprintln!("{}: {} updates", twin.name, twin.learner.updates() - first);
    }
    let mut batch = Batch::default();
    let mut rng = Rng::new(0, Stream::Batch);
    twins[0].learner.replay().sample(cli.rows, &mut rng, &mut batch)?;
    table(&mut twins, &spec, &batch)
}

fn twins(run: &Path, config: &RunConfig<Config>, spec: &EnvSpec) -> Result<Vec<Twin>> {
    let method = config.plan.method(config.settings.clone())?;
    let saved = read_checkpoint(run)?;
    let saved = saved.child("trainer")?.child("agent")?;
    if saved.child("replay").is_err() {
        bail!("{}: wanted a checkpoint with its replay, got one without", run.display());
    }
    let candle = Candle::default();
    let kinds: [(_, &dyn Backend, _); 5] = [
        ("f32", &candle, Precision::F32),
        ("autograd", &Autograd, Precision::F32),
        ("backward", &candle, Precision::Backward),
        ("careful", &candle, Precision::Careful),
        ("bf16 throughout", &Coarse, Precision::Careful),
    ];
    kinds
        .into_iter()
        .map(|(name, backend, precision)| {
            let learner =
                learner(method.clone(), precision, backend, spec, config.plan.run.seed, saved)?;
            Ok(Twin { name, learner, logged: BTreeMap::new() })
        })
        .collect()
}

fn learner(
    mut method: Method,
    precision: Precision,
    backend: &dyn Backend,
    spec: &EnvSpec,
    seed: u64,
    saved: &State,
) -> Result<Learner> {
    method.config.networks.precision = precision;
    let mut learner = Learner::new(method, spec, backend, seed)?;
    learner.load(saved)?;
    Ok(learner)
}

/// The run's task, without its world.
fn spec(plan: &Plan) -> Result<EnvSpec> {
    let options = Options { preset: plan.preset.parse()?, ..Options::default() };
    let world = Locomotion::make(&plan.task, &options, copq_envs_rapier::Rapier::new)?;
    Ok(world.spec().clone())
}

impl Twin {
    fn learn(&mut self, updates: u64) -> Result<()> {
        while self.learner.updates() < updates {
            let is_late = self.learner.updates() + 1_000 >= updates;
            let logged = &mut self.logged;
            self.learner.update(&mut |_: u64, name: &str, value: f64| {
                if is_late {
                    logged.entry(name.to_owned()).or_default().push(value);
                }
            })?;
        }
        Ok(())
    }

    /// The mean of what was logged under a name.
    fn mean(&self, name: &str) -> f64 {
        let logged = self.logged.get(name).map_or(&[][..], Vec::as_slice);
        logged.iter().sum::<f64>() / logged.len() as f64
    }

    /// What it thinks of some transitions.
    fn look(&mut self, batch: &Batch, n: usize) -> copq::Result<Seen> {
        let rows = batch.reward.len() / n;
        let mut action = vec![0.0; batch.action.len() / rows];
        let mut q = vec![0.0; n];
        let mut seen = Seen { q: vec![Vec::new(); n], action: Vec::new() };
        let lines = batch.obs.chunks_exact(batch.obs.len() / rows);
        for (obs, done) in lines.zip(batch.action.chunks_exact(action.len())) {
            self.learner.value(obs, done, &mut q)?;
            self.learner.act(obs, Mode::Exploit, &mut action)?;
            seen.q.iter_mut().zip(&q).for_each(|(all, &q)| all.push(f64::from(q)));
            seen.action.extend(action.iter().map(|&a| f64::from(a)));
        }
        Ok(seen)
    }
}

/// The mean critic's values of some transitions, by objective, and the policy's actions.
struct Seen {
    q: Vec<Vec<f64>>,
    action: Vec<f64>,
}

/// How far each is from the first.
fn table(twins: &mut [Twin], spec: &EnvSpec, batch: &Batch) -> Result<()> {
    let names: Vec<_> = spec.objectives.iter().map(|objective| objective.name.as_str()).collect();
    let looks = twins.iter_mut().map(|twin| twin.look(batch, names.len()));
    let looks = looks.collect::<copq::Result<Vec<_>>>()?;
    println!(
        "| objectives: {} | Q, % | Q, in critics' deviations | deviations, ratio | loss, ratio | actions |",
        names.join(", ")
    );
    println!("|---|--:|--:|--:|--:|--:|");
    for (twin, seen) in twins.iter().zip(&looks).skip(1) {
        let (first, exact) = (&twins[0], &looks[0]);
        let cell = |of: &dyn Fn(usize) -> f64| {
            (0..names.len()).map(|i| format!("{:.3}", of(i))).collect::<Vec<_>>().join(", ")
        };
        let apart = |i: usize| distance(&seen.q[i], &exact.q[i]);
        let ratio = |kind: &str, i: usize| {
            let name = format!("{kind}/{}", names[i]);
            twin.mean(&name) / first.mean(&name)
        };
        println!(
            "| {} | {} | {} | {} | {} | {:.4} |",
            twin.name,
            cell(&|i| 100.0 * apart(i) / size(&exact.q[i])),
            cell(&|i| apart(i) / first.mean(&format!("q_std/{}", names[i]))),
            cell(&|i| ratio("q_std", i)),
            cell(&|i| ratio("critic_loss", i)),
            distance(&seen.action, &exact.action),
        );
    }
    Ok(())
}

/// Root mean square.
fn size(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    size(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// The same networks by candle's autograd.
struct Autograd;

impl Backend for Autograd {
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> copq::Result<Box<dyn Critic>> {
        Ok(Box::new(plain::Critics::new(spec, count, networks, rng, &Device::Cpu)?))
    }

    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> copq::Result<Box<dyn Actor>> {
        Ok(match kind {
            ActorKind::Deterministic => {
                Box::new(plain::Deterministic::new(spec, networks, rng, &Device::Cpu)?)
            }
            _ => Box::new(plain::Gaussian::new(spec, networks, rng, &Device::Cpu)?),
        })
    }
}
