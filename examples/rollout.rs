//! Shows what a trained policy does, as an animated picture that needs no window and no graphics card.
//!
//! `cargo run --release --example rollout -- runs/FOLDER` writes rollout.gif there; `--help` explains the rest.

use std::path::PathBuf;

use clap::Parser;
use copq::{Config, Env, Normaliser, Outcome, Policy, Result, Rng, Stream};
use copq_examples::{VIEWS, World, make_view, make_world};
use copq_experiments::animation::{Animation, Scene};
use copq_experiments::{read_checkpoint, read_config};

/// Plays episodes of a trained policy without exploration; writes a GIF in real time, with the returns so far.
///
/// Task, engine and policy are those of the run. Its folder is only read: the run may go on meanwhile.
#[derive(Parser)]
#[command(name = "rollout")]
struct Cli {
    /// Folder of a run, such as runs/td3-a-hopper-cholesky-s0.
    run: PathBuf,
    /// Episodes to show, one after the other.
    #[arg(long, value_name = "N", default_value_t = 1)]
    episodes: usize,
    /// Seed of the episodes; the run's own gives those of its evaluations. [default: the run's own]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Most steps to play of an episode.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    steps: usize,
    /// How to draw: `side` needs nothing, `mujoco` is MuJoCo's own picture, of whichever engine's run.
    #[arg(long, value_parser = VIEWS, default_value = "side")]
    view: String,
    /// The GIF to write. [default: rollout.gif in the run's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Folder for the frames as PNG files, if you want them too.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();
    let run = read_config::<Config>(&cli.run)?;

    // The run's task on its engine, and the policy that it has learned.
    let mut world = make_world(&run.plan)?;
    let actor = copq_candle::actor_for(&run.settings, world.spec(), 1, &mut Rng::new(0, Stream::Init))?;
    let checkpoint = read_checkpoint(&cli.run)?;
    let normaliser = run.settings.normalise.then(|| Normaliser::new(world.spec().observation));
    let mut policy = Policy::load(actor, normaliser, checkpoint.child("trainer")?.child("agent")?)?;

    // Before anything is played, for it may have something to complain of.
    let mut draw = make_view(&cli.view, &world.task().robot)?;
    let mut seeds = Rng::new(cli.seed.unwrap_or(run.plan.run.seed), Stream::Evaluation);
    let mut film = Animation::default();
    for episode in 1..=cli.episodes {
        let end = play(&mut world, &mut policy, seeds.next_u64(), cli.steps, &mut film)?;
        let readings: Vec<_> = end.readings.iter().map(|(name, value)| format!("{name} {value}")).collect();
        println!("episode {episode}: {}", readings.join(", "));
    }
    let out = cli.out.unwrap_or_else(|| cli.run.join("rollout.gif"));
    film.write_gif(&out, &mut *draw)?;
    println!("{} frames in {}", film.frames(), out.display());
    Ok(cli.png.map_or(Ok(()), |folder| film.write_png(&folder, &mut *draw))?)
}

/// Plays an episode into the film, its end for a second; returns the end.
fn play(world: &mut World, policy: &mut Policy, seed: u64, steps: usize, film: &mut Animation) -> Result<Scene> {
    let (spec, dt) = (world.spec().clone(), world.task().robot.dt());
    let (mut obs, mut action) = (vec![0.0; spec.observation], vec![0.0; spec.action()]);
    let (mut reward, mut returns) = (vec![0.0; spec.objectives.len()], vec![0.0; spec.objectives.len()]);
    world.reset(seed, &mut obs)?;
    let mut scene = look(world, 0, &returns);
    for step in 1..=steps {
        film.push(scene, dt);
        policy.act(&obs, &mut action)?;
        let outcome = world.step(&action, &mut obs, &mut reward)?;
        returns.iter_mut().zip(&reward).for_each(|(sum, reward)| *sum += f64::from(*reward));
        scene = look(world, step, &returns);
        if outcome != Outcome::Running {
            break;
        }
    }
    film.push(scene.clone(), 1.0);
    Ok(scene)
}

/// Where the robot is now, with the steps and returns so far.
fn look(world: &World, steps: usize, returns: &[f64]) -> Scene {
    let returns = returns.iter().map(|sum| format!("{sum:.1}"));
    let mut readings = vec![("steps".to_owned(), steps.to_string())];
    readings.extend(world.spec().objectives.iter().cloned().zip(returns));
    Scene { position: world.qpos().to_vec(), readings }
}
