//! Learning only from the policy's own steps: PPO and its constrained variants.
//!
//! The learner gathers an epoch of steps, sets the costs' multipliers from the costs of episodes,
//! estimates advantages, updates the policy and its critics, and discards the data. As with
//! off-policy methods ([`Method`](crate::Method)), there is one [`Learner`], and a method is a
//! value given to it. Constants and rules are OmniSafe's.
//!
//! | method | preset | limits are enforced by | the policy's step |
//! |---|---|---|---|
//! | PPO | [`Method::ppo`] | nothing | clipped ratios |
//! | PPOLag | [`Method::ppo_lag`] | a multiplier by Adam | clipped ratios |
//! | CPPOPID | [`Method::cppo_pid`] | a multiplier by a PID controller | clipped ratios |
//! | RCPO | [`Method::rcpo`] | a multiplier by Adam | natural gradient |
//! | CUP | [`Method::cup`] | a second step, weighted by a multiplier | clipped ratios |
//! | PPOSaute | [`Method::ppo_saute`] | a budget in the observation ([`Saute`]) | clipped ratios |
//!
//! Rewards make one signal, weighted by the task's weights, with one critic. A method with
//! multipliers has a multiplier and a critic for every cost. In other methods except PPOSaute, a
//! cost counts in the signal with its own weight, which is 0 unless given. Nothing here has a
//! priority order.

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
