//! SAC's entropy bonus: its weight is the temperature alpha, learned so that the policy keeps a
//! given entropy.

use serde::{Deserialize, Serialize};

use crate::adam::Adam;
use crate::error::{check_not_negative, check_positive};
use crate::{EnvSpec, Error, Result, State};

/// The entropy bonus of a stochastic policy.
///
/// ```
/// use copq::{Entropy, Method};
///
/// let mut method = Method::sac();
/// assert_eq!(method.config.entropy, Some(Entropy::default()));
/// // A fixed temperature.
/// method.config.entropy = Some(Entropy { temperature: 0.2, lr: 0.0, ..Entropy::default() });
/// method.config.check()?;
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Entropy {
    /// The initial temperature.
    pub temperature: f64,
    /// Adam's step size on its logarithm; 0 keeps the temperature fixed.
    pub lr: f64,
    /// The target entropy, in nats for actions in [-1, 1]; by default minus the action's length.
    pub target: Option<f64>,
    /// The objective that the bonus is added to; by default the one that the task names
    /// ([`EnvSpec::entropy`]).
    pub objective: Option<String>,
}

impl Default for Entropy {
    /// Initial temperature 1, step size 5e-4 (paper Table D.3).
    fn default() -> Self {
        Self { temperature: 1.0, lr: 5e-4, target: None, objective: None }
    }
}

impl Entropy {
    /// An error for numbers that no task can use.
    pub(crate) fn check(&self) -> Result<()> {
        check_positive("entropy.temperature", self.temperature)?;
        check_not_negative("entropy.lr", self.lr)
    }
}

/// alpha, and what is needed to learn it.
#[derive(Clone, Debug)]
pub(crate) struct Temperature {
    log_alpha: [f64; 1],
    target: f64,
    objective: usize,
    adam: Adam,
}

impl Temperature {
    /// The temperature for a task's policy.
    pub(crate) fn new(entropy: &Entropy, spec: &EnvSpec) -> Result<Self> {
        entropy.check()?;
        let target = entropy.target.unwrap_or(-(spec.action_len() as f64));
        // That of uniform actions. An unreachable target would raise the temperature for ever.
        let most = spec.action_len() as f64 * std::f64::consts::LN_2;
        if !(target.is_finite() && target < most) {
            return Err(Error::invalid(
                "entropy.target",
                format!("less than {most:.2}, the most there can be"),
                target,
            ));
        }
        Ok(Self {
            log_alpha: [libm::log(entropy.temperature)],
            target,
            objective: objective(entropy, spec)?,
            adam: Adam::new(entropy.lr, 0.0, 1),
        })
    }

    /// The temperature.
    pub(crate) fn alpha(&self) -> f64 {
        libm::exp(self.log_alpha[0])
    }

    /// The objective whose value includes the bonus.
    pub(crate) fn objective(&self) -> usize {
        self.objective
    }

    /// One step down `alpha * mean(-log pi - target)` (Haarnoja et al. 2018, eq. 18): up when the
    /// entropy is too small.
    pub(crate) fn update(&mut self, mean_log_prob: f64) {
        let grad = self.alpha() * (-mean_log_prob - self.target);
        self.adam.step(&mut self.log_alpha, |_, _| grad);
    }

    /// Writes temperature and optimiser state.
    pub(crate) fn save(&self, state: &mut State) {
        state.put("log_alpha", self.log_alpha);
        self.adam.save(state);
    }

    /// Restores what [`Temperature::save`] wrote.
    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        state.read("log_alpha", &mut self.log_alpha)?;
        self.adam.load(state)
    }
}

/// The position of the objective that the bonus is added to, a reward of positive weight.
fn objective(entropy: &Entropy, spec: &EnvSpec) -> Result<usize> {
    let names = spec.names();
    let found = match &entropy.objective {
        Some(name) => Some(
            names
                .iter()
                .position(|known| known == name)
                .ok_or_else(|| Error::unknown("objective for the entropy bonus", name, &names))?,
        ),
        None => spec.entropy_objective(),
    };
    match found {
        Some(i) if spec.limit(i).is_none() && spec.objectives[i].weight > 0.0 => Ok(i),
        Some(i) => Err(Error::invalid(
            "the entropy bonus's objective",
            "a reward with a positive weight",
            names[i],
        )),
        None => Err(Error::invalid("the entropy bonus's objective", "a reward", "only costs")),
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;
    use crate::Objective;

    fn spec() -> EnvSpec {
        let cost = Objective::cost("cost", 10.0).weight(-1.0);
        EnvSpec::new("test", 1, 3)
            .objective(cost)
            .reward("speed", 1.0)
            .reward("effort", 0.5)
            .horizon(100)
    }

    #[test]
    fn too_little_entropy_raises_the_temperature_and_too_much_lowers_it() {
        let step = |mean_log_prob| {
            let mut temperature = Temperature::new(&Entropy::default(), &spec()).unwrap();
            temperature.update(mean_log_prob);
            temperature.alpha()
        };
        // The entropy to hold is -3, so a log-probability of 3 is just right; Adam's first step is
        // its step size.
        assert_abs_diff_eq!(libm::log(step(3.5)), 5e-4, epsilon = 1e-9);
        assert_abs_diff_eq!(libm::log(step(2.5)), -5e-4, epsilon = 1e-9);
        assert_eq!(step(3.0), 1.0);
    }

    #[test]
    fn the_bonus_goes_on_a_reward() {
        let on = |name: Option<&str>| {
            objective(&Entropy { objective: name.map(String::from), ..Default::default() }, &spec())
        };
        assert_eq!((on(None).unwrap(), on(Some("speed")).unwrap()), (2, 1));
        let error = on(Some("cost")).unwrap_err().to_string();
        assert_eq!(
            error,
            "the entropy bonus's objective: wanted a reward with a positive weight, got cost"
        );
        assert!(on(Some("sped")).unwrap_err().to_string().contains("'sped'; known: speed,"));
        let named = EnvSpec { entropy: Some("speed".into()), ..spec() };
        assert_eq!(
            objective(&Entropy::default(), &named).unwrap(),
            1,
            "what the task names comes before the last"
        );
    }

    #[test]
    fn an_entropy_out_of_reach_is_refused() {
        let of = |target| {
            Temperature::new(&Entropy { target: Some(target), ..Default::default() }, &spec())
        };
        assert!(of(2.0).is_ok());
        let error = of(2.1).unwrap_err().to_string();
        assert_eq!(error, "entropy.target: wanted less than 2.08, the most there can be, got 2.1");
    }
}
