//! A custom backend: the smallest networks there are, without a tensor library.

use copq::{
    ActionGrad, Actor, ActorKind, Backend, Critic, EnvSpec, Error, Net, Networks, QGrad, QView,
    Result, Rng, Sample, SampleGrad, State,
};

/// Critics that are linear in (1, s, a, s a, a^2), and a linear policy, both by gradient descent.
/// For one observation and one action.
#[derive(Debug)]
pub struct Linear;

const FEATURES: usize = 5;

fn features(s: f32, a: f32) -> [f32; FEATURES] {
    [1.0, s, a, s * a, a * a]
}

/// Their slope in a.
fn slopes(s: f32, a: f32) -> [f32; FEATURES] {
    [0.0, 0.0, 1.0, s, 2.0 * a]
}

fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Parameters, and their slow copy.
struct Weights {
    online: Vec<f32>,
    target: Vec<f32>,
}

impl Weights {
    fn new(len: usize, rng: &mut Rng) -> Self {
        let mut online = vec![0.0; len];
        rng.fill_normal(&mut online);
        online.iter_mut().for_each(|w| *w *= 0.1);
        Self { target: online.clone(), online }
    }

    fn of(&self, net: Net) -> &[f32] {
        if net == Net::Online { &self.online } else { &self.target }
    }

    fn descend(&mut self, grad: &[f32], step: f32) {
        for (w, grad) in self.online.iter_mut().zip(grad) {
            *w -= step * grad;
        }
    }

    fn update_target(&mut self, tau: f32) {
        for (target, online) in self.target.iter_mut().zip(&self.online) {
            *target += tau * (online - *target);
        }
    }

    fn save(&self, state: &mut State) {
        state.put("online", self.online.as_slice());
        state.put("target", self.target.as_slice());
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("online", &mut self.online)?;
        state.read("target", &mut self.target)
    }
}

impl Backend for Linear {
    fn critics(
        &self,
        spec: &EnvSpec,
        _: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        let objectives = spec.objectives.len();
        let weights = Weights::new(count * objectives * FEATURES, rng);
        Ok(Box::new(LinearCritics { critics: count, objectives, weights }))
    }

    fn actor(
        &self,
        _: &EnvSpec,
        _: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        if kind != ActorKind::Deterministic {
            return Err(Error::invalid("linear policy", "a deterministic method", "another"));
        }
        Ok(Box::new(LinearActor(Weights::new(2, rng))))
    }
}

struct LinearCritics {
    critics: usize,
    objectives: usize,
    weights: Weights,
}

impl LinearCritics {
    /// Calls `visit` with the place of every value, its row and the place of its weights.
    fn each(&self, rows: usize, mut visit: impl FnMut(usize, usize, usize)) {
        for k in 0..self.critics {
            for row in 0..rows {
                for i in 0..self.objectives {
                    let value = (k * rows + row) * self.objectives + i;
                    visit(value, row, (k * self.objectives + i) * FEATURES);
                }
            }
        }
    }

    /// dL/dq at the online critics.
    fn grad(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>) -> Result<Vec<f32>> {
        let mut q = vec![0.0; self.critics * obs.len() * self.objectives];
        self.values(Net::Online, obs, act, &mut q)?;
        let mut grad_q = vec![0.0; q.len()];
        grad(QView::new(&q, self.critics, self.objectives)?, &mut grad_q)?;
        Ok(grad_q)
    }
}

impl Critic for LinearCritics {
    fn critics(&self) -> usize {
        self.critics
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn values(&mut self, net: Net, obs: &[f32], act: &[f32], q: &mut [f32]) -> Result<()> {
        let weights = self.weights.of(net);
        self.each(obs.len(), |value, row, at| {
            q[value] = dot(&weights[at..at + FEATURES], &features(obs[row], act[row]));
        });
        Ok(())
    }

    fn fit(&mut self, obs: &[f32], act: &[f32], grad: QGrad<'_>, tau: f32) -> Result<()> {
        let grad_q = self.grad(obs, act, grad)?;
        let mut grad = vec![0.0; self.weights.online.len()];
        self.each(obs.len(), |value, row, at| {
            for (grad, x) in grad[at..].iter_mut().zip(features(obs[row], act[row])) {
                *grad += grad_q[value] * x;
            }
        });
        self.weights.descend(&grad, 0.1);
        self.weights.update_target(tau);
        Ok(())
    }

    fn action_grad(
        &mut self,
        obs: &[f32],
        act: &[f32],
        grad: QGrad<'_>,
        out: &mut [f32],
    ) -> Result<()> {
        let grad_q = self.grad(obs, act, grad)?;
        out.fill(0.0);
        self.each(obs.len(), |value, row, at| {
            let weights = &self.weights.online[at..at + FEATURES];
            out[row] += grad_q[value] * dot(weights, &slopes(obs[row], act[row]));
        });
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.weights.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.weights.load(state)
    }
}

/// a = tanh(b + c s)
struct LinearActor(Weights);

impl Actor for LinearActor {
    fn action_len(&self) -> usize {
        1
    }

    fn mode(&mut self, net: Net, obs: &[f32], action: &mut [f32]) -> Result<()> {
        let weights = self.0.of(net);
        for (action, s) in action.iter_mut().zip(obs) {
            *action = (weights[0] + weights[1] * s).tanh();
        }
        Ok(())
    }

    fn improve(&mut self, obs: &[f32], _: &[f32], grad: ActionGrad<'_>) -> Result<()> {
        let mut action = vec![0.0; obs.len()];
        let mut grad_action = vec![0.0; obs.len()];
        self.mode(Net::Online, obs, &mut action)?;
        let sample = Sample { action: &action, log_prob: None };
        grad(sample, SampleGrad { action: &mut grad_action, log_prob: None })?;
        let mut grad = [0.0; 2];
        for ((s, a), grad_a) in obs.iter().zip(&action).zip(grad_action) {
            let through_tanh = grad_a * (1.0 - a * a);
            grad[0] += through_tanh;
            grad[1] += through_tanh * s;
        }
        self.0.descend(&grad, 0.05);
        Ok(())
    }

    fn update_target(&mut self, tau: f32) -> Result<()> {
        self.0.update_target(tau);
        Ok(())
    }

    fn export(&self, state: &mut State) -> Result<()> {
        state.put("weights", self.0.online.as_slice());
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.0.save(state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.0.load(state)
    }
}
