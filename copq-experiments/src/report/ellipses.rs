//! What critics disagreed about in training, and what bounds make of it.

use std::collections::BTreeMap;

use copq::projection::{Disagreement, by_name};
use copq::{Result, read_weights};
use copq_render::Plane;
use nalgebra::{DMatrix, DVector};

use super::groups::World;
use super::stored::Stored;
use super::{Report, file_name};

/// Bounds that are built on the covariance.
const BOUNDS: [&str; 4] = ["cholesky", "eigen", "extremum", "diagonal"];
/// When in training, as shares of it.
const MOMENTS: [(&str, f64); 3] = [("early", 0.05), ("half-way", 0.5), ("last", 1.0)];

impl Report {
    /// The ellipses of the two most important objectives of each task and method whose runs report
    /// how their critics disagree: a name for a file, and the picture.
    pub fn ellipses(&self) -> Vec<(String, Plane)> {
        let mut all = Vec::new();
        for world in &self.groups.worlds {
            for (label, numbers) in self.groups.labels.iter().zip(&world.runs) {
                if let Some(pair) = numbers.iter().find_map(|&n| self.runs[n].pair(world)) {
                    let name = format!("{}-{}-ellipses", file_name(&world.name), file_name(label));
                    // Numbers that cannot be drawn are still in metrics.csv.
                    all.extend(
                        pair.plane(&format!("{label}: {}", world.short)).ok().map(|p| (name, p)),
                    );
                }
            }
        }
        all
    }
}

/// Two objectives of a run, with the traces of how its critics disagree about them.
struct Pair<'a> {
    names: [&'a str; 2],
    std: [&'a [[f64; 2]]; 2],
    correlation: &'a [[f64; 2]],
    weights: [f32; 2],
    /// The share of these two in the length of all weights.
    share: f32,
}

impl Stored {
    /// The first two objectives whose critics' correlation the run reports.
    fn pair(&self, world: &World) -> Option<Pair<'_>> {
        let trace = |name: &str| {
            let found = self.traces.iter().find(|(known, _)| known == name);
            found.map(|(_, points)| points.as_slice()).filter(|points| !points.is_empty())
        };
        let quantities = self.evaluated.as_ref()?.quantities();
        let titles: Vec<String> = quantities.iter().skip(1).map(|q| q.title()).collect();
        let own = match self.own_weights(&titles) {
            Some(own) => own,
            None if titles.iter().all(|title| world.weights.contains_key(title)) => BTreeMap::new(),
            None => return None,
        };
        let [first, second, ..] = titles.as_slice() else { return None };
        let (name, correlation) = self
            .traces
            .iter()
            .find(|(name, _)| *name == format!("correlation/{first}/{second}"))?;
        let mut names = name.strip_prefix("correlation/")?.split('/');
        let names = [names.next()?, names.next()?];
        // A cost's weight is minus its multiplier, if one is reported.
        let weight = |name: &str| match trace(&format!("multiplier/{name}")) {
            Some(multiplier) => -at(multiplier, f64::INFINITY) as f32,
            None => own.get(name).or(world.weights.get(name)).map_or(1.0, |&weight| weight as f32),
        };
        let weights = names.map(weight);
        let share = length(weights) / length(titles.iter().map(|name| weight(name)));
        let std = [trace(&format!("q_std/{first}"))?, trace(&format!("q_std/{second}"))?];
        (!correlation.is_empty()).then_some(Pair {
            names,
            std,
            correlation,
            weights,
            share: if share.is_finite() { share } else { 1.0 },
        })
    }
}

impl Stored {
    /// The weights that its plan gives to objectives of these names; none if it is not clear which
    /// is whose.
    fn own_weights(&self, titles: &[String]) -> Option<BTreeMap<String, f64>> {
        let plan = self.plan();
        let Some(weights) = plan.and_then(|plan| plan.weights.as_ref()) else {
            return Some(BTreeMap::new());
        };
        // A list is in the task's own order.
        if plan.is_some_and(|plan| plan.order.is_some()) && !weights.contains('=') {
            return None;
        }
        let names: Vec<&str> = titles.iter().map(String::as_str).collect();
        let weights = read_weights(weights, &names).ok()?.into_iter();
        Some(weights.map(|(i, weight)| (titles[i].clone(), f64::from(weight))).collect())
    }
}

