//! Pictures of all robots: what any picture of a robot shows, whoever draws it.
#![cfg(feature = "render")]

use std::io::Write;

use copq::Result;
use copq_envs::RobotSpec;
use copq_envs::robot::{Preset, ant, halfcheetah, hopper, humanoid, walker2d};
use copq_envs_mujoco::Renderer;

const SIZE: [u32; 2] = [320, 240];

fn robots() -> Vec<RobotSpec> {
    let all = |preset| [hopper, walker2d, halfcheetah, ant, humanoid].map(|make| make(preset));
    [Preset::GymV5, Preset::Paper].into_iter().flat_map(all).collect()
}

/// Draws robots in magenta, a colour that is nowhere else; `None` on a machine that cannot.
fn renderer(robot: &RobotSpec) -> Option<Renderer> {
    let made: Result<Renderer> = Renderer::new(robot, SIZE, |_| [255, 0, 255]);
    match made {
        Err(error) if error.to_string().contains("apt-get install libegl1") => {
            writeln!(std::io::stderr(), "SKIPPED: {error}").unwrap_or_default();
            None
        }
        made => Some(made.unwrap()),
    }
}

/// A picture, and where in it the robot is.
#[derive(Clone)]
struct Seen {
    picture: Vec<u8>,
    /// Column and row of each of the robot's pixels.
    robot: Vec<[i64; 2]>,
}

impl Seen {
    fn look(renderer: &mut Renderer, qpos: &[f64]) -> Self {
        let picture = renderer.draw(qpos).unwrap().to_vec();
        assert_eq!(picture.len() as u32, 3 * SIZE[0] * SIZE[1]);
        let is_robot =
            |pixel: &[u8]| pixel[0] / 2 > pixel[1] && pixel[2] / 2 > pixel[1] && pixel[0] > 40;
        let robot = picture
            .chunks(3)
            .enumerate()
            .filter(|(_, pixel)| is_robot(pixel))
            .map(|(at, _)| place(at));
        Self { robot: robot.collect(), picture }
    }

    /// The smallest and the largest column (0) or row (1) of the robot.
    fn extent(&self, axis: usize) -> [i64; 2] {
        let along = || self.robot.iter().map(|pixel| pixel[axis]);
        [along().min().unwrap(), along().max().unwrap()]
    }

    /// How many pixels differ that are the robot's in neither picture.
    fn apart(&self, other: &Self) -> usize {
        let robots: std::collections::HashSet<_> = self.robot.iter().chain(&other.robot).collect();
        let pairs = self.picture.chunks(3).zip(other.picture.chunks(3)).enumerate();
        pairs.filter(|(at, (own, other))| own != other && !robots.contains(&place(*at))).count()
    }
}

/// Column and row of the n-th pixel.
fn place(at: usize) -> [i64; 2] {
    [at as i64 % i64::from(SIZE[0]), at as i64 / i64::from(SIZE[0])]
}

/// The robot after a move of its root: along x, along z.
fn moved(robot: &RobotSpec, [x, z]: [f64; 2]) -> Vec<f64> {
    let mut qpos = robot.initial_qpos.clone();
    qpos[0] += x;
    // A free root counts y between them.
    qpos[if robot.joints[0].kind.nq() == 7 { 2 } else { 1 }] += z;
    qpos
}

#[test]
fn a_robot_is_where_its_position_says() {
    for robot in robots() {
        let Some(mut renderer) = renderer(&robot) else { return };
        let look = |by| Seen::look(&mut renderer, &moved(&robot, by));
        let [start, ahead, above, again] =
            [[0.0, 0.0], [0.3, 0.0], [0.0, 0.2], [0.0, 0.0]].map(look);
        let name = &robot.name;
        let pixels = start.robot.len() as f64 / f64::from(SIZE[0] * SIZE[1]);
        println!("{name}: {:.1} % of the picture", 100.0 * pixels);
        assert!((0.005..0.2).contains(&pixels), "{name} fills {pixels}");
        assert!(start.picture == again.picture, "{name}: one position, two pictures");
        for (axis, size) in SIZE.into_iter().enumerate() {
            let [low, high] = start.extent(axis);
            assert!(low > 0 && high < i64::from(size) - 1, "{name} is cut off at {low} or {high}");
        }
        // The camera goes with it: the robot stays in its place, and the tiles pass by.
        let shift = (0..2).flat_map(|axis| (0..2).map(move |end| (axis, end)));
        let shift: Vec<_> =
            shift.map(|(axis, end)| ahead.extent(axis)[end] - start.extent(axis)[end]).collect();
        assert!(shift.iter().all(|by| by.abs() <= 1), "{name} moved by {shift:?}");
        assert!(
            start.apart(&ahead) > (SIZE[0] * SIZE[1] / 20) as usize,
            "{name}: nothing passes by"
        );
        // Up is up, and the horizon stays.
        let rise = [0, 1].map(|end| start.extent(1)[end] - above.extent(1)[end]);
        assert!(rise.iter().all(|&by| by > 8), "{name} rose by {rise:?}");
        assert!(
            start.picture[..3 * SIZE[0] as usize] == above.picture[..3 * SIZE[0] as usize],
            "{name}: the sky moved"
        );
    }
}

/// Bodies move as forward kinematics has them, seen at a joint that no other motion hides.
#[test]
fn a_bent_joint_shows() {
    for robot in robots() {
        let Some(mut renderer) = renderer(&robot) else { return };
        let mut qpos = robot.initial_qpos.clone();
        let start = Seen::look(&mut renderer, &qpos);
        *qpos.last_mut().unwrap() += 0.5;
        let bent = Seen::look(&mut renderer, &qpos);
        let changed = bent.robot.iter().filter(|pixel| !start.robot.contains(pixel)).count();
        assert!(changed > 5, "{}: {changed} new pixels", robot.name);
    }
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let robot = hopper(Preset::GymV5);
    let Some(mut renderer) = renderer(&robot) else { return };
    assert!(renderer.draw(&[0.0; 5]).unwrap_err().to_string().contains("qpos"));
    assert!(renderer.draw(&[f64::NAN; 6]).unwrap_err().to_string().contains("finite numbers"));
    renderer.draw(&robot.initial_qpos).unwrap();
    let error = Renderer::new(&robot, [0, 240], |_| [0; 3]).unwrap_err().to_string();
    assert!(error.contains("size of a picture") && error.contains("0 x 240"), "{error}");
    let error = Renderer::new(&robot, [20_000, 240], |_| [0; 3]).err().unwrap().to_string();
    assert!(error.contains("wanted 1 to 8192 pixels"), "{error}");
}
