//! What networks are like, for the backend that builds them.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::check_positive;
use crate::{Error, Result};

/// Network shapes and step sizes, for the backend that builds the networks.
///
/// ```
/// use copq::{Activation, Init, Method, Networks};
///
/// let mut method = Method::cop_td3();
/// method.config.networks = Networks {
///     hidden: vec![400, 300],
///     init: Init::Lecun,
///     activation: Activation::Silu,
///     ..Networks::default()
/// };
/// method.config.check()?;
///
/// method.config.networks.hidden.clear();
/// let error = method.config.check().unwrap_err();
/// assert_eq!(error.to_string(), "networks.hidden: wanted one or more positive widths, got []");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Networks {
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Adam's step size for the critics.
    pub critic_lr: f64,
    /// Adam's step size for the actor.
    pub actor_lr: f64,
    /// How weights and biases are drawn.
    pub init: Init,
    /// The function after each hidden layer.
    pub activation: Activation,
    /// How many bits the products of an update have; on-policy methods have f32 alone.
    #[serde(skip_serializing_if = "is_default")]
    pub precision: Precision,
}

/// Left out of a file, so that a run keeps the settings that it had before this one came.
fn is_default(precision: &Precision) -> bool {
    *precision == Precision::default()
}

/// How many bits the products of an off-policy update have: 32, or 16 (bf16: f32's range with eight
/// significant bits) in its less delicate parts. Parameters, optimiser, sums, the first layer
/// forward, the last layer both ways, and policies as they act are always f32.
/// Every processor computes the same bits, and those without the instruction for bf16 gain no time.
///
/// ```
/// use copq::{Method, Precision};
///
/// let mut method = Method::cop_td3();
/// method.config.networks.precision = Precision::Backward;
/// method.config.check()?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// f32 everywhere.
    #[default]
    F32,
    /// bf16 on the way back below the last layer: values, targets and bounds are as in f32;
    /// gradients differ by less than 0.5 % in a test.
    Backward,
    /// And between critics' hidden layers forward, where no bound's gradient is taken (fits,
    /// targets, FAMO's second look, a multiplier's cost estimate, values that are asked for): values
    /// differ by less than 0.2 % in a test. Learning has not been shown to be unharmed yet.
    Careful,
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::Backward => "backward",
            Self::Careful => "careful",
        })
    }
}

/// The function between two layers of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// max(0, x): every off-policy method of the paper.
    #[default]
    Relu,
    /// tanh(x).
    Tanh,
    /// x / (1 + exp(-x)): CAL's authors have it in their cost critics; here it is all networks'.
    Silu,
}

/// The distribution of a network's initial weights; every layer has the same rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Init {
    /// Weights and biases uniform within 1/sqrt(inputs): `torch.nn.Linear`'s, and so TD3's.
    #[default]
    Torch,
    /// Weights uniform within sqrt(3/inputs), which keeps the inputs' variance, and no biases:
    /// Brax's.
    Lecun,
}

impl Default for Networks {
    /// Two hidden layers of 256 with ReLU, step sizes 3e-4 (paper Table D.3).
    fn default() -> Self {
        Self {
            hidden: vec![256, 256],
            critic_lr: 3e-4,
            actor_lr: 3e-4,
            init: Init::Torch,
            activation: Activation::Relu,
            precision: Precision::F32,
        }
    }
}

impl Networks {
    /// An error for a setting no network can have.
    pub fn check(&self) -> Result<()> {
        if self.hidden.is_empty() || self.hidden.contains(&0) {
            return Err(Error::invalid(
                "networks.hidden",
                "one or more positive widths",
                format!("{:?}", self.hidden),
            ));
        }
        for (name, lr) in
            [("networks.critic_lr", self.critic_lr), ("networks.actor_lr", self.actor_lr)]
        {
            check_positive(name, lr)?;
        }
        Ok(())
    }

    /// The same for what has no other precision than f32, such as an on-policy method.
    pub fn check_f32(&self, what: &str) -> Result<()> {
        self.check()?;
        match self.precision {
            Precision::F32 => Ok(()),
            other => Err(Error::invalid("networks.precision", format!("f32 for {what}"), other)),
        }
    }
}
