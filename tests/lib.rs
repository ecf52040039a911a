//! What crosses the crates of copq: composed agents, engines, golden data, resume.

/// The README's own code, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The README's quick start, run: a test has little time, and leaves its policy among the temporary
/// files.
///
/// ```
/// use copq::{Learner, Method, Silent, Trainer, projection::Extremum};
/// use copq_candle::Candle;
///
/// fn main() -> copq::Result<()> {
///     std::env::set_current_dir(std::env::temp_dir()).map_err(|e| copq::Error::other("a folder", e))?;
///     let env = copq_envs_rapier::make("a/hopper")?;
///     let method = Method::cop_td3().bound(Extremum); // the swap (COP-Q has Cholesky here); its critics come with it
///     let learner = Learner::new(method, env.spec(), &Candle::default(), 0)?;
///     let mut trainer = Trainer::new(env, learner)?;
///     trainer.run(1_050, &mut Silent)?;
///     println!("{}", trainer.evaluate(10)?);
///     trainer.agent().save_policy("hopper.safetensors")
/// }
/// ```
#[cfg(doctest)]
struct QuickStart;
