//! Experience, each observation stored once: a ring of transitions that grows as it fills.

use std::collections::VecDeque;

use crate::error::check_len;
use crate::{Batch, EnvSpec, Error, Outcome, Result, Rng, State, Transition};

/// The number of transitions by which the storage grows: a power of two, and a few megabytes.
const CHUNK: usize = 1 << 16;
/// The largest number of observation components by which it grows at once, 64 MB of them.
const LARGEST: usize = 1 << 24;

/// A uniform replay buffer.
///
/// A transition's next observation is its successor's observation, found by index. The last
/// observation is stored separately only where an episode ends, or where the caller breaks off and
/// starts elsewhere. All numbers are f32.
///
/// ```
/// use copq::{Batch, EnvSpec, Outcome, Replay, Rng, Stream, Transition};
///
/// // Observations of 2 numbers, 1 action, 1 objective; room for 1,000 transitions.
/// let spec = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
/// let mut replay = Replay::new(&spec, 1_000)?;
/// replay.push(Transition {
///     obs: &[0.3, 1.0],
///     action: &[0.5],
///     reward: &[2.0],
///     next_obs: &[0.9, 1.5],
///     outcome: Outcome::Terminated,
/// })?;
///
/// let mut batch = Batch::default();
/// replay.sample(4, &mut Rng::new(0, Stream::Batch), &mut batch)?;
/// assert_eq!(batch.next_obs, [0.9, 1.5].repeat(4));
/// assert_eq!(batch.alive, [0.0; 4]); // there is no value after a fall
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Replay {
    capacity: usize,
    observation: usize,
    action: usize,
    objectives: usize,
    obs: Vec<f32>,
    act: Vec<f32>,
    reward: Vec<f32>,
    end: Vec<End>,
    /// Where the next transition goes; also the oldest one once the ring is full.
    cursor: usize,
    /// The next observation of the newest transition.
    latest: Vec<f32>,
    /// Observations after which an episode ended, oldest first, flattened.
    finals: VecDeque<f32>,
    /// How many final observations have been dropped from the front.
    dropped: u32,
}

/// What follows a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// The next transition's observation.
    Next,
    /// The final observation with this running number, and whether the bootstrap stops there.
    Final { number: u32, terminated: bool },
}

impl Replay {
    /// An empty buffer for at most `capacity` transitions of an environment.
    pub fn new(spec: &EnvSpec, capacity: usize) -> Result<Self> {
        if capacity == 0 || u32::try_from(capacity).is_err() {
            return Err(Error::invalid("replay capacity", format!("1 to {}", u32::MAX), capacity));
        }
        spec.check()?;
        Ok(Self {
            capacity,
            observation: spec.obs_len,
            action: spec.action_len(),
            objectives: spec.objectives.len(),
            obs: Vec::new(),
            act: Vec::new(),
            reward: Vec::new(),
            end: Vec::new(),
            cursor: 0,
            latest: Vec::new(),
            finals: VecDeque::new(),
            dropped: 0,
        })
    }

    /// Transitions held.
    pub fn len(&self) -> usize {
        self.end.len()
    }

    /// Whether nothing has been stored.
    pub fn is_empty(&self) -> bool {
        self.end.is_empty()
    }

    /// Bytes of memory that the storage takes.
    pub fn bytes(&self) -> usize {
        let floats = self.obs.capacity()
            + self.act.capacity()
            + self.reward.capacity()
            + self.finals.capacity();
        floats * size_of::<f32>() + self.end.capacity() * size_of::<End>()
    }

    /// Stores a transition, over the oldest one if the buffer is full.
    pub fn push(&mut self, t: Transition<'_>) -> Result<()> {
        check_len("transition's observation", t.obs.len(), self.observation)?;
        check_len("transition's next observation", t.next_obs.len(), self.observation)?;
        check_len("transition's action", t.action.len(), self.action)?;
        check_len("transition's reward", t.reward.len(), self.objectives)?;
        self.close_interrupted(t.obs);
        self.make_room()?;
        let end = match t.outcome {
            Outcome::Running => End::Next,
            outcome => End::Final {
                number: self.keep_final(t.next_obs),
                terminated: outcome == Outcome::Terminated,
            },
        };
        let i = self.cursor;
        write_row(&mut self.obs, i, t.obs);
        write_row(&mut self.act, i, t.action);
        write_row(&mut self.reward, i, t.reward);
        write_row(&mut self.end, i, &[end]);
        self.latest.clear();
        self.latest.extend_from_slice(t.next_obs);
        self.cursor = (i + 1) % self.capacity;
        Ok(())
    }

