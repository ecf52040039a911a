//! The curves in a run's `evaluations.csv`.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::Path;

use copq::{Error, Result};

use copq_render::Point;

use crate::numbers::grouped;
use crate::sheet::Sheet;
use crate::statistics::area_under;

/// How many of the last evaluations are taken together.
pub(crate) const LAST: usize = 5;

/// Steps and values of one run.
pub(crate) type Line = Vec<[f64; 2]>;

/// A run's evaluations: the file's numbers, read once.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    steps: Vec<u64>,
    columns: Vec<(String, Vec<f64>)>,
    /// Why there are no more.
    damage: Option<String>,
}

/// What a curve shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Quantity {
    WeightedTotal,
    Return(String),
}

impl Quantity {
    /// The beginning of its columns' names.
    fn column(&self) -> String {
        match self {
            Self::WeightedTotal => "weighted_total".to_owned(),
            Self::Return(objective) => format!("return/{objective}"),
        }
    }

    pub(crate) fn title(&self) -> String {
        match self {
            Self::WeightedTotal => "weighted total".to_owned(),
            Self::Return(objective) => objective.clone(),
        }
    }
}

impl Evaluated {
    /// Reads `evaluations.csv` in a run's folder; an error if there is no evaluation, or a damaged
    /// one.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("evaluations.csv");
        let invalid = |wanted: &str, got: &str| {
            Error::invalid(format!("'{}'", path.display()), wanted.to_owned(), got)
        };
        match Self::read_if_any(folder)? {
            None => Err(invalid("at least one evaluation", "none")),
            Some(Self { damage: Some(damage), .. }) => Err(invalid("whole rows", &damage)),
            Some(evaluated) => Ok(evaluated),
        }
    }

    /// The evaluations up to a damaged row; `None` if there is no evaluation yet.
    pub(crate) fn read_if_any(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join("evaluations.csv");
        if !path.exists() {
            return Ok(None);
        }
        let sheet = Sheet::read(&path)?;
        let column = |name: &String| Some((name.clone(), sheet.column(name)?));
        let columns = sheet.columns().iter().filter_map(column).collect();
        let steps = sheet.steps();
        if steps.is_empty() {
            return sheet.damage(&path).map_or(Ok(None), Err);
        }
        let damage = sheet.damage(&path).map(|damage| damage.to_string());
        Ok(Some(Self { steps, columns, damage }))
    }

    /// Why there are no more evaluations, if a row is damaged.
    pub(crate) fn damage(&self) -> Option<&String> {
        self.damage.as_ref()
    }

    /// The evaluations up to a step.
    pub(crate) fn until(mut self, end: u64) -> Self {
        let count = self.steps.iter().take_while(|&&step| step <= end).count();
        self.steps.truncate(count);
        self.columns.iter_mut().for_each(|(_, values)| values.truncate(count));
        self
    }

    /// The weighted total, then the objectives in the order of their priority.
    pub(crate) fn quantities(&self) -> Vec<Quantity> {
        let objective = |(column, _): &(String, Vec<f64>)| {
            Some(column.strip_prefix("return/")?.strip_suffix("/mean")?.to_owned())
        };
        let objectives = self.columns.iter().filter_map(objective).map(Quantity::Return);
        std::iter::once(Quantity::WeightedTotal).chain(objectives).collect()
    }

    /// Mean, lowest and highest episode of each evaluation.
    pub(crate) fn over_episodes(&self, quantity: &Quantity) -> Vec<Point> {
        let [middle, low, high] =
            ["mean", "min", "max"].map(|statistic| self.statistic(quantity, statistic));
        let steps = self.steps.iter().enumerate();
        let point =
            |(i, &step)| Point { step: step as f64, middle: middle[i], low: low[i], high: high[i] };
        steps.map(point).collect()
    }

    /// For each objective, at each evaluation: how much more the critics expect at an episode's
    /// start than it then returns.
    pub(crate) fn value_errors(&self) -> Vec<(String, Line)> {
        let error = |(name, expected): &(String, Vec<f64>)| {
            let objective = name.strip_prefix("q_start/")?;
            let came = self.columns.iter().find(|(name, _)| {
                name.strip_prefix("discounted/").is_some_and(|came| came == objective)
            });
            let points = self.steps.iter().zip(expected.iter().zip(&came?.1));
            let points = points.map(|(&step, (expected, came))| [step as f64, expected - came]);
            let points: Vec<_> = points.filter(|point| point[1].is_finite()).collect();
            (!points.is_empty()).then(|| (format!("value_error/{objective}"), points))
        };
        self.columns.iter().filter_map(error).collect()
    }

    /// The step of the last evaluation.
    pub(crate) fn last_step(&self) -> u64 {
        self.steps.last().copied().unwrap_or(0)
    }

    /// The step of the last evaluation up to a step.
    fn last_until(&self, end: u64) -> u64 {
        self.steps.iter().rev().copied().find(|&step| step <= end).unwrap_or(0)
    }

    /// Step and mean return of each evaluation.
    pub(crate) fn means(&self, quantity: &Quantity) -> Line {
        self.means_until(quantity, u64::MAX)
    }

    /// The same up to a step.
    pub(crate) fn means_until(&self, quantity: &Quantity, end: u64) -> Line {
        let means = self.steps.iter().zip(self.statistic(quantity, "mean"));
        let until = means.filter(|(step, _)| **step <= end);
        until.map(|(&step, value)| [step as f64, value]).collect()
    }

    /// Steps and means of the evaluations up to a step, without that of step 0, whose policy has
    /// not trained.
    pub(crate) fn trained(&self, quantity: &Quantity, end: u64) -> (Vec<f64>, Vec<f64>) {
        let means = self.means_until(quantity, end).into_iter();
        means.filter(|[step, _]| *step > 0.0).map(|[step, value]| (step, value)).unzip()
    }

    /// How this run's evaluations differ from another's, before the end of either: how often, and
    /// over how many episodes.
    pub(crate) fn unlike(&self, other: &Self) -> Option<String> {
        let end = self.last_step().min(other.last_step());
        let [ours, theirs] = [self, other].map(|run| run.evaluations_before(end));
        if ours == theirs {
            return None;
        }
        let words = [ours, theirs].map(|(steps, mut episodes)| {
            episodes.sort_unstable();
            episodes.dedup();
            let counts: Vec<String> = episodes.iter().map(u64::to_string).collect();
            let known =
                (!counts.is_empty()).then(|| format!(" of {} episodes", counts.join(" or ")));
            format!("{} evaluations{}", steps.len(), known.unwrap_or_default())
        });
        let end = grouped(end);
        Some(match words {
            [ours, theirs] if ours == theirs => format!("{ours} before step {end}, but at others"),
            [ours, theirs] => format!("{ours} before step {end}, not {theirs}"),
        })
    }

    /// Steps and episodes of the evaluations before a step.
    fn evaluations_before(&self, end: u64) -> (&[u64], Vec<u64>) {
        let count = self.steps.partition_point(|&step| step < end);
        let episodes = self.columns.iter().find(|(name, _)| name == "episodes");
        let episodes = episodes.map_or(&[][..], |(_, episodes)| &episodes[..count]);
        (&self.steps[..count], episodes.iter().map(|&episodes| episodes as u64).collect())
    }

    /// The area under the weighted total's curve up to a step, over its length.
    pub(crate) fn area(&self, end: u64) -> f64 {
        let means = self.means_until(&Quantity::WeightedTotal, end).into_iter();
        let (steps, values): (Vec<_>, Vec<_>) = means.map(|[step, value]| (step, value)).unzip();
        area_under(&steps, &values)
    }

    /// One number per evaluation, NaN where there is none.
    fn statistic(&self, quantity: &Quantity, statistic: &str) -> Vec<f64> {
        let name = format!("{}/{statistic}", quantity.column());
        let column = self.columns.iter().find(|(column, _)| *column == name);
        column.map_or_else(|| vec![f64::NAN; self.steps.len()], |(_, values)| values.clone())
    }
}

