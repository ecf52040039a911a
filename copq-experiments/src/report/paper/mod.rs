//! What a paper reports: its numbers and claims, as in a sweep's file.

mod check;
mod measure;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub(super) use check::KnownTasks;
pub use measure::Measure;

/// What a claim compares with if it is about the limit of a cost.
pub(super) const LIMIT: &str = "limit";

/// What a paper reports for the tasks and methods of a [`Report`](crate::Report), beside which the
/// runs are put.
///
/// A sweep's file holds it, as TOML:
///
/// ```
/// use copq_experiments::paper::Paper;
///
/// let paper: Paper = toml::from_str(r#"
/// [reference]                 # scores that count as 1 where tasks are taken together
/// "a/walker2d" = 5185
///
/// [[published]]               # numbers that stand in a table, beside the runs' own
/// source = "Table 2"
/// task = "a/walker2d"
/// of = "final"
/// seeds = 5
/// scores = { cop-q = [5185, 465], independent = [382, 391] }
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
/// assert_eq!(paper.published[0].scores["independent"].std(), Some(391.0));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Reference scores of tasks: results are divided by them when tasks are taken together.
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
///
/// ```
/// use copq_experiments::paper::{Measure, Published, Score};
///
/// let ours = ("cop-q".to_owned(), Score::WithStd([5_185.0, 465.0]));
/// let theirs = ("independent".to_owned(), Score::Mean(382.0));
/// let column = Published {
///     source: "Table 2".to_owned(),
///     task: "a/walker2d".to_owned(),
///     of: Measure::Final,
///     quantity: None, // the weighted total
///     seeds: 5,
///     scores: [ours, theirs].into(),
/// };
/// let score = |method: &str| column.scores[method];
/// assert_eq!((score("cop-q").std(), score("independent").std()), (Some(465.0), None));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where it stands.
    pub source: String,
    /// The task.
    pub task: String,
    /// Which number of a seed it is the mean of; it is shown in the report's table of that number.
    pub of: Measure,
    /// The objective, where a table has several. [default: the weighted total]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// How many seeds it is the mean of.
    pub seeds: usize,
    /// Each method's number.
    pub scores: BTreeMap<String, Score>,
}

/// A published number: `5185`, or `[5185, 465]` with a standard deviation over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "wanted a number, or a mean and a standard deviation in brackets")]
pub enum Score {
    /// Mean and standard deviation (divided by n, as in papers).
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

/// A statement about methods on tasks that an interval over seeds bears out, contradicts or leaves
/// open. It is judged for each of its methods on each of its tasks against each of those in `than`.
///
/// ```
/// use copq_experiments::paper::{Claim, Measure, OneOrMore, Relation};
///
/// let claim: Claim = toml::from_str(r#"
/// says = "it ends above separate critics"
/// source = "section 5.1"
/// task = ["a/walker2d", "a/ant"]
/// of = "final"
/// method = "cop-q"
/// is = "above"
/// than = "independent"
/// "#)?;
/// assert_eq!((claim.of, claim.is), (Measure::Final, Relation::Above));
/// assert_eq!(claim.task.all(), ["a/walker2d", "a/ant"]);
/// assert_eq!(claim.than, OneOrMore::One("independent".to_owned()));
/// # Ok::<(), toml::de::Error>(())
/// ```
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
    /// The methods that it is about.
    pub method: OneOrMore,
    /// How their numbers compare.
    pub is: Relation,
    /// The methods that they are compared with; `limit` is the limit of a cost, the claim's
    /// quantity.
    pub than: OneOrMore,
    /// For `near` and `not-below`: how far off is near enough, as a share of the other's mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
}

/// One name or several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "wanted a name, or several in brackets")]
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

/// How a number compares with another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// Larger.
    Above,
    /// Smaller.
    Below,
    /// Not smaller by more than a share of the other.
    NotBelow,
    /// Neither smaller nor larger by more than a share of the other.
    Near,
}

impl Relation {
    /// In words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Above => "above",
            Self::Below => "below",
            Self::NotBelow => "not below",
            Self::Near => "near",
        }
    }
}

impl Paper {
    /// Adds another file's; what both have is kept once.
    pub fn and(mut self, other: Self) -> Self {
        for (task, score) in other.reference {
            self.reference.entry(task).or_insert(score);
        }
        for published in other.published {
            if !self.published.contains(&published) {
                self.published.push(published);
            }
        }
        for claim in other.claims {
            if !self.claims.contains(&claim) {
                self.claims.push(claim);
            }
        }
        self
    }

    /// The published numbers beside a table's column.
    pub(super) fn column(
        &self,
        of: Measure,
        task: &str,
        quantity: Option<&str>,
    ) -> Option<&Published> {
        self.published.iter().find(|published| published.is_of(of, task, quantity))
    }
}

impl Published {
    fn is_of(&self, of: Measure, task: &str, quantity: Option<&str>) -> bool {
        self.of == of && self.task == task && self.quantity.as_deref() == quantity
    }
}
