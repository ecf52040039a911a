//! The seeds of a method on a task, and up to which step they are compared.

use super::Report;
use super::groups::World;
use super::paper::Measure;
use super::table::Cell;
use crate::figure::{Evaluated, LAST, Line, Quantity, common_end};
use crate::standing::Standing;
use crate::statistics::mean;

/// The seeds of a method on a task.
pub(super) struct Seeds<'a> {
    seeds: Vec<&'a Evaluated>,
    /// The step up to which they are compared: one that all have reached.
    pub(super) end: u64,
    /// Runs that have begun.
    pub(super) begun: usize,
}

impl Seeds<'_> {
    /// The values of a quantity up to a step, one list per seed.
    pub(super) fn values(&self, quantity: &Quantity, end: u64) -> Vec<Line> {
        self.seeds.iter().map(|seed| seed.means_until(quantity, end)).collect()
    }

    /// The cell of each seed's number.
    pub(super) fn cell(&self, values: &[f64]) -> Cell {
        Cell::of(values, self.begun)
    }

    /// One number per seed, of a quantity up to a step; none if a seed has fewer evaluations than
    /// the measure needs.
    pub(super) fn measured(&self, measure: Measure, quantity: &Quantity, end: u64) -> Vec<f64> {
        let curves = self.values(quantity, end);
        if measure.is_early(&curves) {
            return Vec::new();
        }
        curves.iter().map(|curve| measure.of(curve, None)).collect()
    }

    /// The same for the weighted totals up to the end.
    pub(super) fn totals(&self, measure: Measure) -> Vec<f64> {
        self.measured(measure, &Quantity::WeightedTotal, self.end)
    }

    pub(super) fn len(&self) -> usize {
        self.seeds.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.seeds.is_empty()
    }

    /// How many steps each seed's last few evaluations span, if it has that many.
    pub(super) fn spans(&self) -> Vec<u64> {
        let curves = self.values(&Quantity::WeightedTotal, self.end);
        let span = |curve: &Line| Some((curve.last()?[0] - curve.iter().nth_back(LAST)?[0]) as u64);
        curves.iter().filter_map(span).collect()
    }

    /// The last step that all of them have reached.
    pub(super) fn reached(&self) -> u64 {
        self.seeds.iter().map(|seed| seed.last_step()).min().unwrap_or(0)
    }

    /// The step up to which they are compared with another method's.
    pub(super) fn common_end(&self, other: &Self) -> u64 {
        common_end(self.seeds.iter().chain(&other.seeds).copied())
    }
}

impl Report {
    pub(super) fn seeds(&self, world: &World, label: usize) -> Seeds<'_> {
        let numbers = &world.runs[label];
        let begun = numbers.iter().filter(|&&n| self.runs[n].standing != Standing::Waiting);
        let seeds = self.far_enough(numbers);
        let end = common_end(seeds.iter().copied());
        Seeds { seeds, end, begun: begun.count() }
    }

    /// The ends of all methods on a task, in order.
    pub(super) fn all_ends(&self, world: &World) -> Vec<u64> {
        let seeds = (0..self.groups.labels.len()).map(|label| self.seeds(world, label));
        let mut ends: Vec<u64> = seeds.filter(|s| !s.is_empty()).map(|s| s.end).collect();
        ends.sort_unstable();
        ends
    }

    /// Each seed's mean of the last few evaluations; none if a seed has fewer.
    pub(super) fn ends(&self, world: &World, label: usize, quantity: &Quantity) -> Vec<f64> {
        let seeds = self.seeds(world, label);
        seeds.measured(Measure::LastFive, quantity, seeds.end)
    }

    /// Whether a method's mean cost exceeds its limit on a task, by those evaluations.
    pub(super) fn exceeds(&self, world: &World, label: usize) -> bool {
        world.limits.iter().any(|(cost, &limit)| {
            mean(&self.ends(world, label, &Quantity::Return(cost.clone()))) > limit
        })
    }
}
