//! One multilayer perceptron: forward, backward, and all that it has learned.

use copq::{Activation, Net, Result, State};

use super::activation::{activate, multiply};
use super::layout::Layout;
use super::panels::{PanelRow, Panels};
use super::product::{Finish, affine};
use super::threads::Threads;
use super::workspace::{Gate, Workspace};
use super::{adam, passes};
use crate::learned::Learned;
use crate::shape::{Layer, Shape};

/// A network, its target and its optimiser.
#[derive(Clone, Debug)]
pub(super) struct Network {
    layout: Layout,
    learned: Learned<PanelRow>,
    activation: Activation,
    /// Every layer's outputs from the last [`Network::forward`], the hidden ones after their
    /// activation.
    outputs: Vec<Panels>,
    /// The activation's slopes there, of hidden layers; ReLU's follow from its outputs.
    slopes: Vec<Panels>,
}

impl Network {
    /// A network that goes on from what was learned.
    pub fn new(shape: Shape, activation: Activation, learned: &Learned) -> Self {
        let layout = Layout::new(shape);
        let outputs = vec![Panels::default(); layout.maps().len()];
        let smooth = activation != Activation::Relu;
        let slopes = vec![Panels::default(); if smooth { outputs.len() - 1 } else { 0 }];
        Self { learned: learned.map(|flat| layout.pack(flat)), layout, activation, outputs, slopes }
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
        self.learned = learned.map(|flat| self.layout.pack(flat));
    }

    /// Runs a batch through.
    pub fn values(&self, net: Net, input: &Panels, out: &mut [f32], workspace: &mut Workspace) {
        let parameters = match net {
            Net::Online => &self.learned.online,
            Net::Target => &self.learned.target,
        };
        let (outputs, threads) = workspace.outputs(self.layout.maps().len());
        run(&self.layout, parameters, self.activation, input, outputs, &mut [], threads);
        outputs[self.layout.maps().len() - 1].get(0, out);
    }

    /// Runs a batch through the online network, and remembers what a backward pass needs.
    pub fn forward(&mut self, input: &Panels, out: &mut [f32], workspace: &Workspace) {
        let Self { layout, learned, activation, outputs, slopes } = self;
        run(layout, &learned.online, *activation, input, outputs, slopes, workspace.threads());
        outputs[outputs.len() - 1].get(0, out);
    }

    /// After [`Network::forward`] on the same input: backward from dL/dout, each layer taking its
    /// optimiser step, and its target following by `tau`, as soon as it has its gradient.
    pub fn learn(
        &mut self,
        input: &Panels,
        grad_out: &[f32],
        lr: f64,
        tau: f32,
        workspace: &mut Workspace,
    ) {
        let Self { layout, learned, outputs, slopes, .. } = self;
        workspace.begin(input.rows(), grad_out);
        learned.steps += 1;
        for (i, (layer, map)) in layout.maps().enumerate().rev() {
            let below = i.checked_sub(1).map(|below| &outputs[below]);
            if below.is_some() {
                workspace.transpose(layer, &learned.online[map.clone()], 0);
            }
            adam::step(learned, map, workspace.gradient(below.unwrap_or(input)), lr, tau);
            if let Some(below) = below {
                workspace.step_down(gate(below, slopes.get(i - 1)));
            }
        }
    }

    /// After [`Network::forward`] on the same input: writes dL/dparameters, laid out as they are.
    pub fn gradient(
        &self,
        input: &Panels,
        grad_out: &[f32],
        out: &mut Vec<PanelRow>,
        workspace: &mut Workspace,
    ) {
        out.resize(self.layout.len(), PanelRow::default());
        workspace.begin(input.rows(), grad_out);
        for (i, (layer, map)) in self.layout.maps().enumerate().rev() {
            let below = i.checked_sub(1).map(|below| &self.outputs[below]);
            workspace.gradient_into(below.unwrap_or(input), &mut out[map.clone()]);
            if let Some(below) = below {
                workspace.transpose(layer, &self.learned.online[map], 0);
                workspace.step_down(gate(below, self.slopes.get(i - 1)));
            }
        }
    }

