//! What is measured: sizes of one COP-TD3 update, and the weights and batches that every program
//! starts from.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Result, bail};
use candle_core::{Device, Tensor};
use copq::{Actor, Critic, EnvSpec, Networks, Precision, Rng, State, Stream};
use copq_candle::fused;

/// The discount.
pub const DISCOUNT: f32 = 0.99;
/// The weight of the online networks in a Polyak step.
pub const TAU: f32 = 0.005;
/// Number of different batches. The i-th update uses the (i modulo this)-th.
pub const BATCHES: usize = 20;
/// Adam's step size, for all networks.
pub const LR: f64 = 3e-4;

/// Sizes of an update.
#[derive(Clone, Debug)]
pub struct Workload {
    /// Length of an observation.
    pub observation: usize,
    /// Length of an action.
    pub action: usize,
    /// Number of objectives, N.
    pub objectives: usize,
    /// Number of critics, K.
    pub critics: usize,
    /// Width of each of the two hidden layers.
    pub width: usize,
    /// Rows of a batch.
    pub rows: usize,
    /// Critic updates for each actor update.
    pub actor_delay: usize,
    /// Threads an update may use.
    pub threads: usize,
    /// The precision of copq's networks.
    pub precision: Precision,
}

impl Workload {
    /// `walker2d` and `humanoid` are COP-TD3 on Gymnasium's robots of those names; `redq` has
    /// walker2d's shapes with 10 critics and an actor that moves in every 20th update, the last of
    /// an environment step.
    pub fn named(name: &str, threads: usize) -> Result<Self> {
        let walker2d = Self {
            observation: 17,
            action: 6,
            objectives: 3,
            critics: 4,
            width: 256,
            rows: 256,
            actor_delay: 2,
            threads,
            precision: Precision::F32,
        };
        match name {
            "walker2d" => Ok(walker2d),
            "humanoid" => Ok(Self { observation: 348, action: 17, ..walker2d }),
            "redq" => Ok(Self { critics: 10, actor_delay: 20, ..walker2d }),
            _ => bail!("workload {name}: wanted walker2d, humanoid or redq"),
        }
    }

    /// The environment that has these shapes.
    pub fn spec(&self) -> EnvSpec {
        let spec = EnvSpec::new("benchmark", self.observation, self.action);
        (0..self.objectives).fold(spec, |spec, i| spec.reward(format!("objective {i}"), 1.0))
    }

    /// Hidden layers and step sizes.
    pub fn networks(&self) -> Networks {
        Networks {
            hidden: vec![self.width; 2],
            critic_lr: LR,
            actor_lr: LR,
            precision: self.precision,
            ..Networks::default()
        }
    }

    /// The same in another precision.
    pub fn in_precision(&self, precision: Precision) -> Self {
        Self { precision, ..self.clone() }
    }

    /// The batches, always the same.
    pub fn batches(&self) -> Vec<Inputs> {
        let mut rng = Rng::new(0, Stream::Batch);
        (0..BATCHES).map(|_| Inputs::random(self, &mut rng)).collect()
    }

    /// The first of the batches.
    pub fn batch(&self) -> Inputs {
        Inputs::random(self, &mut Rng::new(0, Stream::Batch))
    }

    /// Writes what the peers need: `networks.safetensors` and `batches.safetensors`.
    pub fn write(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder)?;
        let spec = self.spec();
        let networks = self.networks();
        let mut rng = Rng::new(0, Stream::Init);
        let mut weights = State::default();
        let critics = fused::Critics::new(&spec, self.critics, &networks, &mut rng)?;
        critics.save(weights.child_mut("critics"))?;
        let actor = fused::Deterministic::new(&spec, &networks, &mut rng)?;
        actor.save(weights.child_mut("actor"))?;
        weights.write_file(folder.join("networks.safetensors"))?;
        let mut arrays = HashMap::new();
        for (i, batch) in self.batches().iter().enumerate() {
            for (name, values) in batch.arrays() {
                let tensor = Tensor::from_slice(
                    values,
                    (self.rows, values.len() / self.rows),
                    &Device::Cpu,
                )?;
                arrays.insert(format!("{i}.{name}"), tensor);
            }
        }
        Ok(candle_core::safetensors::save(&arrays, folder.join("batches.safetensors"))?)
    }
}

/// What one update reads: transitions, and the clipped noise that smooths their next actions (TD3).
#[derive(Clone, Debug)]
pub struct Inputs {
    /// `rows x observation`
    pub obs: Vec<f32>,
    /// `rows x action`
    pub action: Vec<f32>,
    /// `rows x objectives`
    pub reward: Vec<f32>,
    /// `rows x observation`
    pub next_obs: Vec<f32>,
    /// `rows`; 0 where the episode terminated, else 1
    pub alive: Vec<f32>,
    /// `rows x action`
    pub noise: Vec<f32>,
}

impl Inputs {
    fn random(workload: &Workload, rng: &mut Rng) -> Self {
        let rows = workload.rows;
        let mut normals = |width: usize| {
            let mut values = vec![0.0; rows * width];
            rng.fill_normal(&mut values);
            values
        };
        let mut batch = Self {
            obs: normals(workload.observation),
            action: normals(workload.action),
            reward: normals(workload.objectives),
            next_obs: normals(workload.observation),
            alive: normals(1),
            noise: normals(workload.action),
        };
        batch.action.iter_mut().for_each(|x| *x = x.clamp(-1.0, 1.0));
        batch.alive.iter_mut().for_each(|x| *x = if *x > 2.0 { 0.0 } else { 1.0 });
        batch.noise.iter_mut().for_each(|x| *x = (0.2 * *x).clamp(-0.5, 0.5));
        batch
    }

    /// Every array by name.
    fn arrays(&self) -> [(&'static str, &[f32]); 6] {
        let Self { obs, action, reward, next_obs, alive, noise } = self;
        [
            ("obs", obs),
            ("action", action),
            ("reward", reward),
            ("next_obs", next_obs),
            ("alive", alive),
            ("noise", noise),
        ]
    }
}
