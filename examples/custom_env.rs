//! An environment of your own: a cart that should be quick, but above all must not hit the wall.
//!
//! `cargo run --release -p copq-examples --example custom_env -- 20000` checks it, then trains for
//! that many steps.

use copq::{
    Env, EnvSpec, Learner, Method, Outcome, Result, Rng, Silent, State, Stream, Trainer, check_env,
};
use copq_candle::Candle;

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
        // By priority: no crash first, then progress.
        let spec =
            EnvSpec::new("cart", 2, 1).reward("safety", 1.0).reward("progress", 1.0).horizon(200);
        Self { spec, state: [0.0; 2], steps: 0 }
    }
}

impl Env for Cart {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        // An episode depends only on its seed.
        self.state = [Rng::new(seed, Stream::Custom).uniform_in(0.0, 2.0) as f32, 0.0];
        self.steps = 0;
        obs.copy_from_slice(&self.state);
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.state[1] += TICK * action[0];
        self.state[0] += TICK * self.state[1];
        self.steps += 1;
        let distance = WALL - self.state[0];
        let safe = distance > 0.0;
        reward.copy_from_slice(&[f32::from(safe), -(distance - 1.0).abs() / WALL]);
        obs.copy_from_slice(&self.state);
        Ok(if !safe {
            Outcome::Terminated // nothing follows
        } else if self.steps == self.spec.horizon {
            Outcome::Truncated // time ran out, but the state keeps its value
        } else {
            Outcome::Running
        })
    }

    // With these a run can stop in the middle of an episode and resume, bit for bit.
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
    print!("{}", check_env(&mut Cart::new())?); // do this first

    let mut method = Method::cop_td3().warm_up((steps / 10).max(1));
    method.config.networks.hidden = vec![64, 64];
    let learner = Learner::new(method, &Cart::new().spec, &Candle::default(), 0)?;
    let mut trainer = Trainer::new(Cart::new(), learner)?;
    trainer.run(steps, &mut Silent)?;
    println!("{}", trainer.evaluate(10)?);
    Ok(())
}
