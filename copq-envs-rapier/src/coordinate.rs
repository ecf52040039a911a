//! Where a joint's entries of qpos and qvel live in rapier's multibody.

use std::ops::Range;

use copq_envs::RobotSpec;
use rapier3d_f64::prelude::{Multibody, MultibodyLink};

use crate::free_joint::Free;
use crate::link::Moves;
use crate::scalar_joint::Axis;

/// The place of one joint on both sides.
#[derive(Clone, Debug)]
pub(crate) struct Coordinate {
    /// Its entries of qpos.
    pub qpos: Range<usize>,
    /// Its entries of qvel.
    pub qvel: Range<usize>,
    /// Its place in rapier.
    pub joint: Place,
}

/// A joint in rapier's multibody.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// A free root.
    Free(Free),
    /// A slide or a hinge.
    Axis(Axis),
}

/// The coordinates of all joints, from what each link moves (in the order of the joints) and its
/// index.
pub(crate) fn coordinates<'a>(
    robot: &RobotSpec,
    multibody: &Multibody,
    links: impl Iterator<Item = (&'a Moves, usize)>,
) -> Vec<Coordinate> {
    let places = links.flat_map(|(moves, id)| {
        multibody.link(id).map_or_else(Vec::new, |link| places(robot, moves, link))
    });
    let mut q = 0;
    let mut v = 0;
    let joints = robot.joints.iter().zip(places).map(|(spec, joint)| {
        let qpos = q..q + spec.kind.nq();
        let qvel = v..v + spec.kind.nv();
        (q, v) = (qpos.end, qvel.end);
        Coordinate { qpos, qvel, joint }
    });
    joints.collect()
}

fn places(robot: &RobotSpec, moves: &Moves, link: &MultibodyLink) -> Vec<Place> {
    let id = link.link_id();
    let axis = |&(joint, axis): &(usize, usize)| {
        let reference = robot.joints[joint].reference;
        let stiffness = robot.joints[joint].stiffness;
        Place::Axis(Axis { link: id, axis, dof: first_dof(link, axis), reference, stiffness })
    };
    match moves {
        Moves::Free => vec![Place::Free(Free { link: id, dof: link.assembly_id() })],
        Moves::Axes(axes) => axes.iter().map(axis).collect(),
    }
}

/// The index of a link's axis in the multibody's velocity vector.
fn first_dof(link: &MultibodyLink, axis: usize) -> usize {
    let locked = link.joint.data.locked_axes.bits();
    link.assembly_id() + (0..axis).filter(|before| (locked >> before) & 1 == 0).count()
}

impl Coordinate {
    /// rapier's degrees of freedom, as indices into the multibody's velocity vector.
    pub(crate) fn dofs(&self) -> Range<usize> {
        let first = match &self.joint {
            Place::Free(free) => free.dof,
            Place::Axis(axis) => axis.dof,
        };
        first..first + self.qvel.len()
    }

    /// Writes the joint's entries of qpos.
    pub(crate) fn position(&self, multibody: &Multibody, qpos: &mut [f64]) {
        let qpos = &mut qpos[self.qpos.clone()];
        match &self.joint {
            Place::Free(free) => free.position(multibody, qpos),
            Place::Axis(axis) => qpos[0] = axis.position(multibody),
        }
    }

    /// Writes the joint's entries of qvel.
    pub(crate) fn velocity(&self, multibody: &Multibody, qvel: &mut [f64]) {
        let velocity = multibody.generalized_velocity();
        let qvel = &mut qvel[self.qvel.clone()];
        match &self.joint {
            Place::Free(free) => free.velocity(multibody, velocity.as_slice(), qvel),
            Place::Axis(axis) => qvel[0] = velocity[axis.dof],
        }
    }

    /// Writes the displacement, in rapier's degrees of freedom, that takes the pristine multibody
    /// to `qpos`.
    pub(crate) fn displacement(&self, qpos: &[f64], out: &mut [f64]) {
        let qpos = &qpos[self.qpos.clone()];
        match &self.joint {
            Place::Free(free) => free.displacement(qpos, out),
            // The pristine coordinates are 0, so a displacement is a position.
            Place::Axis(axis) => out[axis.dof] = qpos[0] - axis.reference,
        }
    }

    /// Writes the velocity, in rapier's degrees of freedom, that is `qvel` at `qpos`.
    pub(crate) fn freedoms(&self, qpos: &[f64], qvel: &[f64], out: &mut [f64]) {
        let qpos = &qpos[self.qpos.clone()];
        let qvel = &qvel[self.qvel.clone()];
        match &self.joint {
            Place::Free(free) => free.freedoms(qpos, qvel, out),
            Place::Axis(axis) => out[axis.dof] = qvel[0],
        }
    }
}
