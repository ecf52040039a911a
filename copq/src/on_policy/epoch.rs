//! The steps of an epoch, environment after environment, and the rows that they become for
//! learning.

use super::advantage::{centre, generalised, moments, standardise};
use super::update::Rows;
use crate::error::check_len;
use crate::{Error, Result, State};

/// One step as the policy took it: what it saw, did and expected.
#[derive(Clone, Debug, Default)]
pub(super) struct Taken {
    /// As the networks saw it.
    pub obs: Vec<f32>,
    /// As it was sampled.
    pub action: Vec<f32>,
    pub log_prob: f64,
    /// One for each signal: the reward's, then the costs'.
    pub values: Vec<f32>,
}

/// Where a path of rows ends.
#[derive(Clone, Debug)]
struct End {
    /// The row after it.
    row: usize,
    /// The value of what would have followed, for each signal.
    values: Vec<f32>,
}

/// The rows of an epoch while it is gathered; each environment has the same number.
#[derive(Clone, Debug)]
pub(super) struct Epoch {
    /// Room for the rows of each environment, and how many each has.
    capacity: usize,
    filled: Vec<usize>,
    obs_len: usize,
    rows: Rows,
    /// Rewards and values, signal by signal.
    signals: Vec<Vec<f32>>,
    values: Vec<Vec<f32>>,
    ends: Vec<End>,
    /// The deviation of each signal's advantages, before they are standardised or centred.
    spreads: Vec<f64>,
}

impl Epoch {
    /// Room for `steps` steps of `envs` environments together.
    pub fn new(steps: usize, envs: usize, [obs, action]: [usize; 2], signals: usize) -> Self {
        let zeros = vec![vec![0.0; steps]; signals];
        Self {
            capacity: steps / envs,
            filled: vec![0; envs],
            obs_len: obs,
            rows: Rows {
                obs: vec![0.0; steps * obs],
                action: vec![0.0; steps * action],
                log_prob: vec![0.0; steps],
                advantages: zeros.clone(),
                targets: zeros.clone(),
            },
            signals: zeros.clone(),
            values: zeros,
            ends: Vec::new(),
            spreads: vec![0.0; signals],
        }
    }

    /// Adds an environment's step and its signals.
    pub fn push(&mut self, env: usize, taken: &Taken, signals: &[f32]) {
        let row = self.next_row(env);
        let action = taken.action.len();
        self.rows.obs[row * self.obs_len..][..self.obs_len].copy_from_slice(&taken.obs);
        self.rows.action[row * action..][..action].copy_from_slice(&taken.action);
        self.rows.log_prob[row] = taken.log_prob;
        for (values, value) in self.values.iter_mut().zip(&taken.values) {
            values[row] = *value;
        }
        for (rewards, reward) in self.signals.iter_mut().zip(signals) {
            rewards[row] = *reward;
        }
        self.filled[env] += 1;
    }

    /// Ends an environment's path after its last row, with the values of what would have followed.
    pub fn end(&mut self, env: usize, values: Vec<f32>) {
        self.ends.push(End { row: self.next_row(env), values });
    }

    fn next_row(&self, env: usize) -> usize {
        env * self.capacity + self.filled[env]
    }

    /// Whether an environment's path has rows and no end.
    pub fn is_open(&self, env: usize) -> bool {
        let row = self.next_row(env);
        self.filled[env] > 0 && self.ends.iter().all(|end| end.row != row)
    }

    /// Whether an environment has all its rows.
    pub fn is_full(&self, env: usize) -> bool {
        self.filled[env] == self.capacity
    }

    /// Whether every environment has all its rows.
    pub fn is_complete(&self) -> bool {
        (0..self.filled.len()).all(|env| self.is_full(env))
    }

    /// Advantages and targets of a complete epoch: the reward's standardised, the costs' centred.
    pub fn finish(&mut self, discount: f64, lambda: f64) -> &Rows {
        self.ends.sort_by_key(|end| end.row);
        for (k, (signal, values)) in self.signals.iter().zip(&self.values).enumerate() {
            let ends = self.ends.iter().map(|end| (end.row, end.values[k]));
            let advantage = &mut self.rows.advantages[k];
            let target = &mut self.rows.targets[k];
            generalised(signal, values, ends, [discount, lambda], advantage, target);
            self.spreads[k] = moments(advantage)[1];
            if k == 0 { standardise(advantage) } else { centre(advantage) }
        }
        &self.rows
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.filled.iter().all(|&rows| rows == 0)
    }

