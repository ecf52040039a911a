//! From metres to pixels.

use tiny_skia::Transform;

use super::Capsule;

/// Where the floor below the robot is, as a share of the picture's height.
const FLOOR: f64 = 0.8;
/// How many times the robot's own height or length fits between the floor and the picture's upper
/// edge.
const ROOM: f64 = 1.5;
/// How far to the right and upwards a metre of depth appears (m).
const DEPTH: [f64; 2] = [0.3, 0.2];
/// The floor's far edge, from the point that the camera follows (m).
const FAR: f64 = 1.5;

/// A parallel projection: x and z as they are, depth at an angle. A robot in the x-z plane is seen
/// exactly from the side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    /// Pixels per metre.
    pub scale: f64,
    middle: f64,
    floor: f64,
    bottom: f64,
}

impl Camera {
    /// Stands as far away as the capsules need for a picture of this size.
    pub fn new(capsules: &[Capsule], width: u32, height: u32) -> Self {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let mut top = 0.0_f64;
        for capsule in capsules {
            for [x, _, z] in capsule.ends {
                (low, high) = (low.min(x - capsule.radius), high.max(x + capsule.radius));
                top = top.max(z + capsule.radius);
            }
        }
        let size = top.max(high - low);
        let floor = FLOOR * f64::from(height);
        // Nothing there, or nothing that has a size: then any distance does.
        let size = if size.is_finite() && size > 0.0 { size } else { 1.0 };
        Self {
            scale: floor / (ROOM * size),
            middle: 0.5 * f64::from(width),
            floor,
            bottom: f64::from(height),
        }
    }

    /// The pixel of a point, given the point that the camera follows.
    pub fn pixel(&self, centre: [f64; 3], [x, y, z]: [f64; 3]) -> (f32, f32) {
        let x = x - centre[0];
        let y = y - centre[1];
        let right = self.middle + self.scale * (x + DEPTH[0] * y);
        (right as f32, (self.floor - self.scale * (z + DEPTH[1] * y)) as f32)
    }

    /// The ranges of x and y over which the floor fills the picture, relative to the point that the
    /// camera follows (m).
    pub fn floor(&self) -> [[f64; 2]; 2] {
        let near = (self.floor - self.bottom) / (self.scale * DEPTH[1]);
        let half = self.middle / self.scale;
        [[-half - DEPTH[0] * FAR, half - DEPTH[0] * near], [near, FAR]]
    }

    /// From metres on the floor, measured like [`Camera::floor`], to pixels.
    pub fn on_floor(&self) -> Transform {
        let [right, up] = DEPTH.map(|part| (self.scale * part) as f32);
        Transform::from_row(
            self.scale as f32,
            0.0,
            right,
            -up,
            self.middle as f32,
            self.floor as f32,
        )
    }
}
