//! From a confidence level to the length of a step, and back: Sigma's ellipsoids under the
//! chi-squared law.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::{Error, Result};

/// sqrt(chi2_N^-1(p)), the Mahalanobis radius that holds a share `confidence` of an N-variate
/// normal (paper eq. 5).
///
/// ```
/// use copq::projection::step_length;
///
/// // One objective: 68.27 % lie within one standard deviation.
/// assert!((step_length(0.682689492137, 1)? - 1.0).abs() < 1e-9);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn step_length(confidence: f64, objectives: usize) -> Result<f64> {
    if !(0.0..1.0).contains(&confidence) {
        return Err(Error::invalid(
            "confidence",
            "a probability from 0 up to, not including, 1",
            confidence,
        ));
    }
    let law = law(objectives)?;
    Ok(bisect(|radius| share(&law, radius) < confidence))
}

/// chi2_N(step^2), the share of an N-variate normal within a Mahalanobis radius of |step|:
/// [`step_length`] inverted.
pub fn confidence(step: f64, objectives: usize) -> Result<f64> {
    if !step.is_finite() {
        return Err(Error::invalid("step of the bound", "a finite number", step));
    }
    Ok(share(&law(objectives)?, step))
}

/// The share within a radius. (statrs panics on squares that underflow in its own scaling.)
fn share(law: &ChiSquared, radius: f64) -> f64 {
    let square = radius * radius;
    if square < f64::MIN_POSITIVE { 0.0 } else { law.cdf(square) }
}

/// The largest number, from zero up, for which `is_short` still holds. (statrs inverts chi2 itself
/// to an absolute tolerance, which leaves no correct digit of a small step.)
fn bisect(is_short: impl Fn(f64) -> bool) -> f64 {
    let mut low = 0.0;
    let mut high = 1.0;
    while is_short(high) {
        high *= 2.0;
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            return low;
        }
        *(if is_short(middle) { &mut low } else { &mut high }) = middle;
    }
}

fn law(objectives: usize) -> Result<ChiSquared> {
    let invalid = |_| Error::invalid("objectives", "at least one", objectives);
    ChiSquared::new(objectives as f64).map_err(invalid)
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn a_unit_step_covers_what_the_paper_says() {
        for (objectives, level) in [(1, 0.683), (2, 0.393), (3, 0.199), (4, 0.090)] {
            assert_abs_diff_eq!(confidence(1.0, objectives).unwrap(), level, epsilon = 5e-4);
            assert_abs_diff_eq!(confidence(-1.0, objectives).unwrap(), level, epsilon = 5e-4);
            assert_abs_diff_eq!(step_length(level, objectives).unwrap(), 1.0, epsilon = 2e-3);
        }
    }

    #[test]
    fn the_two_are_inverse() {
        for objectives in [1, 2, 3, 7, 50] {
            for level in [0.0, 1e-6, 0.05, 0.5, 0.95, 0.999_999] {
                let step = step_length(level, objectives).unwrap();
                let back = confidence(step, objectives).unwrap();
                assert_abs_diff_eq!(back, level, epsilon = 1e-9 * level);
            }
        }
    }

    #[test]
    fn the_ends_are_nothing_and_everything() {
        for objectives in [1, 3, 50] {
            assert_eq!(step_length(0.0, objectives).unwrap(), 0.0);
            assert!(
                [0.0, 1e-162, 1e-300]
                    .iter()
                    .all(|&step| confidence(step, objectives).unwrap() < 1e-9)
            );
            assert!([1e3, 1e200].iter().all(|&step| confidence(step, objectives).unwrap() == 1.0));
            assert!(step_length(1.0 - f64::EPSILON, objectives).unwrap() > 8.0);
        }
    }

    #[test]
    fn two_objectives_have_a_closed_form() {
        // chi2_2(x) = 1 - exp(-x / 2)
        let level = 1.0 - (-4.66_f64 * 4.66 / 2.0).exp();
        assert_abs_diff_eq!(step_length(level, 2).unwrap(), 4.66, epsilon = 1e-6);
    }

    #[test]
    fn what_is_no_probability_is_an_error() {
        for level in [-0.1, 1.0, 1.5, f64::NAN] {
            assert!(
                step_length(level, 2)
                    .unwrap_err()
                    .to_string()
                    .starts_with("confidence: wanted a probability")
            );
        }
        assert!(
            step_length(0.5, 0)
                .unwrap_err()
                .to_string()
                .starts_with("objectives: wanted at least one")
        );
        assert!(confidence(f64::INFINITY, 2).is_err());
    }
}
