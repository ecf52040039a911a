//! A multilayer perceptron of candle tensors, with its target and its optimiser.

use candle_core::{DType, Device, Result, Tensor, Var};
use copq::{Activation, Net};

use crate::adam::{BETA1, BETA2, EPSILON, Step};
use crate::learned::Learned;
use crate::shape::Shape;

/// One network; every list holds layer 0's weight (`output x input`), layer 0's bias, layer 1's
/// weight and so on.
#[derive(Debug)]
pub(super) struct Network {
    online: Vec<Var>,
    target: Vec<Tensor>,
    m: Vec<Tensor>,
    v: Vec<Tensor>,
    steps: u64,
    activation: Activation,
}

impl Network {
    /// Puts what was learned on a device.
    pub fn new(
        shape: &Shape,
        activation: Activation,
        learned: &Learned,
        device: &Device,
    ) -> Result<Self> {
        let tensors = |values: &[f32]| -> Result<Vec<Tensor>> {
            shape
                .arrays()
                .map(|(_, dims, range)| Tensor::from_slice(&values[range], dims, device))
                .collect()
        };
        Ok(Self {
            online: tensors(&learned.online)?
                .iter()
                .map(Var::from_tensor)
                .collect::<Result<_>>()?,
            target: tensors(&learned.target)?,
            m: tensors(&learned.m)?,
            v: tensors(&learned.v)?,
            steps: learned.steps,
            activation,
        })
    }

    /// Fetches what was learned from the device.
    pub fn learned(&self) -> Result<Learned> {
        let online: Vec<Tensor> = self.online.iter().map(|var| var.as_tensor().clone()).collect();
        Ok(Learned {
            online: flat(&online)?,
            target: flat(&self.target)?,
            m: flat(&self.m)?,
            v: flat(&self.v)?,
            steps: self.steps,
        })
    }

    /// `rows x input` to `rows x output`; the activation after every layer but the last.
    pub fn forward(&self, net: Net, input: &Tensor) -> Result<Tensor> {
        let parameter = |i: usize| match net {
            Net::Online => self.online[i].as_tensor(),
            Net::Target => &self.target[i],
        };
        let layers = self.target.len() / 2;
        let mut x = input.clone();
        for layer in 0..layers {
            x = x.matmul(&parameter(2 * layer).t()?)?.broadcast_add(parameter(2 * layer + 1))?;
            if layer + 1 < layers {
                x = match self.activation {
                    Activation::Relu => relu(&x)?,
                    Activation::Tanh => x.tanh()?,
                    Activation::Silu => x.silu()?,
                };
            }
        }
        Ok(x)
    }

    /// One Adam step (no weight decay) that lowers a loss made with the online parameters.
    pub fn step(&mut self, grads: &candle_core::backprop::GradStore, lr: f64) -> Result<()> {
        self.steps += 1;
        let Step { rate, root } = Step::new(lr, self.steps);
        for (i, var) in self.online.iter().enumerate() {
            let Some(grad) = grads.get(var) else { continue };
            self.m[i] = ((&self.m[i] * BETA1)? + (grad * (1.0 - BETA1))?)?.detach();
            self.v[i] = ((&self.v[i] * BETA2)? + (grad.sqr()? * (1.0 - BETA2))?)?.detach();
            let scale = ((self.v[i].sqrt()? * (1.0 / root))? + EPSILON)?;
            var.set(&(var.as_detached_tensor() - ((&self.m[i] * rate)? / scale)?)?)?;
        }
        Ok(())
    }

    /// Polyak averaging: target <- (1 - tau) target + tau online.
    pub fn update_target(&mut self, tau: f32) -> Result<()> {
        for (target, online) in self.target.iter_mut().zip(&self.online) {
            *target = ((&*target * f64::from(1.0 - tau))?
                + (online.as_detached_tensor() * f64::from(tau))?)?;
        }
        Ok(())
    }
}

/// max(0, x), with derivative 0 at exactly 0 as in PyTorch; candle's own has 1 there.
fn relu(x: &Tensor) -> Result<Tensor> {
    x * x.gt(0f32)?.to_dtype(DType::F32)?
}

/// A tensor's values in row-major order.
pub(crate) fn values(tensor: &Tensor) -> Result<Vec<f32>> {
    tensor.flatten_all()?.to_vec1()
}

fn flat(tensors: &[Tensor]) -> Result<Vec<f32>> {
    Ok(tensors.iter().map(values).collect::<Result<Vec<_>>>()?.concat())
}
