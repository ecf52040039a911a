//! What is drawn from the replay for one update.

use crate::EnvSpec;

/// A batch of transitions in flat, reusable arrays.
///
/// ```
/// use copq::{Batch, EnvSpec, Outcome, Replay, Rng, Stream, Transition};
///
/// let spec = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
/// let mut replay = Replay::new(&spec, 10)?;
/// let obs = [0.3, 1.0];
/// let outcome = Outcome::Truncated; // time ran out: the next state is as good as any
/// replay.push(Transition { obs: &obs, action: &[0.5], reward: &[2.0], next_obs: &obs, outcome })?;
///
/// let mut batch = Batch::default();
/// replay.sample(3, &mut Rng::new(0, Stream::Batch), &mut batch)?;
/// assert_eq!((batch.obs.len(), batch.reward.len()), (3 * 2, 3));
/// assert_eq!(batch.alive, [1.0; 3]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// s, `rows x observation`
    pub obs: Vec<f32>,
    /// a in [-1, 1], `rows x action`
    pub action: Vec<f32>,
    /// r, `rows x objectives`
    pub reward: Vec<f32>,
    /// s', `rows x observation`
    pub next_obs: Vec<f32>,
    /// 1 - d: 0 where the episode terminated, else 1
    pub alive: Vec<f32>,
}

impl Batch {
    /// An empty batch with room for `rows` transitions, so that sampling allocates nothing.
    pub fn with_capacity(spec: &EnvSpec, rows: usize) -> Self {
        Self {
            obs: Vec::with_capacity(rows * spec.obs_len),
            action: Vec::with_capacity(rows * spec.action_len()),
            reward: Vec::with_capacity(rows * spec.objectives.len()),
            next_obs: Vec::with_capacity(rows * spec.obs_len),
            alive: Vec::with_capacity(rows),
        }
    }

    pub(crate) fn clear(&mut self) {
        for column in
            [&mut self.obs, &mut self.action, &mut self.reward, &mut self.next_obs, &mut self.alive]
        {
            column.clear();
        }
    }
}
