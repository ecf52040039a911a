//! A point mass on a line and an agent that learns to push it, small enough to train a thousand
//! steps in a blink.

use copq::{
    Agent, Env, EnvSpec, Method, Mode, Objective, Observer, Outcome, Result, Rng, State, Stream,
    Trainer, Transition,
};
use copq_experiments::{Plan, Run, RunFolder, RunSettings};
use serde::{Deserialize, Serialize};

/// Settings of the agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Step size.
    pub rate: f32,
}

/// Position and velocity; rewarded for speed, and effort is a cost under a limit.
pub struct PointMass {
    spec: EnvSpec,
    position: f64,
    velocity: f64,
    steps: u64,
    wind: Rng,
}

impl PointMass {
    pub fn new() -> Self {
        let effort = Objective::cost("effort", 31.5).weight(-0.5);
        let spec = EnvSpec::new("test/point-mass", 2, 1).reward("speed", 1.0).objective(effort);
        let spec = spec.action_bounds(&[-2.0], &[2.0]).horizon(70);
        Self { spec, position: 0.0, velocity: 0.0, steps: 0, wind: Rng::with_stream(0, 99) }
    }

    fn observe(&self, obs: &mut [f32]) {
        obs.copy_from_slice(&[self.position as f32, self.velocity as f32]);
    }
}

impl Env for PointMass {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.wind = Rng::with_stream(seed, 99);
        (self.position, self.velocity, self.steps) = (self.wind.normal(), 0.0, 0);
        self.observe(obs);
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        let push = f64::from(action[0]);
        self.velocity = 0.9 * self.velocity + 0.1 * push + 0.02 * self.wind.normal();
        self.position += 0.1 * self.velocity;
        self.steps += 1;
        self.observe(obs);
        reward.copy_from_slice(&[self.velocity as f32, (push * push) as f32]);
        Ok(if self.position > 6.0 {
            Outcome::Terminated
        } else if self.steps >= self.spec.horizon as u64 {
            Outcome::Truncated
        } else {
            Outcome::Running
        })
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("point", [self.position, self.velocity]);
        state.put("steps", [self.steps]);
        self.wind.save("wind", state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let mut point = [0.0; 2];
        state.read("point", &mut point)?;
        [self.position, self.velocity] = point;
        self.steps = state.get_one("steps")?;
        self.wind.load("wind", state)
    }
}

/// Pushes as hard as its one weight says, which follows a noisy rule.
pub struct Pusher {
    seed: u64,
    weight: f32,
    rate: f32,
    updates: u64,
    noise: Rng,
}

impl Agent for Pusher {
    fn seed(&self) -> u64 {
        self.seed
    }

    fn discount(&self) -> f64 {
        0.99
    }

    fn act(&mut self, obs: &[f32], mode: Mode, action: &mut [f32]) -> Result<()> {
        let noise = if mode == Mode::Explore { 0.3 * self.noise.normal() as f32 } else { 0.0 };
        action[0] = (self.weight - 0.1 * obs[1] + noise).clamp(-1.0, 1.0);
        Ok(())
    }

    fn observe(&mut self, transition: Transition<'_>) -> Result<()> {
        self.weight +=
            self.rate * (0.01 + transition.reward[0] * transition.action[0]).clamp(-0.1, 0.1);
        self.weight = self.weight.min(0.8);
        Ok(())
    }

    fn update(&mut self, log: &mut dyn Observer) -> Result<()> {
        self.updates += 1;
        // A warm-up without any numbers, as real learners have it.
        if self.updates > 150 {
            log.scalar(self.updates, "q/speed", f64::from(self.weight) + self.noise.normal());
            log.scalar(self.updates, "q/effort", f64::from(self.weight));
        }
        Ok(())
    }

    fn value(&mut self, obs: &[f32], action: &[f32], q: &mut [f32]) -> Result<()> {
        q.copy_from_slice(&[20.0 * action[0] + obs[1], 4.0 * action[0] * action[0]]);
        Ok(())
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("weight", [self.weight]);
        state.put("updates", [self.updates]);
        self.noise.save("noise", state);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.weight = state.get_one("weight")?;
        self.updates = state.get_one("updates")?;
        self.noise.load("noise", state)
    }
}

/// A short run's plan.
pub fn plan(seed: u64, steps: u64) -> Plan {
    let run = RunSettings {
        steps,
        seed,
        eval_every: 250,
        eval_episodes: 4,
        log_every: 100,
        checkpoint_every: 300,
        ..RunSettings::default()
    };
    Plan { task: "test/point-mass".to_owned(), run, ..Plan::new(&Method::cop_td3()) }
}

/// The agent's settings.
pub fn settings() -> Settings {
    Settings { rate: 0.01 }
}

/// A fresh agent.
pub fn pusher(seed: u64, noise: Rng) -> Pusher {
    Pusher { seed, weight: 0.0, rate: settings().rate, updates: 0, noise }
}

/// A fresh trainer.
pub fn trainer(seed: u64) -> Trainer {
    let noise = Rng::new(seed, Stream::Explore);
    let agent = pusher(seed, noise);
    Trainer::new(PointMass::new(), Box::new(agent) as Box<dyn Agent>).unwrap()
}

/// A run in an opened folder.
pub fn run(folder: RunFolder, plan: &Plan) -> Run {
    let eval_env = Box::new(PointMass::new());
    Run::new(trainer(plan.run.seed), Some(eval_env), folder, plan.run).unwrap()
}
