//! The forces of contacts, as the last timestep applied them.

use rapier3d_f64::prelude::{ColliderHandle, ContactManifold, ContactPair, Vector};

use crate::world::World;

/// One contact point between two geoms.
pub(crate) struct Touch {
    /// The geoms, by index.
    pub geoms: [usize; 2],
    /// Where they touch, in world axes (m).
    pub point: Vector,
    /// The force on the first geom, in world axes (N); the second feels the opposite.
    pub force: Vector,
}

/// All contacts of the last timestep, whose length is `dt`.
pub(crate) fn touches(world: &World, dt: f64) -> impl Iterator<Item = Touch> {
    let pairs = world.narrow_phase.contact_pairs();
    pairs.flat_map(move |pair| {
        let manifolds = pair.solver_manifolds().iter();
        manifolds.flat_map(move |manifold| between(world, pair, manifold, dt))
    })
}

fn between(
    world: &World,
    pair: &ContactPair,
    manifold: &ContactManifold,
    dt: f64,
) -> impl Iterator<Item = Touch> {
    let geoms = [pair.collider1, pair.collider2].map(|collider| geom(world, collider));
    // The points on both sides differ by the depth; colliders live as long as their pairs.
    let first = world
        .colliders
        .get(pair.collider1)
        .map(|collider| *collider.position())
        .unwrap_or_default();
    manifold.data.solver_contacts.iter().map(move |active| {
        let contact = &manifold.points[active.contact_indices()[0] as usize];
        let impulse =
            contact.data.warmstart_tangent_world - manifold.data.normal * contact.data.impulse;
        Touch { geoms, point: first * contact.local_p1, force: impulse / dt }
    })
}

fn geom(world: &World, collider: ColliderHandle) -> usize {
    world.colliders.get(collider).map_or(0, |collider| collider.user_data as usize)
}
