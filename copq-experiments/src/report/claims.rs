//! What of a paper's claims the runs show.

use copq::{Error, Result};

use super::Report;
use super::groups::World;
use super::paper::{Claim, Relation};
use super::table::{markdown_row, number};
use super::tables::Seeds;
use crate::figure::Quantity;
use crate::numbers::grouped;
use crate::sheet::encode;
use crate::statistics::{FEWEST, Sample};

/// What stands above the table.
pub(super) const NOTE: &str = "Each claim on each task: means ± standard deviations (seeds) as far as both methods have \
     come, and their difference with its interval at 95 % (Welch's; from a limit Student's). Seen, or not \
     seen: the interval says so, from three seeds of each on. The same of the paper's own numbers, where \
     it has them. Seeds that would decide: with so many of each, four times in five; by these runs or, \
     where they have too few seeds, by the paper's numbers.";
const SEEN: &str = "seen";
const NOT_SEEN: &str = "not seen";
const UNDECIDED: &str = "undecided";
const TOO_FEW: &str = "too few seeds";

/// Claims, judged: a row for each, on each task against each other method.
pub(super) struct Judged {
    pub rows: Vec<[String; 8]>,
}

/// Two methods' numbers, or one and a limit.
struct Comparison {
    ours: Sample,
    theirs: Sample,
}

impl Comparison {
    fn difference(&self) -> f64 {
        self.ours.mean - self.theirs.mean
    }

    /// Where the difference lies, if there are seeds enough to say so.
    fn interval(&self) -> Option<[f64; 2]> {
        let is_enough = self.ours.seeds.min(self.theirs.seeds) >= FEWEST;
        self.ours.difference(&self.theirs).filter(|_| is_enough)
    }

    /// How far the difference may be from nothing for `near`.
    fn margin(&self, claim: &Claim) -> f64 {
        claim.within.unwrap_or(0.0) * self.theirs.mean.abs()
    }

    fn verdict(&self, claim: &Claim) -> &'static str {
        let Some([low, high]) = self.interval() else { return TOO_FEW };
        let margin = self.margin(claim);
        let [is_so, is_not] = match claim.is {
            Relation::Above => [low > 0.0, high < 0.0],
            Relation::Below => [high < 0.0, low > 0.0],
            Relation::Near => [low > -margin && high < margin, low > margin || high < -margin],
        };
        match (is_so, is_not) {
            (true, _) => SEEN,
            (_, true) => NOT_SEEN,
            _ => UNDECIDED,
        }
    }

    /// How many seeds of each would decide, in words.
    fn seeds_to_decide(&self, claim: &Claim) -> String {
        let far = self.difference().abs() - self.margin(claim);
        let seeds = self.ours.seeds_to_tell(&self.theirs, far);
        seeds.map_or("over 10,000".to_owned(), |seeds| grouped(seeds.max(FEWEST) as u64))
    }

    /// Both, and how far apart.
    fn words(&self) -> [String; 2] {
        let shown = |sample: &Sample| match sample.seeds {
            usize::MAX => number(sample.mean, sample.mean.abs()),
            seeds => {
                let [mean, std] = [sample.mean, sample.std].map(|x| number(x, sample.mean.abs()));
                if seeds > 1 { format!("{mean} ± {std} ({seeds})") } else { format!("{mean} (1)") }
            }
        };
        let interval = self.interval().map_or(String::new(), |[low, high]| {
            let size = low.abs().max(high.abs());
            let [middle, low, high] = [self.difference(), low, high].map(|x| number(x, size));
            format!("{middle} [{low}, {high}]")
        });
        [format!("{} to {}", shown(&self.ours), shown(&self.theirs)), interval]
    }
}

impl Report {
    /// The paper's claims on the tasks and methods of these runs; nothing if there is none.
    pub(super) fn judged(&self) -> Option<Judged> {
        let mut rows = Vec::new();
        for claim in &self.paper.claims {
            for task in claim.task.all() {
                rows.extend(claim.than.all().iter().map(|than| self.judge(claim, task, than)));
            }
        }
        (!rows.is_empty()).then_some(Judged { rows })
    }

