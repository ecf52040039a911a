//! Everything one network has learned, in flat buffers: what both implementations start from, save
//! and load.

use copq::{Error, Init, Result, Rng, State};

use crate::init;
use crate::shape::{Array, Shape};

/// Parameters, slow copy and optimiser state of one network; every buffer of numbers holds the
/// network's [`Array`]s one after another.
#[derive(Clone, Debug)]
pub(crate) struct Learned<T = f32> {
    /// Trained parameters.
    pub online: Vec<T>,
    /// Their slow copy.
    pub target: Vec<T>,
    /// Adam's first moment.
    pub m: Vec<T>,
    /// Adam's second moment.
    pub v: Vec<T>,
    /// Optimiser steps so far.
    pub steps: u64,
}

impl Learned {
    /// Fresh weights, a target equal to them, and an optimiser that has not begun.
    pub fn new(shape: &Shape, initial: Init, rng: &mut Rng) -> Self {
        Self::from_online(init::parameters(shape, initial, rng))
    }

    /// These weights, a target equal to them, and an optimiser that has not begun.
    pub fn from_online(online: Vec<f32>) -> Self {
        let zeros = vec![0.0; online.len()];
        Self { target: online.clone(), online, m: zeros.clone(), v: zeros, steps: 0 }
    }

    /// Writes online parameters alone, each array by its name.
    pub fn export(online: &[f32], arrays: &[Array], state: &mut State) {
        for Array { name, dims, range } in arrays {
            state.put_shaped(name, dims, &online[range.clone()]);
        }
    }

    /// Reads what [`Learned::export`] wrote.
    pub fn import(arrays: &[Array], state: &State) -> Result<Vec<f32>> {
        let mut online = vec![0.0; arrays.last().map_or(0, |last| last.range.end)];
        for Array { name, dims, range } in arrays {
            if let Some(shape) = state.shape(name).filter(|shape| shape != dims) {
                let (wanted, got) = (format!("{dims:?}"), format!("{shape:?}"));
                return Err(Error::invalid(format!("shape of '{name}'"), wanted, got));
            }
            state.read(name, &mut online[range.clone()])?;
        }
        Ok(online)
    }

    /// Writes subtrees `online`, `target`, `adam_m`, `adam_v` of arrays by their names, and the
    /// count `steps`.
    pub fn save(&self, arrays: &[Array], state: &mut State) {
        let parts = [
            ("online", &self.online),
            ("target", &self.target),
            ("adam_m", &self.m),
            ("adam_v", &self.v),
        ];
        for (part, values) in parts {
            Self::export(values, arrays, state.child_mut(part));
        }
        state.put("steps", [self.steps]);
    }

    /// Reads what [`Learned::save`] wrote.
    pub fn load(arrays: &[Array], state: &State) -> Result<Self> {
        let part = |part| Self::import(arrays, state.child(part)?);
        let [online, target, m, v] =
            [part("online")?, part("target")?, part("adam_m")?, part("adam_v")?];
        Ok(Self { online, target, m, v, steps: state.get_one("steps")? })
    }
}

impl<T> Learned<T> {
    /// The same in another layout.
    pub fn map<U>(&self, layout: impl Fn(&[T]) -> Vec<U>) -> Learned<U> {
        let Self { online, target, m, v, steps } = self;
        Learned {
            online: layout(online),
            target: layout(target),
            m: layout(m),
            v: layout(v),
            steps: *steps,
        }
    }
}

/// Writes an ensemble's networks as subtrees `critic.0`, `critic.1` and so on.
pub(crate) fn save_critics(
    critics: impl Iterator<Item = Learned>,
    arrays: &[Array],
    state: &mut State,
) {
    for (k, learned) in critics.enumerate() {
        learned.save(arrays, state.child_mut(&format!("critic.{k}")));
    }
}

/// Reads what [`save_critics`] wrote; there must be exactly `critics` networks.
pub(crate) fn load_critics(
    critics: usize,
    arrays: &[Array],
    state: &State,
) -> Result<Vec<Learned>> {
    let saved = state.children().filter(|(name, _)| name.starts_with("critic.")).count();
    if saved != critics {
        return Err(Error::invalid("saved critics", critics, saved));
    }
    (0..critics).map(|k| Learned::load(arrays, state.child(&format!("critic.{k}"))?)).collect()
}
