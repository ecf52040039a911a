//! Shows what a trained policy does: its episodes as an animated picture, drawn without a window or a graphics card.
//!
//! `cargo run --release --example rollout -- runs/FOLDER` writes rollout.gif; `--help` explains the rest.

use std::path::PathBuf;

use clap::Parser;
use copq::{Actor, Config, Env, Error, Net, Outcome, Result, Rng, Stream};
use copq_envs::{Locomotion, Physics, RobotSpec, robot::Segment};
use copq_experiments::animation::{Animation, Capsule, Scene, limb_colour};
use copq_experiments::{read_checkpoint, read_config};

/// Plays episodes of a trained policy without exploration; writes them as a GIF that runs in real time.
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
    /// Seed of the episodes; the run's own gives those that it was evaluated on. [default: the run's own]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Most steps to play of an episode.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    steps: usize,
    /// The GIF to write.
    #[arg(long, value_name = "FILE", default_value = "rollout.gif")]
    out: PathBuf,
    /// Folder for the frames as PNG files, if you want them too.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let cli = Cli::parse();
    let run = read_config::<Config>(&cli.run)?;
    let saved = read_checkpoint(&cli.run)?;

    // The run's task on its engine, and the policy that it has learned.
    let task = copq_envs::task(&run.plan.task)?;
    let physics = engine(&run.plan.engine, &task.robot)?;
    let mut world = Locomotion::new(task, physics)?;
    let mut policy = copq_candle::actor(world.spec(), &run.settings.networks, &mut Rng::new(0, Stream::Init))?;
    policy.load(saved.child("trainer")?.child("agent")?.child("actor")?)?;

    let mut seeds = Rng::new(cli.seed.unwrap_or(run.plan.run.seed), Stream::Evaluation);
    let mut animation = Animation::default();
    for episode in 1..=cli.episodes {
        let readings = play(&mut world, &mut policy, seeds.next_u64(), cli.steps, &mut animation)?;
        let readings: Vec<_> = readings.iter().map(|(name, value)| format!("{name} {value}")).collect();
        println!("episode {episode}: {}", readings.join(", "));
    }
    animation.write_gif(&cli.out)?;
    println!("{} frames in {}", animation.frames(), cli.out.display());
    Ok(cli.png.map_or(Ok(()), |folder| animation.write_png(&folder))?)
}

type World = Locomotion<Box<dyn Physics>>;
type Readings = Vec<(String, String)>;

fn engine(name: &str, robot: &RobotSpec) -> Result<Box<dyn Physics>> {
    match name {
        "rapier" => Ok(Box::new(copq_envs_rapier::Rapier::new(robot)?)),
        _ => Err(Error::unknown("engine", name, &["rapier"])),
    }
}

/// Plays an episode into the animation, its end for a second; its length and returns.
fn play(
    world: &mut World,
    policy: &mut dyn Actor,
    seed: u64,
    steps: usize,
    animation: &mut Animation,
) -> Result<Readings> {
    let (spec, dt) = (world.spec().clone(), world.task().robot.dt());
    let (mut obs, mut action) = (vec![0.0; spec.observation], vec![0.0; spec.action()]);
    let (mut reward, mut returns) = (vec![0.0; spec.objectives.len()], vec![0.0; spec.objectives.len()]);
    world.reset(seed, &mut obs)?;
    let mut scene = look(world, 0, &returns);
    for step in 1..=steps {
        animation.push(scene, dt);
        policy.sample(Net::Online, &obs, &[], &mut action, &mut [])?;
        let outcome = world.step(&action, &mut obs, &mut reward)?;
        returns.iter_mut().zip(&reward).for_each(|(sum, reward)| *sum += f64::from(*reward));
        scene = look(world, step, &returns);
        if outcome != Outcome::Running {
            break;
        }
    }
    animation.push(scene.clone(), 1.0);
    Ok(scene.readings)
}

/// The robot as it is now, with the steps and returns so far.
fn look(world: &World, steps: usize, returns: &[f64]) -> Scene {
    let robot = &world.task().robot;
    let mut qpos = vec![0.0; robot.nq()];
    world.physics().qpos(&mut qpos);
    let bodies = robot.body_poses(&qpos);
    let capsule = |Segment { limb, ends, radius }| Capsule { ends, radius, colour: limb_colour(limb) };
    let capsules = robot.segments(&bodies).into_iter().map(capsule).collect();
    // Adding 0 to a rounded number makes a 0 of -0.
    let returns = returns.iter().map(|sum| format!("{:.1}", (10.0 * sum).round() / 10.0 + 0.0));
    let mut readings: Readings = world.spec().objectives.iter().cloned().zip(returns).collect();
    readings.insert(0, ("steps".into(), steps.to_string()));
    Scene { capsules, centre: robot.centre_of_mass(&bodies), readings }
}
