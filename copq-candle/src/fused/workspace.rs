//! The buffers of a pass, for one network after another.

use copq::Result;

use super::activation::multiply;
use super::gradient::{Descent, descend, gradient};
use super::half::{self, Across, Down};
use super::last;
use super::panels::{PanelRow, Panels, WIDTH};
use super::product::{Finish, Inputs, affine};
use super::threads::Threads;
use super::transpose::transpose;
use crate::shape::Layer;

/// Buffers that grow to the largest layer and batch and are then reused, and the threads that share
/// each product except the last layer's (one unless set). A thread's networks share a workspace, so
/// that little of it leaves the cache.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    threads: Threads,
    /// Whether the current layer of a backward pass is the last.
    is_last: bool,
    /// Whether the backward pass below the last layer is in bf16.
    is_half: bool,
    /// Hidden layers' outputs, if no backward pass will follow.
    outputs: Vec<Panels>,
    /// dL/d(outputs of the current layer, before their activation).
    delta: Panels,
    /// The next `delta`.
    below: Panels,
    /// The first layer's weight transposed, for the requested columns.
    turned: Panels,
    halves: Halves,
}

/// Factors of products in bf16.
#[derive(Clone, Debug, Default)]
pub(super) struct Halves {
    across: Across,
    map: Down,
    left: Down,
    right: Down,
}

impl Workspace {
    /// An empty workspace for a given number of threads.
    pub fn shared(threads: usize) -> Result<Self> {
        Ok(Self { threads: Threads::new(threads)?, ..Self::default() })
    }

    /// The threads that share a product.
    pub fn threads(&self) -> &Threads {
        &self.threads
    }

    /// Buffers for the outputs of a given number of hidden layers, and what computes them.
    pub fn outputs(&mut self, layers: usize, in_half: bool) -> (&mut [Panels], Layers<'_>) {
        if self.outputs.len() < layers {
            self.outputs.resize_with(layers, Panels::default);
        }
        let Self { outputs, threads, halves, .. } = self;
        (&mut outputs[..layers], Layers::new(threads, halves, in_half))
    }

    /// What computes the outputs of hidden layers.
    pub fn layers(&mut self, in_half: bool) -> Layers<'_> {
        Layers::new(&self.threads, &mut self.halves, in_half)
    }

    /// Begins a backward pass at a network's outputs with dL/doutputs. `in_half` says whether it
    /// continues in bf16 below the last layer.
    pub fn begin(&mut self, rows: usize, grad: &[f32], in_half: bool) {
        (self.is_last, self.is_half) = (true, in_half);
        self.delta.set(rows, &[grad]);
    }

    /// Steps the current layer's parameters down their gradient, given its inputs.
    pub fn descend(&mut self, input: &Panels, map: Descent<'_>) {
        let Self { threads, delta, halves: Halves { left, right, .. }, .. } = self;
        if self.is_last {
            last::descend(input, delta, map);
        } else if self.is_half {
            left.set(input);
            right.set(delta);
            half::descend(left, right, map, threads);
        } else {
            descend(input, delta, map, threads);
        }
    }

    /// dL/dparameters of the current layer, laid out like the parameters, given its inputs.
    pub fn gradient_into(&self, input: &Panels, out: &mut [PanelRow]) {
        if self.is_last {
            last::gradient(input, &self.delta, out);
        } else {
            gradient(input, &self.delta, out, &self.threads);
        }
    }

    /// Goes through the current layer's transposed weight to the layer below, and back through the
    /// lower layer's activation. ReLU passes gradients where its output is positive; any other
    /// activation multiplies them by its slope.
    pub fn step_down(&mut self, turned: &Panels, output: &Panels, slope: Option<&Panels>) {
        let finish = if slope.is_some() { Finish::Keep } else { Finish::Mask(output) };
        let in_half = self.is_half && !self.is_last;
        let Self { threads, delta, below, halves, .. } = self;
        let mut layers = Layers::new(threads, halves, in_half);
        layers.inner(delta, turned.lines(), output.cols(), finish, below);
        if let Some(slope) = slope {
            multiply(below, slope);
        }
        std::mem::swap(delta, below);
        self.is_last = false;
    }

    /// Ends a backward pass through the first layer: dL/d(its inputs' columns from `first` on).
    pub fn step_out(&mut self, layer: &Layer, map: &[PanelRow], first: usize, out: &mut [f32]) {
        let panel = first / WIDTH;
        let cols = layer.input - panel * WIDTH;
        let Self { threads, delta, below, turned, halves, .. } = self;
        transpose(layer, map, panel, turned);
        let mut layers = Layers::new(threads, halves, self.is_half);
        layers.inner(delta, turned.lines(), cols, Finish::Keep, below);
        below.get(first % WIDTH, out);
    }
}

/// Runs rows through layers, forward or backward.
pub(super) struct Layers<'a> {
    threads: &'a Threads,
    /// Present for bf16, which excludes the first layer forward and the last layer.
    halves: Option<&'a mut Halves>,
}

impl<'a> Layers<'a> {
    fn new(threads: &'a Threads, halves: &'a mut Halves, in_half: bool) -> Self {
        Self { threads, halves: in_half.then_some(halves) }
    }

    /// Computes a layer's output in f32.
    pub fn in_f32(
        &self,
        input: Inputs<'_>,
        map: &[PanelRow],
        cols: usize,
        finish: Finish<&Panels>,
        out: &mut Panels,
    ) {
        affine(input, map, cols, finish, out, self.threads);
    }

    /// The same for a layer that may be in bf16.
    pub fn inner(
        &mut self,
        input: &Panels,
        map: &[PanelRow],
        cols: usize,
        finish: Finish<&Panels>,
        out: &mut Panels,
    ) {
        match &mut self.halves {
            None => self.in_f32(Inputs::all(input), map, cols, finish, out),
            Some(Halves { across, map: weights, .. }) => {
                across.set(input);
                weights.set_map(map, cols);
                half::affine(across, weights, finish, out, self.threads);
            }
        }
    }
}