    /// If the newest transition does not lead to `obs`, the caller has started elsewhere. Then this
    /// stores where the transition did lead.
    fn close_interrupted(&mut self, obs: &[f32]) {
        let Some(newest) = self.newest() else { return };
        if self.end[newest] == End::Next && self.latest != obs {
            self.finals.extend(&self.latest);
            self.end[newest] = End::Final { number: self.last_number(), terminated: false };
        }
    }

    fn newest(&self) -> Option<usize> {
        (!self.is_empty()).then(|| (self.cursor + self.capacity - 1) % self.capacity)
    }

    fn keep_final(&mut self, obs: &[f32]) -> u32 {
        self.finals.extend(obs);
        self.last_number()
    }

    /// The running number of the final observation kept last.
    fn last_number(&self) -> u32 {
        // At most u32::MAX transitions are held at a time, so numbers modulo 2^32 stay unique.
        self.dropped.wrapping_add((self.finals.len() / self.observation) as u32).wrapping_sub(1)
    }

    /// Drops the oldest transition if full; otherwise grows by a chunk when needed.
    fn make_room(&mut self) -> Result<()> {
        let chunk = self.chunk();
        if self.len() < self.capacity {
            if self.len().is_multiple_of(chunk) {
                let more = chunk.min(self.capacity - self.len());
                self.reserve(more)?;
            }
        } else if let End::Final { .. } = self.end[self.cursor] {
            self.finals.drain(..self.observation);
            self.dropped = self.dropped.wrapping_add(1);
        }
        Ok(())
    }

    /// The number of transitions by which it grows.
    fn chunk(&self) -> usize {
        (LARGEST / self.observation.max(1)).clamp(1, CHUNK)
    }

    /// Makes room for `more` additional transitions.
    fn reserve(&mut self, more: usize) -> Result<()> {
        let Self { obs, act, reward, end, .. } = self;
        obs.try_reserve_exact(more * self.observation)
            .and_then(|()| act.try_reserve_exact(more * self.action))
            .and_then(|()| reward.try_reserve_exact(more * self.objectives))
            .and_then(|()| end.try_reserve_exact(more))
            .map_err(|_| {
                let wanted = format!("memory for {more} transitions more (or a smaller capacity)");
                Error::invalid("replay buffer", wanted, "none")
            })
    }

    /// Fills `batch` with `rows` transitions drawn uniformly with replacement.
    pub fn sample(&self, rows: usize, rng: &mut Rng, batch: &mut Batch) -> Result<()> {
        if self.is_empty() {
            return Err(Error::invalid("replay buffer", "at least 1 transition to sample from", 0));
        }
        batch.clear();
        for _ in 0..rows {
            self.gather(rng.below(self.len()), batch);
        }
        Ok(())
    }

    fn gather(&self, i: usize, batch: &mut Batch) {
        batch.obs.extend_from_slice(row(&self.obs, i, self.observation));
        batch.action.extend_from_slice(row(&self.act, i, self.action));
        batch.reward.extend_from_slice(row(&self.reward, i, self.objectives));
        match self.end[i] {
            End::Final { number, terminated } => {
                let start = number.wrapping_sub(self.dropped) as usize * self.observation;
                batch.next_obs.extend(self.finals.range(start..start + self.observation));
                batch.alive.push(if terminated { 0.0 } else { 1.0 });
            }
            End::Next => {
                let next = if Some(i) == self.newest() {
                    &self.latest
                } else {
                    row(&self.obs, (i + 1) % self.capacity, self.observation)
                };
                batch.next_obs.extend_from_slice(next);
                batch.alive.push(1.0);
            }
        }
    }

