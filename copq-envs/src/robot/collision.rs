//! Which pairs of geoms may touch: MuJoCo's rule.

use super::{Geom, RobotSpec};

impl RobotSpec {
    /// Whether geoms `a` and `b` (indices) may touch: the bits of one's type and the other's affinity meet, and their
    /// bodies are neither the same nor parent and child. The world counts as nobody's parent here.
    pub fn collide(&self, a: usize, b: usize) -> bool {
        let (a, b) = (&self.geoms[a], &self.geoms[b]);
        bits_meet(a, b) && a.body != b.body && !self.is_parent(a, b) && !self.is_parent(b, a)
    }

    fn is_parent(&self, parent: &Geom, child: &Geom) -> bool {
        parent.body.is_some() && child.body.is_some_and(|body| self.bodies[body].parent == parent.body)
    }
}

fn bits_meet(a: &Geom, b: &Geom) -> bool {
    a.contype & b.conaffinity != 0 || b.contype & a.conaffinity != 0
}
