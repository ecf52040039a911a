//! How fewer bits change what is learned, without the noise of acting. Learners continue from one
//! run's checkpoint with the same batches of its replay, in every precision. What they have learned
//! is then evaluated in f32, and its distance from the f32 learner's is reported.
//!
//! Learning magnifies any difference, so other learners show what a difference means. The nulls are
//! f32 after every weight of the critics was moved up or down by chance by a unit in its last
//! place, and candle's autograd, which adds up the same numbers in a different order. A positive
//! control also has inputs and values in bf16.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Parser;
use copq::{Actor, ActorKind, Agent, Backend, Batch, Config, Critic, Env, EnvSpec, Learner};
use copq::{Mode, Networks, Precision, Rng, State, Stream};
use copq_bench::coarse::Coarse;
use copq_candle::{Candle, Device, plain};
use copq_envs::{Locomotion, Options};
use copq_experiments::{Plan, RunConfig, read_checkpoint, read_config};

/// Compares learners of all precisions on one run's experience.
#[derive(Parser)]
struct Cli {
    /// Folder of a run whose checkpoint includes its replay.
    run: PathBuf,

    /// Number of updates that every learner does.
    #[arg(long, default_value_t = 3_000)]
    updates: u64,

    /// Number of transitions of the replay at which they are compared.
    #[arg(long, default_value_t = 1_000)]
    rows: usize,
}

/// A learner, and what was logged during its last thousand updates, by name.
struct Twin {
    name: String,
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
    let candle = Candle::default();
    let mut by = learner(&config, &spec, Precision::F32, &candle, &checkpoint(&cli.run)?)?;
    table(&twins, &mut by, &spec, &batch)
}

/// The run's learner as it was saved.
fn checkpoint(run: &Path) -> Result<State> {
    Ok(read_checkpoint(run)?.child("trainer")?.child("agent")?.clone())
}

/// Number of nulls whose weights start a unit in the last place away.
const NULLS: u64 = 3;

fn twins(run: &Path, config: &RunConfig<Config>, spec: &EnvSpec) -> Result<Vec<Twin>> {
    let saved = &checkpoint(run)?;
    if saved.child("replay").is_err() {
        bail!("{}: wanted a checkpoint with its replay, got one without", run.display());
    }
    let candle = Candle::default();
    let twin = |name: &str, backend: &dyn Backend, precision, saved: &State| -> Result<Twin> {
        let learner = learner(config, spec, precision, backend, saved)?;
        Ok(Twin { name: name.to_owned(), learner, logged: BTreeMap::new() })
    };
    let mut twins = vec![twin("f32", &candle, Precision::F32, saved)?];
    for i in 1..=NULLS {
        let mut moved = saved.clone();
        move_last_places(moved.child_mut("critic"), &mut Rng::new(i, Stream::Custom));
        twins.push(twin(&format!("null {i}"), &candle, Precision::F32, &moved)?);
    }
    twins.push(twin("null, autograd", &Autograd, Precision::F32, saved)?);
    twins.push(twin("backward", &candle, Precision::Backward, saved)?);
    twins.push(twin("careful", &candle, Precision::Careful, saved)?);
    twins.push(twin("bf16 inputs and values", &Coarse, Precision::Careful, saved)?);
    Ok(twins)
}

fn learner(
    config: &RunConfig<Config>,
    spec: &EnvSpec,
    precision: Precision,
    backend: &dyn Backend,
    saved: &State,
) -> Result<Learner> {
    let mut method = config.plan.off_policy_method(config.settings.clone())?;
    method.config.networks.precision = precision;
    let mut learner = Learner::new(method, spec, backend, config.plan.run.seed)?;
    learner.load(saved)?;
    Ok(learner)
}

/// Moves every f32 by a unit in the last place, up or down.
fn move_last_places(state: &mut State, rng: &mut Rng) {
    let names: Vec<_> = state.values().map(|(name, _)| name.to_owned()).collect();
    for name in names {
        let Ok(values) = state.get::<f32>(&name) else { continue };
        let moved: Vec<_> = values
            .iter()
            .map(|x| if rng.below(2) == 0 { x.next_up() } else { x.next_down() })
            .collect();
        match state.shape(&name).map(<[_]>::to_vec) {
            Some(shape) => state.put_shaped(&name, &shape, moved),
            None => state.put(&name, moved),
        }
    }
    let children: Vec<_> = state.children().map(|(name, _)| name.to_owned()).collect();
    for name in children.iter().filter(|name| !name.starts_with("adam")) {
        move_last_places(state.child_mut(name), rng);
    }
}

