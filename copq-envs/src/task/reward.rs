//! Rewards as sums of a few signals, so that a task is data and not code.

use copq::{Error, Result};

use crate::{Field, Readings};

/// A quantity of one environment step.
///
/// ```
/// use copq_envs::Readings;
/// use copq_envs::task::{Motion, Signal, SignalSum};
///
/// // A step backwards and to the side.
/// let readings = &Readings::default();
/// let velocity = [-3.0, 4.0];
/// let motion = Motion { healthy: true, velocity, control: 0.2, motor_control: 0.1, readings };
/// let value = |signal| SignalSum::new("one", 1.0).plus(1.0, signal).reward(&motion);
/// let signals = [Signal::Velocity, Signal::ForwardSpeed, Signal::Speed];
/// assert_eq!(signals.map(value), [-3.0, 3.0, 5.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Signal {
    /// 1 if the robot is healthy after the step, else 0.
    Healthy,
    /// 1 on every step, including the one that ends unhealthy.
    Alive,
    /// Signed forward velocity (m/s): the change of x over the step, divided by the step's length.
    Velocity,
    /// Absolute value of the forward velocity (m/s).
    ForwardSpeed,
    /// Speed in the x-y plane (m/s); for a planar robot, the absolute value of its forward
    /// velocity.
    Speed,
    /// Sum of the squared actions, each clamped to [-1, 1].
    Control,
    /// Sum of the squared controls: the clamped actions in the motors' own units.
    MotorControl,
    /// Sum of the squared contact forces and torques (N^2, N^2 m^2) of all bodies. Each number is
    /// clipped to [-clip, clip] and the sum to `cap`; either may be infinite.
    Contact {
        /// Bound of every number.
        clip: f64,
        /// Bound of the sum.
        cap: f64,
    },
}

impl Signal {
    /// The field it is computed from, if any.
    pub fn field(self) -> Option<Field> {
        matches!(self, Self::Contact { .. }).then_some(Field::ContactForce)
    }
}

/// One component of the reward vector: a sum of factor x signal.
///
/// ```
/// use copq_envs::task::{Signal, SignalSum};
///
/// // A cost for your own task. It comes first.
/// let mut task = copq_envs::task("gym/hopper")?;
/// let cost = SignalSum::new("energy", 0.0).plus(1.0, Signal::Control).limit(200.0);
/// task.objectives.insert(0, cost);
/// assert_eq!(task.env_spec().names(), ["energy", "reward"]);
/// assert_eq!(task.env_spec().limit(0), Some(200.0));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SignalSum {
    /// Its name, such as `safety`.
    pub name: String,
    /// Its weight in the task's total return, not normalised; 0 for a cost, whose weight is a
    /// multiplier that the learner finds.
    pub weight: f32,
    /// Factors and signals.
    pub terms: Vec<(f64, Signal)>,
    /// For a cost: the limit that its undiscounted sum over an episode must not exceed.
    pub limit: Option<f64>,
}

/// What happened in one step.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Whether the robot is healthy after the step.
    pub healthy: bool,
    /// Velocity along x and y (m/s).
    pub velocity: [f64; 2],
    /// Sum of the squared, clamped actions.
    pub control: f64,
    /// Sum of the squared controls.
    pub motor_control: f64,
    /// What the engine reported after the step.
    pub readings: &'a Readings,
}

impl SignalSum {
    /// An empty sum, without a limit.
    pub fn new(name: &str, weight: f32) -> Self {
        Self { name: name.into(), weight, terms: Vec::new(), limit: None }
    }

    /// Adds a term.
    pub fn plus(mut self, factor: f64, signal: Signal) -> Self {
        self.terms.push((factor, signal));
        self
    }

    /// Makes it a cost, whose undiscounted sum over an episode must not exceed `limit`.
    pub fn limit(self, limit: f64) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// An error for a factor that is not finite, or a bound that is negative or NaN.
    pub(crate) fn check(&self) -> Result<()> {
        for (factor, signal) in &self.terms {
            let wrong = |wanted: &str| {
                let got = format!("{factor} x {signal:?}");
                Err(Error::invalid(format!("objective '{}'", self.name), wanted, got))
            };
            if !factor.is_finite() {
                return wrong("finite factors");
            }
            if let Signal::Contact { clip, cap } = signal
                && !(*clip >= 0.0 && *cap >= 0.0)
            {
                return wrong("a clip and a cap of 0 or more");
            }
        }
        Ok(())
    }

    /// The reward for a step, unweighted.
    pub fn reward(&self, motion: &Motion<'_>) -> f64 {
        self.terms.iter().map(|(factor, signal)| factor * motion.value(*signal)).sum()
    }
}

impl Motion<'_> {
    fn value(&self, signal: Signal) -> f64 {
        match signal {
            Signal::Healthy => f64::from(u8::from(self.healthy)),
            Signal::Alive => 1.0,
            Signal::Velocity => self.velocity[0],
            Signal::ForwardSpeed => self.velocity[0].abs(),
            Signal::Speed => self.velocity[0].hypot(self.velocity[1]),
            Signal::Control => self.control,
            Signal::MotorControl => self.motor_control,
            Signal::Contact { clip, cap } => {
                let forces = self.readings.get(Field::ContactForce).iter();
                forces.map(|force| force.clamp(-clip, clip).powi(2)).sum::<f64>().min(cap)
            }
        }
    }
}
