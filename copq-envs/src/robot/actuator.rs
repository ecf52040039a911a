//! A motor on a joint.

/// One motor: the joint's generalised force is gear x control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Index of the joint that it drives (a slide or a hinge).
    pub joint: usize,
    /// Force for a control of 1 (N or N m).
    pub gear: f64,
    /// Limits of the control.
    pub range: [f64; 2],
}
