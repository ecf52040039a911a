//! Everything in a rapier world that changes from step to step, so that a clone or a serialised
//! copy is a snapshot.

use copq::{Error, Result};
use rapier3d_f64::prelude::{
    BroadPhaseBvh, BvhOptimizationStrategy, ColliderSet, IslandManager, Multibody, MultibodyIndex,
    MultibodyJointSet, NarrowPhase, RigidBodySet,
};
use serde::{Deserialize, Serialize};

/// The sets that rapier's pipeline steps, including contact memory (warm starts, cached pairs).
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct World {
    pub islands: IslandManager,
    pub broad_phase: BroadPhaseBvh,
    pub narrow_phase: NarrowPhase,
    pub bodies: RigidBodySet,
    pub colliders: ColliderSet,
    pub joints: MultibodyJointSet,
}

impl World {
    pub(crate) fn empty() -> Self {
        Self {
            islands: IslandManager::new(),
            // A robot's tree has some twenty leaves; using it costs less than optimising it.
            broad_phase: BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None),
            narrow_phase: NarrowPhase::new(),
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: MultibodyJointSet::new(),
        }
    }

    pub(crate) fn multibody(&self, index: MultibodyIndex) -> &Multibody {
        &self.joints[index]
    }

    /// The robot and the set of bodies that it belongs to, for writing.
    pub(crate) fn split(&mut self, index: MultibodyIndex) -> (&mut Multibody, &mut RigidBodySet) {
        let Some(multibody) = self.joints.get_multibody_mut(index) else {
            unreachable!("an assembled world never loses its one multibody");
        };
        (multibody, &mut self.bodies)
    }

    /// All of it as bytes; floats keep their bits.
    pub(crate) fn to_bytes(&self) -> Result<Vec<u8>> {
        postcard::to_allocvec(self).map_err(|source| Error::other("writing a rapier world", source))
    }

    /// The inverse of [`World::to_bytes`].
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self> {
        postcard::from_bytes(bytes).map_err(|source| Error::other("reading a rapier world", source))
    }
}
