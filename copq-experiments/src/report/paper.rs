//! What a paper says: its numbers, and what it claims.

use std::collections::BTreeMap;

use copq::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::statistics::{area_under, max, mean};

/// Evaluations that a reward and its cost are the mean of.
pub(super) const LAST: usize = 5;
/// The tables that published numbers can stand beside.
const TABLES: [&str; 5] = ["final", "best", "best-of-mean", "area", "reward-and-cost"];

/// What a paper says of the tasks and methods of a [`Report`](super::Report), beside which the runs
/// are put.
///
/// A sweep's file holds it, as TOML:
///
/// ```
/// use copq_experiments::Paper;
///
/// let paper: Paper = toml::from_str(r#"
/// [reference]                 # scores that count as 1 where tasks are taken together
/// "a/walker2d" = 5185
///
/// [[published]]               # numbers that stand in a table, beside the runs' own
/// source = "Table 2"
/// table = "final"
/// task = "a/walker2d"
/// seeds = 5
/// of = { cop-q = [5185, 465], independent = [382, 391] }
///
/// [[claim]]                   # and what the paper concludes
/// says = "it ends above separate critics"
/// source = "section 5.1"
/// task = "a/walker2d"
/// of = "final"
/// method = "cop-q"
/// is = "above"
/// than = "independent"
/// "#)?;
/// assert_eq!(paper.published[0].of["independent"].std(), Some(391.0));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Scores of tasks, by which results are divided where tasks are taken together.
    #[serde(default)]
    pub reference: BTreeMap<String, f64>,
    /// Numbers, for the report's tables.
    #[serde(default)]
    pub published: Vec<Published>,
    /// Statements that runs can bear out or not.
    #[serde(default, rename = "claim")]
    pub claims: Vec<Claim>,
}

/// A column of a paper's table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where it stands.
    pub source: String,
    /// The report's table beside whose own numbers it stands: `final`, `best`, `best-of-mean`,
    /// `area` or `reward-and-cost`.
    pub table: String,
    /// The task.
    pub task: String,
    /// The objective, where a table has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// How many seeds it is of.
    pub seeds: usize,
    /// Each method's number.
    pub of: BTreeMap<String, Score>,
}

/// A published number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Score {
    /// Mean and standard deviation over seeds.
    WithStd([f64; 2]),
    /// The mean alone.
    Mean(f64),
}

impl Score {
    /// The mean.
    pub fn mean(self) -> f64 {
        match self {
            Self::WithStd([mean, _]) | Self::Mean(mean) => mean,
        }
    }

    /// The standard deviation, if it is known.
    pub fn std(self) -> Option<f64> {
        match self {
            Self::WithStd([_, std]) => Some(std),
            Self::Mean(_) => None,
        }
    }
}

/// A statement about methods on tasks, which an interval over seeds bears out, or contradicts, or
/// leaves open. It is judged for each of its tasks against each of the methods in `than`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// In words.
    pub says: String,
    /// Where it stands.
    pub source: String,
    /// The tasks.
    pub task: OneOrMore,
    /// Which number of a seed.
    pub of: Measure,
    /// The objective. [default: the weighted total]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// The method that it is about.
    pub method: String,
    /// How its number lies.
    pub is: Relation,
    /// To which methods' numbers; `limit` is the limit of a cost.
    pub than: OneOrMore,
    /// Of `near`: how far it may lie from the other's mean, as a share of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
}

/// One name or several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OneOrMore {
    /// One.
    One(String),
    /// Several.
    More(Vec<String>),
}

impl OneOrMore {
    /// All of them.
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::More(names) => names,
        }
    }
}

/// A number that a seed's evaluations come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The last one.
    Final,
    /// The mean of the last five.
    LastFive,
    /// The highest, once it trains.
    Highest,
    /// The area under the curve over its length.
    Area,
    /// The mean difference of neighbouring ones in the second half of training.
    Swing,
}

impl Measure {
    /// Of a seed's steps and values.
    pub(super) fn of(self, curve: &[(u64, f64)]) -> f64 {
        let (steps, values): (Vec<f64>, Vec<f64>) =
            curve.iter().map(|&(step, value)| (step as f64, value)).unzip();
        match self {
            Self::Final => values.last().copied().unwrap_or(f64::NAN),
            Self::LastFive => mean(&values[values.len().saturating_sub(LAST)..]),
            Self::Highest => max(values.get(1..).unwrap_or_default()),
            Self::Area => area_under(&steps, &values),
            Self::Swing => {
                let half = &values[values.len() / 2..];
                mean(&half.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect::<Vec<f64>>())
            }
        }
    }

    /// In words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Final => "last",
            Self::LastFive => "last five",
            Self::Highest => "highest",
            Self::Area => "whole run",
            Self::Swing => "swing",
        }
    }

    /// The report's table that has it.
    pub(super) fn table(self) -> Option<&'static str> {
        match self {
            Self::Final => Some("final"),
            Self::LastFive => Some("reward-and-cost"),
            Self::Highest => Some("best"),
            Self::Area => Some("area"),
            Self::Swing => None,
        }
    }
}

/// How a number lies to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// Larger.
    Above,
    /// Smaller.
    Below,
    /// Not further from it than a share of it.
    Near,
}

impl Paper {
    /// An error for a name that none of these tasks and methods has, so that a slip of the pen does
    /// not hide a number.
    pub fn check(&self, tasks: &[&str], methods: &[&str]) -> Result<()> {
        let known = |what: String, name: &str, all: &[&str]| match all.contains(&name) {
            true => Ok(()),
            false => Err(Error::invalid(what, all.join(" or "), name)),
        };
        for (number, published) in self.published.iter().enumerate() {
            let of = |what: &str| format!("{what} of published numbers ({})", published.source);
            known(of("table"), &published.table, &TABLES)?;
            known(of("task"), &published.task, tasks)?;
            for method in published.of.keys() {
                known(of("method"), method, methods)?;
            }
            let is_same = |other: &Published| {
                other.is_of(&published.table, &published.task)
                    && other.quantity == published.quantity
            };
            if self.published[..number].iter().any(is_same) {
                return Err(Error::invalid(of("column"), "one for each column", "a second one"));
            }
        }
        for claim in &self.claims {
            let of = |what: &str| format!("{what} of the claim that {}", claim.says);
            let others = [methods, &["limit"]].concat();
            known(of("method"), &claim.method, methods)?;
            claim.task.all().iter().try_for_each(|task| known(of("task"), task, tasks))?;
            claim.than.all().iter().try_for_each(|than| known(of("than"), than, &others))?;
            let is_fit = claim.within.is_some_and(|within| within > 0.0);
            match claim.is {
                Relation::Near if !is_fit => {
                    return Err(Error::invalid(of("within"), "a share above 0 for near", "none"));
                }
                Relation::Above | Relation::Below if claim.within.is_some() => {
                    return Err(Error::invalid(of("within"), "none but for near", "one"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The numbers beside a table's column.
    pub(super) fn column(
        &self,
        table: &str,
        task: &str,
        quantity: Option<&str>,
    ) -> Option<&Published> {
        let of = |published: &&Published| {
            published.is_of(table, task) && published.quantity.as_deref() == quantity
        };
        self.published.iter().find(of)
    }
}

impl Published {
    fn is_of(&self, table: &str, task: &str) -> bool {
        self.table == table && self.task == task
    }
}
