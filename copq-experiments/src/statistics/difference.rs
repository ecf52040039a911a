//! What sets two methods apart: the difference of their means, and how many seeds would show it.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::mean;

/// The level of intervals.
const LEVEL: f64 = 0.95;
/// Nobody runs more seeds than this.
const MOST: usize = 10_000;

/// A method's seeds in three numbers, as a paper reports them.
///
/// ```
/// use copq_experiments::statistics::Sample;
///
/// // Table 2 of the paper, walker2d: COP-Q and clipped double-Q, five seeds each.
/// let ours = Sample::published(5_185.0, 465.0, 5);
/// let theirs = Sample::published(3_626.0, 1_402.0, 5);
/// let [low, high] = ours.difference(&theirs).unwrap_or_default();
/// assert!(low < 0.0 && 0.0 < high); // five seeds leave it open
/// assert_eq!(ours.seeds_to_tell(&theirs, 0.8), Some(11));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The mean over seeds.
    pub mean: f64,
    /// The standard deviation of a seed (the sum of squares divided by n - 1).
    pub std: f64,
    /// How many seeds.
    pub seeds: usize,
}

impl Sample {
    /// From each seed's number.
    pub fn of(values: &[f64]) -> Self {
        let centre = mean(values);
        let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
        let std = (squares / values.len().saturating_sub(1) as f64).sqrt();
        // Equal numbers have no scatter, however their mean is rounded.
        let is_one_number = values.len() > 1 && values.iter().all(|value| *value == values[0]);
        let std = if is_one_number { 0.0 } else { std };
        Self { mean: centre, std, seeds: values.len() }
    }

    /// From a paper's mean and standard deviation, if the latter is the sum of squares divided by
    /// n.
    pub fn published(mean: f64, std: f64, seeds: usize) -> Self {
        let n = seeds as f64;
        Self { mean, std: std * (n / (n - 1.0)).sqrt(), seeds }
    }

    /// A number that no seed changes, such as a limit.
    pub fn exactly(number: f64) -> Self {
        Self { mean: number, std: 0.0, seeds: usize::MAX }
    }

    /// Whether it is such an exact number.
    pub fn is_exact(&self) -> bool {
        self.seeds == usize::MAX
    }

    /// Every seed's number times a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { mean: factor * self.mean, std: factor.abs() * self.std, ..*self }
    }

    /// Welch's interval at 95 % for how far this mean lies above another (Student's, if one is
    /// exact); none for fewer than two seeds of either, for seeds that are all alike, or for
    /// numbers that are not finite.
    ///
    /// It assumes that seeds are normally distributed. If they are, it is right even for three,
    /// where the [`Bootstrap`](super::Bootstrap) is too short. If some seeds are stuck and others
    /// are not, it contains the true difference less often than it says.
    pub fn difference(&self, other: &Self) -> Option<[f64; 2]> {
        if self.seeds.min(other.seeds) < 2 {
            return None;
        }
        let middle = self.mean - other.mean;
        let both = [self, other].map(|sample| (sample.std.powi(2), sample.seeds as f64));
        let half = half_width(both, &[0.5 * (1.0 + LEVEL)])?;
        Some([middle - half, middle + half]).filter(|ends| ends.iter().all(|end| end.is_finite()))
    }

    /// How many seeds of each it takes to tell this difference of means from none with
    /// [`Sample::difference`], with probability `power`, if these are the true means and standard
    /// deviations; none for more than 10,000, if there is no difference, or if `power` is not
    /// between 0 and 1.
    pub fn seeds_to_tell(&self, other: &Self, power: f64) -> Option<usize> {
        if !(power > 0.0 && power < 1.0) {
            return None;
        }
        let difference = (self.mean - other.mean).abs();
        let is_told = |seeds: usize| {
            let both = [self, other].map(|sample| (sample.std.powi(2), seeds as f64));
            let half = half_width(both, &[0.5 * (1.0 + LEVEL), power]);
            half.is_some_and(|half| half < difference)
        };
        // More seeds can also tell what fewer can.
        let (mut too_few, mut enough) = (1, MOST);
        if !is_told(enough) {
            return None;
        }
        while enough - too_few > 1 {
            let middle = too_few.midpoint(enough);
            *(if is_told(middle) { &mut enough } else { &mut too_few }) = middle;
        }
        Some(enough)
    }
}

