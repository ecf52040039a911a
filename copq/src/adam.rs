//! AdamW on a few numbers in double precision: FAMO's logits, the temperature, the multipliers.

use crate::{Result, State};

const BETA1: f64 = 0.9;
const BETA2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// The optimiser's constants and moments; its defaults are PyTorch's.
#[derive(Clone, Debug)]
pub(crate) struct Adam {
    lr: f64,
    decay: f64,
    first: Vec<f64>,
    second: Vec<f64>,
    steps: u64,
}

impl Adam {
    /// For `len` parameters, with step size `lr` and decoupled weight decay `decay`.
    pub(crate) fn new(lr: f64, decay: f64, len: usize) -> Self {
        Self { lr, decay, first: vec![0.0; len], second: vec![0.0; len], steps: 0 }
    }

    /// One step down the gradient, whose i-th component is `grad(i, i-th parameter)`.
    pub(crate) fn step(&mut self, parameters: &mut [f64], grad: impl Fn(usize, f64) -> f64) {
        self.steps += 1;
        let correct1 = 1.0 - libm::pow(BETA1, self.steps as f64);
        let correct2 = 1.0 - libm::pow(BETA2, self.steps as f64);
        for (i, parameter) in parameters.iter_mut().enumerate() {
            let grad = grad(i, *parameter);
            let m = &mut self.first[i];
            let v = &mut self.second[i];
            *m = BETA1 * *m + (1.0 - BETA1) * grad;
            *v = BETA2 * *v + (1.0 - BETA2) * grad * grad;
            let direction = (*m / correct1) / ((*v / correct2).sqrt() + EPSILON);
            *parameter -= self.lr * (self.decay * *parameter + direction);
        }
    }

    /// Writes the moments.
    pub(crate) fn save(&self, state: &mut State) {
        state.put("first_moment", self.first.as_slice());
        state.put("second_moment", self.second.as_slice());
        state.put("steps", [self.steps]);
    }

    /// Restores what [`Adam::save`] wrote.
    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        state.read("first_moment", &mut self.first)?;
        state.read("second_moment", &mut self.second)?;
        self.steps = state.get_one("steps")?;
        Ok(())
    }
}
