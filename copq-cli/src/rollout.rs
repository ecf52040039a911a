//! `copq rollout`: what a policy does, as an animated picture that needs no window and no graphics
//! card.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use anyhow::ensure;
use copq::on_policy::Saute;
use copq::{AdjustedEnv, Env, Outcome, Policy, Result, Rng, Stream};
use copq_envs_python::{Picture, PythonEnv, is_task};
use copq_render::animation::{Album, Animation, Draw, Scene};

use crate::options::{count, say, whole};
use crate::python::{PythonProcess, make_python};
use crate::saved::{Learned, note_other_versions};
use crate::view::{VIEWS, make_view};
use crate::world::{World, adjusted, make_world};

/// Films episodes of a run's last or best policy, without exploration: a GIF in real time, with the
/// returns so far.
///
/// Task, engine and policy are the run's own. The run may continue meanwhile: nothing in its folder
/// is written but rollout.gif.
#[derive(clap::Args)]
pub struct Rollout {
    /// Folder of the run, such as runs/cop-td3-a-hopper-cholesky-s0.
    run: PathBuf,

    /// Use the policy of the run's best evaluation (costs within their limits first, then the
    /// weighted total) instead of its last one.
    #[arg(long)]
    best: bool,

    /// Episodes to show, one after the other.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = count,
        allow_negative_numbers = true
    )]
    episodes: usize,

    /// Seed of the episodes; the run's own begins with the episodes of its evaluations. [default:
    /// the run's own]
    #[arg(long, value_name = "N", value_parser = whole, allow_negative_numbers = true)]
    seed: Option<u64>,

    /// Maximum number of steps to play per episode.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        value_parser = count,
        allow_negative_numbers = true
    )]
    steps: usize,

    /// How to draw: `side` needs nothing; `mujoco` uses MuJoCo's own renderer, whichever engine the
    /// run is on. Python environments draw themselves.
    #[arg(long, value_parser = VIEWS, default_value = "side")]
    view: String,

    /// GIF to write. [default: rollout.gif in the run's folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Also write the frames as PNG files into this folder.
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,

    #[command(flatten)]
    process: PythonProcess,
}

/// Films a few seconds of a run's policy, as rollout.gif in its folder.
pub fn film(folder: &Path) -> anyhow::Result<()> {
    let run = folder.to_owned();
    let view = "side".to_owned();
    let process = PythonProcess::default();
    Rollout {
        run,
        best: false,
        episodes: 1,
        seed: None,
        steps: 300,
        view,
        out: None,
        png: None,
        process,
    }
    .run()
}

impl Rollout {
    pub fn run(self) -> anyhow::Result<()> {
        // The run's task on its engine, and the policy that it has learned.
        let mut learned = Learned::read(&self.run)?;
        let out = self.out();
        let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
        let is_gif = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif"));
        let shown = out.display();
        ensure!(is_gif, "--out {shown}: wanted a name that ends in .gif");
        ensure!(folder.is_none_or(Path::is_dir), "--out {shown}: wanted an existing folder");
        self.process.over(&mut learned.plan)?;
        if is_task(&learned.plan.task) {
            return self.film_python(&learned);
        }
        let world = adjusted(make_world(&learned.plan)?, &learned.plan)?;
        let robot = &world.env().task().robot;
        // Before anything is played, because it may fail.
        let mut draw = make_view(&self.view, robot)?;
        let dt = robot.dt();
        match learned.saute() {
            None => {
                let mut look = |env: &mut AdjustedEnv<World>| Ok(env.env().qpos().to_vec());
                self.film(&learned, Stage::new(world, dt, &mut look)?, &mut *draw)
            }
            Some(saute) => {
                let world = Saute::new(world, saute)?;
                let mut look =
                    |env: &mut Saute<AdjustedEnv<World>>| Ok(env.env().env().qpos().to_vec());
                self.film(&learned, Stage::new(world, dt, &mut look)?, &mut *draw)
            }
        }
    }

    fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| self.run.join("rollout.gif"))
    }

    /// Films a Python environment, which draws itself whenever it is looked at.
    fn film_python(self, learned: &Learned) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.view == "side",
            "--view {}: wanted none, because Python environments draw their own pictures",
            self.view
        );
        let plan = &learned.plan;
        let world = adjusted(make_python(plan, Some(&self.run), true)?, plan)?;
        note_other_versions(plan, world.spec());
        let dt = 1.0 / world.env().frames_per_second();
        let album = RefCell::new(Album::default());
        let picture = |env: &mut PythonEnv| {
            let Picture { width, height, rgb } = env.picture()?;
            album.borrow_mut().add([width, height], &rgb)
        };
        let mut draw = |position: &[f64]| album.borrow().draw(position);
        match learned.saute() {
            None => {
                let mut look = |env: &mut AdjustedEnv<PythonEnv>| picture(env.env_mut());
                self.film(learned, Stage::new(world, dt, &mut look)?, &mut draw)
            }
            Some(saute) => {
                let world = Saute::new(world, saute)?;
                let mut look =
                    |env: &mut Saute<AdjustedEnv<PythonEnv>>| picture(env.env_mut().env_mut());
                self.film(learned, Stage::new(world, dt, &mut look)?, &mut draw)
            }
        }
    }

    /// Plays on a stage, and films it.
    fn film<E: Env>(
        self,
        learned: &Learned,
        mut stage: Stage<'_, E>,
        draw: &mut Draw<'_>,
    ) -> anyhow::Result<()> {
        let mut policy = learned.policy(self.best, stage.rollout.env().spec())?;
        let mut seeds = Rng::new(self.seed.unwrap_or(learned.plan.run.seed), Stream::Evaluation);
        let mut film = Animation::default();
        for episode in 1..=self.episodes {
            let end = stage.play(&mut policy, seeds.next_u64(), self.steps, &mut film)?;
            let readings: Vec<_> =
                end.readings.iter().map(|(name, value)| format!("{name} {value}")).collect();
            say(&format!("episode {episode}: {}\n", readings.join(", ")))?;
        }
        let out = self.out();
        film.write_gif(&out, draw)?;
        say(&format!("{} frames in {}\n", film.frames(), out.display()))?;
        if let Some(folder) = self.png {
            film.write_png(&folder, draw)?;
        }
        Ok(())
    }
}

/// An environment with an episode in it, and how to look at it.
struct Stage<'a, E> {
    rollout: copq::Rollout<E>,
    /// Seconds that a step takes.
    dt: f64,
    /// Returns the current position, as it is drawn.
    look: &'a mut dyn FnMut(&mut E) -> Result<Vec<f64>>,
}

impl<'a, E: Env> Stage<'a, E> {
    fn new(world: E, dt: f64, look: &'a mut dyn FnMut(&mut E) -> Result<Vec<f64>>) -> Result<Self> {
        Ok(Self { rollout: copq::Rollout::new(world)?, dt, look })
    }

    /// Plays an episode into the film, its end for a second; returns the end.
    fn play(
        &mut self,
        policy: &mut Policy,
        seed: u64,
        steps: usize,
        film: &mut Animation,
    ) -> Result<Scene> {
        let mut action = vec![0.0; policy.action_len()];
        self.rollout.reset(seed)?;
        for _ in 0..steps {
            film.push(self.scene()?, self.dt);
            policy.act(self.rollout.obs(), &mut action)?;
            if self.rollout.step(&action)? != Outcome::Running {
                break;
            }
        }
        let end = self.scene()?;
        film.push(end.clone(), 1.0);
        Ok(end)
    }

    /// What there is to see now, with the steps and returns so far.
    fn scene(&mut self) -> Result<Scene> {
        let position = (self.look)(self.rollout.env_mut())?;
        let episode = self.rollout.episode();
        let mut readings = vec![("steps".to_owned(), episode.length.to_string())];
        for (name, sum) in self.rollout.env().spec().names().into_iter().zip(&episode.returns) {
            readings.push((name.to_owned(), format!("{sum:.1}")));
        }
        Ok(Scene { position, readings })
    }
}
