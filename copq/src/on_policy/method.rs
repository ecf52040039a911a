//! The on-policy methods by name, each with its source.

use super::config::{Ascent, Config, Constraint, NaturalStep, SauteConfig, SecondStep};
use crate::{Error, PidConfig, Result};

/// A method's name, how it is made, and where it is from.
type Preset = (&'static str, fn() -> Method, &'static str);

const METHODS: &[Preset] = &[
    ("ppo", Method::ppo, "Schulman et al. 2017; OmniSafe's constants"),
    ("ppo-lag", Method::ppo_lag, "Ray et al. 2019; OmniSafe's constants"),
    ("cppo-pid", Method::cppo_pid, "Stooke et al. 2020; OmniSafe's constants, paper Table E.3"),
    ("rcpo", Method::rcpo, "Tessler et al. 2019; OmniSafe's constants, paper Table E.3"),
    ("cup", Method::cup, "Yang et al. 2022; OmniSafe's constants, paper Table E.3"),
    ("ppo-saute", Method::ppo_saute, "Sootla et al. 2022; OmniSafe's constants, paper Table E.3"),
];

/// What an on-policy [`Learner`](super::Learner) learns by: numbers, and which of the rules they
/// switch on.
///
/// ```
/// use copq::on_policy::{Ascent, Constraint, Method};
///
/// // PPOLag is PPO with a multiplier, ...
/// let mut method = Method::ppo();
/// method.config.constraint = Some(Constraint::Adam(Ascent::default()));
/// assert_eq!(method.config, Method::ppo_lag().config);
///
/// // ... and all of them have a name.
/// assert_eq!(Method::by_name("cup")?.config.target_kl, 0.01);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Method {
    /// The name by which command lines, run folders and checkpoints know it.
    pub name: String,
    /// Its numbers.
    pub config: Config,
    /// Where it is from.
    pub source: String,
}

impl Method {
    /// A method of your own.
    pub fn new(name: impl Into<String>, config: Config) -> Self {
        Self { name: name.into(), config, source: String::new() }
    }

    /// The names that [`Method::by_name`] knows.
    pub fn names() -> impl ExactSizeIterator<Item = &'static str> {
        METHODS.iter().map(|(name, ..)| *name)
    }

    /// The method of that name; the error of an unknown one lists the known, nearest first.
    pub fn by_name(name: &str) -> Result<Self> {
        let names: Vec<_> = Self::names().collect();
        let preset = METHODS.iter().find(|(known, ..)| *known == name);
        let (name, make, source) = preset.ok_or_else(|| Error::unknown("method", name, &names))?;
        Ok(Self { name: (*name).to_owned(), source: (*source).to_owned(), ..make() })
    }

    /// PPO with clipped ratios, an early stop by KL, and a step size that falls to nothing. A cost
    /// counts by its own weight, 0 unless it is given.
    ///
    /// | setting | value |
    /// |---|---|
    /// | steps an epoch, worlds | 2,048, 1 |
    /// | passes, minibatch, target KL, clip | 40, 64, 0.02, 0.2 |
    /// | step sizes | 3e-4: the policy's falls to 0 over 1,024,000 steps, the critics' stays |
    /// | discount, lambda | 0.99, 0.95 |
    /// | gradient's norm, critics' L2, entropy | at most 40, 0.001, 0 |
    /// | observations | in units of their deviation, cut at 5 |
    /// | networks | 64 x 64, tanh, PyTorch's weights; deviations begin at 1 |
    pub fn ppo() -> Self {
        Self::new("ppo", Config::default())
    }

    /// PPO whose costs are weighed by a multiplier that Adam moves by 0.035 an epoch.
    pub fn ppo_lag() -> Self {
        let constraint = Some(Constraint::Adam(Ascent::default()));
        Self::new("ppo-lag", Config { constraint, ..Config::default() })
    }

    /// PPO whose costs are weighed by a PID controller's multiplier: gains 0.1, 0.01 and 0.01 an
    /// epoch for each unit of an episode's cost, a delay of 10, and no cap.
    pub fn cppo_pid() -> Self {
        let constraint = Some(Constraint::Pid(PidConfig::cppo_pid()));
        Self::new("cppo-pid", Config { constraint, ..Config::default() })
    }

    /// One natural gradient an epoch on a reward less the costs, which Adam's multiplier weighs;
    /// critics take 10 passes in minibatches of 128 with a step size of 1e-3.
    pub fn rcpo() -> Self {
        let mut config = Config {
            natural: Some(NaturalStep::default()),
            passes: 10,
            batch: 128,
            target_kl: 0.01,
            ..Self::ppo_lag().config
        };
        config.networks.critic_lr = 1e-3;
        Self::new("rcpo", config)
    }

    /// PPO on the reward, then a second step down the costs ([`SecondStep`]); both stop at a KL of
    /// 0.01, and the multiplier ends at 2.
    pub fn cup() -> Self {
        let config = Config {
            target_kl: 0.01,
            second: Some(SecondStep::default()),
            constraint: Some(Constraint::Adam(Ascent { cap: 2.0, ..Ascent::default() })),
            ..Config::default()
        };
        Self::new("cup", config)
    }

    /// PPO in a world that shows how much of a cost's budget is left, and pays -1 once it is spent
    /// ([`Saute`](super::Saute)).
    pub fn ppo_saute() -> Self {
        let saute = Some(SauteConfig::default());
        Self::new("ppo-saute", Config { saute, ..Config::default() })
    }
}
