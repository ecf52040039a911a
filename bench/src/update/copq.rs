//! The update with copq's core and one of its network implementations.

use std::sync::Arc;

use anyhow::Result;
use copq::projection::Cholesky;
use copq::{Actor, BoundQuery, Critic, Net, Projection, QView, Rng, Scratch, Stream};
use copq_candle::{Device, fused, plain};

use super::{Losses, Update};
use crate::workload::{DISCOUNT, Inputs, TAU, Workload};

/// Critics, actor and the projection between them.
pub struct Copq {
    critic: Box<dyn Critic>,
    actor: Box<dyn Actor>,
    projection: Arc<dyn Projection>,
    weights: Vec<f32>,
    actor_delay: usize,
    scratch: Scratch,
    next_action: Vec<f32>,
    q: Vec<f32>,
    target: Vec<f32>,
    bound: Vec<f32>,
    grad_bound: Vec<f32>,
}

impl Copq {
    /// With the fast networks.
    pub fn fused(workload: &Workload) -> Result<Self> {
        Self::projecting(workload, Arc::new(Cholesky))
    }

    /// With the fast networks and another projection.
    pub fn projecting(workload: &Workload, projection: Arc<dyn Projection>) -> Result<Self> {
        let spec = workload.spec();
        let networks = workload.networks();
        let mut rng = Rng::new(0, Stream::Init);
        let critic = fused::Critics::new(&spec, workload.critics, &networks, &mut rng)?
            .threads(workload.threads)?;
        let actor =
            fused::Deterministic::new(&spec, &networks, &mut rng)?.threads(workload.threads)?;
        Ok(Self::new(workload, Box::new(critic), Box::new(actor), projection))
    }

    /// With the readable networks.
    pub fn plain(workload: &Workload) -> Result<Self> {
        let spec = workload.spec();
        let networks = workload.networks();
        let mut rng = Rng::new(0, Stream::Init);
        let critic =
            plain::Critics::new(&spec, workload.critics, &networks, &mut rng, &Device::Cpu)?;
        let actor = plain::Deterministic::new(&spec, &networks, &mut rng, &Device::Cpu)?;
        Ok(Self::new(workload, Box::new(critic), Box::new(actor), Arc::new(Cholesky)))
    }

    fn new(
        workload: &Workload,
        critic: Box<dyn Critic>,
        actor: Box<dyn Actor>,
        projection: Arc<dyn Projection>,
    ) -> Self {
        let values = workload.rows * workload.objectives;
        Self {
            critic,
            actor,
            projection,
            weights: workload.spec().weights(),
            actor_delay: workload.actor_delay,
            scratch: Scratch::default(),
            next_action: vec![0.0; workload.rows * workload.action],
            q: vec![0.0; workload.critics * values],
            target: vec![0.0; values],
            bound: vec![0.0; values],
            grad_bound: vec![-1.0 / workload.rows as f32; values],
        }
    }

    /// y = r + gamma (1 - d) (lower bound at s', a').
    fn targets(&mut self, batch: &Inputs) -> Result<()> {
        self.actor.mode(Net::Target, &batch.next_obs, &mut self.next_action)?;
        for (action, noise) in self.next_action.iter_mut().zip(&batch.noise) {
            *action = (*action + noise).clamp(-1.0, 1.0);
        }
        self.critic.values(Net::Target, &batch.next_obs, &self.next_action, &mut self.q)?;
        let n = self.weights.len();
        let q = QView::new(&self.q, self.critic.critics(), n)?;
        self.projection.project(lower(q, &self.weights), &mut self.scratch, &mut self.target)?;
        for (row, target) in self.target.chunks_exact_mut(n).enumerate() {
            for (y, r) in target.iter_mut().zip(&batch.reward[row * n..]) {
                *y = r + DISCOUNT * batch.alive[row] * *y;
            }
        }
        Ok(())
    }

    fn fit_critics(&mut self, batch: &Inputs) -> Result<Vec<f32>> {
        let Self { critic, target, weights, .. } = self;
        let mut losses = vec![0.0; weights.len()];
        let grad = &mut |q: QView<'_>, grad: &mut [f32]| {
            let scale = 1.0 / (q.critics() * q.rows()) as f32;
            for (q, grad) in
                q.values().chunks_exact(target.len()).zip(grad.chunks_exact_mut(target.len()))
            {
                for (i, ((grad, q), y)) in grad.iter_mut().zip(q).zip(target.iter()).enumerate() {
                    losses[i % weights.len()] += scale * (q - y) * (q - y);
                    *grad = 2.0 * scale * (q - y);
                }
            }
            Ok(())
        };
        critic.fit(&batch.obs, &batch.action, grad, TAU)?;
        Ok(losses)
    }

    fn improve_actor(&mut self, batch: &Inputs) -> Result<f32> {
        let Self { critic, actor, projection, weights, scratch, bound, grad_bound, .. } = self;
        actor.improve(&batch.obs, &[], &mut |sample, grad| {
            let grad_q = &mut |q: QView<'_>, grad_q: &mut [f32]| {
                projection.project(lower(q, weights), scratch, bound)?;
                projection.vjp(lower(q, weights), scratch, grad_bound, grad_q)
            };
            critic.action_grad(&batch.obs, sample.action, grad_q, grad.action)
        })?;
        Ok(bound.iter().zip(grad_bound).map(|(bound, grad)| bound * *grad).sum())
    }
}

impl Update for Copq {
    fn update(&mut self, number: usize, batch: &Inputs) -> Result<Losses> {
        self.targets(batch)?;
        let critic = self.fit_critics(batch)?;
        let actor = number
            .is_multiple_of(self.actor_delay)
            .then(|| self.improve_actor(batch))
            .transpose()?;
        self.actor.update_target(TAU)?;
        Ok(Losses { critic, actor })
    }
}

fn lower<'a>(q: QView<'a>, weights: &'a [f32]) -> BoundQuery<'a> {
    BoundQuery { q, weights, step: -1.0 }
}
