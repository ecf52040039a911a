//! Which of a paper's claims the runs bear out.

use super::Report;
use super::groups::World;
use super::paper::{Claim, LIMIT, Relation};
use super::seeds::Seeds;
use crate::figure::Quantity;
use crate::statistics::{FEWEST, Sample};

/// A claim on one task, of one method against another.
pub(super) struct Judged<'a> {
    pub claim: &'a Claim,
    /// What the task is called.
    pub task: String,
    pub method: &'a str,
    pub than: &'a str,
    /// The comparison in the runs' numbers.
    pub runs: Option<Comparison>,
    /// How many seeds of both are planned; more than there are if some wait, or failed early.
    pub planned: [usize; 2],
    /// The step up to which both methods are compared, and the one that they should reach.
    pub steps: [u64; 2],
    /// Whether both have come as far as they should.
    pub has_ended: bool,
    /// Whether a seed has fewer evaluations than the number needs.
    is_early: bool,
    /// The comparison in the paper's numbers.
    pub paper: Option<Comparison>,
}

/// Two methods' numbers, or one method's and a limit.
#[derive(Clone, Copy)]
pub(super) struct Comparison {
    pub ours: Sample,
    pub theirs: Sample,
}

/// What an interval says about a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Seen,
    Contradicted,
    Undecided,
    TooFewSeeds,
    TooEarly,
    NoScatter,
    NotANumber,
}

impl Verdict {
    pub fn words(self) -> &'static str {
        match self {
            Self::Seen => "seen",
            Self::Contradicted => "contradicted",
            Self::Undecided => "undecided",
            Self::TooFewSeeds => "too few seeds",
            Self::TooEarly => "too early",
            Self::NoScatter => "no scatter",
            Self::NotANumber => "not a number",
        }
    }
}

impl Comparison {
    /// Pairs of which the first must lie above the second for the claim to hold.
    fn conditions(&self, claim: &Claim) -> Vec<[Sample; 2]> {
        let Self { ours, theirs } = *self;
        // Shares are of the size of the other's mean, whatever its sign.
        let off = claim.within.unwrap_or(0.0) * theirs.mean.signum();
        match claim.is {
            Relation::Above => vec![[ours, theirs]],
            Relation::Below => vec![[theirs, ours]],
            Relation::NotBelow => vec![[ours, theirs.times(1.0 - off)]],
            Relation::Near => {
                vec![[ours, theirs.times(1.0 - off)], [theirs.times(1.0 + off), ours]]
            }
        }
    }

    pub fn verdict(&self, claim: &Claim) -> Verdict {
        if self.ours.mean.is_nan() || self.theirs.mean.is_nan() {
            return Verdict::NotANumber;
        }
        if self.ours.seeds.min(self.theirs.seeds) < FEWEST {
            return Verdict::TooFewSeeds;
        }
        // Seeds that are all alike, as at a return's maximum, say nothing about others.
        if self.ours.std == 0.0 && self.theirs.std == 0.0 {
            return Verdict::NoScatter;
        }
        let conditions = self.conditions(claim);
        let ends: Option<Vec<[f64; 2]>> =
            conditions.iter().map(|[more, less]| more.difference(less)).collect();
        match ends {
            Some(ends) if ends.iter().all(|[low, _]| *low > 0.0) => Verdict::Seen,
            Some(ends) if ends.iter().any(|[_, high]| *high < 0.0) => Verdict::Contradicted,
            _ => Verdict::Undecided,
        }
    }

    /// How many seeds of each would decide, four times in five, that all conditions hold or that
    /// one does not, if these are the true means and standard deviations. None for more than
    /// 10,000.
    pub fn seeds_to_decide(&self, claim: &Claim) -> Option<usize> {
        const MISSED: f64 = 0.2;
        let conditions = self.conditions(claim);
        let seeds = |[more, less]: &[Sample; 2], missed| more.seeds_to_tell(less, 1.0 - missed);
        let wrong = conditions.iter().filter(|[more, less]| more.mean < less.mean);
        if let Some(fewest) = wrong.clone().filter_map(|wrong| seeds(wrong, MISSED)).min() {
            return Some(fewest.max(FEWEST));
        }
        if wrong.count() > 0 {
            return None;
        }
        let missed = MISSED / conditions.len() as f64;
        let all: Option<Vec<usize>> = conditions.iter().map(|pair| seeds(pair, missed)).collect();
        all?.into_iter().max().map(|most| most.max(FEWEST))
    }
}