/// The spec of the run's task, without its environment.
fn spec(plan: &Plan) -> Result<EnvSpec> {
    if plan.order.is_some() || plan.weights.is_some() || !plan.limits.is_empty() {
        bail!("the run: wanted one of a task as it is, got one with an order, weights or limits");
    }
    let options = Options { preset: plan.preset.parse()?, ..Options::default() };
    let world = Locomotion::make(&plan.task, &options, copq_envs_rapier::Rapier::new)?;
    Ok(world.spec().clone())
}

impl Twin {
    fn learn(&mut self, updates: u64) -> Result<()> {
        while self.learner.updates() < updates {
            let before = self.learner.updates();
            let is_late = before + 1_000 >= updates;
            let logged = &mut self.logged;
            self.learner.update(&mut |_: u64, name: &str, value: f64| {
                if is_late {
                    logged.entry(name.to_owned()).or_default().push(value);
                }
            })?;
            if self.learner.updates() == before {
                bail!("the run: wanted one that has begun to update, got one in its warm-up");
            }
        }
        Ok(())
    }

    /// The mean of what was logged under a name.
    fn mean(&self, name: &str) -> f64 {
        let logged = self.logged.get(name).map_or(&[][..], Vec::as_slice);
        logged.iter().sum::<f64>() / logged.len() as f64
    }
}

/// What a learner estimates for some transitions, by objective.
struct Look {
    q: Vec<Vec<f64>>,
    /// The critics' standard deviation, root mean square.
    std: Vec<f64>,
    action: Vec<f64>,
}

/// What a twin has learned, evaluated by another learner.
fn look(twin: &Twin, by: &mut Learner, batch: &Batch, n: usize) -> copq::Result<Look> {
    let mut state = State::default();
    twin.learner.save(&mut state)?;
    by.load(&state)?;
    let rows = batch.reward.len() / n;
    let mut action = vec![0.0; batch.action.len() / rows];
    let mut look = Look { q: vec![Vec::new(); n], std: Vec::new(), action: Vec::new() };
    let mut stds = vec![Vec::new(); n];
    let lines = batch.obs.chunks_exact(batch.obs.len() / rows);
    for (obs, done) in lines.zip(batch.action.chunks_exact(action.len())) {
        let estimate = by.estimate(obs, done)?;
        look.q.iter_mut().zip(&estimate.mean).for_each(|(all, &q)| all.push(q));
        stds.iter_mut().zip(&estimate.std).for_each(|(all, &std)| all.push(std));
        by.act(obs, Mode::Exploit, &mut action)?;
        look.action.extend(action.iter().map(|&a| f64::from(a)));
    }
    look.std = stds.iter().map(|stds| size(stds)).collect();
    Ok(look)
}

/// Prints how far each twin is from the first.
fn table(twins: &[Twin], by: &mut Learner, spec: &EnvSpec, batch: &Batch) -> Result<()> {
    let names: Vec<_> = spec.names();
    let looks = twins.iter().map(|twin| look(twin, by, batch, names.len()));
    let looks = looks.collect::<copq::Result<Vec<_>>>()?;
    let first = names.join(", ");
    println!("| {first} | Q, % | Q, in stds | std, ratio | loss, ratio | actions |");
    println!("|---|--:|--:|--:|--:|--:|");
    for (twin, look) in twins.iter().zip(&looks).skip(1) {
        let exact = &looks[0];
        let cell = |of: &dyn Fn(usize) -> f64| {
            (0..names.len()).map(|i| format!("{:.3}", of(i))).collect::<Vec<_>>().join(", ")
        };
        let apart = |i: usize| distance(&look.q[i], &exact.q[i]);
        let loss = |i: usize| {
            let name = format!("critic_loss/{}", names[i]);
            twin.mean(&name) / twins[0].mean(&name)
        };
        println!(
            "| {} | {} | {} | {} | {} | {:.4} |",
            twin.name,
            cell(&|i| 100.0 * apart(i) / size(&exact.q[i])),
            cell(&|i| apart(i) / exact.std[i]),
            cell(&|i| look.std[i] / exact.std[i]),
            cell(&loss),
            distance(&look.action, &exact.action),
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

/// The same networks with candle's autograd.
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
