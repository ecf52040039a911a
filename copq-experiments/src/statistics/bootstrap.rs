//! Intervals over seeds by resampling them.

use copq::{Rng, Stream};

/// The fewest seeds of a task for which there is an interval.
pub const FEWEST: usize = 3;

/// The stratified percentile bootstrap: seeds are resampled within each task. It is seeded, so that
/// a table has the same intervals every time.
///
/// With few seeds an interval is too short for its level. For the mean of normal values at 95 %,
/// the interval of three seeds (from the lowest to the highest) contains the true mean three times
/// in four, that of five seeds four times in five, and that of ten nine times in ten. A statistic
/// of several tasks' seeds together weights a task by its seeds, so each should have equally many.
///
/// ```
/// use copq_experiments::statistics::{Bootstrap, mean};
///
/// let seeds = [10.0, 12.0, 11.0, 9.0, 13.0];
/// let [low, high] = Bootstrap::default().interval(&[&seeds[..]], mean).unwrap_or_default();
/// assert!(9.0 < low && low < 11.0 && 11.0 < high && high < 13.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bootstrap {
    /// How many times all seeds are drawn.
    pub draws: usize,
    /// The share of the draws that the interval covers, from 0 to 1.
    pub level: f64,
    /// The seed of the draws.
    pub seed: u64,
}

impl Default for Bootstrap {
    /// 10,000 draws and 95 %.
    fn default() -> Self {
        Self { draws: 10_000, level: 0.95, seed: 0 }
    }
}

impl Bootstrap {
    /// The interval of a statistic of all tasks' seeds together, each task being a slice of
    /// `tasks`; none if a task has fewer than [`FEWEST`], or if the statistic of one of the draws
    /// is not finite.
    pub fn interval<S: AsRef<[f64]>>(
        &self,
        tasks: &[S],
        statistic: impl Fn(&[f64]) -> f64,
    ) -> Option<[f64; 2]> {
        if tasks.is_empty() || tasks.iter().any(|seeds| seeds.as_ref().len() < FEWEST) {
            return None;
        }
        let mut rng = Rng::new(self.seed, Stream::Custom);
        let mut drawn = Vec::new();
        let mut statistics: Vec<f64> = (0..self.draws.max(1))
            .map(|_| {
                drawn.clear();
                for seeds in tasks.iter().map(AsRef::as_ref) {
                    drawn.extend(seeds.iter().map(|_| seeds[rng.below(seeds.len())]));
                }
                statistic(&drawn)
            })
            .collect();
        if statistics.iter().any(|statistic| !statistic.is_finite()) {
            return None;
        }
        statistics.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.level.clamp(0.0, 1.0));
        Some([quantile(&statistics, tail), quantile(&statistics, 1.0 - tail)])
    }
}

/// Interpolates between the two neighbouring sorted values, as NumPy's `quantile` does.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let below = at.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::mean;

    #[test]
    fn quantiles_lie_between_their_neighbours() {
        let sorted = [1.0, 2.0, 4.0];
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(|q| quantile(&sorted, q)),
            [1.0, 1.5, 2.0, 3.0, 4.0]
        );
    }

    /// Some draws have it, and some have not.
    #[test]
    fn a_seed_that_is_no_number_leaves_no_interval() {
        for broken in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let seeds = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, broken];
            assert_eq!(Bootstrap::default().interval(&[seeds], mean), None);
        }
    }

    /// Of intervals at 95 % for the mean of 30 draws of a skewed law, nearly that share holds the
    /// true mean; and of two tasks together, too.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut rng = Rng::new(1, Stream::Custom);
        let bootstrap = Bootstrap { draws: 400, ..Bootstrap::default() };
        let mut held = [0, 0];
        let experiments = 600;
        for _ in 0..experiments {
            let mut draw = |scale: f64| -> Vec<f64> {
                (0..30).map(|_| -scale * (1.0 - rng.uniform()).ln()).collect()
            };
            let one = draw(1.0);
            let two = [draw(1.0), draw(3.0)];
            for (held, (tasks, truth)) in
                held.iter_mut().zip([(std::slice::from_ref(&one), 1.0), (&two[..], 2.0)])
            {
                let [low, high] = bootstrap.interval(tasks, mean).unwrap();
                *held += usize::from(low <= truth && truth <= high);
            }
        }
        for held in held {
            let share = held as f64 / experiments as f64;
            assert!((0.90..0.98).contains(&share), "{share}");
        }
    }

    /// What the documentation says of few seeds.
    #[test]
    fn intervals_of_few_seeds_hold_the_truth_less_often() {
        let mut rng = Rng::new(2, Stream::Custom);
        let bootstrap = Bootstrap { draws: 2_000, ..Bootstrap::default() };
        for (seeds, wanted) in [(3, 0.75), (5, 0.83), (10, 0.90)] {
            let experiments = 1_000;
            let held = (0..experiments).filter(|_| {
                let values: Vec<f64> = (0..seeds).map(|_| rng.normal()).collect();
                let [low, high] = bootstrap.interval(&[values], mean).unwrap();
                low <= 0.0 && 0.0 <= high
            });
            let share = held.count() as f64 / f64::from(experiments);
            assert!((share - wanted).abs() < 0.04, "{seeds} seeds: {share}");
        }
    }

    /// Seeds are drawn within their task: tasks far apart do not widen each other's interval.
    #[test]
    fn tasks_are_strata() {
        let [low, high] =
            Bootstrap::default().interval(&[[0.0, 1.0, 2.0], [100.0, 101.0, 102.0]], mean).unwrap();
        assert!(50.0 < low && high < 52.0, "{low} {high}");
    }
}