impl Judged<'_> {
    pub fn verdict(&self) -> Verdict {
        match self.runs {
            None => Verdict::TooFewSeeds,
            Some(_) if self.is_early => Verdict::TooEarly,
            Some(runs) => runs.verdict(self.claim),
        }
    }

    /// Whether no seed is missing and none has further to go.
    pub fn is_over(&self) -> bool {
        let seeds = self.runs.map_or([0; 2], |runs| [runs.ours.seeds, runs.theirs.seeds]);
        let is_whole = seeds.iter().zip(self.planned).all(|(&seeds, planned)| seeds >= planned);
        is_whole && self.has_ended
    }

    pub fn verdict_of_paper(&self) -> Option<Verdict> {
        Some(self.paper?.verdict(self.claim))
    }

    /// The numbers that say how many seeds would decide: the runs' if they are undecided, the
    /// paper's if there are too few seeds.
    pub fn to_decide_by(&self) -> Option<Comparison> {
        match self.verdict() {
            Verdict::Undecided => self.runs,
            Verdict::TooFewSeeds => self.paper,
            _ => None,
        }
    }
}

impl Report {
    /// The paper's claims on the tasks and methods of these runs.
    pub(super) fn judged(&self) -> Vec<Judged<'_>> {
        let mut all = Vec::new();
        for claim in &self.paper.claims {
            for task in claim.task.all() {
                for world in self.groups.worlds.iter().filter(|world| world.task == *task) {
                    for method in claim.method.all() {
                        let others = claim.than.all().iter();
                        all.extend(others.map(|than| self.judge(claim, world, method, than)));
                    }
                }
            }
        }
        all
    }

    fn judge<'a>(
        &'a self,
        claim: &'a Claim,
        world: &World,
        method: &'a str,
        than: &'a str,
    ) -> Judged<'a> {
        let label = |name: &str| self.groups.method(world, name);
        let seeds = |name: &str| {
            let seeds = label(name).map(|label| self.seeds(world, label));
            seeds.filter(|seeds| !seeds.is_empty())
        };
        let (ours, theirs) = (seeds(method), seeds(than));
        let reached = ours.iter().chain(&theirs).map(Seeds::reached).min().unwrap_or(0);
        let end = match (&ours, &theirs) {
            (Some(ours), Some(theirs)) => ours.common_end(theirs),
            (ours, theirs) => ours.as_ref().or(theirs.as_ref()).map_or(0, |seeds| seeds.end),
        };
        let numbers =
            [method, than].into_iter().filter_map(label).flat_map(|label| &world.runs[label]);
        let wanted = numbers.filter_map(|&number| self.runs[number].steps_wanted()).min();
        let limit = claim.quantity.as_ref().and_then(|name| world.limits.get(name)).copied();
        let quantity = claim.quantity.clone().map_or(Quantity::WeightedTotal, Quantity::Return);
        let curves =
            [&ours, &theirs].map(|seeds| seeds.as_ref().map(|seeds| seeds.values(&quantity, end)));
        let is_early = curves.iter().flatten().any(|curves| claim.of.is_early(curves));
        let samples = curves.map(|curves| {
            let values = curves?.into_iter().map(|curve| claim.of.of(&curve, limit));
            Some(Sample::of(&values.collect::<Vec<_>>()))
        });
        let exactly = || limit.filter(|_| than == LIMIT).map(Sample::exactly);
        let [first, second] = samples;
        let comparison = first.zip(second.or_else(exactly));
        Judged {
            claim,
            task: world.short.clone(),
            method,
            than,
            planned: [method, than]
                .map(|name| label(name).map_or(0, |label| world.runs[label].len())),
            steps: [end, wanted.unwrap_or(end)],
            has_ended: wanted.is_none_or(|wanted| reached >= wanted),
            is_early,
            runs: comparison.map(|(ours, theirs)| Comparison { ours, theirs }),
            paper: self.by_paper(claim, world, [method, than]),
        }
    }

    /// The same in the paper's numbers; its standard deviations are taken as divided by n.
    fn by_paper(
        &self,
        claim: &Claim,
        world: &World,
        [method, than]: [&str; 2],
    ) -> Option<Comparison> {
        let quantity = claim.quantity.as_deref();
        let column = self.paper.column(claim.of, &world.task, quantity)?;
        if column.seeds < 2 {
            return None;
        }
        let sample = |method: &str| {
            let score = column.scores.get(method)?;
            Some(Sample::published(score.mean(), score.std()?, column.seeds))
        };
        let theirs = match than {
            LIMIT => Sample::exactly(*world.limits.get(quantity?)?),
            method => sample(method)?,
        };
        Some(Comparison { ours: sample(method)?, theirs })
    }
}
