//! How an engine advances time and solves for constraint forces.

/// The integrator of a physics step; an engine with only one may use that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// The classic fourth-order Runge-Kutta method.
    Rk4,
    /// Semi-implicit Euler with joint damping taken at the end of the step (MuJoCo's default).
    Euler,
    /// Semi-implicit Euler with joint damping taken at the start of the step (Brax).
    EulerExplicitDamping,
}

/// The algorithm that finds constraint forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Newton's method on the primal problem.
    Newton,
    /// Projected Gauss-Seidel on the dual problem.
    Pgs,
}

/// The constraint solver, in MuJoCo's terms; engines with their own solver ignore it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solver {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Maximum number of iterations in a step.
    pub iterations: u32,
    /// Maximum number of iterations of a line search (MuJoCo 3 and later; Newton only).
    pub ls_iterations: u32,
}

impl Solver {
    /// MuJoCo's default: Newton, 100 iterations, 50 in a line search.
    pub const MUJOCO: Self =
        Self { algorithm: Algorithm::Newton, iterations: 100, ls_iterations: 50 };
}
