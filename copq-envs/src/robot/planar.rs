//! What robots in the x-z plane share: a root that slides along x and z and pitches about y, and
//! limbs of one capsule each.

use super::{Body, Capsule, Geom, Joint, Softness};

/// Density of every limb (kg/m^3).
const DENSITY: f64 = 1000.0;

/// 150 degrees (rad) as Brax rounds them.
pub(super) const BRAX_150: f64 = 2.61799;
/// 45 degrees (rad) as Brax rounds them.
#[expect(clippy::approx_constant, reason = "the rounding is the fact")]
pub(super) const BRAX_45: f64 = 0.785398;

/// The root joints, x, z and pitch, of body 0. qpos of z is `height` (m) at the reference pose; the
/// slides' axes pass that far below the body, which changes nothing.
pub(super) fn root(height: f64, softness: Softness) -> Vec<Joint> {
    let anchor = [0.0, 0.0, -height];
    vec![
        Joint { anchor, softness, ..Joint::slide("rootx", 0, [1.0, 0.0, 0.0]) },
        Joint { anchor, reference: height, softness, ..Joint::slide("rootz", 0, [0.0, 0.0, 1.0]) },
        Joint { softness, ..Joint::hinge("rooty", 0, [0.0, 1.0, 0.0]) },
    ]
}

/// One limb: a body with one capsule. Points are (x, z) of the world at the reference pose (m); the
/// bodies' frames follow by subtraction, as they did for Gymnasium's, so they have the same bits.
pub(super) struct Limb {
    pub name: &'static str,
    pub parent: Option<usize>,
    pub origin: [f64; 2],
    pub ends: [[f64; 2]; 2],
    pub radius: f64,
    pub friction: f64,
    /// Where its joint is.
    pub joint: [f64; 2],
}

impl Limb {
    /// The capsule in world coordinates.
    fn capsule(&self) -> Capsule {
        Capsule::between(at(self.ends[0]), at(self.ends[1]), self.radius)
    }

    /// The limb's body, as a solid.
    fn body(&self, limbs: &[Self]) -> Body {
        let parent = self.parent.map_or([0.0; 2], |parent| limbs[parent].origin);
        let mut inertial = self.capsule().solid(DENSITY);
        inertial.com = from(self.origin, inertial.com);
        Body::new(self.name, self.parent, from(parent, at(self.origin)), inertial)
    }

    /// The capsule of body `index`.
    pub(super) fn geom(&self, index: usize) -> Geom {
        let geom = Geom::capsule(&format!("{}_geom", self.name), index, self.capsule());
        Geom { pos: from(self.origin, geom.pos), ..geom }
    }

    /// A hinge about -y that moves body `index`.
    pub(super) fn hinge(&self, index: usize) -> Joint {
        let joint = Joint::hinge(&format!("{}_joint", self.name), index, [0.0, -1.0, 0.0]);
        Joint { anchor: from(self.origin, at(self.joint)), ..joint }
    }
}

/// The limbs' bodies.
pub(super) fn bodies(limbs: &[Limb]) -> Vec<Body> {
    limbs.iter().map(|limb| limb.body(limbs)).collect()
}

fn at([x, z]: [f64; 2]) -> [f64; 3] {
    [x, 0.0, z]
}

/// A point of the world as seen from an origin.
fn from(origin: [f64; 2], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [x - origin[0], y, z - origin[1]]
}
