//! MuJoCo giving up, on the engine that is handed in: a model whose stack is too small for its
//! contacts.

use copq::Result;

use crate::simulation::{Array, Call, Simulation};

/// Twenty balls side by side, in a world of this size.
fn balls(size: &str) -> String {
    let ball =
        |i| format!("<body pos=\"{i} 0 0.1\"><freejoint/><geom size=\"0.1\" condim=\"6\"/></body>");
    let balls: String = (0..20).map(ball).collect();
    format!(
        "<mujoco><size {size}/><worldbody><geom type=\"plane\" size=\"9 9 \
         9\"/>{balls}</worldbody></mujoco>"
    )
}

/// Piles the balls up in one place: MuJoCo says what is wrong, the process lives, and the data can
/// be reset.
pub(crate) fn an_internal_error_comes_back(
    open: fn(&str) -> Result<Box<dyn Simulation>>,
    size: &str,
) {
    let mut simulation = open(&balls(size)).unwrap();
    for ball in simulation.array_mut(Array::Qpos).chunks_mut(7) {
        ball[..3].copy_from_slice(&[0.0, 0.0, 0.05]);
    }
    let error = simulation.call(Call::Step, 1).unwrap_err();
    assert!(error.to_lowercase().contains("stack overflow"), "{error}");
    simulation.call(Call::Reset, 1).unwrap();
    assert_eq!(simulation.array(Array::Qpos)[7..10], [1.0, 0.0, 0.1]);
}

pub(crate) fn a_broken_model_is_an_error(open: fn(&str) -> Result<Box<dyn Simulation>>) {
    let error = open("<mujoco><worldbody><body><freejoint/></body></worldbody></mujoco>")
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("compiling a robot's MJCF") && error.contains("mass and inertia"),
        "{error}"
    );
}
