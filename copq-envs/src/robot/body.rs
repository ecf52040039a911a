//! A rigid body: where it hangs and how its mass is distributed.

use std::f64::consts::PI;

/// One rigid body of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// A name for messages.
    pub name: String,
    /// Index of the parent body; `None` is the world.
    pub parent: Option<usize>,
    /// Origin of the frame in the parent's frame (m), with all joints at their reference.
    pub pos: [f64; 3],
    /// Orientation of the frame in the parent's frame (w, x, y, z).
    pub quat: [f64; 4],
    /// Mass and inertia.
    pub inertial: Inertial,
}

/// How a body's mass is distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass in the body frame (m).
    pub com: [f64; 3],
    /// Moments of inertia about the centre of mass along the principal axes (kg m^2).
    pub moments: [f64; 3],
    /// Orientation of the principal axes in the body frame (w, x, y, z).
    pub quat: [f64; 4],
}

impl Inertial {
    /// A solid capsule along its local z axis: a cylinder of length `2 half_length` between two half balls.
    ///
    /// `density` in kg/m^3, lengths in m, `com` and `quat` in the body frame.
    pub fn capsule(density: f64, radius: f64, half_length: f64, com: [f64; 3], quat: [f64; 4]) -> Self {
        let (r2, length) = (radius * radius, 2.0 * half_length);
        let cylinder = density * PI * r2 * length;
        let ball = density * PI * r2 * radius * 4.0 / 3.0;
        // Each half ball's centre of mass lies 3 r / 8 beyond the cylinder's end.
        let across = cylinder * (r2 / 4.0 + length * length / 12.0)
            + ball * (0.4 * r2 + half_length * half_length + 0.75 * half_length * radius);
        let along = cylinder * r2 / 2.0 + ball * 0.4 * r2;
        Self { mass: cylinder + ball, com, moments: [across, across, along], quat }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_without_a_cylinder_is_a_ball() {
        let ball = Inertial::capsule(1000.0, 0.1, 0.0, [0.0; 3], [1.0, 0.0, 0.0, 0.0]);
        let mass = 1000.0 * 4.0 / 3.0 * PI * 1e-3;
        assert!((ball.mass - mass).abs() < 1e-12);
        assert!(ball.moments.iter().all(|moment| (moment - 0.4 * mass * 1e-2).abs() < 1e-15));
    }
}
