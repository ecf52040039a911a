//! One multilayer perceptron: forward, backward, and all that it has learned.

use std::ops::Range;

use copq::{Activation, Net, Networks, Precision, Result, State};

use super::activation::{activate, multiply};
use super::adam::Adam;
use super::gradient::Descent;
use super::kept::{Begun, Turned};
use super::last;
use super::layout::Layout;
use super::panels::{PanelRow, Panels};
use super::product::{Finish, Inputs, affine};
use super::workspace::{Layers, Workspace};
use super::{adam, passes};
use crate::learned::Learned;
use crate::shape::Shape;

/// A network, its target and its optimiser.
#[derive(Clone, Debug)]
pub(super) struct Network {
    layout: Layout,
    learned: Learned<PanelRow>,
    activation: Activation,
    /// Whether the backward pass of a step is in bf16.
    is_half: bool,
    /// Hidden layers' outputs from the last [`Network::forward`], after their activation.
    outputs: Vec<Panels>,
    /// The activation's slopes there; ReLU's follow from its outputs.
    slopes: Vec<Panels>,
    begun: Begun,
    turned: Turned,
}

impl Network {
    /// A network that starts from what was learned.
    pub fn new(shape: Shape, networks: &Networks, learned: &Learned) -> Self {
        let Networks { activation, precision, .. } = *networks;
        let layout = Layout::new(shape);
        let outputs = vec![Panels::default(); layout.maps().len() - 1]; // There is a last layer.
        let smooth = activation != Activation::Relu;
        let slopes = vec![Panels::default(); if smooth { outputs.len() } else { 0 }];
        let learned = learned.map(|flat| layout.pack(flat));
        Self {
            learned,
            layout,
            activation,
            is_half: precision != Precision::F32,
            outputs,
            slopes,
            begun: Begun::default(),
            turned: Turned::default(),
        }
    }

    /// Its layers.
    pub fn shape(&self) -> &Shape {
        self.layout.shape()
    }

    /// What it has learned.
    pub fn learned(&self) -> Learned {
        self.learned.map(|lines| self.layout.unpack(lines))
    }

    /// Replaces what it has learned; the layers must be the same.
    pub fn set_learned(&mut self, learned: &Learned) {
        self.moved();
        self.learned = learned.map(|flat| self.layout.pack(flat));
    }

    /// Adds up the first `count` inputs of a batch in the online network's first layer. The sums
    /// are reused until the weights move or [`Network::forget`] is called.
    pub fn begin(&mut self, input: &Panels, count: usize, workspace: &Workspace) {
        let Self { layout, learned, begun, .. } = self;
        begun.begin(layout, &learned.online, input, count, workspace.threads());
    }

    /// Drops the sums of [`Network::begin`]: the next batch has different first inputs.
    pub fn forget(&mut self) {
        self.begun.forget();
    }

    /// Drops everything that was kept: the weights have moved.
    fn moved(&mut self) {
        self.forget();
        self.turned.forget();
    }

    /// Runs a batch through, in f32 or with bf16 between hidden layers.
    pub fn values(
        &self,
        net: Net,
        input: &Panels,
        in_half: bool,
        out: &mut [f32],
        workspace: &mut Workspace,
    ) {
        let (parameters, input) = match net {
            Net::Online => (&self.learned.online, self.begun.on(input)),
            Net::Target => (&self.learned.target, Inputs::all(input)),
        };
        let layout = &self.layout;
        let (outputs, through) = workspace.outputs(self.outputs.len(), in_half);
        hidden(layout, parameters, self.activation, input, outputs, &mut [], through);
        last::affine(top(outputs), &parameters[layout.last()], out);
    }

    /// Runs a batch through the online network, and remembers what a backward pass needs.
    pub fn forward(
        &mut self,
        input: &Panels,
        in_half: bool,
        out: &mut [f32],
        workspace: &mut Workspace,
    ) {
        let Self { layout, learned, activation, outputs, slopes, begun, .. } = self;
        let through = workspace.layers(in_half);
        hidden(layout, &learned.online, *activation, begun.on(input), outputs, slopes, through);
        last::affine(top(outputs), &learned.online[layout.last()], out);
    }

    /// After [`Network::forward`] on the same input: backward from dL/dout. As soon as a layer has
    /// its gradient, it takes its optimiser step and its target follows by `tau`.
    pub fn learn(
        &mut self,
        input: &Panels,
        grad_out: &[f32],
        lr: f64,
        tau: f32,
        workspace: &mut Workspace,
    ) {
        workspace.begin(input.rows(), grad_out, self.is_half);
        let Self { layout, learned, outputs, slopes, turned, .. } = self;
        turned.turn(layout, &learned.online);
        learned.steps += 1;
        let adam = Adam::new(lr, learned.steps, tau);
        for (i, (_, map)) in layout.maps().enumerate().rev() {
            let below = i.checked_sub(1).map(|below| &outputs[below]);
            workspace.descend(below.unwrap_or(input), descent(learned, map, adam));
            if let Some(below) = below {
                workspace.step_down(turned.layer(i), below, slopes.get(i - 1));
            }
        }
        self.moved();
    }

    /// After [`Network::forward`] on the same input: writes dL/dparameters, laid out like the
    /// parameters, in f32.
    pub fn gradient(
        &mut self,
        input: &Panels,
        grad_out: &[f32],
        out: &mut Vec<PanelRow>,
        workspace: &mut Workspace,
    ) {
        let Self { layout, learned, outputs, slopes, turned, .. } = self;
        turned.turn(layout, &learned.online);
        out.resize(layout.len(), PanelRow::default());
        workspace.begin(input.rows(), grad_out, false);
        for (i, (_, map)) in layout.maps().enumerate().rev() {
            let below = i.checked_sub(1).map(|below| &outputs[below]);
            workspace.gradient_into(below.unwrap_or(input), &mut out[map]);
            if let Some(below) = below {
                workspace.step_down(turned.layer(i), below, slopes.get(i - 1));
            }
        }
    }

