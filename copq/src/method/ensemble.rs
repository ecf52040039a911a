//! Which critics a method learns with.

use serde::{Deserialize, Serialize};

use crate::separate::equal_counts;
use crate::{Backend, Critic, EnvSpec, Networks, Objective, Result, Rng, SeparateCritics};

/// The critics that a method is meant for. N objectives have N values, in priority order.
///
/// ```
/// use copq::projection::{Extremum, IndependentMin};
/// use copq::{Ensemble, Method};
///
/// // Critics follow the bound ...
/// assert_eq!(Method::cop_td3().bound(Extremum).critics, Ensemble::Spanning);
/// let separate = Method::cop_td3().bound(IndependentMin);
/// assert_eq!(separate.critics, Ensemble::Separate { cost: 2, reward: 2 });
/// // ... unless you choose others.
/// assert_eq!(Method::cop_td3().critics(Ensemble::Joint(5)).critics, Ensemble::Joint(5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Ensemble {
    /// N + 1 critics of all N values: the fewest that can disagree in N directions.
    Spanning,
    /// This many critics of all N values.
    Joint(usize),
    /// Scalar critics, a given number for each cost and another for each reward.
    Separate {
        /// Critics of each cost.
        cost: usize,
        /// Critics of each reward.
        reward: usize,
    },
}

impl Ensemble {
    /// Builds the networks for a task with a backend; fresh weights come from `rng`.
    pub fn build(
        self,
        backend: &dyn Backend,
        spec: &EnvSpec,
        networks: &Networks,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        let objectives = spec.objectives.len();
        match self {
            Self::Spanning => backend.critics(spec, networks, objectives + 1, rng),
            Self::Joint(count) => backend.critics(spec, networks, count, rng),
            Self::Separate { .. } => {
                let counts = self.scalars(spec);
                let scalars = backend.critics(&scalar(spec), networks, counts.iter().sum(), rng)?;
                Ok(Box::new(SeparateCritics::new(scalars, &counts)?))
            }
        }
    }

    /// The number of networks.
    pub(crate) fn count(self, spec: &EnvSpec) -> usize {
        match self {
            Self::Spanning => spec.objectives.len() + 1,
            Self::Joint(count) => count,
            Self::Separate { .. } => self.scalars(spec).into_iter().fold(0, usize::saturating_add),
        }
    }

    /// An error if a drawn subset (REDQ) could hold one network twice.
    pub(crate) fn check_subset(self, spec: &EnvSpec) -> Result<()> {
        equal_counts(&self.scalars(spec))
    }

    /// The number of scalar critics of each objective; empty if critics are of all values.
    fn scalars(self, spec: &EnvSpec) -> Vec<usize> {
        let Self::Separate { cost, reward } = self else { return Vec::new() };
        let count = |objective: &Objective| if objective.is_cost() { cost } else { reward };
        spec.objectives.iter().map(count).collect()
    }
}

/// The same environment with one value to learn.
fn scalar(spec: &EnvSpec) -> EnvSpec {
    EnvSpec { objectives: vec![Objective::reward("value", 1.0)], entropy: None, ..spec.clone() }
}
