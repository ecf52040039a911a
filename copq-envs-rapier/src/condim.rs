//! MuJoCo's contact dimension: a pair of geoms with condim 1 touches without friction.

use rapier3d_f64::prelude::{ColliderHandle, ColliderSet, ContactModificationContext, PhysicsHooks};

/// Takes the friction from contacts between colliders whose user data, their condim, is 1 on both sides.
pub(crate) struct Condim;

impl PhysicsHooks for Condim {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        if !smooth(context.colliders, context.collider1) || !smooth(context.colliders, context.collider2) {
            return;
        }
        if let Some(contacts) = context.rigid_mut() {
            *contacts.friction = 0.0;
        }
    }
}

fn smooth(colliders: &ColliderSet, handle: ColliderHandle) -> bool {
    colliders.get(handle).is_some_and(|collider| collider.user_data == 1)
}
