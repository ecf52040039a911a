//! Shows what a trained policy does: its episodes as an animated picture, drawn without a window or a graphics card.
//!
//! `cargo run --release --example rollout -- runs/FOLDER` writes rollout.gif; `--help` explains the rest.

use std::path::PathBuf;

use clap::Parser;
use copq::{Actor, Config, Env, Error, Net, Outcome, Result, Rng, Stream};
use copq_envs::robot::Segment;
use copq_envs::{Locomotion, Physics, RobotSpec};
use copq_experiments::animation::{Animation, Capsule, Scene, part_colour};
use copq_experiments::{read_checkpoint, read_config};

/// Plays episodes of a trained policy, without exploration, and writes them as an animated GIF in real time.
///
/// Task, engine and networks are those of the run; its folder is only read, and may belong to a run that still goes on.
#[derive(Parser)]
#[command(name = "rollout")]
struct Cli {
    /// Folder of a run, such as runs/td3-a-hopper-cholesky-s0: its config.toml and checkpoint.safetensors are used.
    run: PathBuf,

    /// Episodes to show, one after the other.
    #[arg(long, value_name = "N", default_value_t = 1)]
    episodes: usize,

    /// Seed of the episodes. With the run's own, they are those that the run was evaluated on. [default: the run's]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Most steps to play of an episode.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    steps: usize,

    /// The GIF to write.
    #[arg(long, value_name = "FILE", default_value = "rollout.gif")]
    out: PathBuf,

    /// Folder for every frame as a PNG as well.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();

    // The run's task on its engine, and its policy.
    let run = read_config::<Config>(&cli.run)?;
    let task = copq_envs::task(&run.plan.task)?;
    let physics = engine(&run.plan.engine, &task.robot)?;
    let mut env = Locomotion::new(task, physics)?;
    let mut actor = copq_candle::actor(env.spec(), &run.settings.networks, &mut Rng::new(0, Stream::Init))?;
    actor.load(read_checkpoint(&cli.run)?.child("trainer")?.child("agent")?.child("actor")?)?;

    // Its episodes.
    let mut seeds = Rng::new(cli.seed.unwrap_or(run.plan.run.seed), Stream::Evaluation);
    let mut animation = Animation::default();
    for episode in 1..=cli.episodes {
        let end = play(&mut env, &mut actor, seeds.next_u64(), cli.steps, &mut animation)?;
        let readings: Vec<_> = end.readings.iter().map(|(name, value)| format!("{name} {value}")).collect();
        println!("episode {episode}: {}", readings.join(", "));
    }

    // The picture.
    animation.write_gif(&cli.out)?;
    println!("{} frames in {}", animation.frames(), cli.out.display());
    Ok(cli.png.map_or(Ok(()), |folder| animation.write_png(&folder))?)
}

/// A robot and its task on an engine chosen at run time.
type World = Locomotion<Box<dyn Physics>>;

fn engine(name: &str, robot: &RobotSpec) -> Result<Box<dyn Physics>> {
    match name {
        "rapier" => Ok(Box::new(copq_envs_rapier::Rapier::new(robot)?)),
        _ => Err(Error::unknown("engine", name, &["rapier"])),
    }
}

/// Plays one episode into the animation, its end for a second; returns the end.
fn play(env: &mut World, actor: &mut dyn Actor, seed: u64, steps: usize, animation: &mut Animation) -> Result<Scene> {
    let (spec, dt) = (env.spec().clone(), env.task().robot.dt());
    let (mut obs, mut action) = (vec![0.0; spec.observation], vec![0.0; spec.action()]);
    let (mut reward, mut returns) = (vec![0.0; spec.objectives.len()], vec![0.0; spec.objectives.len()]);
    env.reset(seed, &mut obs)?;
    let mut scene = look(env, 0, &returns);
    for step in 1..=steps {
        animation.push(scene, dt);
        actor.sample(Net::Online, &obs, &[], &mut action, &mut [])?;
        let outcome = env.step(&action, &mut obs, &mut reward)?;
        returns.iter_mut().zip(&reward).for_each(|(sum, reward)| *sum += f64::from(*reward));
        scene = look(env, step, &returns);
        if outcome != Outcome::Running {
            break;
        }
    }
    animation.push(scene.clone(), 1.0);
    Ok(scene)
}

/// The robot where it is now, with the step and the returns so far.
fn look(env: &World, step: usize, returns: &[f64]) -> Scene {
    let robot = &env.task().robot;
    let mut qpos = vec![0.0; robot.nq()];
    env.physics().qpos(&mut qpos);
    let bodies = robot.body_poses(&qpos);
    let limb = |Segment { body, ends, radius }| Capsule { ends, radius, colour: part_colour(body.unwrap_or_default()) };
    let returns = env.spec().objectives.iter().zip(returns).map(|(name, sum)| (name.clone(), format!("{sum:.1}")));
    Scene {
        capsules: robot.segments(&bodies).into_iter().map(limb).collect(),
        centre: robot.centre_of_mass(&bodies),
        readings: [("step".into(), step.to_string())].into_iter().chain(returns).collect(),
    }
}
