//! An update reduced to its matrix products: the floor for every program that computes them this
//! way.

use anyhow::Result;
use rayon::prelude::*;

use super::{Losses, Update};
use crate::workload::{Inputs, Workload};

/// The networks' arrays, with the sizes and in the number that an update touches.
pub struct Products {
    critics: Vec<Network>,
    actor: Network,
    observation: usize,
    actor_delay: usize,
    pool: rayon::ThreadPool,
}

/// One network's weights, activations and gradients.
struct Network {
    /// Input and output width of each layer.
    layers: Vec<(usize, usize)>,
    rows: usize,
    /// How many threads share a product.
    threads: usize,
    online: Vec<Vec<f32>>,
    target: Vec<Vec<f32>>,
    grad: Vec<Vec<f32>>,
    /// The input, then each layer's output.
    activations: Vec<Vec<f32>>,
    delta: [Vec<f32>; 2],
    action_grad: Vec<f32>,
}

impl Products {
    /// Arrays for a workload. With more than one thread, the critics are spread over them, as in
    /// copq.
    pub fn new(workload: &Workload) -> Result<Self> {
        let Workload { observation, action, objectives, width, rows, .. } = *workload;
        let critic =
            || Network::new(&[observation + action, width, width, objectives], rows, action, 1);
        Ok(Self {
            critics: (0..workload.critics).map(|_| critic()).collect(),
            actor: Network::new(&[observation, width, width, action], rows, 0, workload.threads),
            observation,
            actor_delay: workload.actor_delay,
            pool: rayon::ThreadPoolBuilder::new().num_threads(workload.threads).build()?,
        })
    }

    /// Runs the actor's products one after another, each shared by all threads, as in copq.
    fn actor(&mut self, task: impl Fn(&mut Network) + Send + Sync) {
        self.pool.install(|| task(&mut self.actor));
    }

    fn each_critic(&mut self, task: impl Fn(&mut Network) + Send + Sync) {
        if self.pool.current_num_threads() == 1 {
            self.critics.iter_mut().for_each(task);
        } else {
            self.pool.install(|| self.critics.par_iter_mut().for_each(task));
        }
    }
}

impl Update for Products {
    fn update(&mut self, number: usize, _batch: &Inputs) -> Result<Losses> {
        self.actor(|actor| actor.forward(false));
        self.each_critic(|critic| critic.forward(false));
        self.each_critic(|critic| critic.forward(true));
        self.each_critic(Network::backward);
        if number.is_multiple_of(self.actor_delay) {
            let observation = self.observation;
            self.actor(|actor| actor.forward(true));
            self.each_critic(|critic| critic.forward(true));
            self.each_critic(|critic| critic.backward_to_input(observation));
            self.actor(Network::backward);
        }
        Ok(Losses::default())
    }
}

impl Network {
    fn new(widths: &[usize], rows: usize, action: usize, threads: usize) -> Self {
        let layers: Vec<_> = widths.windows(2).map(|pair| (pair[0], pair[1])).collect();
        // Scaled so that products neither grow nor fade from layer to layer.
        let weights = || {
            layers.iter().map(|&(input, output)| vec![1.0 / input as f32; input * output]).collect()
        };
        let widest = widths.iter().max().copied().unwrap_or(0);
        Self {
            online: weights(),
            target: weights(),
            grad: weights(),
            activations: widths.iter().map(|width| vec![1.0; rows * width]).collect(),
            delta: [(); 2].map(|()| vec![1.0; rows * widest]),
            action_grad: vec![0.0; rows * action],
            layers,
            rows,
            threads,
        }
    }

    fn forward(&mut self, online: bool) {
        let weights = if online { &self.online } else { &self.target };
        for (i, &(input, output)) in self.layers.iter().enumerate() {
            let (below, above) = self.activations.split_at_mut(i + 1);
            let weight = Matrix::new(&weights[i], input).t();
            product(
                self.threads,
                &mut above[0],
                (self.rows, input, output),
                Matrix::new(&below[i], input),
                weight,
            );
        }
    }

