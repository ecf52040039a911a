//! Every kind of joint and body that the builder knows, in one machine.

use copq_envs::RobotSpec;
use copq_envs::robot::Joint;

use super::parts::{block, contraption, crooked};

/// A free base that carries a fixed mast; on the mast an arm with a tilted hinge, a slide across it
/// and two more hinges; a hook below; beside them a cart of its own on two slides and a hinge, and
/// a stone that is part of the world.
pub fn crane() -> RobotSpec {
    let bodies = vec![
        crooked("base", None),
        crooked("mast", Some(0)),
        crooked("arm", Some(1)),
        crooked("rope", Some(2)),
        crooked("hook", Some(3)),
        crooked("cart", None),
        block("stone", None),
    ];
    let anchored = |joint: Joint, anchor: [f64; 3]| Joint { anchor, ..joint };
    let joints = vec![
        Joint::free("free", 0),
        anchored(Joint::hinge("tilted", 2, [0.48, -0.6, 0.64]), [0.1, 0.2, 0.3]),
        Joint { reference: 0.2, ..Joint::slide("across", 2, [0.6, 0.8, 0.0]) },
        anchored(Joint::hinge("down", 2, [0.0, 0.0, -1.0]), [-0.1, 0.0, 0.1]),
        anchored(Joint::hinge("left", 2, [0.0, 1.0, 0.0]), [0.0, 0.3, 0.0]),
        Joint { armature: 0.7, ..Joint::slide("back", 3, [-1.0, 0.0, 0.0]) },
        anchored(
            Joint { reference: -0.3, ..Joint::hinge("swing", 4, [0.0, -1.0, 0.0]) },
            [0.0, 0.0, 0.4],
        ),
        Joint::slide("x", 5, [1.0, 0.0, 0.0]),
        Joint::slide("z", 5, [0.0, 0.0, 1.0]),
        anchored(Joint::hinge("pitch", 5, [0.0, 1.0, 0.0]), [0.2, 0.0, 0.1]),
    ];
    contraption(bodies, joints)
}
