//! What is drawn from the replay for one update.

/// A batch of transitions in flat, reusable arrays.
///
/// ```
/// use copq::{Batch, Outcome, Replay, Rng, Stream, Transition};
///
/// let mut replay = Replay::new(10, 2, 1, 1)?;
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
    /// Room for `rows` transitions, so that sampling allocates nothing.
    pub fn reserve(&mut self, rows: usize, observation: usize, action: usize, objectives: usize) {
        self.obs.reserve(rows * observation);
        self.action.reserve(rows * action);
        self.reward.reserve(rows * objectives);
        self.next_obs.reserve(rows * observation);
        self.alive.reserve(rows);
    }

    pub(crate) fn clear(&mut self) {
        for column in
            [&mut self.obs, &mut self.action, &mut self.reward, &mut self.next_obs, &mut self.alive]
        {
            column.clear();
        }
    }
}
