//! What a network keeps of its weights as they are, until they move.

use super::layout::Layout;
use super::panels::{PanelRow, Panels};
use super::product::{Finish, Inputs, affine};
use super::threads::Threads;
use super::transpose::transpose;

/// What the first inputs of a batch have added up to in the first layer.
#[derive(Clone, Debug, Default)]
pub(super) struct Begun {
    /// How many there are; none, if nothing has begun.
    inputs: usize,
    sums: Panels,
}

impl Begun {
    /// Adds up the first `count` inputs, if that has not been done.
    pub fn begin(
        &mut self,
        layout: &Layout,
        parameters: &[PanelRow],
        input: &Panels,
        count: usize,
        threads: &Threads,
    ) {
        if self.inputs == count {
            return;
        }
        if let Some((layer, map)) = layout.maps().next() {
            let first = Inputs::first(input, count);
            let sums = &mut self.sums;
            affine(first, &parameters[map], layer.output, Finish::Keep, sums, threads);
            self.inputs = count;
        }
    }

    pub fn forget(&mut self) {
        self.inputs = 0;
    }

    /// What is left of a batch for the first layer.
    pub fn on<'a>(&'a self, input: &'a Panels) -> Inputs<'a> {
        match self.inputs {
            0 => Inputs::all(input),
            count => Inputs::rest(input, count, &self.sums),
        }
    }
}

/// Layers' weights turned round for the way back; not the first one's.
#[derive(Clone, Debug, Default)]
pub(super) struct Turned {
    is_present: bool,
    layers: Vec<Panels>,
}

impl Turned {
    /// Turns them round, if that has not been done.
    pub fn turn(&mut self, layout: &Layout, parameters: &[PanelRow]) {
        if self.is_present {
            return;
        }
        self.layers.resize_with(layout.maps().len(), Panels::default);
        for ((layer, map), turned) in layout.maps().zip(&mut self.layers).skip(1) {
            transpose(layer, &parameters[map], 0, turned);
        }
        self.is_present = true;
    }

    pub fn forget(&mut self) {
        self.is_present = false;
    }

    /// After [`Turned::turn`]: a layer's.
    pub fn layer(&self, layer: usize) -> &Panels {
        &self.layers[layer]
    }
}