    /// An error if a loaded position points to nothing; `ends` last observations were loaded.
    fn check_positions(&self, ends: usize) -> Result<()> {
        // A ring that is not full is written at its end.
        let len = self.len();
        let cursor = self.cursor;
        let sound = if len < self.capacity { cursor == len } else { cursor < len };
        if !sound {
            return Err(Error::invalid(
                "saved replay's cursor",
                format!("a place among {len} transitions"),
                cursor,
            ));
        }
        for end in &self.end {
            if let End::Final { number, .. } = *end
                && number.wrapping_sub(self.dropped) as usize >= ends
            {
                let wanted = format!("one of {ends} last observations");
                return Err(Error::invalid("saved replay's last observation", wanted, number));
            }
        }
        Ok(())
    }

    /// Writes the contents and the cursor.
    pub fn save(&self, state: &mut State) {
        let rows = self.len();
        state.put_shaped("obs", &[rows, self.observation], self.obs.as_slice());
        state.put_shaped("action", &[rows, self.action], self.act.as_slice());
        state.put_shaped("reward", &[rows, self.objectives], self.reward.as_slice());
        let end: Vec<u64> = self.end.iter().map(|&end| encode(end)).collect();
        state.put("end", end);
        state.put("latest", self.latest.as_slice());
        let finals: Vec<f32> = self.finals.iter().copied().collect();
        state.put_shaped("finals", &[finals.len() / self.observation, self.observation], finals);
        state.put("cursor", [self.cursor as u64]);
        state.put("dropped", [u64::from(self.dropped)]);
        state.put("capacity", [self.capacity as u64]);
    }

    /// Restores what [`Replay::save`] wrote, into a buffer of the same shape and capacity.
    pub fn load(&mut self, state: &State) -> Result<()> {
        let capacity: u64 = state.get_one("capacity")?;
        if capacity != self.capacity as u64 {
            return Err(Error::invalid("saved replay's capacity", self.capacity, capacity));
        }
        let end: Vec<End> = state.get::<u64>("end")?.iter().map(|&code| decode(code)).collect();
        let ends = end.iter().filter(|&&end| end != End::Next).count();
        let latest = if end.is_empty() { 0 } else { self.observation };
        let mut fresh = Self {
            obs: sized(state, "obs", end.len() * self.observation)?,
            act: sized(state, "action", end.len() * self.action)?,
            reward: sized(state, "reward", end.len() * self.objectives)?,
            latest: sized(state, "latest", latest)?,
            finals: sized(state, "finals", ends * self.observation)?.into(),
            cursor: state.get_one::<u64>("cursor")? as usize,
            dropped: state.get_one::<u64>("dropped")? as u32,
            end,
            ..*self
        };
        fresh.check_positions(ends)?;
        let held = fresh.len();
        let room = fresh.len().next_multiple_of(self.chunk()).min(self.capacity);
        fresh.reserve(room - held)?;
        *self = fresh;
        Ok(())
    }
}

fn row(values: &[f32], i: usize, width: usize) -> &[f32] {
    &values[i * width..(i + 1) * width]
}

/// Overwrites row `i`, or appends it when it is the first beyond the end.
fn write_row<T: Copy>(values: &mut Vec<T>, i: usize, row: &[T]) {
    let start = i * row.len();
    if start == values.len() {
        values.extend_from_slice(row);
    } else {
        values[start..start + row.len()].copy_from_slice(row);
    }
}

fn sized(state: &State, name: &str, wanted: usize) -> Result<Vec<f32>> {
    let values = state.get::<f32>(name)?;
    check_len(&format!("saved replay's {name}"), values.len(), wanted)?;
    Ok(values.to_vec())
}

/// 0 for `Next`, otherwise 1 + 2 number + terminated.
fn encode(end: End) -> u64 {
    match end {
        End::Next => 0,
        End::Final { number, terminated } => 1 + 2 * u64::from(number) + u64::from(terminated),
    }
}

fn decode(code: u64) -> End {
    match code.checked_sub(1) {
        None => End::Next,
        Some(code) => End::Final { number: (code / 2) as u32, terminated: code % 2 == 1 },
    }
}
