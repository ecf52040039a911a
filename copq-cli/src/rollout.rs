//! `copq rollout`: what a policy does, as an animated picture that needs no window and no graphics
//! card.

use std::path::{Path, PathBuf};

use copq::on_policy::Saute;
use copq::{Env, LimitedEnv, Outcome, Policy, Rng, Stream};
use copq_render::animation::{Animation, Scene};

use crate::options::{count, say, whole};
use crate::saved::Learned;
use crate::view::{VIEWS, make_view};
use crate::world::{World, make_world};

/// Plays episodes of a trained policy without exploration; writes a GIF in real time, with the
/// returns so far.
///
/// Task, engine and policy are those of the run. Its folder is only read: the run may go on
/// meanwhile.
#[derive(clap::Args)]
pub struct Rollout {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Episodes to show, one after the other.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = count,
        allow_negative_numbers = true
    )]
    episodes: usize,

    /// Seed of the episodes; the run's own gives those of its evaluations. [default: the run's own]
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    seed: Option<u64>,

    /// Most steps to play of an episode.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        value_parser = count,
        allow_negative_numbers = true
    )]
    steps: usize,

    /// How to draw: `side` needs nothing, `mujoco` is MuJoCo's own picture, of whichever engine's
    /// run.
    #[arg(long, value_parser = VIEWS, default_value = "side")]
    view: String,

    /// The GIF to write. [default: rollout.gif in the run's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Folder for the frames as PNG files, if you want them too.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
}

/// Films a few seconds of a run's policy, as rollout.gif in its folder.
pub fn film(folder: &Path) -> anyhow::Result<()> {
    let run = folder.to_owned();
    let view = "side".to_owned();
    Rollout { run, episodes: 1, seed: None, steps: 300, view, out: None, png: None }.run()
}

impl Rollout {
    pub fn run(self) -> anyhow::Result<()> {
        // The run's task on its engine, and the policy that it has learned.
        let learned = Learned::read(&self.run)?;
        let world = make_world(&learned.plan)?;
        match learned.saute() {
            None => self.film(&learned, world, |world| world),
            Some(saute) => {
                let limits =
                    learned.plan.limits.iter().map(|(cost, &limit)| (cost.as_str(), limit));
                let limited = LimitedEnv::new(world, limits)?;
                self.film(&learned, Saute::new(limited, saute)?, |saute| saute.env().env())
            }
        }
    }

    /// Plays in a world, and films the robot in it.
    fn film<E: Env>(
        self,
        learned: &Learned,
        world: E,
        robot: fn(&E) -> &World,
    ) -> anyhow::Result<()> {
        let mut policy = learned.policy(&self.run, world.spec())?;

        // Before anything is played, for it may have something to complain of.
        let mut draw = make_view(&self.view, &robot(&world).task().robot)?;
        let mut seeds = Rng::new(self.seed.unwrap_or(learned.plan.run.seed), Stream::Evaluation);
        let mut film = Animation::default();
        let mut rollout = copq::Rollout::new(world)?;
        for episode in 1..=self.episodes {
            let stage = Stage { rollout: &mut rollout, robot };
            let end = stage.play(&mut policy, seeds.next_u64(), self.steps, &mut film)?;
            let readings: Vec<_> =
                end.readings.iter().map(|(name, value)| format!("{name} {value}")).collect();
            say(&format!("episode {episode}: {}\n", readings.join(", ")))?;
        }
        let out = self.out.unwrap_or_else(|| self.run.join("rollout.gif"));
        film.write_gif(&out, &mut *draw)?;
        say(&format!("{} frames in {}\n", film.frames(), out.display()))?;
        if let Some(folder) = self.png {
            film.write_png(&folder, &mut *draw)?;
        }
        Ok(())
    }
}

/// A world with an episode in it, and how to see its robot.
struct Stage<'a, E> {
    rollout: &'a mut copq::Rollout<E>,
    robot: fn(&E) -> &World,
}

impl<E: Env> Stage<'_, E> {
    /// Plays an episode into the film, its end for a second; returns the end.
    fn play(
        self,
        policy: &mut Policy,
        seed: u64,
        steps: usize,
        film: &mut Animation,
    ) -> copq::Result<Scene> {
        let dt = (self.robot)(self.rollout.env()).task().robot.dt();
        let mut action = vec![0.0; policy.action_len()];
        self.rollout.reset(seed)?;
        for _ in 0..steps {
            film.push(self.look(), dt);
            policy.act(self.rollout.obs(), &mut action)?;
            if self.rollout.step(&action)? != Outcome::Running {
                break;
            }
        }
        film.push(self.look(), 1.0);
        Ok(self.look())
    }

    /// Where the robot is now, with the steps and returns so far.
    fn look(&self) -> Scene {
        let world = self.rollout.env();
        let episode = self.rollout.episode();
        let mut readings = vec![("steps".to_owned(), episode.length.to_string())];
        for (name, sum) in world.spec().names().into_iter().zip(&episode.returns) {
            readings.push((name.to_owned(), format!("{sum:.1}")));
        }
        Scene { position: (self.robot)(world).qpos().to_vec(), readings }
    }
}
