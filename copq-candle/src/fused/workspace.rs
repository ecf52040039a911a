//! What a pass works on, for one network after another.

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
    /// Whether the present layer of a backward pass is the last.
    is_last: bool,
    /// Every layer's outputs, where no backward pass will follow.
    outputs: Vec<Panels>,
    /// dL/d(outputs of the present layer, before their activation).
    delta: Panels,
    /// What becomes `delta` next.
    below: Panels,
    /// The first layer's weight turned round, for the columns that are asked for.
    turned: Panels,
    halves: Halves,
}

/// What products in bf16 work on.
#[derive(Clone, Debug, Default)]
pub(super) struct Halves {
    /// Whether the present pass is to be in bf16 below its last layer.
    wanted: bool,
    /// Whether it is there; then `delta` is the workspace's.
    has_begun: bool,
    delta: Down,
    across: Across,
    left: Down,
    map: Down,
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

    /// Buffers for the outputs of so many layers, and what computes them.
    pub fn outputs(&mut self, layers: usize, in_half: bool) -> (&mut [Panels], Forward<'_>) {
        if self.outputs.len() < layers {
            self.outputs.resize_with(layers, Panels::default);
        }
        let Self { outputs, threads, halves, .. } = self;
        (&mut outputs[..layers], Forward { threads, halves: in_half.then_some(halves) })
    }

    /// What computes the outputs of a network's layers.
    pub fn forward(&mut self, in_half: bool) -> Forward<'_> {
        let Self { threads, halves, .. } = self;
        Forward { threads, halves: in_half.then_some(halves) }
    }

    /// Begins at a network's outputs with dL/doutputs, and goes on in bf16 below the last layer or
    /// not.
    pub fn begin(&mut self, rows: usize, grad: &[f32], in_half: bool) {
        self.is_last = true;
        self.delta.set(rows, &[grad]);
        (self.halves.wanted, self.halves.has_begun) = (in_half, false);
    }

    /// A step of the present layer's parameters down their gradient, given its inputs.
    pub fn descend(&mut self, input: &Panels, map: Descent<'_>) {
        let Halves { has_begun, delta, left, .. } = &mut self.halves;
        if *has_begun {
            left.set(input);
            half::descend(left, delta, map, &self.threads);
        } else if self.is_last {
            last::descend(input, &self.delta, map);
        } else {
            descend(input, &self.delta, map, &self.threads);
        }
    }

    /// dL/dparameters of the present layer, laid out as they are, given its inputs.
    pub fn gradient_into(&self, input: &Panels, out: &mut [PanelRow]) {
        if self.is_last {
            last::gradient(input, &self.delta, out);
        } else {
            gradient(input, &self.delta, out, &self.threads);
        }
    }

    /// Goes down to the layer below, back through its activation, by the present layer's weight
    /// turned round.
    pub fn step_down(&mut self, turned: &Panels, gate: Gate<'_>) {
        let (cols, finish) = match gate {
            Gate::Mask(output) => (output.cols(), Finish::Mask(output)),
            Gate::Slope(slope) => (slope.cols(), Finish::Keep),
        };
        let Self { delta, below, halves, threads, .. } = self;
        halves.or_f32(delta, turned.lines(), cols, finish, below, threads);
        if let Gate::Slope(slope) = gate {
            multiply(below, slope);
        }
        std::mem::swap(delta, below);
        self.is_last = false;
        if halves.wanted {
            halves.delta.set(delta);
            halves.has_begun = true;
        }
    }

    /// After [`Workspace::begin`] on the way through the first layer: dL/d(its inputs' columns from
    /// `first` on).
    pub fn step_out(&mut self, layer: &Layer, map: &[PanelRow], first: usize, out: &mut [f32]) {
        let panel = first / WIDTH;
        let cols = layer.input - panel * WIDTH;
        let Self { delta, below, turned, halves, threads, .. } = self;
        let back = if self.is_last {
            &last::back(layer, map)[panel * (layer.output + 1)..]
        } else {
            transpose(layer, map, panel, turned);
            turned.lines()
        };
        halves.or_f32(delta, back, cols, Finish::Keep, below, threads);
        below.get(first % WIDTH, out);
    }
}

/// How layers' outputs are computed.
pub(super) struct Forward<'a> {
    threads: &'a Threads,
    /// Present if it is in bf16 between hidden layers.
    halves: Option<&'a mut Halves>,
}

impl Forward<'_> {
    /// A layer's outputs from a network's inputs.
    pub fn first(
        &self,
        input: Inputs<'_>,
        map: &[PanelRow],
        cols: usize,
        finish: Finish<&Panels>,
        out: &mut Panels,
    ) {
        affine(input, map, cols, finish, out, self.threads);
    }

    /// A hidden layer's outputs from those of the one below.
    pub fn inner(
        &mut self,
        input: &Panels,
        map: &[PanelRow],
        cols: usize,
        finish: Finish<&Panels>,
        out: &mut Panels,
    ) {
        match &mut self.halves {
            None => self.first(Inputs::all(input), map, cols, finish, out),
            Some(Halves { across, map: weights, .. }) => {
                across.set(input);
                weights.set_map(map, cols);
                half::affine(across, weights, finish, out, self.threads);
            }
        }
    }
}

impl Halves {
    /// A product on the way back: below the last layer in bf16, if that is wanted.
    fn or_f32(
        &mut self,
        delta: &Panels,
        map: &[PanelRow],
        cols: usize,
        finish: Finish<&Panels>,
        out: &mut Panels,
        threads: &Threads,
    ) {
        if self.has_begun {
            self.across.set(delta);
            self.map.set_map(map, cols);
            half::affine(&self.across, &self.map, finish, out, threads);
        } else {
            affine(Inputs::all(delta), map, cols, finish, out, threads);
        }
    }
}
