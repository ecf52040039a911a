//! Pictures by MuJoCo's own renderer, without a window. They show a robot at any position,
//! whichever engine it comes from.

mod scenery;

use std::error::Error as _;
use std::fmt;

use copq::error::check_len;
use copq::{Error, Result};
use copq_envs::RobotSpec;
use mujoco_rs::renderer::MjRenderer;
use mujoco_rs::wrappers::{MjData, MjModel, MjvCamera};

use crate::mujoco_rs::{compile, version};

/// Largest width and height of a picture in pixels: every OpenGL can draw as many.
const LARGEST: u32 = 8_192;

/// What EGL consists of, for users who lack it.
const INSTALL: &str = "pictures need EGL and OpenGL; Mesa's work without a graphics card (Debian: apt-get install libegl1 \
                       libgl1-mesa-dri)";
/// Degrees from the x axis in which the camera looks (90 is along y), and above the horizon.
const VIEW: [f64; 2] = [112.0, -16.0];
/// Distance of the camera, in multiples of the robot's size: its height or its length, whichever is
/// larger.
const DISTANCE: f64 = 2.1;

/// Draws a robot above a chequered floor, seen by a camera that follows it sideways and in depth.
///
/// It has its own model, so an engine that runs at the same time is not affected. It is tied to its
/// thread, as OpenGL is.
///
/// ```no_run
/// // A robot as its task begins, with grey limbs.
/// let robot = copq_envs::task("a/hopper")?.robot;
/// let mut renderer = copq_envs_mujoco::Renderer::new(&robot, [400, 300], |_| [128; 3])?;
/// let picture = renderer.draw(&robot.initial_qpos)?;
/// assert_eq!(picture.len(), 3 * 400 * 300);
/// # Ok::<(), copq::Error>(())
/// ```
pub struct Renderer {
    robot: RobotSpec,
    data: MjData<Box<MjModel>>,
    renderer: MjRenderer,
}

impl Renderer {
    /// A renderer of pictures of this size in pixels. `colour` gives the red, green and blue of the
    /// robot's n-th limb (see [`RobotSpec::limbs`]).
    ///
    /// An error if there is no EGL that draws without a window: it says what to install.
    pub fn new(
        robot: &RobotSpec,
        [width, height]: [u32; 2],
        colour: impl Fn(usize) -> [u8; 3],
    ) -> Result<Self> {
        robot.check()?;
        if [width, height].iter().any(|pixels| !(1..=LARGEST).contains(pixels)) {
            return Err(Error::invalid(
                "size of a picture",
                format!("1 to {LARGEST} pixels in width and height"),
                format!("{width} x {height}"),
            ));
        }
        let mut model = compile(&scenery::add(&robot.mjcf(version()?), [width, height]))?;
        paint(&mut model, &robot.limbs(), colour);
        let camera = camera(robot, &model);
        let renderer =
            MjRenderer::builder().width(width).height(height).camera(camera).build(&model);
        let renderer = renderer.map_err(|error| {
            let cause = error.source().map_or_else(|| error.to_string(), ToString::to_string);
            failure(format!("{cause}; {INSTALL}"))
        })?;
        let data = MjData::try_new(Box::new(model))
            .map_err(|error| Error::other("making MuJoCo's data", error))?;
        Ok(Self { robot: robot.clone(), data, renderer })
    }

    /// The robot at a position (nq): red, green and blue of every pixel, row by row from the top.
    pub fn draw(&mut self, qpos: &[f64]) -> Result<&[u8]> {
        check_len("qpos", qpos.len(), self.robot.nq())?;
        if !qpos.iter().all(|value| value.is_finite()) {
            return Err(Error::invalid("position to draw", "finite numbers", format!("{qpos:?}")));
        }
        self.data.qpos_mut().copy_from_slice(qpos);
        self.data.forward();
        let [x, y, _] = self.robot.centre_of_mass(&self.robot.body_poses(qpos));
        self.renderer.camera_mut().lookat[..2].copy_from_slice(&[x, y]);
        // Twice, because MuJoCo centres the endless floor where the camera was the last time. So
        // each position has one picture.
        let renderer = &mut self.renderer;
        let data = &mut self.data;
        let drawn = renderer
            .sync_data(data)
            .and_then(|()| renderer.sync_data(data))
            .and_then(|()| renderer.render());
        drawn.map_err(|error| failure(error.to_string()))?;
        // There are no pixels only if they had been turned off.
        Ok(self.renderer.rgb_flat().unwrap_or_default())
    }
}

impl fmt::Debug for Renderer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Renderer").field("robot", &self.robot.name).finish_non_exhaustive()
    }
}

fn failure(what: String) -> Error {
    Error::Env { env: "MuJoCo's renderer".into(), what }
}

/// Gives every body's geoms the colour of its limb; the world's have their own.
fn paint(model: &mut MjModel, limbs: &[usize], colour: impl Fn(usize) -> [u8; 3]) {
    let bodies = model.geom_bodyid().to_vec();
    for (rgba, body) in model.geom_rgba_mut().iter_mut().zip(bodies) {
        // The world is MuJoCo's body 0.
        if let Some(limb) = (body as usize).checked_sub(1).map(|body| limbs[body]) {
            let [red, green, blue] = colour(limb).map(|part| f32::from(part) / 255.0);
            *rgba = [red, green, blue, 1.0];
        }
    }
}

/// A camera at a distance proportional to the robot's size, aimed at half its height.
fn camera(robot: &RobotSpec, model: &MjModel) -> MjvCamera {
    let segments = robot.segments(&robot.body_poses(&robot.initial_qpos));
    let ends = || segments.iter().flat_map(|segment| segment.ends.map(|end| (end, segment.radius)));
    let highest = |axis: usize| {
        ends().map(|(end, radius)| end[axis] + radius).fold(f64::NEG_INFINITY, f64::max)
    };
    let lowest =
        |axis: usize| ends().map(|(end, radius)| end[axis] - radius).fold(f64::INFINITY, f64::min);
    let across = (0..2).map(|axis| highest(axis) - lowest(axis)).fold(0.0, f64::max);
    let mut camera = MjvCamera::new_free(model);
    [camera.azimuth, camera.elevation] = VIEW;
    camera.distance = DISTANCE * highest(2).max(across);
    camera.lookat[2] = 0.5 * highest(2);
    camera
}
