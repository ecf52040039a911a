//! Critics with inputs and values in bf16, which copq does not offer. A proof that fewer bits are
//! harmless must be able to find these critics harmful.

use copq::{
    Actor, ActorKind, Backend, Critic, EnvSpec, Net, Networks, QGrad, QView, Result, Rng, State,
};
use copq_candle::Candle;

/// Copq's networks, except that the critics' inputs and values are in bf16, as if all layers were.
#[derive(Clone, Copy)]
pub struct Coarse;

impl Backend for Coarse {
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        let inner = Candle::default().critics(spec, networks, count, rng)?;
        Ok(Box::new(CoarseCritic { inner, obs: Vec::new(), act: Vec::new(), q: Vec::new() }))
    }

    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        Candle::default().actor(spec, networks, kind, rng)
    }
}

struct CoarseCritic {
    inner: Box<dyn Critic>,
    obs: Vec<f32>,
    act: Vec<f32>,
    q: Vec<f32>,
}

impl CoarseCritic {
    fn take_in(&mut self, obs: &[f32], act: &[f32]) {
        round_into(&mut self.obs, obs);
        round_into(&mut self.act, act);
    }
}

impl Critic for CoarseCritic {
    fn critics(&self) -> usize {
        self.inner.critics()
    }

    fn objectives(&self) -> usize {
        self.inner.objectives()
    }

    fn shared(&self) -> bool {
        self.inner.shared()
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        self.take_in(obs, act);
        self.inner.values(net, &self.obs, &self.act, q)?;
        q.iter_mut().for_each(|q| *q = rounded(*q));
        Ok(())
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        self.take_in(obs, act);
        let Self { inner, obs, act, q } = self;
        inner.fit(obs, act, &mut |exact, dq| grad(coarse(q, exact)?, dq), tau)
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        self.take_in(obs, act);
        let Self { inner, obs, act, q } = self;
        inner.action_grad(obs, act, &mut |exact, dq| grad(coarse(q, exact)?, dq), out)
    }

    fn exact_values(&mut self, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<bool> {
        if !self.inner.exact_values(obs, act, q)? {
            self.inner.values(Net::Online, obs, act, q)?;
        }
        Ok(true)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.inner.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.inner.load(state)
    }
}

/// Values in bf16.
fn coarse<'a>(q: &'a mut Vec<f32>, exact: QView<'_>) -> Result<QView<'a>> {
    round_into(q, exact.values());
    QView::new(q, exact.critics(), exact.objectives())
}

fn round_into(to: &mut Vec<f32>, from: &[f32]) {
    to.clear();
    to.extend(from.iter().map(|&x| rounded(x)));
}

/// The nearest bf16, ties to even.
fn rounded(x: f32) -> f32 {
    half::bf16::from_f32(x).to_f32()
}
