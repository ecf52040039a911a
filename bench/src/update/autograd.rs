//! The update as one would write it with candle and candle-nn: layers, autograd, and an optimiser
//! that steps on a loss.

use anyhow::{Context, Result};
use candle_core::{D, Device, Tensor, Var};
use candle_nn::{AdamW, Linear, Module, Optimizer, ParamsAdamW};
use copq::{Actor, Critic, Rng, State, Stream};
use copq_candle::fused;

use super::{Losses, Update};
use crate::workload::{DISCOUNT, Inputs, LR, TAU, Workload};

/// Critics, actor, their targets and their optimisers.
pub struct Autograd {
    critics: Vec<Mlp>,
    actor: Mlp,
    target_critics: Vec<Mlp>,
    target_actor: Mlp,
    critic_optimiser: AdamW,
    actor_optimiser: AdamW,
    /// The unit direction.
    direction: Vec<f64>,
    actor_delay: usize,
}

impl Autograd {
    /// Starts from the same weights as copq's own networks.
    pub fn new(workload: &Workload) -> Result<Self> {
        let spec = workload.spec();
        let networks = workload.networks();
        let mut rng = Rng::new(0, Stream::Init);
        let mut saved_critics = State::default();
        let mut saved_actor = State::default();
        fused::Critics::new(&spec, workload.critics, &networks, &mut rng)?
            .save(&mut saved_critics)?;
        fused::Deterministic::new(&spec, &networks, &mut rng)?.save(&mut saved_actor)?;
        let critics = || {
            (0..workload.critics).map(|k| Mlp::load(saved_critics.child(&format!("critic.{k}"))?))
        };
        let online = critics().collect::<Result<Vec<_>>>()?;
        let actor = Mlp::load(&saved_actor)?;
        let settings = || ParamsAdamW { lr: LR, weight_decay: 0.0, ..Default::default() };
        let critic_vars = online.iter().flat_map(|critic| critic.vars.clone()).collect();
        Ok(Self {
            critic_optimiser: AdamW::new(critic_vars, settings())?,
            actor_optimiser: AdamW::new(actor.vars.clone(), settings())?,
            target_critics: critics().collect::<Result<_>>()?,
            target_actor: Mlp::load(&saved_actor)?,
            critics: online,
            actor,
            direction: vec![1.0 / (workload.objectives as f64).sqrt(); workload.objectives],
            actor_delay: workload.actor_delay,
        })
    }

    fn targets(&self, batch: &Tensors) -> Result<Tensor> {
        let next_action = self.target_actor.forward(&batch.next_obs)?.tanh()?.detach();
        let next_action = (next_action + &batch.noise)?.clamp(-1.0, 1.0)?;
        let q = values(&self.target_critics, &batch.next_obs, &next_action)?.detach();
        let discounted =
            (lower_bound(&q, &self.direction)?.broadcast_mul(&batch.alive)? * f64::from(DISCOUNT))?;
        Ok((&batch.reward + discounted)?)
    }

    fn fit_critics(&mut self, batch: &Tensors) -> Result<Vec<f32>> {
        let target = self.targets(batch)?;
        let q = values(&self.critics, &batch.obs, &batch.action)?;
        let losses = q.broadcast_sub(&target)?.sqr()?.mean((0, 1))?;
        self.critic_optimiser.backward_step(&losses.sum_all()?)?;
        Ok(losses.to_vec1()?)
    }

    fn improve_actor(&mut self, batch: &Tensors) -> Result<f32> {
        let action = self.actor.forward(&batch.obs)?.tanh()?;
        let q = values(&self.critics, &batch.obs, &action)?;
        let loss = lower_bound(&q, &self.direction)?.sum(D::Minus1)?.mean_all()?.neg()?;
        self.actor_optimiser.backward_step(&loss)?;
        Ok(loss.to_scalar()?)
    }
}

impl Update for Autograd {
    fn update(&mut self, number: usize, batch: &Inputs) -> Result<Losses> {
        let batch = Tensors::new(batch)?;
        let critic = self.fit_critics(&batch)?;
        let actor = number
            .is_multiple_of(self.actor_delay)
            .then(|| self.improve_actor(&batch))
            .transpose()?;
        for (target, online) in self.target_critics.iter().zip(&self.critics) {
            target.update_target(online)?;
        }
        self.target_actor.update_target(&self.actor)?;
        Ok(Losses { critic, actor })
    }
}

/// A batch on candle's device.
struct Tensors {
    obs: Tensor,
    action: Tensor,
    reward: Tensor,
    next_obs: Tensor,
    alive: Tensor,
    noise: Tensor,
}

impl Tensors {
    fn new(batch: &Inputs) -> Result<Self> {
        let rows = batch.alive.len();
        let tensor =
            |values: &[f32]| Tensor::from_slice(values, (rows, values.len() / rows), &Device::Cpu);
        Ok(Self {
            obs: tensor(&batch.obs)?,
            action: tensor(&batch.action)?,
            reward: tensor(&batch.reward)?,
            next_obs: tensor(&batch.next_obs)?,
            alive: tensor(&batch.alive)?,
            noise: tensor(&batch.noise)?,
        })
    }
}

