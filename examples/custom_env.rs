//! An environment of one's own: a cart that should be quick, but above all should not hit the wall.
//!
//! `cargo run --release --example custom_env -- 20000` checks it, then trains for that many steps.

use copq::{Config, Env, EnvSpec, Learner, Outcome, Result, Rng, Silent, State, Stream, Trainer, check_env, evaluate};

const WALL: f32 = 10.0;
const TICK: f32 = 0.1;

/// A cart at a distance from a wall, pushed by a force in [-1, 1].
struct Cart {
    spec: EnvSpec,
    /// Position and velocity.
    state: [f32; 2],
    steps: usize,
}

impl Cart {
    fn new() -> Self {
        let spec = EnvSpec {
            name: "cart".into(),
            observation: 2,
            action_low: vec![-1.0],
            action_high: vec![1.0],
            objectives: vec!["safety".into(), "progress".into()], // by priority
            weights: vec![1.0, 1.0],
            limits: vec![], // no costs with limits
            entropy: None,  // a stochastic policy's bonus goes to the last reward
            horizon: 200,
        };
        Self { spec, state: [0.0; 2], steps: 0 }
    }
}

impl Env for Cart {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        // An episode depends on its seed alone; streams 100 to 999 are free.
        self.state = [Rng::with_stream(seed, 100).uniform_in(0.0, 2.0) as f32, 0.0];
        self.steps = 0;
        obs.copy_from_slice(&self.state);
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        let [position, velocity] = &mut self.state;
        *velocity += TICK * action[0];
        *position += TICK * *velocity;
        self.steps += 1;
        let crashed = *position >= WALL;
        reward.copy_from_slice(&[if crashed { 0.0 } else { 1.0 }, -(WALL - 1.0 - *position).abs() / WALL]);
        obs.copy_from_slice(&self.state);
        Ok(match (crashed, self.steps == self.spec.horizon) {
            (true, _) => Outcome::Terminated, // nothing follows
            (_, true) => Outcome::Truncated,  // time ran out, but the state is worth what it is worth
            _ => Outcome::Running,
        })
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("state", self.state);
        state.put("steps", [self.steps as u64]);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("state", &mut self.state)?;
        self.steps = state.get_one::<u64>("steps")? as usize;
        Ok(())
    }
}

fn main() -> Result<()> {
    let steps = copq_examples::steps(20_000)?;
    println!("{:?}", check_env(&mut Cart::new())?); // first of all
    let (spec, mut rng, mut config) = (Cart::new().spec, Rng::new(0, Stream::Init), Config::cop_td3());
    config.start_steps = (steps / 10).max(1);
    config.networks.hidden = vec![64, 64];
    let critic = copq_candle::critic(&spec, 3, &config.networks, &mut rng)?;
    let actor = copq_candle::actor(&spec, &config.networks, &mut rng)?;
    let learner = Learner::new(config, &spec, Box::new(critic), Box::new(actor), 0)?;
    let mut trainer = Trainer::new(Box::new(Cart::new()), Box::new(learner), 0)?;
    while trainer.steps() < steps {
        trainer.step(&mut Silent)?;
    }
    let evaluation = evaluate(trainer.agent_mut(), &mut Cart::new(), 10, 0, 0.99)?;
    println!("safety, progress: {:.1?}", evaluation.mean());
    Ok(())
}