    fn judge(&self, claim: &Claim, task: &str, than: &str) -> [String; 8] {
        let world = self.groups.worlds.iter().find(|world| world.task == task);
        let ours = world.and_then(|world| self.by_runs(claim, world, than));
        let verdict = ours.as_ref().map_or(TOO_FEW, |ours| ours.verdict(claim));
        let theirs = self.by_paper(claim, world, task, than);
        let seeds = match (verdict, &ours, &theirs) {
            (UNDECIDED, Some(ours), _) => ours.seeds_to_decide(claim),
            (TOO_FEW, _, Some(theirs)) => theirs.seeds_to_decide(claim),
            _ => String::new(),
        };
        let is = match claim.is {
            Relation::Above => "above",
            Relation::Below => "below",
            Relation::Near => "near",
        };
        let quantity = claim.quantity.as_deref().unwrap_or("total");
        let what = format!("{quantity} ({}): {} {is} {than}", claim.of.words(), claim.method);
        let [numbers, difference] =
            ours.map_or([String::new(), String::new()], |ours| ours.words());
        [
            format!("{} ({})", claim.says, claim.source),
            task.to_owned(),
            what,
            numbers,
            difference,
            verdict.to_owned(),
            theirs.map_or(String::new(), |theirs| theirs.verdict(claim).to_owned()),
            seeds,
        ]
    }

    /// A claim's numbers as the runs have them, as far as both methods have come.
    fn by_runs(&self, claim: &Claim, world: &World, than: &str) -> Option<Comparison> {
        let quantity = match &claim.quantity {
            Some(name) => Quantity::Return(name.clone()),
            None => Quantity::WeightedTotal,
        };
        let seeds = |name: &str| {
            let label = self.groups.labels.iter().position(|label| label == name)?;
            Some(self.seeds(world, label)).filter(|seeds| !seeds.is_empty())
        };
        let sample = |seeds: &Seeds<'_>, end| Sample::of(&seeds.measured(claim.of, &quantity, end));
        let ours = seeds(&claim.method)?;
        if than == "limit" {
            let limit = *world.limits.get(&quantity.title())?;
            let ours = sample(&ours, ours.end());
            return Some(Comparison { ours, theirs: Sample::exactly(limit) });
        }
        let theirs = seeds(than)?;
        let end = ours.end().min(theirs.end());
        Some(Comparison { ours: sample(&ours, end), theirs: sample(&theirs, end) })
    }

    /// The same as the paper has them.
    fn by_paper(
        &self,
        claim: &Claim,
        world: Option<&World>,
        task: &str,
        than: &str,
    ) -> Option<Comparison> {
        let column = self.paper.column(claim.of.table()?, task, claim.quantity.as_deref())?;
        let sample = |method: &str| {
            let score = column.of.get(method)?;
            Some(Sample { mean: score.mean(), std: score.std()?, seeds: column.seeds })
        };
        let theirs = match than {
            "limit" => Sample::exactly(*world?.limits.get(claim.quantity.as_deref()?)?),
            method => sample(method)?,
        };
        Some(Comparison { ours: sample(&claim.method)?, theirs })
    }
}

