//! Rewards against costs.

use copq_render::Plane;

use super::groups::World;
use super::{Report, file_name};
use crate::figure::Quantity;

impl Report {
    /// What each seed earns against what it costs, one picture for each limit: a name for its file,
    /// and the picture.
    pub fn planes(&self) -> Vec<(String, Plane)> {
        let limited = self.groups.worlds.iter().flat_map(|world| {
            world.limits.iter().map(move |(cost, &limit)| (world, cost.as_str(), limit))
        });
        limited
            .filter(|(world, ..)| self.has_ends(world))
            .map(|(world, cost, limit)| {
                let name = file_name(&format!("{} {cost}", world.name));
                (name, self.plane(world, cost, limit))
            })
            .collect()
    }

    /// Whether a method has come far enough for a dot.
    fn has_ends(&self, world: &World) -> bool {
        let labels = 0..self.groups.labels.len();
        labels.into_iter().any(|i| !self.ends(world, i, &Quantity::WeightedTotal).is_empty())
    }

    fn plane(&self, world: &World, cost: &str, limit: f64) -> Plane {
        let axes = [cost, "weighted total"];
        let title = format!("{}: {cost} and total", world.short);
        let labels = self.groups.labels.iter().enumerate();
        labels.fold(Plane::new(title, axes).limit(limit), |plane, (i, label)| {
            let quantities = [Quantity::Return(cost.to_owned()), Quantity::WeightedTotal];
            let [costs, totals] = quantities.map(|quantity| self.ends(world, i, &quantity));
            plane.points(label, costs.into_iter().zip(totals).map(|(x, y)| [x, y]).collect())
        })
    }
}
