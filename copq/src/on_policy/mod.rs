//! Learning from the policy's own steps alone: PPO and its constrained kin.
//!
//! An epoch of steps is gathered, the multipliers of the costs are set by the episodes' costs,
//! advantages are estimated, the policy and its critics take their steps, and the data is thrown
//! away. Methods are values of the one [`Learner`], as off-policy ones are
//! ([`Method`](crate::Method)); constants and rules are OmniSafe's.
//!
//! | method | preset | costs are held by | the policy's step |
//! |---|---|---|---|
//! | PPO | [`Method::ppo`] | nothing | clipped ratios |
//! | PPOLag | [`Method::ppo_lag`] | a multiplier by Adam | clipped ratios |
//! | CPPOPID | [`Method::cppo_pid`] | a multiplier by a PID controller | clipped ratios |
//! | RCPO | [`Method::rcpo`] | a multiplier by Adam | natural gradient |
//! | CUP | [`Method::cup`] | a second step, weighed by a multiplier | clipped ratios |
//! | PPOSaute | [`Method::ppo_saute`] | a budget in the observation ([`Saute`]) | clipped ratios |
//!
//! Rewards are one signal, weighed by the task's weights, with one critic. A method with multipliers
//! has one for every cost, and a critic; in others but PPOSaute a cost counts in the signal by its
//! own weight, 0 unless it is given. Nothing here has a priority order.

mod advantage;
mod agent;
mod clipped;
mod config;
mod episodes;
mod epoch;
mod gather;
mod learn;
mod learner;
mod method;
mod multiplier;
mod natural;
mod networks;
mod normal;
mod report;
mod saute;
mod second;
#[cfg(test)]
mod tests;
mod update;

pub use config::{Ascent, Config, Constraint, NaturalStep, SauteConfig, SecondStep};
pub use learner::Learner;
pub use method::Method;
pub use networks::{
    Descent, GaussianPolicy, Normal, NormalGrad, NormalGradient, StateValue, ValueGrad,
};
pub use report::Report;
pub use saute::Saute;
pub(crate) use saute::shows_budgets;
pub use update::{Rows, update};
