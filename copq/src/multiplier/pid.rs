//! Multipliers set by a PID controller on the constraint's violation.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::Multiplier;
use super::costs::Costs;
use crate::error::{check_count, check_not_negative};
use crate::{EnvSpec, Error, Observer, Result, State};

/// Share of the past in the smoothed error and cost.
const SMOOTHING: f64 = 0.95;

/// Constants of [`Pid`]; gains are per unit of an episode's cost.
///
/// ```
/// use copq::{Constraint, Method, PidConfig};
///
/// let firm = PidConfig { integral: 1e-6, cap: 10.0, ..PidConfig::default() };
/// let method = Method::sac_pid().constrain(Constraint::Pid(firm));
/// assert_eq!(method.config.constraint, Some(Constraint::Pid(firm)));
/// assert_eq!(firm.delay, 10);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PidConfig {
    /// Gain on the smoothed violation.
    pub proportional: f64,
    /// Gain on the violation's sum.
    pub integral: f64,
    /// Gain on the rise of the smoothed cost.
    pub derivative: f64,
    /// The initial integral.
    pub multiplier: f64,
    /// Updates over which the rise is measured.
    pub delay: usize,
    /// The largest multiplier; `inf` for none.
    pub cap: f64,
    /// The largest integral; `inf` for none.
    pub integral_cap: f64,
}

impl Default for PidConfig {
    /// OmniSafe's SACPID: gains of 1e-6, 1e-7 and 1e-7 per update, a delay of 10, and a cap of 100
    /// on the multiplier.
    fn default() -> Self {
        Self {
            proportional: 1e-6,
            integral: 1e-7,
            derivative: 1e-7,
            multiplier: 0.001,
            delay: 10,
            cap: 100.0,
            integral_cap: f64::INFINITY,
        }
    }
}

/// `lambda = max(0, Kp e + I + Kd max(0, rise))` for each cost (Stooke et al. 2020). Here e is the
/// smoothed violation of the pessimistic cost estimate, I is the violation's running sum times its
/// gain, never negative, and the rise is that of the smoothed cost over `delay` updates. All are in
/// units of an episode's cost.
///
/// ```
/// use copq::{EnvSpec, Multiplier, Pid, PidConfig};
///
/// // The integral alone. The discount is 1, so that limits are compared as they are.
/// let spec = EnvSpec::new("cart", 2, 1).cost("speed", 100.0).reward("progress", 1.0);
/// let mut config = PidConfig { proportional: 0.0, derivative: 0.0, ..PidConfig::default() };
/// (config.integral, config.multiplier) = (0.5, 0.0);
/// let mut pid = Pid::new(config, &spec, 1.0)?;
/// pid.observe(&[103.0, 7.0]); // the cost is 3 above its limit
/// pid.update();
/// assert_eq!(pid.weights(), [-1.5, 1.0]);
/// pid.update();
/// assert_eq!(pid.weights(), [-3.0, 1.0]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Pid {
    config: PidConfig,
    costs: Costs,
    controllers: Vec<Controller>,
}

/// The controller of one multiplier.
#[derive(Clone, Debug)]
pub(crate) struct Controller {
    integral: f64,
    error: f64,
    cost: f64,
    /// The smoothed costs of the last updates, oldest first.
    past: VecDeque<f64>,
    pub(crate) lambda: f64,
}

impl Controller {
    /// One whose multiplier is `lambda` until its first update.
    pub(crate) fn new(config: &PidConfig, lambda: f64) -> Self {
        Self { integral: config.multiplier, error: 0.0, cost: 0.0, past: [0.0].into(), lambda }
    }

    /// Learns from a cost and how far it is above its limit.
    pub(crate) fn update(&mut self, config: &PidConfig, cost: f64, violation: f64) {
        let integral = self.integral + config.integral * violation;
        self.integral = integral.clamp(0.0, config.integral_cap);
        self.error = SMOOTHING * self.error + (1.0 - SMOOTHING) * violation;
        self.cost = SMOOTHING * self.cost + (1.0 - SMOOTHING) * cost;
        let rise = (self.cost - self.past.front().copied().unwrap_or(0.0)).max(0.0);
        let sum = config.proportional * self.error + self.integral + config.derivative * rise;
        self.lambda = sum.clamp(0.0, config.cap);
        // A run saved with a longer delay has more of them.
        while self.past.len() >= config.delay {
            self.past.pop_front();
        }
        self.past.push_back(self.cost);
    }

    pub(crate) fn save(&self, state: &mut State) {
        state.put("numbers", [self.integral, self.error, self.cost, self.lambda]);
        state.put("past", self.past.iter().copied().collect::<Vec<f64>>());
    }

    pub(crate) fn load(&mut self, state: &State) -> Result<()> {
        let mut numbers = [0.0; 4];
        state.read("numbers", &mut numbers)?;
        [self.integral, self.error, self.cost, self.lambda] = numbers;
        self.past.clear();
        self.past.extend(state.get::<f64>("past")?);
        Ok(())
    }
}

impl PidConfig {
    /// OmniSafe's CPPOPID, which learns once per epoch: gains of 0.1, 0.01 and 0.01, and no cap.
    pub fn cppo_pid() -> Self {
        Self {
            proportional: 0.1,
            integral: 0.01,
            derivative: 0.01,
            cap: f64::INFINITY,
            ..Self::default()
        }
    }