/// Every quantity that any run has: the weighted total, then objectives in the runs' order.
pub(crate) fn quantities<'a>(runs: impl Iterator<Item = &'a Evaluated>) -> Vec<Quantity> {
    let mut all = vec![Quantity::WeightedTotal];
    for quantity in runs.flat_map(Evaluated::quantities) {
        if !all.contains(&quantity) {
            all.push(quantity);
        }
    }
    all
}

/// The steps that all lines have, each with their values there.
pub(crate) fn at_shared_steps(lines: &[Line]) -> Vec<(f64, Vec<f64>)> {
    // Steps are whole numbers, or means of such, that seeds share to the bit.
    let mut by_step: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for &[step, value] in lines.iter().flatten() {
        by_step.entry(step.to_bits()).or_default().push(value);
    }
    by_step.retain(|_, values| values.len() == lines.len());
    by_step.into_iter().map(|(step, values)| (f64::from_bits(step), values)).collect()
}

/// The step up to which runs are compared, each by its evaluations until then. Of the runs' last
/// evaluations up to the step that all have reached, it is the one that the other runs' evaluations
/// lag behind least.
pub(crate) fn common_end<'a>(runs: impl Iterator<Item = &'a Evaluated> + Clone) -> u64 {
    let reached = runs.clone().map(Evaluated::last_step).min().unwrap_or(0);
    let last = |end| runs.clone().map(move |run| run.last_until(end));
    let behind = |end: u64| end - last(end).min().unwrap_or(end);
    last(reached).min_by_key(|&end| (behind(end), Reverse(end))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evaluated so often, up to a step.
    fn every(interval: usize, last: u64) -> Evaluated {
        let steps: Vec<u64> = (0..=last).step_by(interval).collect();
        let episodes = vec![10.0; steps.len()];
        Evaluated { steps, columns: vec![("episodes".to_owned(), episodes)], damage: None }
    }

    #[test]
    fn runs_are_compared_where_all_are_evaluated() {
        let end = |runs: &[(usize, u64)]| {
            let runs: Vec<_> = runs.iter().map(|&(interval, last)| every(interval, last)).collect();
            common_end(runs.iter())
        };
        assert_eq!(end(&[]), 0);
        assert_eq!(end(&[(5_000, 300_000), (5_000, 150_000)]), 150_000);
        assert_eq!(end(&[(5_000, 150_000), (20_000, 300_000)]), 140_000);
        // Where they share no step, the one that leaves the others least behind.
        assert_eq!(end(&[(5_000, 200_000), (20_480, 300_000)]), 184_320);
        assert_eq!(end(&[(5_000, 200_000), (20_480, 184_320)]), 184_320);
    }

    #[test]
    fn seeds_that_are_evaluated_otherwise_say_so() {
        let usual = every(10, 100);
        assert_eq!(usual.unlike(&every(10, 60)), None);
        // A last evaluation at a run's end is nothing else.
        let mut ended = every(10, 60);
        ended.steps.push(65);
        ended.columns[0].1.push(10.0);
        assert_eq!(usual.unlike(&ended), None);
        let rare = every(20, 100).unlike(&usual).unwrap();
        let wanted =
            "5 evaluations of 10 episodes before step 100, not 10 evaluations of 10 episodes";
        assert_eq!(rare, wanted);
        let mut short = every(10, 100);
        short.columns[0].1[3] = 5.0;
        let short = short.unlike(&usual).unwrap();
        assert!(short.starts_with("10 evaluations of 5 or 10 episodes before step 100"), "{short}");
        let mut late = every(10, 100);
        late.steps[3] = 31;
        let late = late.unlike(&usual).unwrap();
        assert_eq!(late, "10 evaluations of 10 episodes before step 100, but at others");
    }
}
