//! Numbers that summarise a curve of evaluations.

use serde::{Deserialize, Serialize};

use crate::figure::{LAST, Line};
use crate::statistics::{area_under, max, mean};

/// A number that summarises a seed's evaluations. It is too early for it before there is one
/// evaluation (two for the swing, five for the last five) after that of step 0, whose policy has
/// not trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The last evaluation, once the policy trains.
    Final,
    /// The mean of the last five evaluations.
    LastFive,
    /// The highest evaluation, once the policy trains.
    Best,
    /// The highest point of the seeds' mean curve. It is no seed's own number, so only for
    /// published numbers.
    BestOfMean,
    /// The area under the curve divided by its length: the mean of the whole run.
    Area,
    /// The mean difference between neighbouring evaluations, as a share of their mean, in the
    /// second half.
    Swing,
    /// The share of evaluations above the limit, once the policy trains.
    Exceeded,
}

impl Measure {
    /// From a seed's steps and values under a limit; NaN if one of the values is.
    pub(in crate::report) fn of(self, curve: &[[f64; 2]], limit: Option<f64>) -> f64 {
        let (steps, values): (Vec<f64>, Vec<f64>) =
            curve.iter().map(|&[step, value]| (step, value)).unzip();
        let trained = curve.iter().filter(|[step, _]| *step > 0.0).map(|&[_, value]| value);
        let trained: Vec<f64> = trained.collect();
        if values.iter().any(|value| value.is_nan()) {
            return f64::NAN;
        }
        match self {
            Self::Final => values.last().copied().unwrap_or(f64::NAN),
            Self::LastFive => mean(&values[values.len().saturating_sub(LAST)..]),
            Self::Best => max(&trained),
            Self::BestOfMean => f64::NAN,
            Self::Area => area_under(&steps, &values),
            Self::Swing => {
                let half = &values[values.len() / 2..];
                let steps: Vec<f64> =
                    half.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
                mean(&steps) / mean(half).abs()
            }
            Self::Exceeded => {
                let Some(limit) = limit else { return f64::NAN };
                let over = trained.iter().filter(|&&value| value > limit);
                over.count() as f64 / trained.len() as f64
            }
        }
    }

    /// Whether one of these seeds' curves has fewer evaluations than it needs; that of step 0 does
    /// not count, as its policy has not trained.
    pub(in crate::report) fn is_early(self, curves: &[Line]) -> bool {
        curves.iter().any(|curve| {
            let trained = curve.iter().filter(|[step, _]| *step > 0.0).count();
            match self {
                Self::Final | Self::Area | Self::Best | Self::BestOfMean | Self::Exceeded => {
                    trained < 1
                }
                Self::Swing => trained < 2,
                Self::LastFive => trained < LAST,
            }
        })
    }

    /// Whether it is in the units of its quantity.
    pub(in crate::report) fn is_of_quantity(self) -> bool {
        !matches!(self, Self::Swing | Self::Exceeded)
    }

    /// In words.
    pub(in crate::report) fn words(self) -> &'static str {
        match self {
            Self::Final => "at the end",
            Self::LastFive => "last five",
            Self::Best => "best",
            Self::BestOfMean => "best of the mean",
            Self::Area => "whole run",
            Self::Swing => "swing",
            Self::Exceeded => "share over the limit",
        }
    }

    /// The report's table that contains it.
    pub(in crate::report) fn table(self) -> Option<&'static str> {
        match self {
            Self::Final => Some("final"),
            Self::LastFive => Some("reward-and-cost"),
            Self::Best => Some("best"),
            Self::BestOfMean => Some("best-of-mean"),
            Self::Area => Some("area"),
            Self::Swing | Self::Exceeded => None,
        }
    }
}
