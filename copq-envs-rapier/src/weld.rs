//! Bodies that no joint separates move as one: which body carries which, and their common mass.

use copq_envs::RobotSpec;
use copq_envs::robot::Inertial;
use rapier3d_f64::na::{Matrix3, SymmetricEigen};
use rapier3d_f64::prelude::{MassProperties, Matrix, Pose, Rotation, Vector};

use crate::frame::{pose, rotation};

/// What a body of the description is welded to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weld {
    /// The body with joints that carries it, possibly itself; `None` is the world.
    pub carrier: Option<usize>,
    /// Its frame in the carrier's.
    pub pose: Pose,
}

/// The weld of each body.
pub(crate) fn welds(robot: &RobotSpec) -> Vec<Weld> {
    let mut welds: Vec<Weld> = Vec::with_capacity(robot.bodies.len());
    for (index, body) in robot.bodies.iter().enumerate() {
        let ground = Weld { carrier: None, pose: Pose::IDENTITY };
        let parent = body.parent.map_or(ground, |parent| welds[parent]);
        let jointed = robot.joints_of(index).next().is_some();
        let carried =
            Weld { carrier: parent.carrier, pose: parent.pose * pose(body.pos, body.quat) };
        welds.push(if jointed {
            Weld { carrier: Some(index), pose: Pose::IDENTITY }
        } else {
            carried
        });
    }
    welds
}

/// The mass of everything that a body carries, in its frame.
pub(crate) fn mass(robot: &RobotSpec, welds: &[Weld], carrier: usize) -> MassProperties {
    let riders =
        || welds.iter().zip(&robot.bodies).filter(move |(weld, _)| weld.carrier == Some(carrier));
    if riders().count() == 1 {
        return alone(&robot.bodies[carrier].inertial);
    }
    let mass: f64 = riders().map(|(_, body)| body.inertial.mass).sum();
    let centre = |weld: &Weld, inertial: &Inertial| weld.pose * Vector::from_array(inertial.com);
    let com = riders()
        .map(|(weld, body)| body.inertial.mass * centre(weld, &body.inertial))
        .sum::<Vector>()
        / mass;
    let moments = riders().map(|(weld, body)| {
        let arm = centre(weld, &body.inertial) - com;
        inertia(&body.inertial, weld.pose.rotation, arm)
    });
    principal(mass, com, moments.fold(Matrix::ZERO, |sum, moment| sum + moment))
}

fn alone(inertial: &Inertial) -> MassProperties {
    MassProperties::with_principal_inertia_frame(
        Vector::from_array(inertial.com),
        inertial.mass,
        Vector::from_array(inertial.moments),
        rotation(inertial.quat),
    )
}

/// Inertia about a point `arm` away from the centre of mass, for a body rotated by `turn`.
pub(crate) fn inertia(inertial: &Inertial, turn: Rotation, arm: Vector) -> Matrix {
    let axes = Matrix::from_quat(turn * rotation(inertial.quat));
    let centred =
        axes * Matrix::from_diagonal(Vector::from_array(inertial.moments)) * axes.transpose();
    let outer = Matrix::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
    centred + (Matrix::from_diagonal(Vector::splat(arm.length_squared())) - outer) * inertial.mass
}

/// rapier's own diagonalisation is a closed form that loses half the digits where two moments are
/// nearly equal.
fn principal(mass: f64, com: Vector, inertia: Matrix) -> MassProperties {
    let SymmetricEigen { mut eigenvectors, eigenvalues } =
        SymmetricEigen::new(Matrix3::from_column_slice(&inertia.to_cols_array()));
    if eigenvectors.determinant() < 0.0 {
        eigenvectors.neg_mut();
    }
    let axes = Matrix::from_cols_slice(eigenvectors.as_slice());
    let moments = Vector::from_slice(eigenvalues.as_slice());
    MassProperties::with_principal_inertia_frame(
        com,
        mass,
        moments,
        Rotation::from_mat3(&axes).normalize(),
    )
}
