//! Where a module's variables come from: our own random numbers, so that a seed gives the same
//! weights every time.

use std::sync::{Arc, Mutex, PoisonError};

use candle_core::{DType, Device, Result, Shape, Tensor, Var};
use candle_nn::Init;
use candle_nn::init::{FanInOut, NormalOrUniform};
use candle_nn::var_builder::SimpleBackend;
use copq::Rng;

/// Variables in the order in which a module asked for them, with the paths that it gave them.
#[derive(Clone, Debug, Default)]
pub(super) struct Variables(Arc<Mutex<Vec<(String, Var)>>>);

impl Variables {
    /// The variables made so far.
    pub fn taken(&self) -> Vec<(String, Var)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Makes variables by candle's rules (`Init`) from our own generator.
pub(super) struct Seeded {
    pub variables: Variables,
    pub rng: Mutex<Rng>,
}

impl Seeded {
    fn draw(&self, shape: &Shape, rule: Init) -> Vec<f32> {
        let mut rng = self.rng.lock().unwrap_or_else(PoisonError::into_inner);
        let mut values = vec![0.0; shape.elem_count()];
        for value in &mut values {
            *value = match rule {
                Init::Const(constant) => constant as f32,
                Init::Randn { mean, stdev } => (mean + stdev * rng.normal()) as f32,
                Init::Uniform { lo, up } => rng.uniform_in(lo, up) as f32,
                Init::Kaiming { dist, fan, non_linearity } => {
                    let std = non_linearity.gain() / (fan_of(fan, shape) as f64).sqrt();
                    match dist {
                        NormalOrUniform::Normal => (std * rng.normal()) as f32,
                        NormalOrUniform::Uniform => {
                            let bound = 3f64.sqrt() * std;
                            rng.uniform_in(-bound, bound) as f32
                        }
                    }
                }
            };
        }
        values
    }
}

fn fan_of(fan: FanInOut, shape: &Shape) -> usize {
    fan.for_shape(shape).max(1)
}

impl SimpleBackend for Seeded {
    fn get(
        &self,
        shape: Shape,
        name: &str,
        rule: Init,
        dtype: DType,
        device: &Device,
    ) -> Result<Tensor> {
        let values = Tensor::from_vec(self.draw(&shape, rule), shape, device)?.to_dtype(dtype)?;
        let variable = Var::from_tensor(&values)?;
        let tensor = variable.as_tensor().clone();
        let mut all = self.variables.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.iter().any(|(known, _)| known == name) {
            candle_core::bail!(
                "variable '{name}' is made twice; give each layer its own path by VarBuilder::pp"
            );
        }
        all.push((name.to_owned(), variable));
        Ok(tensor)
    }

    fn get_unchecked(&self, name: &str, _: DType, _: &Device) -> Result<Tensor> {
        candle_core::bail!("variable '{name}' has no shape; use VarBuilder::get")
    }

    fn contains_tensor(&self, name: &str) -> bool {
        self.variables.taken().iter().any(|(known, _)| known == name)
    }
}
