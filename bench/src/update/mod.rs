//! One COP-TD3 update, written in several equivalent ways.

mod autograd;
mod copq;
mod learner;
mod products;

use ::copq::Precision;
use anyhow::{Result, bail};

pub use self::autograd::Autograd;
pub use self::copq::Copq;
pub use self::learner::Full;
pub use self::products::Products;
use crate::workload::{Inputs, Workload};

/// A program that does one update after another.
pub trait Update {
    /// The `number`-th update, counted from 1, on a batch.
    fn update(&mut self, number: usize, batch: &Inputs) -> Result<Losses>;
}

/// What an update reports, to show that programs agree. Empty for programs that compute no losses.
#[derive(Clone, Debug, Default)]
pub struct Losses {
    /// Mean squared errors, one per objective.
    pub critic: Vec<f32>,
    /// The actor's loss, if it moved.
    pub actor: Option<f32>,
}

/// The names that [`make`] accepts.
pub const NAMES: [&str; 9] = [
    "copq",
    "products",
    "learner",
    "plain",
    "autograd",
    "backward",
    "careful",
    "learner-backward",
    "learner-careful",
];

/// An update by its name:
///
/// * `copq`: the core and the fused networks, without what the peers lack (replay, FAMO, reports);
/// * `products`: only its matrix products;
/// * `learner`: the whole of [`copq::Learner::update`](::copq::Agent::update);
/// * `plain`: like `copq`, with the readable networks of candle tensors;
/// * `backward`, `careful`, `learner-backward`, `learner-careful`: the same in these precisions;
/// * `autograd`: as one would write it with candle and candle-nn alone.
pub fn make(name: &str, workload: &Workload) -> Result<Box<dyn Update>> {
    Ok(match name {
        "copq" => Box::new(Copq::fused(workload)?),
        "products" => Box::new(Products::new(workload)?),
        "learner" => Box::new(Full::new(workload)?),
        "backward" => Box::new(Copq::fused(&workload.in_precision(Precision::Backward))?),
        "careful" => Box::new(Copq::fused(&workload.in_precision(Precision::Careful))?),
        "learner-backward" => Box::new(Full::new(&workload.in_precision(Precision::Backward))?),
        "learner-careful" => Box::new(Full::new(&workload.in_precision(Precision::Careful))?),
        "plain" => Box::new(Copq::plain(workload)?),
        "autograd" => Box::new(Autograd::new(workload)?),
        _ => bail!("update {name}: wanted one of {NAMES:?}"),
    })
}