/// The sum of some quantiles of Student's t, times the standard error of the difference of two
/// means, each given by a variance and a number of seeds. A test at one quantile has the power of
/// another where the difference is as large as both together.
fn half_width(both: [(f64, f64); 2], shares: &[f64]) -> Option<f64> {
    let errors = both.map(|(variance, seeds)| variance / seeds);
    let error: f64 = errors.iter().sum();
    if error == 0.0 {
        return None;
    }
    let parts = errors.iter().zip(both).map(|(error, (_, seeds))| error.powi(2) / (seeds - 1.0));
    let freedom = error.powi(2) / parts.sum::<f64>();
    let law = StudentsT::new(0.0, 1.0, freedom).ok()?;
    Some(error.sqrt() * shares.iter().map(|&share| law.inverse_cdf(share)).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use copq::{Rng, Stream};

    use super::*;
    use crate::statistics::tests::{cases, numbers};

    #[test]
    fn scipys_intervals() {
        for case in cases() {
            let [first, second] = ["first", "second"].map(|name| Sample::of(&numbers(&case[name])));
            for (got, name) in [
                (first.difference(&second), "welch"),
                (first.difference(&Sample::exactly(100.0)), "student"),
            ] {
                let wanted = numbers(&case[name]);
                for (got, wanted) in got.unwrap().into_iter().zip(wanted) {
                    assert!((got - wanted).abs() < 1e-6 * (1.0 + wanted.abs()), "{name}: {got}");
                }
            }
        }
    }

    /// With as many seeds as it says, the difference is told as often as it says.
    #[test]
    fn so_many_seeds_tell_a_difference() {
        let mut rng = Rng::new(4, Stream::Custom);
        for (std, difference) in [(1.0, 3.0), (1.0, 1.5), (2.0, 1.5)] {
            let [more, less] = [difference, 0.0].map(|mean| Sample { mean, std, seeds: 5 });
            let seeds = more.seeds_to_tell(&less, 0.8).unwrap();
            let experiments = 2_000;
            let told = (0..experiments).filter(|_| {
                let mut draw = |mean: f64| -> Vec<f64> {
                    (0..seeds).map(|_| mean + std * rng.normal()).collect()
                };
                let [first, second] = [difference, 0.0].map(|mean| Sample::of(&draw(mean)));
                first.difference(&second).unwrap()[0] > 0.0
            });
            let share = told.count() as f64 / f64::from(experiments);
            assert!((0.76..0.92).contains(&share), "{seeds} seeds: {share}");
        }
    }

    #[test]
    fn what_cannot_be_told() {
        let alike = Sample::of(&[1_000.0; 3]);
        assert_eq!(alike.difference(&Sample::exactly(900.0)), None);
        assert_eq!(alike.seeds_to_tell(&Sample::exactly(999.0), 0.8), None);
        let wide = Sample::of(&[0.0, 1.0, 2.0]);
        let far = Sample { mean: 9.0, ..wide };
        assert!(wide.seeds_to_tell(&far, 0.99).is_some());
        for power in [-0.1, 0.0, 1.0, 80.0, f64::NAN] {
            assert_eq!(wide.seeds_to_tell(&far, power), None, "{power}");
        }
        assert_eq!(wide.seeds_to_tell(&Sample { mean: 1.0 + 1e-6, ..wide }, 0.8), None);
        for few in [Sample::of(&[1.0]), Sample::of(&[]), Sample::of(&[1.0, f64::NAN, 2.0])] {
            assert_eq!(
                (few.difference(&Sample::exactly(0.0)), few.difference(&wide)),
                (None, None)
            );
            assert_eq!(few.seeds_to_tell(&wide, 0.8), None);
        }
    }
}
