//! Solid shapes: a capsule between two points, a ball, and their inertia, in the arithmetic of
//! MuJoCo's compiler.

use std::f64::consts::PI;

use super::{Inertial, Shape};

/// A capsule in a body's frame.
///
/// ```
/// use copq_envs::robot::Capsule;
///
/// // A rod of 1 m between the centres of its caps, as heavy as water.
/// let rod = Capsule::between([0.0; 3], [1.0, 0.0, 0.0], 0.05);
/// assert_eq!((rod.half_length, rod.centre), (0.5, [0.5, 0.0, 0.0]));
/// assert!((rod.solid(1000.0).mass - 8.377580).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Radius (m).
    pub radius: f64,
    /// Half the length of the cylinder between the caps (m).
    pub half_length: f64,
    /// Centre (m).
    pub centre: [f64; 3],
    /// Orientation (w, x, y, z): turns z onto the capsule's axis.
    pub quat: [f64; 4],
}

impl Capsule {
    /// The capsule whose caps are centred on two points (m); its local z axis points from `to` to
    /// `from`.
    pub fn between(from: [f64; 3], to: [f64; 3], radius: f64) -> Self {
        let axis = [0, 1, 2].map(|i| from[i] - to[i]);
        let centre = [0, 1, 2].map(|i| 0.5 * (from[i] + to[i]));
        Self { radius, half_length: norm(axis) / 2.0, centre, quat: z_onto(unit(axis)) }
    }

    /// Its shape.
    pub fn shape(&self) -> Shape {
        Shape::Capsule { radius: self.radius, half_length: self.half_length }
    }

    /// Mass and inertia when filled (density in kg/m^3): a cylinder between two half balls, each
    /// with its centre of mass 3 r / 8 beyond the cylinder's end.
    pub fn solid(&self, density: f64) -> Inertial {
        let r = self.radius;
        let length = 2.0 * self.half_length;
        let mass = density * (PI * (r * r * length + 4.0 * r * r * r / 3.0));
        let ball = mass * 4.0 * r / (4.0 * r + 3.0 * length);
        let cylinder = mass - ball;
        let ball_moment = 2.0 * ball * r * r / 5.0;
        let across = cylinder * (3.0 * r * r + length * length) / 12.0
            + (ball_moment + ball * length * (3.0 * r + 2.0 * length) / 8.0);
        let along = cylinder * r * r / 2.0 + ball_moment;
        Inertial { mass, com: self.centre, moments: [across, across, along], quat: self.quat }
    }
}

/// Mass and inertia of a filled ball (density in kg/m^3, radius and centre in m).
pub(super) fn solid_ball(density: f64, radius: f64, centre: [f64; 3]) -> Inertial {
    let mass = density * (4.0 * PI * radius * radius * radius / 3.0);
    let moment = 2.0 * mass * radius * radius / 5.0;
    Inertial { mass, com: centre, moments: [moment; 3], quat: [1.0, 0.0, 0.0, 0.0] }
}

/// The vector scaled to length 1, or unchanged if only rounding separates its length from 1.
pub(super) fn unit(vector: [f64; 3]) -> [f64; 3] {
    let norm = norm(vector);
    if (norm - 1.0).abs() < 1e-15 { vector } else { vector.map(|x| x / norm) }
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// The shortest rotation of z onto a unit vector (about x if it points straight up or down).
fn z_onto([x, y, z]: [f64; 3]) -> [f64; 4] {
    let sine = norm([-y, x, 0.0]);
    let axis = if sine < 1e-10 { [1.0, 0.0, 0.0] } else { unit([-y, x, 0.0]) };
    let half = sine.atan2(z) / 2.0;
    let [x, y, z] = axis.map(|component| component * half.sin());
    [half.cos(), x, y, z]
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn a_capsule_without_a_cylinder_is_a_ball() {
        let ball = solid_ball(1000.0, 0.1, [0.0; 3]);
        let centre = [0.0; 3];
        let capsule = Capsule { radius: 0.1, half_length: 0.0, centre, quat: [1.0, 0.0, 0.0, 0.0] }
            .solid(1000.0);
        assert_abs_diff_eq!(ball.mass, 4.0 / 3.0 * PI, epsilon = 1e-12);
        assert_abs_diff_eq!(capsule.mass, ball.mass, epsilon = 1e-12);
        let moments = [0.4 * ball.mass * 1e-2; 3];
        assert_abs_diff_eq!(capsule.moments[..], moments[..], epsilon = 1e-15);
    }

    #[test]
    fn z_turns_onto_the_axis() {
        for (from, wanted) in [
            ([0.0, 0.0, 2.0], [1.0, 0.0, 0.0, 0.0]),
            ([0.0, 0.0, -2.0], [0.0, 1.0, 0.0, 0.0]),
            ([3.0, 0.0, 0.0], [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0]),
        ] {
            let quat = Capsule::between(from, [0.0; 3], 0.1).quat;
            assert_abs_diff_eq!(quat[..], wanted[..], epsilon = 1e-15);
        }
    }
}