    fn backward(&mut self) {
        self.begin_backward();
        for (i, &(input, output)) in self.layers.iter().enumerate().rev() {
            let delta = Matrix::new(&self.delta[0], output);
            let below = Matrix::new(&self.activations[i], input);
            product(self.threads, &mut self.grad[i], (output, self.rows, input), delta.t(), below);
            if i > 0 {
                step_down(
                    self.threads,
                    &mut self.delta,
                    (self.rows, output, input),
                    &self.online[i],
                );
            }
        }
    }

    fn backward_to_input(&mut self, first: usize) {
        self.begin_backward();
        for (i, &(input, output)) in self.layers.iter().enumerate().skip(1).rev() {
            step_down(self.threads, &mut self.delta, (self.rows, output, input), &self.online[i]);
        }
        let (input, output) = self.layers[0];
        let weight =
            Matrix { values: &self.online[0][first..], ..Matrix::new(&self.online[0], input) };
        let shape = (self.rows, output, input - first);
        product(
            self.threads,
            &mut self.action_grad,
            shape,
            Matrix::new(&self.delta[0], output),
            weight,
        );
    }

    /// Sets a fresh gradient of the output. Otherwise gradients would fade to subnormal numbers,
    /// which are slow.
    fn begin_backward(&mut self) {
        let output = self.layers.last().map_or(0, |&(_, output)| output);
        self.delta[0][..self.rows * output].fill(1.0);
    }
}

fn step_down(
    threads: usize,
    [here, below]: &mut [Vec<f32>; 2],
    (rows, output, input): (usize, usize, usize),
    weight: &[f32],
) {
    let out = &mut below[..rows * input];
    product(
        threads,
        out,
        (rows, output, input),
        Matrix::new(here, output),
        Matrix::new(weight, input),
    );
    std::mem::swap(here, below);
}

/// A matrix in a slice; element (i, j) is at `i * row_step + j * col_step`.
#[derive(Clone, Copy)]
struct Matrix<'a> {
    values: &'a [f32],
    row_step: usize,
    col_step: usize,
}

impl<'a> Matrix<'a> {
    fn new(values: &'a [f32], width: usize) -> Self {
        Self { values, row_step: width, col_step: 1 }
    }

    fn t(self) -> Self {
        Self { row_step: self.col_step, col_step: self.row_step, ..self }
    }

    fn holds(self, rows: usize, cols: usize) -> bool {
        rows > 0
            && cols > 0
            && (rows - 1) * self.row_step + (cols - 1) * self.col_step < self.values.len()
    }
}

/// `out = left * right`, `m x k` times `k x n`.
fn product(
    threads: usize,
    out: &mut [f32],
    (m, k, n): (usize, usize, usize),
    left: Matrix<'_>,
    right: Matrix<'_>,
) {
    assert!(
        out.len() == m * n && left.holds(m, k) && right.holds(k, n),
        "a matrix leaves its slice"
    );
    let lhs = left.values.as_ptr();
    let rhs = right.values.as_ptr();
    let lhs_row = left.row_step as isize;
    let lhs_col = left.col_step as isize;
    let rhs_row = right.row_step as isize;
    let rhs_col = right.col_step as isize;
    let out = out.as_mut_ptr();
    let out_row = n as isize;
    let shared = match threads {
        1 => gemm::Parallelism::None,
        more => gemm::Parallelism::Rayon(more),
    };
    // SAFETY: the assertion keeps every element that `gemm` reads or writes inside its slice. `out`
    // is a `&mut`, so it overlaps neither factor, and it is only written (`read_dst` false).
    unsafe {
        gemm::gemm(
            m, n, k, out, 1, out_row, false, lhs, lhs_col, lhs_row, rhs, rhs_col, rhs_row, 0.0,
            1.0, false, false, false, shared,
        );
    }
}
