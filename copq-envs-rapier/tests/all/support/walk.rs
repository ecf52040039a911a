//! Random actions.

use copq::{Env, Outcome, Rng};

/// An environment driven by uniform random actions, reset whenever an episode ends.
pub struct Walk {
    pub env: Box<dyn Env>,
    rng: Rng,
    pub obs: Vec<f32>,
    pub action: Vec<f32>,
    pub reward: Vec<f32>,
    pub length: usize,
    /// Lengths of the finished episodes.
    pub lengths: Vec<usize>,
}

impl Walk {
    pub fn new(env: Box<dyn Env>, seed: u64) -> Self {
        let spec = env.spec();
        let obs = vec![0.0; spec.obs_len];
        let action = vec![0.0; spec.action_len()];
        let reward = vec![0.0; spec.objectives.len()];
        let mut walk = Self {
            env,
            rng: Rng::with_stream(seed, 99),
            obs,
            action,
            reward,
            length: 0,
            lengths: Vec::new(),
        };
        walk.reset();
        walk
    }

    pub fn reset(&mut self) {
        self.env.reset(self.rng.next_u64(), &mut self.obs).unwrap();
        self.length = 0;
    }

    pub fn step(&mut self) -> Outcome {
        self.action.iter_mut().for_each(|value| *value = self.rng.uniform_in(-1.0, 1.0) as f32);
        let outcome = self.env.step(&self.action, &mut self.obs, &mut self.reward).unwrap();
        self.length += 1;
        if outcome != Outcome::Running {
            self.lengths.push(self.length);
            self.reset();
        }
        outcome
    }
}
