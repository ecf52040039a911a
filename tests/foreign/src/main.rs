//! What a crate outside copq can do: train with a projection, an environment and a backend of its
//! own.

mod backend;
mod projection;
mod thermostat;

use backend::Linear;
use copq::{Env, Learner, Method, Result, Silent, Trainer, check_env};
use copq_candle::Candle;
use projection::SafetyOnly;
use thermostat::Thermostat;

fn main() -> Result<()> {
    own_projection()?;
    own_everything()
}

/// copq's robot and networks.
fn own_projection() -> Result<()> {
    let env = copq_envs_rapier::make("a/hopper")?;
    let mut method = Method::cop_td3().bound(SafetyOnly).warm_up(100);
    method.config.batch = 16;
    let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    trainer.run(200, &mut Silent)?;
    println!("{}", trainer.evaluate(2)?);
    save(&trainer, "hopper")
}

/// Nothing of copq's but the algorithm.
fn own_everything() -> Result<()> {
    println!("{:?}", check_env(&mut Thermostat::new())?);
    let env = Box::new(Thermostat::new());
    let method = Method::cop_td3().bound(SafetyOnly).warm_up(500);
    let learner = Learner::new(method, env.spec(), &Linear, 0)?;
    let mut trainer = Trainer::new(env, learner)?;
    let before = trainer.evaluate(20)?.mean()[0];
    trainer.run(5_000, &mut Silent)?;
    let after = trainer.evaluate(20)?;
    println!("{after}");
    assert!(after.mean()[0] > 0.5 * before, "comfort was {before}, and is {}", after.mean()[0]);
    save(&trainer, "thermostat")
}

/// Writes a policy and takes it away again.
fn save(trainer: &Trainer<Learner>, name: &str) -> Result<()> {
    let file = format!("foreign-{name}-{}.safetensors", std::process::id());
    let file = std::env::temp_dir().join(file);
    trainer.agent().save_policy(&file)?;
    std::fs::remove_file(&file).map_err(|e| copq::Error::other("taking the policy away", e))
}
