//! Which evaluation was the best: costs within their limits first, then the weighted total.

use copq::EnvSpec;

use crate::sheet::Sheet;

/// The best evaluation so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Best(Option<Rank>);

/// How good an evaluation is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rank {
    /// How far costs are above their limits, in total.
    excess: f64,
    total: f64,
}

impl Rank {
    fn of(returns: &[f64], total: f64, spec: &EnvSpec) -> Self {
        let mut excess = 0.0;
        for (i, value) in returns.iter().enumerate() {
            if let Some(limit) = spec.limit(i) {
                excess += (value - f64::from(limit)).max(0.0);
            }
        }
        Self { excess, total }
    }

    fn is_better_than(self, other: Self) -> bool {
        self.excess < other.excess || (self.excess == other.excess && self.total > other.total)
    }
}

impl Best {
    /// The best of the rows of an `evaluations.csv`.
    pub(crate) fn of_rows(sheet: &Sheet, spec: &EnvSpec) -> Self {
        let rows = sheet.steps().len();
        let column = |name: &str| sheet.column(name).unwrap_or_else(|| vec![f64::NAN; rows]);
        let names = spec.names().into_iter();
        let returns: Vec<_> = names.map(|name| column(&format!("return/{name}/mean"))).collect();
        let mut best = Self::default();
        for (row, &total) in column("weighted_total/mean").iter().enumerate() {
            let returns: Vec<f64> = returns.iter().map(|column| column[row]).collect();
            best.update(&returns, total, spec);
        }
        best
    }

    /// Adds an evaluation's mean returns and total; returns whether it is better than all before.
    pub(crate) fn update(&mut self, returns: &[f64], total: f64, spec: &EnvSpec) -> bool {
        let rank = Rank::of(returns, total, spec);
        let is_best = !total.is_nan() && self.0.is_none_or(|best| rank.is_better_than(best));
        if is_best {
            self.0 = Some(rank);
        }
        is_best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_come_before_returns() {
        let spec = EnvSpec::new("test", 1, 1).cost("speed", 10.0).reward("progress", 1.0);
        let mut best = Best::default();
        assert!(best.update(&[30.0, 5.0], 5.0, &spec));
        assert!(!best.update(&[40.0, 9.0], 9.0, &spec), "further above the limit");
        assert!(best.update(&[10.0, 1.0], 1.0, &spec), "within the limit");
        assert!(!best.update(&[10.0, 1.0], 1.0, &spec), "as good is not better");
        assert!(!best.update(&[11.0, 9.0], 9.0, &spec));
        assert!(best.update(&[2.0, 3.0], 3.0, &spec));
        assert!(!best.update(&[2.0, f64::NAN], f64::NAN, &spec));
    }
}
