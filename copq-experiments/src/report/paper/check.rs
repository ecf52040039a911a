//! Whether a paper's names are those of a report's tasks and methods.

use std::collections::{BTreeMap, BTreeSet};

use copq::{Error, Result};

use super::{Claim, LIMIT, Measure, Paper, Published, Relation};

/// What a report has for a task, on any engine: objectives (none if they are not known), costs
/// under a limit, methods.
#[derive(Default)]
pub(in crate::report) struct Known<'a> {
    pub objectives: BTreeSet<&'a str>,
    pub limits: BTreeSet<&'a str>,
    pub methods: BTreeSet<&'a str>,
}

/// A report's tasks by their names.
pub(in crate::report) type KnownTasks<'a> = BTreeMap<&'a str, Known<'a>>;

fn refused<T>(what: String, wanted: &str, got: impl std::fmt::Display) -> Result<T> {
    Err(Error::invalid(what, wanted, got))
}

fn unknown<'a, T>(
    what: String,
    known: impl IntoIterator<Item = &'a &'a str>,
    name: &str,
) -> Result<T> {
    let known: Vec<&str> = known.into_iter().copied().collect();
    refused(what, &known.join(" or "), name)
}

impl Known<'_> {
    fn check_method(&self, what: String, name: &str) -> Result<()> {
        if self.methods.contains(name) { Ok(()) } else { unknown(what, &self.methods, name) }
    }

    fn check_quantity(&self, what: String, quantity: Option<&str>) -> Result<()> {
        match quantity {
            Some(name) if !self.objectives.is_empty() && !self.objectives.contains(name) => {
                unknown(what, &self.objectives, name)
            }
            _ => Ok(()),
        }
    }

    fn check_limit(&self, what: String, quantity: Option<&str>) -> Result<()> {
        match quantity {
            Some(name) if self.limits.contains(name) => Ok(()),
            other => refused(what, "a cost under a limit", other.unwrap_or("none")),
        }
    }
}

impl Paper {
    /// An error for what none of a report's tasks and methods can have, so that a typo does not
    /// hide a number.
    pub(in crate::report) fn check(&self, known: &KnownTasks<'_>) -> Result<()> {
        for (task, score) in &self.reference {
            let what = || format!("reference score of {task}");
            if !known.contains_key(task.as_str()) {
                return unknown(what(), known.keys(), task);
            }
            if !(score.is_finite() && *score > 0.0) {
                return refused(what(), "a positive number, for it counts as 1", score);
            }
        }
        for (number, published) in self.published.iter().enumerate() {
            published.check(known)?;
            let Published { of, task, quantity, .. } = published;
            let is_same = |other: &Published| other.is_of(*of, task, quantity.as_deref());
            if self.published[..number].iter().any(is_same) {
                return refused(published.what("column"), "one a table", "a second one");
            }
        }
        self.claims.iter().try_for_each(|claim| claim.check(known))
    }
}

impl Published {
    fn what(&self, part: &str) -> String {
        format!("{part} of published numbers ({}, {})", self.source, self.task)
    }

    fn check(&self, known: &KnownTasks<'_>) -> Result<()> {
        let what = |part: &str| self.what(part);
        let quantity = self.quantity.as_deref();
        let Some(task) = known.get(self.task.as_str()) else {
            return unknown(what("task"), known.keys(), &self.task);
        };
        task.check_quantity(what("quantity"), quantity)?;
        match (self.of.table(), quantity) {
            (None, _) => return refused(what("of"), "a number of a table", self.of.words()),
            (Some(_), None) if self.of != Measure::LastFive => {}
            (Some(_), Some(_)) if self.of == Measure::LastFive && !task.limits.is_empty() => {}
            (_, got) => {
                let wanted = "an objective for last-five, on a task with a limit, and none else";
                return refused(what("quantity"), wanted, got.unwrap_or("none"));
            }
        }
        if self.seeds == 0 {
            return refused(what("seeds"), "at least 1", 0);
        }
        for (method, score) in &self.scores {
            task.check_method(what("method"), method)?;
            let (mean, std) = (score.mean(), score.std().unwrap_or(0.0));
            if !mean.is_finite() || !std.is_finite() || std < 0.0 {
                let what = what(&format!("score of {method}"));
                return refused(
                    what,
                    "numbers, the deviation at least 0",
                    format!("{mean}, {std}"),
                );
            }
        }
        Ok(())
    }
}

impl Claim {
    fn what(&self, part: &str) -> String {
        format!("{part} of the claim that {}", self.says)
    }

    fn check(&self, known: &KnownTasks<'_>) -> Result<()> {
        for (part, names) in [("task", &self.task), ("method", &self.method), ("than", &self.than)]
        {
            if names.all().is_empty() {
                return refused(self.what(part), "one name at least", "none");
            }
        }
        for name in self.task.all() {
            match known.get(name.as_str()) {
                Some(task) => self.check_on(task)?,
                None => return unknown(self.what("task"), known.keys(), name),
            }
        }
        if self.of == Measure::BestOfMean {
            return refused(self.what("of"), "a number of a seed", self.of.words());
        }
        let is_share = matches!(self.is, Relation::Near | Relation::NotBelow);
        match self.within {
            None if !is_share => Ok(()),
            Some(share) if is_share && share > 0.0 && share < 1.0 => Ok(()),
            got => {
                let wanted = match is_share {
                    true => "a share between 0 and 1",
                    false => "none but for near and not-below",
                };
                let got = got.map_or("none".to_owned(), |share| share.to_string());
                refused(self.what("within"), wanted, got)
            }
        }
    }

    /// On one of its tasks.
    fn check_on(&self, task: &Known<'_>) -> Result<()> {
        let quantity = self.quantity.as_deref();
        task.check_quantity(self.what("quantity"), quantity)?;
        for name in self.method.all() {
            task.check_method(self.what("method"), name)?;
            if self.than.all().contains(name) {
                return refused(self.what("than"), "another than the method", name);
            }
        }
        let is_limit = |than: &&String| *than == LIMIT;
        for name in self.than.all().iter().filter(|than| !is_limit(than)) {
            task.check_method(self.what("than"), name)?;
        }
        let is_of_limit = self.than.all().iter().any(|than| is_limit(&than));
        if is_of_limit && !self.of.is_of_quantity() {
            return refused(self.what("than"), "a method's number, for it is a share", LIMIT);
        }
        if is_of_limit || self.of == Measure::Exceeded {
            task.check_limit(self.what("quantity"), quantity)?;
        }
        Ok(())
    }
}