    /// For a signal, after [`Epoch::finish`]: the deviation of its advantages, and the share of its
    /// targets' variance that its critic had predicted.
    pub fn quality(&self, signal: usize) -> [f64; 2] {
        let targets = &self.rows.targets[signal];
        let missed: Vec<f32> =
            targets.iter().zip(&self.values[signal]).map(|(y, v)| y - v).collect();
        let [_, all] = moments(targets);
        let [_, rest] = moments(&missed);
        let explained = if all > 0.0 { 1.0 - (rest / all).powi(2) } else { 0.0 };
        [self.spreads[signal], explained]
    }

    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.filled.fill(0);
        self.ends.clear();
    }

    /// Writes the rows so far.
    pub fn save(&self, state: &mut State) {
        let filled: Vec<_> = self.filled.iter().map(|&rows| rows as u64).collect();
        state.put("filled", filled);
        state.put("obs", self.rows.obs.as_slice());
        state.put("action", self.rows.action.as_slice());
        state.put("log_prob", self.rows.log_prob.as_slice());
        for (k, (signal, values)) in self.signals.iter().zip(&self.values).enumerate() {
            state.put(&format!("signal.{k}"), signal.as_slice());
            state.put(&format!("value.{k}"), values.as_slice());
        }
        state.put("end_rows", self.ends.iter().map(|end| end.row as u64).collect::<Vec<_>>());
        let values = self.ends.iter().flat_map(|end| &end.values).copied().collect::<Vec<f32>>();
        state.put("end_values", values);
    }

    /// An error unless each path ends once, after a row that its environment has, and the paths of
    /// full environments have ended.
    fn check_ends(&self, rows: &[u64]) -> Result<()> {
        let is_row = |row: u64| {
            let env = (row.max(1) - 1) / self.capacity as u64;
            let filled = self.filled.get(env as usize).copied().unwrap_or(0);
            row > 0 && row <= env * self.capacity as u64 + filled as u64
        };
        for (i, &row) in rows.iter().enumerate() {
            if !is_row(row) || rows[..i].contains(&row) {
                let wanted = "one after a row that its environment has, not repeated";
                return Err(Error::invalid("end of a path of the saved epoch", wanted, row));
            }
        }
        for env in (0..self.filled.len()).filter(|&env| self.is_full(env)) {
            let end = self.next_row(env) as u64;
            if !rows.contains(&end) {
                let what = format!("ends of paths of environment {env} of the saved epoch");
                return Err(Error::invalid(what, "one after its last row", "none"));
            }
        }
        Ok(())
    }

    /// Restores what [`Epoch::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        let filled = state.get::<u64>("filled")?;
        check_len("environments of the saved epoch", filled.len(), self.filled.len())?;
        for (own, &saved) in self.filled.iter_mut().zip(filled) {
            check_at_most("rows of an environment of the saved epoch", saved, self.capacity)?;
            *own = saved as usize;
        }
        state.read("obs", &mut self.rows.obs)?;
        state.read("action", &mut self.rows.action)?;
        state.read("log_prob", &mut self.rows.log_prob)?;
        let signals = self.signals.len();
        for (k, (signal, values)) in self.signals.iter_mut().zip(&mut self.values).enumerate() {
            state.read(&format!("signal.{k}"), signal)?;
            state.read(&format!("value.{k}"), values)?;
        }
        let rows = state.get::<u64>("end_rows")?;
        let values = state.get::<f32>("end_values")?;
        self.check_ends(rows)?;
        check_len("values at the ends of the saved epoch", values.len(), rows.len() * signals)?;
        let ends = rows.iter().zip(values.chunks_exact(signals));
        self.ends =
            ends.map(|(&row, values)| End { row: row as usize, values: values.to_vec() }).collect();
        Ok(())
    }
}

fn check_at_most(what: &str, saved: u64, most: usize) -> Result<()> {
    if saved <= most as u64 {
        return Ok(());
    }
    Err(Error::invalid(what, format!("at most {most}"), saved))
}