/// A multilayer perceptron with ReLU.
struct Mlp {
    layers: Vec<Linear>,
    vars: Vec<Var>,
}

impl Mlp {
    fn load(saved: &State) -> Result<Self> {
        let online = saved.child("online")?;
        let mut layers = Vec::new();
        let mut vars = Vec::new();
        for i in 0..3 {
            let bias = online.get::<f32>(&format!("layer.{i}.bias"))?;
            let weight = online.get::<f32>(&format!("layer.{i}.weight"))?;
            let weight =
                Var::from_slice(weight, (bias.len(), weight.len() / bias.len()), &Device::Cpu)?;
            let bias = Var::from_slice(bias, bias.len(), &Device::Cpu)?;
            layers.push(Linear::new(weight.as_tensor().clone(), Some(bias.as_tensor().clone())));
            vars.extend([weight, bias]);
        }
        Ok(Self { layers, vars })
    }

    fn forward(&self, input: &Tensor) -> Result<Tensor> {
        let (last, hidden) = self.layers.split_last().context("a network without layers")?;
        let mut x = input.clone();
        for layer in hidden {
            x = layer.forward(&x)?.relu()?;
        }
        Ok(last.forward(&x)?)
    }

    fn update_target(&self, online: &Self) -> Result<()> {
        for (target, online) in self.vars.iter().zip(&online.vars) {
            let moved = (target.as_tensor() * f64::from(1.0 - TAU))?
                + (online.as_tensor() * f64::from(TAU))?;
            target.set(&moved?.detach())?;
        }
        Ok(())
    }
}

/// Every critic's values, `critics x rows x objectives`.
fn values(critics: &[Mlp], obs: &Tensor, action: &Tensor) -> Result<Tensor> {
    let input = Tensor::cat(&[obs, action], 1)?;
    let q = critics.iter().map(|critic| critic.forward(&input)).collect::<Result<Vec<_>>>()?;
    Ok(Tensor::stack(&q, 0)?)
}

/// COP-Q's lower bound with its clip, `rows x objectives`: Gram-Schmidt on the critics' deviations,
/// column by column.
fn lower_bound(q: &Tensor, direction: &[f64]) -> Result<Tensor> {
    let mean = q.mean(0)?;
    let deviations = q.broadcast_sub(&mean)?;
    let x = (0..direction.len())
        .map(|i| deviations.narrow(D::Minus1, i, 1))
        .collect::<Result<Vec<_>, _>>()?;
    let mut e: Vec<Tensor> = Vec::new();
    let mut factor: Vec<Vec<Tensor>> = Vec::new();
    for x in &x {
        let row = e.iter().map(|e| (x * e)?.mean(0)).collect::<Result<Vec<_>, _>>()?;
        let mut rest = x.clone();
        for (e, l) in e.iter().zip(&row) {
            rest = (rest - e.broadcast_mul(l)?)?;
        }
        let pivot = rest.sqr()?.mean(0)?.sqrt()?;
        e.push(rest.broadcast_div(&pivot)?);
        factor.push(row.into_iter().chain([pivot]).collect());
    }
    let turned = clip(&factor, direction)?;
    let offset = |row: &Vec<Tensor>| {
        let terms = row.iter().enumerate().map(|(j, l)| l * turned.narrow(1, j, 1)?);
        sum(terms)
    };
    let offsets = factor.iter().map(offset).collect::<Result<Vec<_>>>()?;
    Ok((mean - Tensor::cat(&offsets, 1)?)?)
}

/// R u, `rows x objectives`, with p = L'u. Where `u . p` is negative, u loses its part along p. The
/// result is normalised.
fn clip(factor: &[Vec<Tensor>], direction: &[f64]) -> Result<Tensor> {
    let n = direction.len();
    let p = (0..n)
        .map(|j| sum((j..n).map(|i| &factor[i][j] * direction[i])))
        .collect::<Result<Vec<_>>>()?;
    let p = Tensor::cat(&p, 1)?;
    let u = Tensor::from_slice(direction, (1, n), p.device())?.to_dtype(p.dtype())?;
    let along = p.broadcast_mul(&u)?.sum_keepdim(1)?.minimum(0.0)?;
    let turned = u.broadcast_sub(&p.broadcast_mul(&(along / p.sqr()?.sum_keepdim(1)?)?)?)?;
    Ok(turned.broadcast_div(&turned.sqr()?.sum_keepdim(1)?.sqrt()?)?)
}

fn sum(mut terms: impl Iterator<Item = candle_core::Result<Tensor>>) -> Result<Tensor> {
    let first = terms.next().context("an empty sum")??;
    Ok(terms.try_fold(first, |sum, term| sum + term?)?)
}
