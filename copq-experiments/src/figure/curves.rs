//! The curves in a run's `evaluations.csv`.

use std::path::Path;

use copq::{Error, Result};

use copq_render::Point;

use crate::sheet::Sheet;

/// A run's evaluations.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    sheet: Sheet,
}

/// What a curve is of.
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
    /// Reads `evaluations.csv` in a run's folder.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("evaluations.csv");
        let sheet = Sheet::read(&path)?;
        if sheet.steps().is_empty() {
            return Err(Error::invalid(
                format!("'{}'", path.display()),
                "at least one evaluation",
                "none",
            ));
        }
        Ok(Self { sheet })
    }

    /// The weighted total, then the objectives in the order of their priority.
    pub(crate) fn quantities(&self) -> Vec<Quantity> {
        let objective = |column: &String| {
            Some(column.strip_prefix("return/")?.strip_suffix("/mean")?.to_owned())
        };
        let objectives = self.sheet.columns().iter().filter_map(objective).map(Quantity::Return);
        std::iter::once(Quantity::WeightedTotal).chain(objectives).collect()
    }

    /// Mean, lowest and highest episode of each evaluation.
    pub(crate) fn over_episodes(&self, quantity: &Quantity) -> Vec<Point> {
        let [middle, low, high] =
            ["mean", "min", "max"].map(|statistic| self.statistic(quantity, statistic));
        let steps = self.sheet.steps().into_iter().enumerate();
        let point =
            |(i, step)| Point { step: step as f64, middle: middle[i], low: low[i], high: high[i] };
        steps.map(point).collect()
    }

    /// The step of the last evaluation.
    pub(crate) fn last_step(&self) -> u64 {
        self.sheet.steps().last().copied().unwrap_or(0)
    }

    /// Step and mean return of each evaluation.
    pub(crate) fn means(&self, quantity: &Quantity) -> Vec<(u64, f64)> {
        self.sheet.steps().into_iter().zip(self.statistic(quantity, "mean")).collect()
    }

    /// One number an evaluation, NaN where there is none.
    fn statistic(&self, quantity: &Quantity, statistic: &str) -> Vec<f64> {
        let column = self.sheet.column(&format!("{}/{statistic}", quantity.column()));
        column.unwrap_or_else(|| vec![f64::NAN; self.sheet.steps().len()])
    }
}
