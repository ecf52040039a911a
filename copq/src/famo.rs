//! FAMO: weights for the objectives' critic losses, so that every objective's log-loss falls at a
//! similar rate.

use serde::{Deserialize, Serialize};

use crate::adam::Adam;
use crate::error::check_not_negative;
use crate::{Result, State};

/// FAMO's constants.
///
/// ```
/// use copq::{FamoConfig, FamoDecay, Method};
///
/// let famo = FamoConfig { decay: FamoDecay::L2, ..FamoConfig::default() };
/// let method = Method::cop_td3().balance(famo);
/// assert_eq!(method.config.famo, Some(famo));
/// assert_eq!(famo.lr, 0.025);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FamoConfig {
    /// Adam's step size on the logits.
    pub lr: f64,
    /// How strongly the logits are drawn back to zero.
    pub weight_decay: f64,
    /// Where that decay acts.
    pub decay: FamoDecay,
    /// Whether FAMO also balances losses that share no network
    /// ([`SeparateCritics`](crate::SeparateCritics)), as in the paper's comparison. Otherwise it is
    /// off for them: Adam undoes the scale of such a loss.
    pub separate: bool,
}

/// Where the decay of FAMO's logits acts. The paper names AdamW, but takes the decay from code that
/// uses Adam with L2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FamoDecay {
    /// Beside Adam's step (AdamW, paper Table D.1). A step of 0.025 then meets a decay of 2.5e-5 of
    /// the logit: in long runs, the logits can drift until one objective hardly learns.
    #[default]
    Decoupled,
    /// In the gradient, before Adam divides by its size, following the code of FAMO's authors. The
    /// gradients are small, so this keeps the logits together.
    L2,
}

impl Default for FamoConfig {
    /// Step size 0.025, decoupled weight decay 0.001 (paper Table D.1), for losses that share
    /// networks.
    fn default() -> Self {
        Self { lr: 0.025, weight_decay: 0.001, decay: FamoDecay::Decoupled, separate: false }
    }
}

impl FamoConfig {
    pub(crate) fn check(&self) -> Result<()> {
        check_not_negative("famo.lr", self.lr)?;
        check_not_negative("famo.weight_decay", self.weight_decay)
    }
}

const LOSS_EPS: f64 = 1e-8;

/// Fast adaptive multitask optimisation (Liu et al., NeurIPS 2023): one logit per objective,
/// stepped by how much each objective's loss improved in the last update.
///
/// ```
/// use copq::{Famo, FamoConfig};
///
/// let mut famo = Famo::new(FamoConfig::default(), 2)?;
/// let mut weights = [0.0; 2];
/// famo.weigh(&[1.0, 4.0], &mut weights); // a loss four times as large has a quarter of the weight
/// assert!((weights[0] - 0.8).abs() < 1e-6 && (weights[1] - 0.2).abs() < 1e-6);
///
/// famo.step(&[1.0, 4.0], &[0.5, 4.0]); // the first loss has halved: it can wait
/// assert!(famo.logits()[0] < famo.logits()[1]);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Famo {
    logits: Vec<f64>,
    adam: Adam,
    /// The factor of the logits in the gradient.
    l2: f64,
    softmax: Vec<f64>,
    improvement: Vec<f64>,
}

impl Famo {
    /// Equal weights for `objectives` losses.
    pub fn new(config: FamoConfig, objectives: usize) -> Result<Self> {
        config.check()?;
        let zeros = vec![0.0; objectives];
        let (decoupled, l2) = match config.decay {
            FamoDecay::Decoupled => (config.weight_decay, 0.0),
            FamoDecay::L2 => (0.0, config.weight_decay),
        };
        Ok(Self {
            logits: zeros.clone(),
            adam: Adam::new(config.lr, decoupled, objectives),
            l2,
            softmax: vec![1.0 / objectives as f64; objectives],
            improvement: zeros,
        })
    }

    /// The logits xi, one per objective.
    pub fn logits(&self) -> &[f64] {
        &self.logits
    }

    /// The weights omega_i of the losses' gradients for these losses: positive, summing to one,
    /// `omega_i ~ softmax(xi)_i / loss_i`, so that `sum omega_i grad l_i` descends
    /// `sum softmax(xi)_i log l_i`.
    pub fn weigh(&mut self, losses: &[f64], weights: &mut [f64]) {
        self.refresh_softmax();
        for ((weight, z), loss) in weights.iter_mut().zip(&self.softmax).zip(losses) {
            *weight = z / (loss + LOSS_EPS);
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
    }

    /// One Adam step of the logits from the losses before and after the critics' step, on the same
    /// batch and targets: an objective whose log-loss fell more than the others' loses weight.
    pub fn step(&mut self, before: &[f64], after: &[f64]) {
        self.refresh_softmax();
        for ((delta, before), after) in self.improvement.iter_mut().zip(before).zip(after) {
            *delta = libm::log(before + LOSS_EPS) - libm::log(after + LOSS_EPS);
        }
        let mean: f64 =
            self.softmax.iter().zip(&self.improvement).map(|(z, delta)| z * delta).sum();
        let Self { adam, l2, logits, softmax, improvement } = self;
        adam.step(logits, |i, logit| softmax[i] * (improvement[i] - mean) + *l2 * logit);
    }

    fn refresh_softmax(&mut self) {
        let max = self.logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (z, logit) in self.softmax.iter_mut().zip(&self.logits) {
            *z = libm::exp(logit - max);
        }
        let sum: f64 = self.softmax.iter().sum();
        self.softmax.iter_mut().for_each(|z| *z /= sum);
    }

    /// Writes logits and optimiser state.
    pub fn save(&self, state: &mut State) {
        state.put("logits", self.logits.as_slice());
        self.adam.save(state);
    }

    /// Restores what [`Famo::save`] wrote.
    pub fn load(&mut self, state: &State) -> Result<()> {
        state.read("logits", &mut self.logits)?;
        self.adam.load(state)
    }
}

#[cfg(test)]
mod tests {
    use approx::{abs_diff_eq, assert_abs_diff_eq};

