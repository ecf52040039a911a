//! From a confidence level to the length of a step, and back: Sigma's ellipsoids under the chi-squared law.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::{Error, Result};

/// sqrt(chi2_N^-1(p)), the Mahalanobis radius that holds a share `confidence` of an N-variate normal (paper eq. 5).
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
        return Err(Error::invalid("confidence", "a probability from 0 up to, not including, 1", confidence));
    }
    Ok(law(objectives)?.inverse_cdf(confidence).sqrt())
}

/// chi2_N(step^2), the share of an N-variate normal within a Mahalanobis radius of |step|: [`step_length`] inverted.
pub fn confidence(step: f64, objectives: usize) -> Result<f64> {
    if !step.is_finite() {
        return Err(Error::invalid("step of the bound", "a finite number", step));
    }
    Ok(law(objectives)?.cdf(step * step))
}

fn law(objectives: usize) -> Result<ChiSquared> {
    let invalid = |_| Error::invalid("objectives", "at least one", objectives);
    ChiSquared::new(objectives as f64).map_err(invalid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_step_covers_what_the_paper_says() {
        for (objectives, level) in [(1, 0.683), (2, 0.393), (3, 0.199), (4, 0.090)] {
            assert!((confidence(1.0, objectives).unwrap() - level).abs() < 5e-4);
            assert!((confidence(-1.0, objectives).unwrap() - level).abs() < 5e-4);
            assert!((step_length(level, objectives).unwrap() - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn the_two_are_inverse() {
        for objectives in [1, 2, 3, 7, 50] {
            for level in [0.0, 1e-6, 0.05, 0.5, 0.95, 0.999_999] {
                let step = step_length(level, objectives).unwrap();
                assert!((confidence(step, objectives).unwrap() - level).abs() < 1e-9, "{level} for {objectives}");
            }
        }
    }

    #[test]
    fn two_objectives_have_a_closed_form() {
        // chi2_2(x) = 1 - exp(-x / 2)
        let level = 1.0 - (-4.66_f64 * 4.66 / 2.0).exp();
        assert!((step_length(level, 2).unwrap() - 4.66).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_probability_is_an_error() {
        for level in [-0.1, 1.0, 1.5, f64::NAN] {
            assert!(step_length(level, 2).unwrap_err().to_string().starts_with("confidence: wanted a probability"));
        }
        assert!(step_length(0.5, 0).unwrap_err().to_string().starts_with("objectives: wanted at least one"));
        assert!(confidence(f64::INFINITY, 2).is_err());
    }
}
