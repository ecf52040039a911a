//! How soft a constraint is.

/// MuJoCo's softness of contacts and limits: a spring and a damper, expressed as an acceleration
/// towards the constraint.
///
/// Source: MuJoCo documentation, "Solver parameters".
///
/// ```
/// use copq_envs::robot::Softness;
///
/// let softness = Softness::MUJOCO;
/// assert_eq!((softness.impedance(0.0), softness.impedance(0.001)), (0.9, 0.95));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// solref: time constant (s) and damping ratio, both above 0 (MuJoCo's other form, with
    /// negative numbers, is refused).
    pub solref: [f64; 2],
    /// solimp: impedance at zero depth and at full depth, 0 to 1; the depth (m or rad) where it is
    /// full, above 0; midpoint, between 0 and 1; power, at least 1.
    pub solimp: [f64; 5],
}

impl Softness {
    /// MuJoCo's default.
    pub const MUJOCO: Self = Self { solref: [0.02, 1.0], solimp: [0.9, 0.95, 0.001, 0.5, 2.0] };

    /// The impedance d in (0, 1) at a depth (m or rad): the share of an acceleration that the
    /// constraint takes over.
    pub fn impedance(&self, depth: f64) -> f64 {
        let [shallow, deep, width, midpoint, power] = self.solimp;
        let x = (depth.abs() / width.max(1e-15)).min(1.0);
        let y = if x <= midpoint {
            x.powf(power) / midpoint.powf(power - 1.0)
        } else {
            1.0 - (1.0 - x).powf(power) / (1.0 - midpoint).powf(power - 1.0)
        };
        clipped(shallow + y * (deep - shallow))
    }

    /// Damping b (1/s) and stiffness k (1/s^2) of the acceleration -b v - k d r that the constraint
    /// aims at (MuJoCo's aref), with v the velocity out of the violation, r the negative depth, and
    /// d the impedance there.
    pub fn reference(&self) -> [f64; 2] {
        let [time_constant, damping_ratio] = self.solref;
        let full = clipped(self.solimp[1]);
        [2.0 / (full * time_constant), (full * time_constant * damping_ratio).powi(-2)]
    }

    /// What solref or solimp should be, if engines would not agree on what its value means.
    pub(super) fn flaw(&self) -> Option<&'static str> {
        let positive = |number: &f64| *number > 0.0 && number.is_finite();
        if !self.solref.iter().all(positive) {
            return Some("a solref of a time constant and a damping ratio above 0");
        }
        let [shallow, deep, width, midpoint, power] = self.solimp;
        let fits = [shallow, deep].iter().all(|impedance| (0.0..=1.0).contains(impedance))
            && positive(&width)
            && positive(&midpoint)
            && midpoint < 1.0
            && (1.0..f64::INFINITY).contains(&power);
        (!fits).then_some(
            "a solimp of two impedances from 0 to 1, a depth above 0, a midpoint between 0 and 1 \
             and a power of at least 1",
        )
    }

    /// The softness of a pair of geoms of equal priority: the mean.
    pub fn mean(&self, other: &Self) -> Self {
        let solref = std::array::from_fn(|i| 0.5 * (self.solref[i] + other.solref[i]));
        let solimp = std::array::from_fn(|i| 0.5 * (self.solimp[i] + other.solimp[i]));
        Self { solref, solimp }
    }
}

/// MuJoCo allows no impedance closer to 0 or 1.
fn clipped(impedance: f64) -> f64 {
    impedance.clamp(1e-4, 0.9999)
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn impedance_rises_from_shallow_to_deep() {
        let softness = Softness::MUJOCO;
        let wanted = [
            (0.0, 0.9),
            (0.00025, 0.90625),
            (0.0005, 0.925),
            (0.00075, 0.94375),
            (0.001, 0.95),
            (1.0, 0.95),
        ];
        for (depth, impedance) in wanted {
            assert_abs_diff_eq!(softness.impedance(-depth), impedance, epsilon = 1e-12);
        }
    }

    #[test]
    fn an_impedance_of_0_is_mujocos_smallest() {
        let softness = Softness { solimp: [0.0, 0.0, 0.001, 0.5, 2.0], ..Softness::MUJOCO };
        assert_eq!(softness.impedance(1.0), 1e-4);
        assert_eq!(softness.reference(), [2.0 / (1e-4 * 0.02), (1e-4_f64 * 0.02).powi(-2)]);
    }

    #[test]
    fn the_reference_is_critically_damped_at_full_impedance() {
        // With the constraint's share d of the acceleration: x'' = -2 x' / tc - x / tc^2.
        let [damping, stiffness] = Softness::MUJOCO.reference();
        let d = 0.95;
        assert_abs_diff_eq!(d * damping, 100.0, epsilon = 1e-9);
        assert_abs_diff_eq!(d * stiffness * d, 2500.0, epsilon = 1e-9);
    }
}
