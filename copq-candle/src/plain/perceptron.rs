//! The multilayer perceptron of all backends, made of candle-nn's linear layers.

use candle_core::{DType, Device, Module, Result, Tensor};
use candle_nn::{Linear, VarBuilder, linear};
use copq::{Activation, Networks, Rng, Stream};

use super::failed;
use super::network::Network;
use crate::MakeModule;
use crate::learned::Learned;
use crate::shape::{Layer, Shape};

/// Linear layers with an activation after each but the last.
struct Perceptron {
    layers: Vec<Linear>,
    activation: Activation,
}

impl Perceptron {
    fn new(vars: &VarBuilder<'_>, layers: &[Layer], activation: Activation) -> Result<Self> {
        let mut made = Vec::with_capacity(layers.len());
        for (i, layer) in layers.iter().enumerate() {
            made.push(linear(layer.input, layer.output, vars.pp(format!("layer.{i}")))?);
        }
        Ok(Self { layers: made, activation })
    }
}

impl Module for Perceptron {
    fn forward(&self, input: &Tensor) -> Result<Tensor> {
        let mut x = input.clone();
        for (i, layer) in self.layers.iter().enumerate() {
            x = layer.forward(&x)?;
            if i + 1 < self.layers.len() {
                x = match self.activation {
                    Activation::Relu => relu(&x)?,
                    Activation::Tanh => x.tanh()?,
                    Activation::Silu => x.silu()?,
                };
            }
        }
        Ok(x)
    }
}

/// The user's module, or else the perceptron of all backends.
pub(super) fn network(
    make: Option<&MakeModule>,
    input: usize,
    output: usize,
    networks: &Networks,
    rng: &mut Rng,
    device: &Device,
) -> copq::Result<Network> {
    match make {
        Some(make) => {
            let network = Network::new(make, input, output, rng, device).map_err(failed)?;
            network.check_gradients(input, device)?;
            Ok(network)
        }
        None => perceptron(&Shape::new(input, &networks.hidden, output), networks, rng, device),
    }
}

/// A network of this shape, with the same fresh weights as the fused one from an equal `rng`.
fn perceptron(
    shape: &Shape,
    networks: &Networks,
    rng: &mut Rng,
    device: &Device,
) -> copq::Result<Network> {
    let layers = shape.layers().to_vec();
    let activation = networks.activation;
    let make = move |vars: VarBuilder<'_>, _, _| {
        let module = Perceptron::new(&vars, &layers, activation)?;
        Ok(Box::new(module) as Box<dyn Module + Send>)
    };
    // The layers know their widths, and the weights drawn here are replaced.
    let mut unused = Rng::new(0, Stream::Init);
    let mut network = Network::new(&make, 0, 0, &mut unused, device).map_err(failed)?;
    network.set_learned(&Learned::new(shape, networks.init, rng))?;
    Ok(network)
}

/// max(0, x), with derivative 0 at exactly 0 as in PyTorch; candle's own has 1 there.
fn relu(x: &Tensor) -> Result<Tensor> {
    x * x.gt(0f32)?.to_dtype(DType::F32)?
}
