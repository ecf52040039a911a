//! What a network keeps of its weights as they are, until they move.

use super::last;
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

/// Layers' maps from outputs to inputs, for the way back; not the first one's.
#[derive(Clone, Debug, Default)]
pub(super) struct Turned {
    is_present: bool,
    layers: Vec<Panels>,
}

impl Turned {
    /// Turns the weights round, if that has not been done. The last one lies so already; it is
    /// copied, because a step changes it.
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

    /// After [`Turned::turn`]: a layer's.
    pub fn layer(&self, layer: usize) -> &Panels {
        &self.layers[layer]
    }
}
