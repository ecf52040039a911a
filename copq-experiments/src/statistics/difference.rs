//! What sets two methods apart: the difference of their means, and the seeds that would tell it.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::mean;

/// Shares of errors in [`Sample::seeds_to_tell`]: two-sided level and power.
const LEVEL: f64 = 0.95;
const POWER: f64 = 0.8;
/// More seeds than this nobody runs.
const MOST: usize = 10_000;

/// A method's seeds in three numbers, such as a paper has them.
///
/// ```
/// use copq_experiments::statistics::Sample;
///
/// // Table 2 of the paper, walker2d: COP-Q and clipped double-Q, five seeds each.
/// let ours = Sample { mean: 5_185.0, std: 465.0, seeds: 5 };
/// let theirs = Sample { mean: 3_626.0, std: 1_402.0, seeds: 5 };
/// let [low, high] = ours.difference(&theirs).unwrap_or_default();
/// assert!(low < 0.0 && 0.0 < high); // five seeds leave it open
/// assert_eq!(ours.seeds_to_tell(&theirs, 5_185.0 - 3_626.0), Some(9));
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
    /// Of each seed's number.
    pub fn of(values: &[f64]) -> Self {
        let centre = mean(values);
        let squares: f64 = values.iter().map(|value| (value - centre).powi(2)).sum();
        let std = (squares / values.len().saturating_sub(1) as f64).sqrt();
        Self { mean: centre, std, seeds: values.len() }
    }

    /// A number that no seed changes, such as a limit.
    pub fn exactly(number: f64) -> Self {
        Self { mean: number, std: 0.0, seeds: usize::MAX }
    }

    /// Welch's interval at 95 % for how far this mean lies above another (of an exact number
    /// Student's); none for fewer than two seeds of either, or numbers that are none.
    ///
    /// It takes seeds for normal, and is right for three seeds as well, where the
    /// [`Bootstrap`](super::Bootstrap) is too short.
    pub fn difference(&self, other: &Self) -> Option<[f64; 2]> {
        if self.seeds.min(other.seeds) < 2 {
            return None;
        }
        let middle = self.mean - other.mean;
        let both = [self, other].map(|sample| (sample.std.powi(2), sample.seeds as f64));
        let half = half_width(both, [0.5 * (1.0 + LEVEL)])?;
        Some([middle - half, middle + half]).filter(|ends| ends.iter().all(|end| end.is_finite()))
    }

    /// How many seeds of each it takes to tell a difference of the means from none four times in
    /// five, by an interval at 95 %, if seeds scatter as these do; none for more than 10,000.
    pub fn seeds_to_tell(&self, other: &Self, difference: f64) -> Option<usize> {
        let is_told = |seeds: usize| {
            let both = [self, other].map(|sample| (sample.std.powi(2), seeds as f64));
            half_width(both, [0.5 * (1.0 + LEVEL), POWER])
                .is_some_and(|half| half < difference.abs())
        };
        let seeds: Vec<usize> = (2..=MOST).collect();
        seeds.get(seeds.partition_point(|&seeds| !is_told(seeds))).copied()
    }
}

/// Some quantiles of Student's t, in standard errors of the difference of two means, each of a
/// variance and a number of seeds.
fn half_width<const N: usize>(both: [(f64, f64); 2], shares: [f64; N]) -> Option<f64> {
    let errors = both.map(|(variance, seeds)| variance / seeds);
    let error: f64 = errors.iter().sum();
    if error == 0.0 {
        // Seeds that are all alike leave no doubt.
        return Some(0.0);
    }
    let parts = errors.iter().zip(both).map(|(error, (_, seeds))| error.powi(2) / (seeds - 1.0));
    let freedom = error.powi(2) / parts.sum::<f64>();
    let law = StudentsT::new(0.0, 1.0, freedom).ok()?;
    Some(error.sqrt() * shares.map(|share| law.inverse_cdf(share)).iter().sum::<f64>())
}

#[cfg(test)]
mod tests {
    use copq::{Rng, Stream};

    use super::*;

    /// SciPy's numbers (`tests/data/make_statistics.py`).
    #[test]
    fn scipys_intervals() {
        let reference: serde_json::Value =
            serde_json::from_str(include_str!("../../tests/data/statistics.json")).unwrap();
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
        };
        for case in reference["cases"].as_array().unwrap() {
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
            let sample = Sample { mean: 0.0, std, seeds: 5 };
            let seeds = sample.seeds_to_tell(&sample, difference).unwrap();
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
        assert_eq!(alike.difference(&Sample::exactly(900.0)), Some([100.0, 100.0]));
        assert_eq!(alike.seeds_to_tell(&alike, 1.0), Some(2));
        assert_eq!(alike.seeds_to_tell(&alike, 0.0), None);
        let wide = Sample::of(&[0.0, 1.0, 2.0]);
        assert_eq!(wide.seeds_to_tell(&wide, 1e-6), None);
        for few in [Sample::of(&[1.0]), Sample::of(&[]), Sample::of(&[1.0, f64::NAN, 2.0])] {
            assert_eq!(
                (few.difference(&Sample::exactly(0.0)), few.difference(&wide)),
                (None, None)
            );
            assert_eq!(few.seeds_to_tell(&wide, 1.0), None);
        }
    }
}