    /// One optimiser step of all parameters along a gradient laid out like them. The target does
    /// not follow.
    pub fn descend(&mut self, grad: &[PanelRow], lr: f64) {
        self.moved();
        self.learned.steps += 1;
        let all = 0..self.layout.len();
        let adam = Adam::new(lr, self.learned.steps, 0.0);
        adam::step(descent(&mut self.learned, all, adam), grad);
    }

    /// After [`Network::forward`] on the same input: how the outputs move as the parameters move
    /// along a flat `direction`.
    pub fn push_forward(
        &self,
        input: &Panels,
        direction: &[f32],
        out: &mut [f32],
        workspace: &Workspace,
    ) {
        let Self { layout, learned, outputs, slopes, .. } = self;
        let threads = workspace.threads();
        let direction = layout.pack(direction);
        let mut moved: Option<Panels> = None;
        for (i, (layer, map)) in layout.maps().take(outputs.len()).enumerate() {
            let through = |input: &Panels, map: &[PanelRow]| {
                let mut out = Panels::default();
                affine(Inputs::all(input), map, layer.output, Finish::Keep, &mut out, threads);
                out
            };
            let below = i.checked_sub(1).map_or(input, |below| &outputs[below]);
            let mut here = through(below, &direction[map]);
            if let Some(moved) = &moved {
                let moved = through(moved, &layout.without_bias(i, &learned.online));
                passes::add(here.lines_mut(), moved.lines(), 1.0);
            }
            match slopes.get(i) {
                Some(slopes) => multiply(&mut here, slopes),
                None => passes::mask(here.lines_mut(), outputs[i].lines()),
            }
            moved = Some(here);
        }
        last::affine(top(outputs), &direction[layout.last()], out);
        if let Some(moved) = moved {
            let map = layout.without_bias(outputs.len(), &learned.online);
            let mut through = vec![0.0; out.len()];
            last::affine(&moved, &map, &mut through);
            out.iter_mut().zip(through).for_each(|(out, through)| *out += through);
        }
    }

    /// Optimiser steps so far.
    pub fn steps(&self) -> u64 {
        self.learned.steps
    }

    /// The online parameters, laid out as a gradient is.
    pub fn online(&self) -> &[PanelRow] {
        &self.learned.online
    }

    /// Adds a flat step to the online parameters.
    pub fn shift(&mut self, step: &[f32]) {
        self.moved();
        passes::add(&mut self.learned.online, &self.layout.pack(step), 1.0);
    }

    /// A gradient as a flat buffer.
    pub fn flat(&self, grad: &[PanelRow]) -> Vec<f32> {
        self.layout.unpack(grad)
    }

    /// After [`Network::forward`] on `rows` inputs: dL/d(their columns from `first` on).
    pub fn input_grad(
        &mut self,
        rows: usize,
        grad_out: &[f32],
        first: usize,
        out: &mut [f32],
        workspace: &mut Workspace,
    ) {
        workspace.begin(rows, grad_out, self.is_half);
        let Self { layout, learned, outputs, slopes, turned, .. } = self;
        turned.turn(layout, &learned.online);
        for (i, (layer, map)) in layout.maps().enumerate().rev() {
            if i > 0 {
                workspace.step_down(turned.layer(i), &outputs[i - 1], slopes.get(i - 1));
            } else {
                workspace.step_out(layer, &learned.online[map], first, out);
            }
        }
    }

    /// Polyak averaging of the target.
    pub fn update_target(&mut self, tau: f32) {
        passes::polyak(&mut self.learned.target, &self.learned.online, tau);
    }

    /// Writes what it has learned.
    pub fn save(&self, state: &mut State) {
        self.learned().save(&self.shape().arrays(), state);
    }

    /// Restores what [`Network::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        self.set_learned(&Learned::load(&self.shape().arrays(), state)?);
        Ok(())
    }
}

/// Part of what a network has learned, for a step down a gradient.
fn descent(learned: &mut Learned<PanelRow>, map: Range<usize>, adam: Adam) -> Descent<'_> {
    Descent {
        online: &mut learned.online[map.clone()],
        target: &mut learned.target[map.clone()],
        m: &mut learned.m[map.clone()],
        v: &mut learned.v[map],
        adam,
    }
}

/// Runs a batch through hidden layers. Writes their `outputs` after the activation, and its slopes
/// where there is room for them.
fn hidden(
    layout: &Layout,
    parameters: &[PanelRow],
    activation: Activation,
    input: Inputs<'_>,
    outputs: &mut [Panels],
    slopes: &mut [Panels],
    mut through: Layers<'_>,
) {
    let finish = if activation == Activation::Relu { Finish::Relu } else { Finish::Keep };
    for (i, (layer, map)) in layout.maps().take(outputs.len()).enumerate() {
        let (below, here) = outputs.split_at_mut(i);
        let (out, map) = (&mut here[0], &parameters[map]);
        match below.last() {
            Some(below) => through.inner(below, map, layer.output, finish, out),
            None => through.in_f32(input, map, layer.output, finish, out),
        }
        activate(activation, out, slopes.get_mut(i));
    }
}

/// The last hidden layer's outputs; every network has such a layer ([`Networks::check`]).
fn top(outputs: &[Panels]) -> &Panels {
    &outputs[outputs.len() - 1]
}
