//! Which pairs of geoms may touch: MuJoCo's rule.

use super::{Geom, RobotSpec};

impl RobotSpec {
    /// Whether geoms `a` and `b` (indices) may touch. They may if one's type and the other's
    /// affinity share a bit, and their bodies are neither the same nor parent and child. A body
    /// without joints counts as one with its parent. The world counts as nobody's parent here.
    pub fn collide(&self, a: usize, b: usize) -> bool {
        let a = &self.geoms[a];
        let b = &self.geoms[b];
        let bodies = [a, b].map(|geom| self.welded(geom.body));
        bits_meet(a, b)
            && bodies[0] != bodies[1]
            && !self.is_parent(bodies)
            && !self.is_parent([bodies[1], bodies[0]])
    }

    fn is_parent(&self, [parent, child]: [Option<usize>; 2]) -> bool {
        parent.is_some()
            && child.is_some_and(|child| self.welded(self.bodies[child].parent) == parent)
    }

    /// The body or, if it has no joints, the next one above that has; `None` is the world.
    fn welded(&self, body: Option<usize>) -> Option<usize> {
        let fixed = body.filter(|&body| self.joints_of(body).next().is_none());
        fixed.map_or(body, |fixed| self.welded(self.bodies[fixed].parent))
    }
}

fn bits_meet(a: &Geom, b: &Geom) -> bool {
    a.contype & b.conaffinity != 0 || b.contype & a.conaffinity != 0
}
