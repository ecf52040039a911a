//! Lagrange multipliers learned by gradient ascent, plain or augmented.

use serde::{Deserialize, Serialize};

use super::Multiplier;
use super::costs::Costs;
use crate::adam::Adam;
use crate::error::{check_not_negative, check_positive};
use crate::{EnvSpec, Error, Observer, Result, State};

/// Constants of [`Lagrangian`].
///
/// ```
/// use copq::{Constraint, LagrangianConfig, Method};
///
/// // The plain Lagrangian, without CAL's quadratic term.
/// let plain = LagrangianConfig { augmentation: 0.0, ..LagrangianConfig::default() };
/// let method = Method::cop_cal().constrain(Constraint::Lagrangian(plain));
/// assert_eq!((plain.multiplier, plain.lr), (1.0, 5e-4));
/// assert_eq!(method.config.constraint, Some(Constraint::Lagrangian(plain)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LagrangianConfig {
    /// The initial lambda.
    pub multiplier: f64,
    /// Adam's step size on log lambda.
    pub lr: f64,
    /// c, the strength of the augmented Lagrangian's quadratic term; 0 for the plain Lagrangian.
    pub augmentation: f64,
    /// The largest lambda, which it reaches if a limit cannot be met.
    pub cap: f64,
}

impl Default for LagrangianConfig {
    /// An initial lambda of 1, a step size of 5e-4 (paper Table D.3), CAL's c = 10, and our own cap
    /// of 1e6. Without a cap, lambda grows without bound if a limit cannot be met, until squares of
    /// gradients overflow.
    fn default() -> Self {
        Self { multiplier: 1.0, lr: 5e-4, augmentation: 10.0, cap: 1e6 }
    }
}

impl LagrangianConfig {
    pub(super) fn check(&self) -> Result<()> {
        check_positive("lagrangian.multiplier", self.multiplier)?;
        check_positive("lagrangian.cap", self.cap)?;
        if self.multiplier > self.cap {
            let wanted = format!("at most the cap, {}", self.cap);
            return Err(Error::invalid("lagrangian.multiplier", wanted, self.multiplier));
        }
        check_not_negative("lagrangian.lr", self.lr)?;
        check_not_negative("lagrangian.augmentation", self.augmentation)
    }
}

/// A multiplier lambda for each cost. Its logarithm is learned by gradient ascent on
/// `lambda (Q_c - limit)`, where Q_c is the pessimistic cost of the replayed actions (CAL, Wu et
/// al. 2024).
///
/// Projections see the direction (-lambda, 1). The actor's weight is that of the augmented
/// Lagrangian, `lambda - min(c (limit - Q_c), lambda) = max(0, lambda + c (Q_c - limit))`, next to
/// the raw weights of the rewards.
///
/// How cautious COP-Q is about cost and reward therefore depends on lambda: the cost's margin is
/// its standard deviation times `lambda / sqrt(1 + lambda^2)`, a tenth of it for lambda = 0.1. If c
/// is so large that the estimate's noise outweighs lambda, the augmented term enforces the limit by
/// itself and lambda falls to nothing; DESIGN.md has a measured case.
///
/// ```
/// use copq::{EnvSpec, Lagrangian, LagrangianConfig, Multiplier};
///
/// // The discount is 1, so that limits are compared as they are.
/// let spec = EnvSpec::new("cart", 2, 1).cost("speed", 100.0).reward("progress", 1.0);
/// let mut lagrangian = Lagrangian::new(LagrangianConfig::default(), &spec, 1.0)?;
/// lagrangian.observe(&[103.0, 7.0]); // the cost is 3 above its limit
/// assert_eq!(lagrangian.weights(), [-1.0, 1.0]); // lambda is 1
/// assert_eq!(lagrangian.actor_weights(), [-31.0, 1.0]); // 1 + c 3
///
/// lagrangian.update();
/// assert!(lagrangian.weights()[0] < -1.0); // lambda has grown
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Lagrangian {
    augmentation: f64,
    cap: f64,
    log_lambda: Vec<f64>,
    adam: Adam,
    costs: Costs,
}

impl Lagrangian {
    /// A multiplier for each of a task's costs; an error if it has none.
    pub fn new(config: LagrangianConfig, spec: &EnvSpec, discount: f64) -> Result<Self> {
        config.check()?;
        let costs = Costs::new(spec, discount)?;
        let mut new = Self {
            augmentation: config.augmentation,
            cap: config.cap,
            log_lambda: vec![libm::log(config.multiplier); costs.len()],
            adam: Adam::new(config.lr, 0.0, costs.len()),
            costs,
        };
        new.refresh_weights();
        new.refresh_actor_weights();
        Ok(new)
    }

    /// The i-th cost's lambda.
    fn lambda(&self, i: usize) -> f64 {
        libm::exp(self.log_lambda[i])
    }

    fn refresh_weights(&mut self) {
        for i in 0..self.costs.len() {
            self.costs.set_weight(i, self.lambda(i));
        }
    }

    fn refresh_actor_weights(&mut self) {
        for i in 0..self.costs.len() {
            let effective = self.lambda(i) + self.augmentation * self.costs.violation(i);
            self.costs.set_actor_weight(i, effective.max(0.0));
        }
    }
}

