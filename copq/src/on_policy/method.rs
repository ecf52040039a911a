//! The on-policy methods by name, each with its source.

use super::config::{Ascent, Config, Constraint, NaturalStep, SauteConfig, SecondStep};
use crate::{Error, PidConfig, Result};

/// A method's name, its constructor, and its source.
type Preset = (&'static str, fn() -> Method, &'static str);

const METHODS: &[Preset] = &[
    ("ppo", Method::ppo, "Schulman et al. 2017; OmniSafe's constants"),
    ("ppo-lag", Method::ppo_lag, "Ray et al. 2019; OmniSafe's constants"),
    ("cppo-pid", Method::cppo_pid, "Stooke et al. 2020; OmniSafe's constants, paper Table E.3"),
    ("rcpo", Method::rcpo, "Tessler et al. 2019; OmniSafe's constants, paper Table E.3"),
    ("cup", Method::cup, "Yang et al. 2022; OmniSafe's constants, paper Table E.3"),
    ("ppo-saute", Method::ppo_saute, "Sootla et al. 2022; OmniSafe's constants, paper Table E.3"),
];

/// The algorithm that an on-policy [`Learner`](super::Learner) uses: its settings, and the rules
/// that they switch on.
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
    /// The name that command lines, run folders and checkpoints use for it.
    pub name: String,
    /// Its settings.
    pub config: Config,
    /// Where it comes from.
    pub source: String,
}

impl Method {
    /// Your own method.
    pub fn new(name: impl Into<String>, config: Config) -> Self {
        Self { name: name.into(), config, source: String::new() }
    }

    /// The names that [`Method::by_name`] knows.
    pub fn names() -> impl ExactSizeIterator<Item = &'static str> {
        METHODS.iter().map(|(name, ..)| *name)
    }

    /// The method of that name. The error for an unknown name lists the known ones, nearest first.
    pub fn by_name(name: &str) -> Result<Self> {
        let names: Vec<_> = Self::names().collect();
        let preset = METHODS.iter().find(|(known, ..)| *known == name);
        let (name, make, source) = preset.ok_or_else(|| Error::unknown("method", name, &names))?;
        Ok(Self { name: (*name).to_owned(), source: (*source).to_owned(), ..make() })
    }

    /// PPO with clipped ratios, early stopping by KL, and a step size that falls to 0. A cost
    /// counts with its own weight, which is 0 unless given.
    ///
    /// | setting | value |
    /// |---|---|
    /// | steps per epoch, environments | 2,048, 1 |
    /// | passes, minibatch, target KL, clip | 40, 64, 0.02, 0.2 |
    /// | step sizes | 3e-4: the policy's falls to 0 over 1,024,000 steps, the critics' stays |
    /// | discount, lambda | 0.99, 0.95 |
    /// | gradient's norm, critics' L2, entropy | at most 40, 0.001, 0 |
    /// | observations | normalised by their running mean and deviation, clipped at 5 |
    /// | networks | 64 x 64, tanh, PyTorch's initial weights; deviations start at 1 |
    pub fn ppo() -> Self {
        Self::new("ppo", Config::default())
    }

    /// PPO whose costs are weighted by a multiplier that Adam moves by 0.035 per epoch.
    pub fn ppo_lag() -> Self {
        let constraint = Some(Constraint::Adam(Ascent::default()));
        Self::new("ppo-lag", Config { constraint, ..Config::default() })
    }

    /// PPO whose costs are weighted by a PID controller's multiplier: gains of 0.1, 0.01 and 0.01
    /// per epoch for each unit of an episode's cost, a delay of 10, and no cap.
    pub fn cppo_pid() -> Self {
        let constraint = Some(Constraint::Pid(PidConfig::cppo_pid()));
        Self::new("cppo-pid", Config { constraint, ..Config::default() })
    }

    /// One natural-gradient step per epoch, on the reward minus the costs, which Adam's multiplier
    /// weights. Critics take 10 passes in minibatches of 128 with a step size of 1e-3.
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

    /// PPO on the reward, then a second step down the costs ([`SecondStep`]). Both stop at a KL of
    /// 0.01, and the multiplier is at most 2.
    pub fn cup() -> Self {
        let config = Config {
            target_kl: 0.01,
            second: Some(SecondStep::default()),
            constraint: Some(Constraint::Adam(Ascent { cap: 2.0, ..Ascent::default() })),
            ..Config::default()
        };
        Self::new("cup", config)
    }

    /// PPO in an environment that shows how much of a cost's budget is left
    /// ([`Saute`](super::Saute)), with a reward of -1 once it is spent.
    pub fn ppo_saute() -> Self {
        let saute = Some(SauteConfig::default());
        Self::new("ppo-saute", Config { saute, ..Config::default() })
    }
}