    use super::*;

    /// The numbers were computed independently from the method's equations.
    #[test]
    fn fixture() {
        let mut famo = Famo::new(FamoConfig::default(), 2).unwrap();
        let mut weights = [0.0; 2];
        famo.weigh(&[2.0, 0.5], &mut weights);
        // The fixture leaves out the 1e-8 that guards the logarithm; it moves the weights by 2e-9.
        assert_abs_diff_eq!(weights[..], [0.2, 0.8][..], epsilon = 1e-8);
        famo.step(&[2.0, 0.5], &[1.6, 0.49]);
        let improvement = [0.2231435501, 0.0202027069];
        assert_abs_diff_eq!(famo.improvement[..], improvement[..], epsilon = 1e-9);
        let logits = [-0.0249999951, 0.0249999951];
        assert_abs_diff_eq!(*famo.logits(), logits[..], epsilon = 1e-9);
    }

    /// Each of the two decays, against AdamW and Adam written out for three steps.
    #[test]
    fn decay_acts_beside_the_step_or_before_it() {
        for decay in [FamoDecay::Decoupled, FamoDecay::L2] {
            let mut famo =
                Famo::new(FamoConfig { lr: 0.1, weight_decay: 0.5, decay, separate: false }, 2)
                    .unwrap();
            let mut logits = [0.0; 2];
            let mut m = [0.0; 2];
            let mut v = [0.0; 2];
            for step in 1..=3 {
                let improvement = [0.4 * f64::from(step), 0.1];
                let after = improvement.map(|delta: f64| (-delta).exp());
                famo.step(&[1.0, 1.0], &after);
                let sum: f64 = logits.iter().map(|x: &f64| x.exp()).sum();
                let z = logits.map(|x| x.exp() / sum);
                let mean = z[0] * improvement[0] + z[1] * improvement[1];
                for i in 0..2 {
                    let l2 = if decay == FamoDecay::L2 { 0.5 * logits[i] } else { 0.0 };
                    let grad = z[i] * (improvement[i] - mean) + l2;
                    m[i] = 0.9 * m[i] + 0.1 * grad;
                    v[i] = 0.999 * v[i] + 0.001 * grad * grad;
                    let direction = m[i]
                        / (1.0 - 0.9f64.powi(step))
                        / ((v[i] / (1.0 - 0.999f64.powi(step))).sqrt());
                    let beside = if decay == FamoDecay::Decoupled { 0.5 * logits[i] } else { 0.0 };
                    logits[i] -= 0.1 * (direction + beside);
                }
            }
            let close = abs_diff_eq!(*famo.logits(), logits[..], epsilon = 1e-6);
            assert!(close, "{decay:?}: {:?}, not {logits:?}", famo.logits());
        }
    }

    /// A constant pull on unequal losses: decoupled decay lets the logits run, L2 holds them.
    #[test]
    fn only_l2_holds_the_logits_together() {
        let range = |decay| {
            let mut famo = Famo::new(FamoConfig { decay, ..Default::default() }, 2).unwrap();
            (0..5_000).for_each(|_| famo.step(&[1.0, 1.0], &[0.999, 1.0]));
            famo.logits()[1] - famo.logits()[0]
        };
        assert!(range(FamoDecay::Decoupled) > 5.0, "{}", range(FamoDecay::Decoupled));
        assert!(range(FamoDecay::L2) < 1.0, "{}", range(FamoDecay::L2));
    }

    #[test]
    fn one_objective_always_has_weight_one() {
        let mut famo = Famo::new(FamoConfig::default(), 1).unwrap();
        let mut weights = [0.0];
        famo.step(&[3.0], &[1.0]);
        famo.weigh(&[7.0], &mut weights);
        assert_eq!(weights, [1.0]);
        assert_eq!(famo.logits(), [0.0]);
    }

    #[test]
    fn bad_constants_are_errors() {
        let error = Famo::new(FamoConfig { lr: f64::NAN, ..Default::default() }, 2).unwrap_err();
        assert!(error.to_string().contains("famo.lr"), "{error}");
    }
}