    /// One optimiser step of all parameters along a gradient laid out as they are. There is no
    /// target to follow.
    pub fn descend(&mut self, grad: &[PanelRow], lr: f64) {
        self.learned.steps += 1;
        let all = 0..self.layout.len();
        adam::step(&mut self.learned, all, grad, lr, 0.0);
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
        let threads = workspace.threads();
        let direction = self.layout.pack(direction);
        let mut moved: Option<Panels> = None;
        for (i, (layer, map)) in self.layout.maps().enumerate() {
            let below = i.checked_sub(1).map_or(input, |below| &self.outputs[below]);
            let mut here = Panels::default();
            affine(below, &direction[map.clone()], layer.output, Finish::Keep, &mut here, threads);
            if let Some(moved) = &moved {
                let mut through = Panels::default();
                let weights = without_bias(layer, &self.learned.online[map]);
                affine(moved, &weights, layer.output, Finish::Keep, &mut through, threads);
                passes::add(here.lines_mut(), through.lines(), 1.0);
            }
            if i < self.outputs.len() - 1 {
                match self.slopes.get(i) {
                    Some(slopes) => multiply(&mut here, slopes),
                    None => passes::mask(here.lines_mut(), self.outputs[i].lines()),
                }
            }
            moved = Some(here);
        }
        if let Some(moved) = moved {
            moved.get(0, out);
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
        passes::add(&mut self.learned.online, &self.layout.pack(step), 1.0);
    }

    /// A gradient as a flat buffer.
    pub fn flat(&self, grad: &[PanelRow]) -> Vec<f32> {
        self.layout.unpack(grad)
    }

    /// After [`Network::forward`] on `rows` inputs: dL/d(their columns from `first` on).
    pub fn input_grad(
        &self,
        rows: usize,
        grad_out: &[f32],
        first: usize,
        out: &mut [f32],
        workspace: &mut Workspace,
    ) {
        workspace.begin(rows, grad_out);
        for (i, (layer, map)) in self.layout.maps().enumerate().rev() {
            let parameters = &self.learned.online[map];
            if i > 0 {
                workspace.transpose(layer, parameters, 0);
                workspace.step_down(gate(&self.outputs[i - 1], self.slopes.get(i - 1)));
            } else {
                workspace.step_out(layer, parameters, first, out);
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

/// A layer's map with nothing to start from.
fn without_bias(layer: &Layer, map: &[PanelRow]) -> Vec<PanelRow> {
    let mut map = map.to_vec();
    map.iter_mut()
        .skip(layer.input)
        .step_by(layer.input + 1)
        .for_each(|line| *line = PanelRow::default());
    map
}

/// The way back through a hidden layer's activation.
fn gate<'a>(output: &'a Panels, slope: Option<&'a Panels>) -> Gate<'a> {
    slope.map_or(Gate::Mask(output), Gate::Slope)
}

/// Runs a batch through layers whose `outputs` are then those of every layer, the hidden ones after
/// their activation, whose slopes it writes where there is room for them.
fn run(
    layout: &Layout,
    parameters: &[PanelRow],
    activation: Activation,
    input: &Panels,
    outputs: &mut [Panels],
    slopes: &mut [Panels],
    threads: &Threads,
) {
    let last = layout.maps().len() - 1; // A layout has at least one layer.
    for (i, (layer, map)) in layout.maps().enumerate() {
        let (below, here) = outputs.split_at_mut(i);
        let hidden = i < last;
        let finish =
            if hidden && activation == Activation::Relu { Finish::Relu } else { Finish::Keep };
        affine(
            below.last().unwrap_or(input),
            &parameters[map],
            layer.output,
            finish,
            &mut here[0],
            threads,
        );
        if hidden {
            activate(activation, &mut here[0], slopes.get_mut(i));
        }
    }
}
