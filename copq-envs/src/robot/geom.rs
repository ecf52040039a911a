//! A shape that collides.

use super::{Capsule, Softness};

/// The form of a [`Geom`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// An infinite plane, normal to the local z axis.
    Plane,
    /// A capsule along the local z axis.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Half the length of the cylinder between the caps (m).
        half_length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius (m).
        radius: f64,
    },
}

/// One colliding shape, fixed to a body or to the world.
///
/// ```
/// use copq_envs::robot::{Geom, Shape};
///
/// // A slippery floor.
/// let floor = Geom::new("floor", None, Shape::Plane);
/// let floor = Geom { friction: [0.2, 0.005, 0.0001], ..floor };
/// assert_eq!((floor.body, floor.condim), (None, 3));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Geom {
    /// A name that is unique among the geoms; it may be empty.
    pub name: String,
    /// Index of the body that carries it; `None` is the world.
    pub body: Option<usize>,
    /// Its form.
    pub shape: Shape,
    /// Centre in the body frame (m).
    pub pos: [f64; 3],
    /// Orientation in the body frame (w, x, y, z).
    pub quat: [f64; 4],
    /// Sliding, spinning and rolling friction; a pair takes the larger of each.
    pub friction: [f64; 3],
    /// Dimensions of a contact's force: 1 without friction, 3 with sliding friction; a pair takes
    /// the larger.
    pub condim: u8,
    /// Bits that other geoms' [`Geom::conaffinity`] is compared with.
    pub contype: u32,
    /// Bits that other geoms' [`Geom::contype`] is compared with.
    pub conaffinity: u32,
    /// Distance at which a contact begins (m); a pair takes the sum (MuJoCo 3.5 and later).
    pub margin: f64,
    /// How soft its contacts are.
    pub softness: Softness,
}

impl Geom {
    /// A shape at the body's origin, with MuJoCo's defaults: it may touch anything.
    pub fn new(name: &str, body: Option<usize>, shape: Shape) -> Self {
        Self {
            name: name.into(),
            body,
            shape,
            pos: [0.0; 3],
            quat: [1.0, 0.0, 0.0, 0.0],
            friction: [1.0, 0.005, 0.0001],
            condim: 3,
            contype: 1,
            conaffinity: 1,
            margin: 0.0,
            softness: Softness::MUJOCO,
        }
    }

    /// A capsule, with MuJoCo's defaults.
    pub fn capsule(name: &str, body: usize, capsule: Capsule) -> Self {
        Self {
            pos: capsule.centre,
            quat: capsule.quat,
            ..Self::new(name, Some(body), capsule.shape())
        }
    }
}
