//! What a network computes from its weights and keeps until they move.

use super::last;
use super::layout::Layout;
use super::panels::{PanelRow, Panels};
use super::product::{Finish, Inputs, affine};
use super::threads::Threads;
use super::transpose::transpose;

/// The first layer's sums over the first inputs of a batch.
#[derive(Clone, Debug, Default)]
pub(super) struct Begun {
    /// How many inputs have been added up; 0 if none.
    inputs: usize,
    sums: Panels,
}

impl Begun {
    /// Adds up the first `count` inputs, unless that has been done.
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

    /// The inputs of a batch that the first layer has yet to add up.
    pub fn on<'a>(&'a self, input: &'a Panels) -> Inputs<'a> {
        match self.inputs {
            0 => Inputs::all(input),
            count => Inputs::rest(input, count, &self.sums),
        }
    }
}

/// The layers' maps from outputs to inputs, for the backward pass; not the first layer's.
#[derive(Clone, Debug, Default)]
pub(super) struct Turned {
    is_present: bool,
    layers: Vec<Panels>,
}

impl Turned {
    /// Transposes the weights, unless that has been done. The last one is laid out this way
    /// already. It is copied, because a step changes it.
    pub fn turn(&mut self, layout: &Layout, parameters: &[PanelRow]) {
        if self.is_present {
            return;
        }
        let last = layout.maps().len() - 1; // A layout has at least one layer.
        self.layers.resize_with(last + 1, Panels::default);
        for (i, (layer, map)) in layout.maps().enumerate().skip(1) {
            let (map, out) = (&parameters[map], &mut self.layers[i]);
            if i == last {
                let out = out.reshape(layer.output + 1, layer.input);
                out.copy_from_slice(last::back(layer, map));
            } else {
                transpose(layer, map, 0, out);
            }
        }
        self.is_present = true;
    }

    pub fn forget(&mut self) {
        self.is_present = false;
    }

    /// After [`Turned::turn`]: a layer's map.
    pub fn layer(&self, layer: usize) -> &Panels {
        &self.layers[layer]
    }
}
