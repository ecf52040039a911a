//! Where a trainer's time goes.

use std::time::Duration;

/// Wall-clock time spent since the trainer was made (not saved, as it is not part of the result).
///
/// ```
/// # mod world { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/world.rs")); }
/// # mod still { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/doctest/still.rs")); }
/// # let env = world::World::new();
/// # let learner = still::Still;
/// use copq::{Silent, Trainer};
///
/// let mut trainer = Trainer::new(env, learner)?;
/// trainer.run(30, &mut Silent)?;
/// let spent = trainer.timing();
/// let all = spent.act + spent.env + spent.update;
/// println!("{:.0} % in the environment", 100.0 * spent.env.as_secs_f64() / all.as_secs_f64());
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct Timing {
    /// Choosing actions.
    pub act: Duration,
    /// Inside the environment.
    pub env: Duration,
    /// Storing experience and updating networks.
    pub update: Duration,
}