impl Pair<'_> {
    fn plane(&self, title: &str) -> Result<Plane> {
        let mut plane = Plane::new(title, self.names);
        for (when, share) in MOMENTS {
            plane = plane.closed(when, self.at(share)?.ellipse([0, 1], 1.0, 90)?);
        }
        let last = self.at(1.0)?;
        for name in BOUNDS {
            let bound = last.bound(by_name(name)?.as_ref(), &self.weights, -self.share)?;
            plane = plane.arrow(name, [[0.0, 0.0], [bound[0], bound[1]]]);
        }
        Ok(plane)
    }

    /// The critics' disagreement after a share of the training.
    fn at(&self, share: f64) -> Result<Disagreement> {
        // Never empty, by `Stored::pair`.
        let step = share * self.correlation.last().map_or(0.0, |point| point[0]);
        let [first, second] = self.std.map(|points| at(points, step));
        let correlation = at(self.correlation, step).clamp(-1.0, 1.0);
        let rest = (1.0 - correlation * correlation).sqrt();
        let factor =
            DMatrix::from_row_slice(2, 2, &[first, 0.0, second * correlation, second * rest]);
        Disagreement::with_factor(&DVector::zeros(2), &factor)
    }
}

/// A trace's value nearest to a step; the last value for a step beyond all.
fn at(points: &[[f64; 2]], step: f64) -> f64 {
    let step = step.min(points.last().map_or(0.0, |point| point[0]));
    let nearest = points.iter().min_by(|a, b| (a[0] - step).abs().total_cmp(&(b[0] - step).abs()));
    nearest.map_or(0.0, |point| point[1])
}

/// The length of a vector of weights.
fn length(weights: impl IntoIterator<Item = f32>) -> f32 {
    weights.into_iter().map(|weight| weight * weight).sum::<f32>().sqrt()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::config::{self, MadeWith, RunConfig};
    use crate::plan::Plan;
    use crate::report::ReportRun;

    #[test]
    fn the_weights_are_a_multiplier_s_and_a_share_of_all() {
        let folder = tempfile::tempdir().unwrap();
        let world = |weights: &[(&str, f64)]| World {
            name: String::new(),
            short: String::new(),
            task: String::new(),
            limits: BTreeMap::new(),
            weights: weights.iter().map(|(name, weight)| ((*name).to_owned(), *weight)).collect(),
            runs: Vec::new(),
        };
        let pair = |metrics: &str, evaluations: &str, weights: &[(&str, f64)]| {
            let path = |name: &str| folder.path().join(name);
            std::fs::write(path("metrics.csv"), metrics).unwrap();
            std::fs::write(path("evaluations.csv"), evaluations).unwrap();
            let run = Stored::read(&ReportRun::new(folder.path()));
            let pair = run.pair(&world(weights)).unwrap();
            (pair.weights, pair.share)
        };
        let (weights, share) = pair(
            "step,q_std/cost,q_std/reward,correlation/cost/reward,multiplier/cost\n\
             10,1,1,0.5,9\n20,1,1,0.5,2\n",
            "step,weighted_total/mean,return/cost/mean,return/reward/mean\n0,1,1,1\n20,1,1,1\n",
            &[("cost", 0.0), ("reward", 1.0)],
        );
        assert_eq!((weights, share), ([-2.0, 1.0], 1.0));
        let (weights, share) = pair(
            "step,q_std/a,q_std/b,correlation/a/b\n20,1,1,0.5\n",
            "step,weighted_total/mean,return/a/mean,return/b/mean,return/c/mean\n\
             0,1,1,1,1\n20,1,1,1,1\n",
            &[("a", 1.0), ("b", 1.0), ("c", 1.0)],
        );
        assert_eq!(weights, [1.0, 1.0]);
        assert!((share - (2f32 / 3.0).sqrt()).abs() < 1e-6, "{share}");
    }

    /// The weights of a Python task are in its plan alone.
    #[test]
    fn a_plans_own_weights_count() {
        let folder = tempfile::tempdir().unwrap();
        let weights = |weights: Option<&str>, order: Option<&str>| {
            let mut plan = Plan::new(&copq::Method::cop_td3());
            plan.weights = weights.map(str::to_owned);
            plan.order = order.map(str::to_owned);
            let config =
                RunConfig { plan, settings: toml::Table::new(), made_with: MadeWith::here() };
            config::write(&folder.path().join("config.toml"), &config).unwrap();
            let run = Stored::read(&ReportRun::new(folder.path()));
            let own = run.own_weights(&["a".to_owned(), "b".to_owned()])?;
            Some(["a", "b"].map(|name| own.get(name).copied()))
        };
        assert_eq!(weights(None, None), Some([None, None]));
        assert_eq!(weights(Some("1,100"), None), Some([Some(1.0), Some(100.0)]));
        assert_eq!(weights(Some("b=3"), Some("ba")), Some([None, Some(3.0)]));
        // The list is in another order than these names, and nobody knows which.
        assert_eq!(weights(Some("1,100"), Some("ba")), None);
    }
}