impl Multiplier for Lagrangian {
    fn weights(&self) -> &[f32] {
        &self.costs.weights
    }

    fn actor_weights(&self) -> &[f64] {
        &self.costs.actor_weights
    }

    fn observe(&mut self, bound: &[f32]) {
        self.costs.observe(bound);
        self.refresh_actor_weights();
    }

    fn update(&mut self) {
        let Self { adam, log_lambda, costs, .. } = self;
        adam.step(log_lambda, |i, log_lambda| -libm::exp(log_lambda) * costs.violation(i));
        let most = libm::log(self.cap);
        log_lambda.iter_mut().for_each(|log_lambda| *log_lambda = log_lambda.min(most));
        self.refresh_weights();
    }

    fn log(&self, step: u64, log: &mut dyn Observer) {
        self.costs.log(step, log, |i| self.lambda(i));
    }

    fn save(&self, state: &mut State) {
        state.put("log_lambda", self.log_lambda.as_slice());
        // From the last estimate, and from lambda before its last step.
        state.put("effective", self.costs.effective());
        self.adam.save(state);
    }

    fn load(&mut self, state: &State) -> Result<()> {
        state.read("log_lambda", &mut self.log_lambda)?;
        self.adam.load(state)?;
        self.refresh_weights();
        let mut effective = self.costs.effective();
        state.read("effective", &mut effective)?;
        effective.iter().enumerate().for_each(|(i, &value)| self.costs.set_actor_weight(i, value));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use approx::assert_abs_diff_eq;

    use super::*;

    /// A reward, then two costs with limits of 100 and 10; the discount is 1, so that limits are
    /// compared as they are.
    fn of_two(config: LagrangianConfig) -> Lagrangian {
        let spec = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
        let spec = spec.cost("speed", 100.0).cost("heat", 10.0);
        Lagrangian::new(config, &spec, 1.0).unwrap()
    }

    /// A multiplier that looks at the other cost would hold the wrong limit.
    #[test]
    fn each_cost_has_a_multiplier_by_its_own_estimate_and_limit() {
        let config = LagrangianConfig { augmentation: 0.25, lr: 0.5, ..Default::default() };
        let mut lagrangian = of_two(config);
        lagrangian.observe(&[7.0, 103.0, 8.0]); // 3 over, and 2 under
        assert_eq!(lagrangian.weights(), [1.0, -1.0, -1.0]);
        assert_eq!(lagrangian.actor_weights(), [1.0, -1.75, -0.5]);
        let mut seen = BTreeMap::new();
        lagrangian.log(0, &mut |_: u64, name: &str, value: f64| {
            seen.insert(name.to_owned(), value);
        });
        let of = |kind: &str| ["speed", "heat"].map(|cost| seen[&format!("{kind}/{cost}")]);
        assert_eq!(of("cost_estimate"), [103.0, 8.0]);
        assert_eq!(of("cost_violation"), [3.0, -2.0]);
        assert_eq!(of("multiplier_effective"), [1.75, 0.5]);

        // Adam's first step is its step size.
        lagrangian.update();
        let [reward, speed, heat] = *lagrangian.weights() else { panic!("three objectives") };
        assert_eq!(reward, 1.0);
        assert_abs_diff_eq!([speed, heat][..], [-1.648_721, -0.606_531][..], epsilon = 1e-6);
        let mut state = State::default();
        lagrangian.save(&mut state);
        let mut loaded = of_two(config);
        loaded.load(&state).unwrap();
        assert_eq!(loaded.weights(), lagrangian.weights());
        assert_eq!(loaded.actor_weights(), lagrangian.actor_weights());
    }

    /// A gradient without lambda would move a small multiplier as if it were 1: only where lambda
    /// is far from 1 and the gradients change does Adam tell the two apart.
    #[test]
    fn three_steps_are_adams_on_the_logarithm() {
        let config = LagrangianConfig { multiplier: 0.05, lr: 0.3, ..Default::default() };
        let mut lagrangian = of_two(config);
        let mut log_lambda = [libm::log(0.05); 2];
        let [mut m, mut v] = [[0.0; 2]; 2];
        for (t, over) in [[3.0, -2.0], [-0.5, -4.0], [7.0, 1.0]].into_iter().enumerate() {
            lagrangian.observe(&[0.0, 100.0 + over[0], 10.0 + over[1]]);
            lagrangian.update();
            for i in 0..2 {
                let grad = -log_lambda[i].exp() * f64::from(over[i]);
                m[i] = 0.9 * m[i] + 0.1 * grad;
                v[i] = 0.999 * v[i] + 0.001 * grad * grad;
                let [c1, c2] = [0.9f64, 0.999].map(|beta| 1.0 - beta.powi(t as i32 + 1));
                log_lambda[i] -= 0.3 * (m[i] / c1) / ((v[i] / c2).sqrt() + 1e-8);
                assert_abs_diff_eq!(lagrangian.log_lambda[i], log_lambda[i], epsilon = 1e-12);
            }
        }
    }
}
