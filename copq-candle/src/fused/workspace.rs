//! What a pass works on, for one network after another.

use copq::Result;

use super::activation::multiply;
use super::gradient::{Descent, descend, gradient};
use super::panels::{PanelRow, Panels, WIDTH};
use super::product::{Finish, Inputs, affine};
use super::threads::Threads;
use super::transpose::transpose;
use crate::shape::Layer;

/// What a gradient meets on its way back through an activation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Gate<'a> {
    /// ReLU: passes where this output is positive.
    Mask(&'a Panels),
    /// Any other: is multiplied by this slope.
    Slope(&'a Panels),
}

/// Buffers that grow to the largest layer and batch and are then reused, and the threads that share
/// each product: one unless set. A thread's networks share a workspace, so that little of it leaves
/// the cache.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
    threads: Threads,
    /// Every layer's outputs, where no backward pass will follow.
    outputs: Vec<Panels>,
    /// dL/d(outputs of the present layer, before their activation).
    delta: Panels,
    /// What becomes `delta` next.
    below: Panels,
    /// A layer's weight turned round.
    transposed: Panels,
}

impl Workspace {
    /// An empty one for so many threads.
    pub fn shared(threads: usize) -> Result<Self> {
        Ok(Self { threads: Threads::new(threads)?, ..Self::default() })
    }

    /// The threads that share each product.
    pub fn threads(&self) -> &Threads {
        &self.threads
    }

    /// Buffers for the outputs of so many layers, and the threads to compute them.
    pub fn outputs(&mut self, layers: usize) -> (&mut [Panels], &Threads) {
        if self.outputs.len() < layers {
            self.outputs.resize_with(layers, Panels::default);
        }
        (&mut self.outputs[..layers], &self.threads)
    }

    /// Begins at a network's outputs with dL/doutputs.
    pub fn begin(&mut self, rows: usize, grad: &[f32]) {
        self.delta.set(rows, &[grad]);
    }

    /// A step of the present layer's parameters down their gradient, given its inputs.
    pub fn descend(&self, input: &Panels, map: Descent<'_>) {
        descend(input, &self.delta, map, &self.threads);
    }

    /// dL/dparameters of the present layer, laid out as they are, given its inputs.
    pub fn gradient_into(&self, input: &Panels, out: &mut [PanelRow]) {
        gradient(input, &self.delta, out, &self.threads);
    }

    /// Keeps the present layer's weight for the way down, for inputs from panel `first` on.
    pub fn transpose(&mut self, layer: &Layer, map: &[PanelRow], first: usize) {
        transpose(layer, map, first, &mut self.transposed);
    }

    /// Goes down to the layer below, back through its activation, by a weight that was turned round
    /// before or by the last [`Workspace::transpose`].
    pub fn step_down(&mut self, turned: Option<&Panels>, gate: Gate<'_>) {
        let (cols, finish) = match gate {
            Gate::Mask(output) => (output.cols(), Finish::Mask(output)),
            Gate::Slope(slope) => (slope.cols(), Finish::Keep),
        };
        affine(
            Inputs::all(&self.delta),
            turned.unwrap_or(&self.transposed).lines(),
            cols,
            finish,
            &mut self.below,
            &self.threads,
        );
        if let Gate::Slope(slope) = gate {
            multiply(&mut self.below, slope);
        }
        std::mem::swap(&mut self.delta, &mut self.below);
    }

    /// After [`Workspace::begin`] on the way through the first layer: dL/d(its inputs' columns from
    /// `first` on).
    pub fn step_out(&mut self, layer: &Layer, map: &[PanelRow], first: usize, out: &mut [f32]) {
        let panel = first / WIDTH;
        self.transpose(layer, map, panel);
        let map = self.transposed.lines();
        let cols = layer.input - panel * WIDTH;
        affine(Inputs::all(&self.delta), map, cols, Finish::Keep, &mut self.below, &self.threads);
        self.below.get(first % WIDTH, out);
    }
}