    /// An error that names the first setting that cannot be used.
    pub(crate) fn check(&self) -> Result<()> {
        for (name, value) in [
            ("pid.proportional", self.proportional),
            ("pid.integral", self.integral),
            ("pid.derivative", self.derivative),
            ("pid.multiplier", self.multiplier),
        ] {
            check_not_negative(name, value)?;
        }
        for (name, cap) in [("pid.cap", self.cap), ("pid.integral_cap", self.integral_cap)] {
            if cap.is_nan() || cap < 0.0 {
                return Err(Error::invalid(name, "a number, at least 0, or inf", cap));
            }
        }
        if self.multiplier > self.cap {
            let wanted = format!("at most the cap, {}", self.cap);
            return Err(Error::invalid("pid.multiplier", wanted, self.multiplier));
        }
        check_count("pid.delay", self.delay)
    }
}

impl Pid {
    /// A controller for each of a task's costs; an error if it has none.
    pub fn new(config: PidConfig, spec: &EnvSpec, discount: f64) -> Result<Self> {
        config.check()?;
        let costs = Costs::new(spec, discount)?;
        let controllers = vec![Controller::new(&config, config.multiplier); costs.len()];
        let mut new = Self { config, costs, controllers };
        new.refresh();
        Ok(new)
    }

    fn refresh(&mut self) {
        for (i, controller) in self.controllers.iter().enumerate() {
            self.costs.set_weight(i, controller.lambda);
            self.costs.set_actor_weight(i, controller.lambda);
        }
    }
}

impl Multiplier for Pid {
    fn weights(&self) -> &[f32] {
        &self.costs.weights
    }

    fn actor_weights(&self) -> &[f64] {
        &self.costs.actor_weights
    }

    fn observe(&mut self, bound: &[f32]) {
        self.costs.observe(bound);
    }

    fn update(&mut self) {
        for (i, controller) in self.controllers.iter_mut().enumerate() {
            let [cost, violation] = self.costs.of_episode(i);
            controller.update(&self.config, cost, violation);
        }
        self.refresh();
    }

    fn log(&self, step: u64, log: &mut dyn Observer) {
        self.costs.log(step, log, |i| self.controllers[i].lambda);
    }

    fn save(&self, state: &mut State) {
        for (i, c) in self.controllers.iter().enumerate() {
            c.save(state.child_mut(&format!("controller.{i}")));
        }
    }

    fn load(&mut self, state: &State) -> Result<()> {
        for (i, c) in self.controllers.iter_mut().enumerate() {
            c.load(state.child(&format!("controller.{i}"))?)?;
        }
        self.refresh();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    /// Worked out by hand from OmniSafe's published update, gains 0.1, 0.01 and 0.01, limit 10.
    #[test]
    fn fixture() {
        let config =
            PidConfig { proportional: 0.1, integral: 0.01, derivative: 0.01, ..Default::default() };
        let mut controller = Controller::new(&config, config.multiplier);
        controller.update(&config, 30.0, 20.0);
        // I = 0.201, e = 1, C = 1.5, rise 1.5: 0.1 + 0.201 + 0.015.
        assert_abs_diff_eq!(controller.lambda, 0.316, epsilon = 1e-12);
        controller.update(&config, 0.0, -10.0);
        // I = 0.101, e = 0.45, C = 1.425, rise over the first entry 1.425: 0.045 + 0.101 + 0.01425.
        assert_abs_diff_eq!(controller.lambda, 0.16025, epsilon = 1e-12);
        (0..20).for_each(|_| controller.update(&config, 0.0, -10.0));
        assert_eq!((controller.lambda, controller.past.len()), (0.0, 10));
        // A shorter delay, after loading, forgets what is older.
        controller.update(&PidConfig { delay: 3, ..config }, 0.0, -10.0);
        assert_eq!(controller.past.len(), 3);
    }
    /// A reward, then two costs with limits of 100 and 10.
    fn of_two() -> EnvSpec {
        let spec = EnvSpec::new("cart", 2, 1).reward("progress", 1.0);
        spec.cost("speed", 100.0).cost("heat", 10.0)
    }

    /// A controller that looks at the other cost would hold the wrong limit.
    #[test]
    fn each_cost_has_a_multiplier_by_its_own_estimate_and_limit() {
        let mut config = PidConfig { proportional: 0.0, derivative: 0.0, ..Default::default() };
        (config.integral, config.multiplier) = (0.5, 2.0);
        let spec = of_two();
        let mut pid = Pid::new(config, &spec, 1.0).unwrap();
        pid.observe(&[7.0, 103.0, 9.0]); // 3 over, and 1 under
        for wanted in [[1.0, -3.5, -1.5], [1.0, -5.0, -1.0]] {
            pid.update();
            assert_eq!(pid.weights(), wanted.map(|w| w as f32));
            assert_eq!(pid.actor_weights(), wanted);
        }
        let mut state = State::default();
        pid.save(&mut state);
        let mut loaded = Pid::new(config, &spec, 1.0).unwrap();
        loaded.load(&state).unwrap();
        assert_eq!(loaded.weights(), pid.weights());
    }
    /// A controller that looks at the other cost would brake for its rise.
    #[test]
    fn each_cost_is_held_back_by_its_own_rise() {
        let mut config = PidConfig { proportional: 0.0, integral: 0.0, ..Default::default() };
        (config.derivative, config.multiplier) = (2.0, 0.0);
        let mut pid = Pid::new(config, &of_two(), 1.0).unwrap();
        pid.observe(&[7.0, 103.0, 9.0]);
        pid.update();
        // The smoothed costs have risen from 0 to a twentieth.
        assert_abs_diff_eq!(pid.actor_weights(), &[1.0, -10.3, -0.9][..], epsilon = 1e-12);
    }
}
