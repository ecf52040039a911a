//! The shape of networks, for the backend that builds them.

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
    /// How many bits the products of an update have; on-policy methods support f32 only.
    #[serde(skip_serializing_if = "is_default")]
    pub precision: Precision,
}

/// Whether to leave it out of a file, so that a run keeps the settings that it had before this one
/// existed.
fn is_default(precision: &Precision) -> bool {
    *precision == Precision::default()
}

/// How many bits the products of an off-policy update have: 32, or 16 (bf16: f32's range with eight
/// significant bits) in its less delicate parts. Parameters, the optimiser, sums, the first layer's
/// forward pass, both passes of the last layer, and policies as they act are always f32. Every
/// processor computes the same bits; one without an instruction for bf16 saves no time.
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
    /// bf16 in the backward pass below the last layer. Values, targets and bounds are as in f32;
    /// gradients differ by less than 0.5 % in a test.
    Backward,
    /// Also bf16 in the forward pass between the critics' hidden layers, where no bound's gradient
    /// is taken (fits, targets, FAMO's second evaluation, a multiplier's cost estimate, values on
    /// request). Values differ by less than 0.2 % in a test. It is not shown yet that learning is
    /// unharmed.
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
    /// max(0, x), as in every off-policy method of the paper.
    #[default]
    Relu,
    /// tanh(x).
    Tanh,
    /// x / (1 + exp(-x)). CAL's authors use it in their cost critics; here it applies to all
    /// networks.
    Silu,
}

/// The distribution of a network's initial weights; every layer has the same rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Init {
    /// Weights and biases uniform within 1/sqrt(inputs), as in `torch.nn.Linear` and so in TD3.
    #[default]
    Torch,
    /// Weights uniform within sqrt(3/inputs), which keeps the inputs' variance, and zero biases, as
    /// in Brax.
    Lecun,
}

impl Default for Networks {
    /// Two hidden layers of 256 units with ReLU, and step sizes of 3e-4 (paper Table D.3).
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

    /// The same where only f32 is supported, such as in an on-policy method.
    pub fn check_f32(&self, what: &str) -> Result<()> {
        self.check()?;
        match self.precision {
            Precision::F32 => Ok(()),
            other => Err(Error::invalid("networks.precision", format!("f32 for {what}"), other)),
        }
    }
}
