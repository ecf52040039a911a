//! How soft a constraint is.

/// MuJoCo's softness of contacts and limits: a spring and damper seen as acceleration towards the constraint.
///
/// Source: MuJoCo documentation, "Solver parameters".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// solref: time constant (s) and damping ratio.
    pub solref: [f64; 2],
    /// solimp: impedance at zero depth and at full depth, the depth (m or rad) where it is full, midpoint, power.
    pub solimp: [f64; 5],
}

impl Softness {
    /// MuJoCo's default.
    pub const MUJOCO: Self = Self { solref: [0.02, 1.0], solimp: [0.9, 0.95, 0.001, 0.5, 2.0] };

    /// The impedance d at full depth, in (0, 1): what engines without MuJoCo's depth curve should use.
    pub fn impedance(&self) -> f64 {
        self.solimp[1]
    }
}
