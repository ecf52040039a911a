//! A Gaussian policy's standard deviations: parameters outside its network, which counts their
//! steps.

use copq::{Result, State};

use crate::adam::{BETA1, BETA2, EPSILON, Step};

/// The deviations' logarithms, and Adam's moments of them.
#[derive(Clone, Debug)]
pub(crate) struct Deviations {
    pub log_std: Vec<f32>,
    m: Vec<f32>,
    v: Vec<f32>,
}

impl Deviations {
    /// These deviations, and an optimiser that has not begun.
    pub fn new(log_std: Vec<f32>) -> Self {
        let zeros = vec![0.0; log_std.len()];
        Self { log_std, m: zeros.clone(), v: zeros }
    }

    /// Adam's step number `count`.
    pub fn step(&mut self, grad: &[f32], lr: f64, count: u64) {
        let Step { rate, root } = Step::new(lr, count);
        let moments = self.m.iter_mut().zip(&mut self.v);
        for ((x, (m, v)), &grad) in self.log_std.iter_mut().zip(moments).zip(grad) {
            let grad = f64::from(grad);
            *m = (BETA1 * f64::from(*m) + (1.0 - BETA1) * grad) as f32;
            *v = (BETA2 * f64::from(*v) + (1.0 - BETA2) * grad * grad) as f32;
            let scale = f64::from(*v).sqrt() / root + EPSILON;
            *x = (f64::from(*x) - rate * f64::from(*m) / scale) as f32;
        }
    }

    /// Writes the deviations alone.
    pub fn export(&self, state: &mut State) {
        state.put("log_std", self.log_std.as_slice());
    }

    /// Reads what [`Deviations::export`] wrote, with as many components as these.
    pub fn import(&self, state: &State) -> Result<Self> {
        let mut log_std = self.log_std.clone();
        state.read("log_std", &mut log_std)?;
        Ok(Self::new(log_std))
    }

    pub fn save(&self, state: &mut State) {
        self.export(state);
        state.put("log_std_m", self.m.as_slice());
        state.put("log_std_v", self.v.as_slice());
    }

    /// Reads what [`Deviations::save`] wrote, with as many components as these.
    pub fn load(&self, state: &State) -> Result<Self> {
        let mut loaded = self.import(state)?;
        state.read("log_std_m", &mut loaded.m)?;
        state.read("log_std_v", &mut loaded.v)?;
        Ok(loaded)
    }
}
