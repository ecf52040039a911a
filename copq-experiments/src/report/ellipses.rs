//! What critics disagreed about in training, and what bounds make of it.

use copq::Result;
use copq::projection::{Disagreement, by_name};
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
                let runs = numbers.iter().map(|&number| &self.runs[number]);
                if let Some(run) = runs.into_iter().find(|run| run.pair(world).is_some())
                    && let Some(pair) = run.pair(world)
                {
                    let name = format!("{}-{}-ellipses", file_name(&world.name), file_name(label));
                    // Numbers that no picture can be made of are in metrics.csv all the same.
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
        let [first, second, ..] = titles.as_slice() else { return None };
        let (name, correlation) = self
            .traces
            .iter()
            .find(|(name, _)| *name == format!("correlation/{first}/{second}"))?;
        let mut names = name.strip_prefix("correlation/")?.split('/');
        let names = [names.next()?, names.next()?];
        let weight = |name: &str| world.weights.get(name).map_or(1.0, |&weight| weight as f32);
        let std = [trace(&format!("q_std/{first}"))?, trace(&format!("q_std/{second}"))?];
        (!correlation.is_empty()).then_some(Pair {
            names,
            std,
            correlation,
            weights: names.map(weight),
        })
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
            let bound = last.bound(by_name(name)?.as_ref(), &self.weights, -1.0)?;
            plane = plane.arrow(name, [[0.0, 0.0], [bound[0], bound[1]]]);
        }
        Ok(plane)
    }

    /// The critics' disagreement when a share of the training is over.
    fn at(&self, share: f64) -> Result<Disagreement> {
        // Never empty, by `Stored::pair`.
        let step = share * self.correlation.last().map_or(0.0, |point| point[0]);
        let value = |points: &[[f64; 2]]| {
            let nearest =
                points.iter().min_by(|a, b| (a[0] - step).abs().total_cmp(&(b[0] - step).abs()));
            nearest.map_or(0.0, |point| point[1])
        };
        let [first, second] = self.std.map(value);
        let correlation = value(self.correlation).clamp(-1.0, 1.0);
        let rest = (1.0 - correlation * correlation).sqrt();
        let factor =
            DMatrix::from_row_slice(2, 2, &[first, 0.0, second * correlation, second * rest]);
        Disagreement::with_factor(&DVector::zeros(2), &factor)
    }
}
