//! Ways to draw a robot.

use copq::{Error, Result};
use copq_envs::RobotSpec;
use copq_envs::robot::Segment;
use copq_render::animation::{Capsule, Draw, SideView, limb_colour};

/// The views that [`make_view`] knows.
pub const VIEWS: [&str; 2] = ["side", "mujoco"];

/// Draws a robot's qpos, whichever engine it comes from: from the side, which needs nothing, or as
/// MuJoCo does.
pub fn make_view(name: &str, robot: &RobotSpec) -> Result<Box<Draw<'static>>> {
    match name {
        "side" => from_the_side(robot.clone()),
        #[cfg(feature = "render")]
        "mujoco" => {
            use copq_render::animation::{HEIGHT, WIDTH};
            let mut renderer =
                copq_envs_mujoco::Renderer::new(robot, [WIDTH, HEIGHT], limb_colour)?;
            Ok(Box::new(move |qpos| Ok(renderer.draw(qpos)?.to_vec())))
        }
        #[cfg(not(feature = "render"))]
        "mujoco" => {
            let wanted = "a build with it: cargo run --release --features render -- rollout ...";
            Err(Error::invalid("view mujoco", wanted, "one without"))
        }
        _ => Err(Error::unknown("view", name, &VIEWS)),
    }
}

fn from_the_side(robot: RobotSpec) -> Result<Box<Draw<'static>>> {
    let mut view = SideView::new(&look(&robot, &robot.initial_qpos).0)?;
    Ok(Box::new(move |qpos| {
        let (capsules, centre) = look(&robot, qpos);
        Ok(view.draw(&capsules, centre))
    }))
}

/// The robot's capsules, and the point to follow.
fn look(robot: &RobotSpec, qpos: &[f64]) -> (Vec<Capsule>, [f64; 3]) {
    let bodies = robot.body_poses(qpos);
    let capsule =
        |Segment { limb, ends, radius }| Capsule { ends, radius, colour: limb_colour(limb) };
    (robot.segments(&bodies).into_iter().map(capsule).collect(), robot.centre_of_mass(&bodies))
}
