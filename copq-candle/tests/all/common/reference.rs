//! A network in f64, straight from its definition, and central differences of it.

use copq::{Activation, State};

/// A multilayer perceptron in f64, straight from its definition.
#[derive(Clone)]
pub struct Reference {
    pub layers: Vec<(Vec<f64>, Vec<f64>)>,
    pub activation: Activation,
}

impl Reference {
    pub fn read(saved: &State, layers: usize, activation: Activation) -> Self {
        let get =
            |name: String| saved.get::<f32>(&name).unwrap().iter().map(|&x| f64::from(x)).collect();
        let layer = |i| (get(format!("layer.{i}.weight")), get(format!("layer.{i}.bias")));
        Self { layers: (0..layers).map(layer).collect(), activation }
    }

    pub fn forward(&self, input: &[f64]) -> Vec<f64> {
        let mut x = input.to_vec();
        for (i, (weight, bias)) in self.layers.iter().enumerate() {
            let dot = |row: &[f64]| row.iter().zip(&x).map(|(w, x)| w * x).sum::<f64>();
            let out = weight.chunks_exact(x.len()).zip(bias).map(|(row, b)| dot(row) + b);
            let last = i + 1 == self.layers.len();
            x = out.map(|y| if last { y } else { self.activate(y) }).collect();
        }
        x
    }

    fn activate(&self, x: f64) -> f64 {
        match self.activation {
            Activation::Relu => x.max(0.0),
            Activation::Tanh => x.tanh(),
            Activation::Silu => x / (1.0 + (-x).exp()),
        }
    }

    /// sum(grad * output) over a batch, the function whose gradients are asked for.
    pub fn loss(&self, rows: &[Vec<f64>], grad: &[f32], squash: fn(f64) -> f64) -> f64 {
        let outputs = rows.iter().flat_map(|row| self.forward(row));
        outputs.zip(grad).map(|(y, &g)| squash(y) * f64::from(g)).sum()
    }

    /// Central differences of [`Reference::loss`] for every parameter, in the order of the saved
    /// arrays.
    pub fn parameter_gradient(
        &self,
        rows: &[Vec<f64>],
        grad: &[f32],
        squash: fn(f64) -> f64,
    ) -> Vec<Vec<f32>> {
        self.gradient(|network| network.loss(rows, grad, squash))
    }

    /// Central differences of any function of the network for every parameter, in the order of the
    /// saved arrays.
    pub fn gradient(&self, loss: impl Fn(&Self) -> f64) -> Vec<Vec<f32>> {
        let mut out = Vec::new();
        for layer in 0..self.layers.len() {
            for bias in [false, true] {
                let len =
                    if bias { self.layers[layer].1.len() } else { self.layers[layer].0.len() };
                let nudged = |i: usize, by: f64| {
                    let mut copy = self.clone();
                    let (weights, biases) = &mut copy.layers[layer];
                    (if bias { biases } else { weights })[i] += by;
                    loss(&copy)
                };
                out.push((0..len).map(|i| slope(|by| nudged(i, by))).collect());
            }
        }
        out
    }
}

pub fn slope(f: impl Fn(f64) -> f64) -> f32 {
    const STEP: f64 = 1e-6;
    ((f(STEP) - f(-STEP)) / (2.0 * STEP)) as f32
}