impl Judged {
    /// What stands in each column.
    pub const HEAD: [&str; 8] = [
        "claim",
        "task",
        "number",
        "runs",
        "difference",
        "verdict",
        "by the paper's numbers",
        "seeds that would decide",
    ];

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let rows = self.rows.iter().map(|row| markdown_row(row));
        let head = markdown_row(&Self::HEAD.map(str::to_owned));
        format!("{NOTE}\n\n{head}{}\n{}", "|---".repeat(8) + "|", rows.collect::<String>())
    }

    /// As CSV.
    pub fn csv(&self) -> Result<String> {
        let head = Self::HEAD.map(str::to_owned);
        let lines = std::iter::once(&head).chain(&self.rows);
        let bytes = lines.map(|line| encode(line)).collect::<Result<Vec<_>>>()?.concat();
        String::from_utf8(bytes).map_err(|e| Error::other("encoding claims", e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::paper::{Measure, OneOrMore, Paper};
    use crate::report::tests::stored;
    use crate::report::{Report, ReportRun};

    fn claim(is: Relation, than: &str, within: Option<f64>) -> Claim {
        let one = |name: &str| OneOrMore::One(name.to_owned());
        Claim {
            says: "it does".to_owned(),
            source: "Table 1".to_owned(),
            task: one("a/hopper"),
            of: Measure::Final,
            quantity: None,
            method: "good".to_owned(),
            is,
            than: one(than),
            within,
        }
    }

    /// Runs of methods that end with these totals, a seed each, on the task that claims are about.
    fn report(methods: &[(&str, &[f64])], paper: Paper) -> Report {
        let folder = tempfile::tempdir().unwrap();
        let mut runs = Vec::new();
        for (method, totals) in methods {
            for (seed, &total) in totals.iter().enumerate() {
                let change = |plan: &mut crate::Plan| plan.run.seed = seed as u64;
                let name = format!("{method}-s{seed}");
                let label = Some((*method).to_owned());
                let run = stored(folder.path(), &name, change, &[0.0, total]);
                runs.push(ReportRun { label, ..run });
            }
        }
        Report::read("x", &runs).paper(paper)
    }

    fn verdicts(methods: &[(&str, &[f64])], claims: &[Claim]) -> Vec<[String; 8]> {
        let paper = Paper { claims: claims.to_vec(), ..Paper::default() };
        report(methods, paper).judged().unwrap().rows
    }

    #[test]
    fn an_interval_decides() {
        let methods: [(&str, &[f64]); 4] = [
            ("good", &[100.0, 101.0, 102.0]),
            ("bad", &[90.0, 91.0, 92.0]),
            ("wide", &[50.0, 100.0, 159.0]),
            ("short", &[1.0, 2.0]),
        ];
        let near = |within| (Relation::Near, Some(within));
        for (than, (is, within), wanted) in [
            ("bad", (Relation::Above, None), SEEN),
            ("bad", (Relation::Below, None), NOT_SEEN),
            ("wide", (Relation::Above, None), UNDECIDED),
            ("wide", (Relation::Below, None), UNDECIDED),
            ("short", (Relation::Above, None), TOO_FEW),
            ("none", (Relation::Above, None), TOO_FEW),
            ("bad", near(0.2), SEEN),
            ("bad", near(0.05), NOT_SEEN),
            ("bad", near(0.1), UNDECIDED),
        ] {
            let row = &verdicts(&methods, &[claim(is, than, within)])[0];
            assert_eq!(row[5], wanted, "{than} {is:?} {within:?}: {row:?}");
            assert_eq!(row[7].is_empty(), wanted != UNDECIDED, "{row:?}");
        }
        let row = &verdicts(&methods, &[claim(Relation::Above, "bad", None)])[0];
        assert_eq!(row[3], "101 ± 1 (3) to 91.0 ± 1.0 (3)");
        assert_eq!(row[4], "10.0 [7.7, 12.3]");
    }

    /// Beside the runs, which are too few, what the paper's own numbers say.
    #[test]
    fn a_papers_numbers_are_judged_too() {
        let text = r#"
            [[published]]
            source = "Table 2"
            table = "final"
            task = "a/hopper"
            seeds = 5
            of = { good = [5185, 465], bad = [3626, 1402], worse = 12 }
        "#;
        let claims = ["bad", "worse"].map(|than| claim(Relation::Above, than, None)).to_vec();
        let paper = Paper { claims, ..toml::from_str(text).unwrap() };
        let report = report(&[("good", &[5_000.0])], paper);
        let rows = report.judged().unwrap().rows;
        assert_eq!(rows[0][5..], [TOO_FEW, UNDECIDED, "9"]);
        assert_eq!(rows[1][5..], [TOO_FEW, "", ""]);
        let table = &report.tables()[0];
        assert_eq!(table.columns, ["a/hopper at 10", "a/hopper: Table 2"]);
        assert!(table.markdown().ends_with("| good | 5000 (1) | 5185 ± 465 (5) |\n"));
    }

    #[test]
    fn names_that_no_run_has_are_errors() {
        let check = |claim: Claim| {
            let paper = Paper { claims: vec![claim], ..Paper::default() };
            paper.check(&["a/hopper"], &["good", "bad"]).map_err(|error| error.to_string())
        };
        assert_eq!(check(claim(Relation::Above, "bad", None)), Ok(()));
        assert_eq!(check(claim(Relation::Above, "limit", None)), Ok(()));
        for (wrong, word) in [
            (claim(Relation::Above, "bed", None), "bed"),
            (Claim { method: "god".to_owned(), ..claim(Relation::Above, "bad", None) }, "god"),
            (claim(Relation::Near, "bad", None), "within"),
            (claim(Relation::Above, "bad", Some(0.1)), "within"),
        ] {
            let said = check(wrong).unwrap_err();
            assert!(said.contains(word) && said.contains("it does"), "{said}");
        }
    }
}
