//! Claims against runs whose numbers are known.

use std::path::Path;

use super::claims::{Judged, Verdict};
use super::paper::{Claim, Measure, OneOrMore, Paper, Relation, Score};
use super::tests::stored;
use super::{Report, ReportRun, claims_table};
use crate::figure::Quantity;

fn one(name: &str) -> OneOrMore {
    OneOrMore::One(name.to_owned())
}

fn claim(is: Relation, than: &str, within: Option<f64>) -> Claim {
    Claim {
        says: "it does".to_owned(),
        source: "Table 1".to_owned(),
        task: one("b/hopper"),
        of: Measure::Final,
        quantity: None,
        method: one("good"),
        is,
        than: one(than),
        within,
    }
}

/// A seed of a method for each list of costs, which are the weighted totals, too, evaluated at
/// steps 0, 10 and so on of 30.
fn runs(folder: &Path, methods: &[(&str, &[&[f64]])]) -> Vec<ReportRun> {
    let mut runs = Vec::new();
    for (method, seeds) in methods {
        for (seed, costs) in seeds.iter().enumerate() {
            let change = |plan: &mut crate::Plan| {
                plan.task = "b/hopper".to_owned();
                plan.run.seed = seed as u64;
                plan.run.steps = 30;
            };
            let run = stored(folder, &format!("{method}-s{seed}"), change, costs);
            let rows = costs.iter().enumerate().map(|(i, x)| format!("{},{x},{x}\n", 10 * i));
            let text = "step,weighted_total/mean,return/cost/mean\n".to_owned()
                + &rows.collect::<String>();
            std::fs::write(run.folder.join("evaluations.csv"), text).unwrap();
            runs.push(ReportRun {
                label: Some((*method).to_owned()),
                limits: [("cost".to_owned(), 95.0)].into(),
                weights: [("cost".to_owned(), 0.0)].into(),
                ..run
            });
        }
    }
    runs
}

fn report(methods: &[(&str, &[&[f64]])], paper: Paper) -> copq::Result<Report> {
    let folder = tempfile::tempdir().unwrap();
    Report::read("x", &runs(folder.path(), methods)).paper(paper)
}

/// What runs show of a claim.
fn verdict(methods: &[(&str, &[&[f64]])], claim: Claim) -> (Verdict, Option<Option<usize>>) {
    let paper = Paper { claims: vec![claim.clone()], ..Paper::default() };
    let report = report(methods, paper).unwrap();
    let judged = report.judged();
    let [judged] = &judged[..] else { panic!("one row") };
    (judged.verdict(), judged.to_decide_by().map(|by| by.seeds_to_decide(&claim)))
}

const METHODS: [(&str, &[&[f64]]); 5] = [
    ("good", &[&[0.0, 100.0], &[0.0, 101.0], &[0.0, 102.0]]),
    ("bad", &[&[0.0, 90.0], &[0.0, 91.0], &[0.0, 92.0]]),
    ("wide", &[&[0.0, 50.0], &[0.0, 100.0], &[0.0, 159.0]]),
    ("short", &[&[0.0, 1.0], &[0.0, 2.0]]),
    ("broken", &[&[0.0, 1.0], &[0.0, f64::NAN], &[0.0, 2.0]]),
];

#[test]
fn an_interval_decides() {
    use Relation::{Above, Below, Near, NotBelow};
    for (is, than, within, wanted) in [
        (Above, "bad", None, Verdict::Seen),
        (Below, "bad", None, Verdict::Contradicted),
        (Above, "wide", None, Verdict::Undecided),
        (Below, "wide", None, Verdict::Undecided),
        (Above, "short", None, Verdict::TooFewSeeds),
        (Above, "broken", None, Verdict::NotANumber),
        (Near, "bad", Some(0.2), Verdict::Seen),
        (Near, "bad", Some(0.05), Verdict::Contradicted),
        (Near, "bad", Some(0.1), Verdict::Undecided),
        (NotBelow, "bad", Some(0.01), Verdict::Seen),
        (NotBelow, "wide", Some(0.1), Verdict::Undecided),
    ] {
        let (verdict, seeds) = verdict(&METHODS, claim(is, than, within));
        assert_eq!(verdict, wanted, "{than} {is:?} {within:?}");
        assert_eq!(seeds.is_some(), wanted == Verdict::Undecided, "{than} {is:?} {within:?}");
    }
    // 5 % below is not below, 15 % is.
    let bad = |is, within| Claim { method: one("bad"), ..claim(is, "good", within) };
    assert_eq!(verdict(&METHODS, bad(NotBelow, Some(0.15))).0, Verdict::Seen);
    assert_eq!(verdict(&METHODS, bad(NotBelow, Some(0.05))).0, Verdict::Contradicted);
    // Of less than nothing a share is not less: -100 lies near -91, and not below -99.
    let negative: [(&str, &[&[f64]]); 2] = [
        ("good", &[&[0.0, -100.0], &[0.0, -100.5], &[0.0, -101.0]]),
        ("bad", &[&[0.0, -91.0], &[0.0, -92.0], &[0.0, -93.0]]),
    ];
    assert_eq!(verdict(&negative, claim(Near, "bad", Some(0.2))).0, Verdict::Seen);
    assert_eq!(verdict(&negative, claim(NotBelow, "bad", Some(0.2))).0, Verdict::Seen);
    assert_eq!(verdict(&negative, claim(NotBelow, "bad", Some(0.01))).0, Verdict::Contradicted);
}

#[test]
fn a_limit_and_every_measure() {
    let of = |of, is, than: &str| Claim {
        of,
        quantity: Some("cost".to_owned()),
        ..claim(is, than, None)
    };
    let [good, bad] = [[9.0, 80.0, 80.0, 90.0, 91.0, 91.0], [9.0, 99.0, 99.0, 10.0, 99.0, 99.0]];
    let methods: [(&str, &[&[f64]]); 2] = [
        ("good", &[&good, &good, &[9.0, 80.0, 80.0, 90.0, 91.0, 91.5]]),
        ("bad", &[&bad, &bad, &[9.0, 94.0, 94.0, 20.0, 98.0, 98.0]]),
    ];
    use Relation::{Above, Below};
    for claim in [
        of(Measure::Final, Below, "limit"),
        of(Measure::Best, Below, "limit"),
        of(Measure::Exceeded, Below, "bad"),
        of(Measure::Swing, Below, "bad"),
        of(Measure::LastFive, Above, "bad"),
        of(Measure::Area, Above, "bad"),
        Claim { method: one("bad"), ..of(Measure::Final, Above, "limit") },
    ] {
        assert_eq!(verdict(&methods, claim.clone()).0, Verdict::Seen, "{claim:?}");
    }
    let curve = [[0.0, 9.0], [10.0, 99.0], [20.0, 10.0], [30.0, 98.0]];
    assert_eq!(Measure::Exceeded.of(&curve, Some(95.0)), 2.0 / 3.0);
    assert_eq!(Measure::Swing.of(&curve, None), 88.0 / 54.0);
    assert_eq!([Measure::Best, Measure::LastFive].map(|of| of.of(&curve, None)), [99.0, 54.0]);
}

/// What cannot be judged yet, or at all, says why; and a seed that is missing is not forgotten.
#[test]
fn what_is_no_answer_says_so() {
    let of = |of| Claim { of, ..claim(Relation::Above, "bad", None) };
    let young: [(&str, &[&[f64]]); 2] =
        [("good", &[&[1.0], &[2.0], &[3.0]]), ("bad", &[&[1.0], &[2.0], &[3.0]])];
    for measure in [Measure::Final, Measure::Best, Measure::Area, Measure::LastFive] {
        assert_eq!(verdict(&young, of(measure)).0, Verdict::TooEarly, "{measure:?}");
    }
    let full: [(&str, &[&[f64]]); 2] = [
        ("good", &[&[0.0, 9.0], &[0.0, 9.0], &[0.0, 9.0]]),
        ("bad", &[&[0.0, 1.0], &[0.0, 2.0], &[0.0, 3.0]]),
    ];
    assert_eq!(verdict(&full, of(Measure::LastFive)).0, Verdict::TooEarly);
    // The policy of step 0 has not trained, and is none of five.
    let five: &[f64] = &[0.0, 9.0, 8.0, 9.0, 8.0];
    let seeds: &[&[f64]] = &[five; 3];
    let five = [("good", seeds), ("bad", seeds)];
    assert_eq!(verdict(&five, of(Measure::LastFive)).0, Verdict::TooEarly);
    let costs = report(&five, Paper::default()).unwrap();
    let world = &costs.groups.worlds[0];
    assert!(costs.ends(world, 0, &Quantity::WeightedTotal).is_empty());
    assert!(costs.planes().is_empty());
    assert_eq!(verdict(&full, of(Measure::Final)).0, Verdict::Seen);
    let both = [full[0], ("bad", full[0].1)];
    assert_eq!(verdict(&both, of(Measure::Final)).0, Verdict::NoScatter);
    // One of four has failed early.
    let whole: &[f64] = &[0.0, 1.0, 2.0, 3.0];
    let other: &[f64] = &[0.0, 1.0, 2.0, 4.0];
    let good: &[&[f64]] = &[whole, other, whole, &[0.0]];
    let paper = Paper { claims: vec![of(Measure::Final)], ..Paper::default() };
    let report = report(&[("good", good), ("bad", &[whole, other, whole])], paper).unwrap();
    let judged = report.judged();
    assert!(!judged[0].is_over());
    let text = claims_table::markdown(&judged);
    assert!(text.contains("undecided so far") && text.contains("± 0.47 (3 of 4) to "), "{text}");
}

/// Beside runs that are too few, and have not come to their end, what the paper's numbers say.
#[test]
fn a_papers_numbers_are_judged_too() {
    let text = r#"
        [[published]]
        source = "Table 2"
        task = "b/hopper"
        of = "final"
        seeds = 5
        scores = { good = [5185, 465], bad = [3626, 1402], short = 83 }
    "#;
    let claims = ["bad", "short"].map(|than| claim(Relation::Above, than, None)).to_vec();
    let paper = Paper { claims, ..toml::from_str(text).unwrap() };
    let report = report(&METHODS, paper).unwrap();
    let judged = report.judged();
    let paper: Vec<_> = judged.iter().map(Judged::verdict_of_paper).collect();
    assert_eq!(paper, [Some(Verdict::Undecided), None]);
    let text = claims_table::markdown(&judged);
    let line = "| it does (Table 1) | b/hopper | total, at the end: good above bad | seen so far | undecided \
                |  | 10.0 [7.7, 12.3] | 101 ± 1 (3) to 91.0 ± 0.8 (3), at 10 of 30 steps |\n";
    assert!(text.contains(line), "{text}");
    let table = &report.tables()[0];
    assert_eq!(table.columns, ["b/hopper at 10", "b/hopper: Table 2"]);
    assert!(table.markdown().contains(" | 5185 ± 465 (5) |\n"));
    assert!(table.markdown().contains(" | 83 (5) |\n"));
    let csv = String::from_utf8(claims_table::csv(&judged).unwrap()).unwrap();
    assert!(csv.starts_with("claim,source,task,of,quantity,method,is,than,"), "{csv}");
    assert!(csv.contains(",seen,undecided,,false,10,30,101.0,1.0,3,3,91.0,1.0,3,3,"), "{csv}");
}

/// Runs of a method, with these rows in place of their own.
fn evaluated(runs: &[ReportRun], method: &str, rows: &[(u64, f64)]) {
    for run in runs.iter().filter(|run| run.label.as_deref() == Some(method)) {
        let rows = rows.iter().map(|(step, x)| format!("{step},{x},{x}\n"));
        let text = "step,weighted_total/mean,return/cost/mean\n".to_owned();
        let file = run.folder.join("evaluations.csv");
        std::fs::write(file, text + &rows.collect::<String>()).unwrap();
    }
}

/// Methods that are evaluated at other steps are compared up to one of them.
#[test]
fn methods_are_compared_up_to_one_step() {
    let folder = tempfile::tempdir().unwrap();
    let none: &[f64] = &[0.0];
    let all = runs(folder.path(), &[("good", &[none; 3]), ("bad", &[none; 3])]);
    let often: Vec<(u64, f64)> = (0..=20).map(|i| (5 * i, i as f64)).collect();
    let rare: Vec<(u64, f64)> = (0..=9).map(|i| (16 * i, 3.0 * i as f64)).collect();
    evaluated(&all, "good", &often);
    evaluated(&all, "bad", &rare);
    let claims = vec![claim(Relation::Below, "bad", None)];
    let report = Report::read("x", &all).paper(Paper { claims, ..Paper::default() }).unwrap();
    let [judged] = &report.judged()[..] else { panic!("one row") };
    let runs = judged.runs.unwrap();
    // At 95 and 96 of the 100 steps that both have reached; not at 100 and 96.
    assert_eq!((judged.steps[0], runs.ours.mean, runs.theirs.mean), (96, 19.0, 18.0));
    // Both have come as far as they go.
    assert!(judged.is_over());
    let tables = report.tables();
    assert_eq!(tables[0].columns, ["b/hopper at 100 to 144"]);
    let shown = |table: &str, row: usize| {
        let table = tables.iter().find(|one| one.name == table).unwrap();
        table.rows[row].1[0].plain()
    };
    assert_eq!(shown("final", 0), "20.0 ± 0.0 [20.0, 20.0] (3, to 100)");
    assert_eq!(shown("final", 1), "27.0 ± 0.0 [27.0, 27.0] (3, to 144)");
    assert_eq!(shown("improvement", 0), "0.000 (3, to 96)");
    let costs = tables.iter().find(|table| table.name == "reward-and-cost").unwrap();
    assert!(costs.note.contains(" They span 25 to 80 steps."), "{}", costs.note);
    assert!(costs.csv().unwrap().contains(",0,144\n"));
}

/// Who is over a limit does not win by it unmarked.
#[test]
fn totals_over_a_limit_are_marked() {
    let over: &[f64] = &[0.0, 96.0, 96.0, 96.0, 96.0, 96.0];
    let under: &[f64] = &[0.0, 99.0, 94.0, 94.0, 94.0, 94.0];
    let report = report(&[("over", &[over; 3]), ("under", &[under; 3])], Paper::default()).unwrap();
    for table in report.tables().iter().filter(|table| table.name != "reward-and-cost") {
        let marks = table.rows.iter().map(|(label, cells)| (label.as_str(), cells[0].is_violated));
        match table.name {
            "improvement" => {
                assert_eq!(marks.collect::<Vec<_>>(), [("under", false)]);
                assert_eq!(table.columns, ["b/hopper at 50, over*"]);
            }
            _ => assert_eq!(marks.collect::<Vec<_>>(), [("over", true), ("under", false)]),
        }
        assert!(
            table.note.contains(" * means that the mean cost of the last 5 "),
            "{}",
            table.note
        );
    }
}

/// A seed that is evaluated otherwise than the others of its method counts, and says so.
#[test]
fn seeds_that_are_evaluated_otherwise_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let usual: &[f64] = &[0.0, 1.0, 2.0, 3.0];
    let mut all = runs(folder.path(), &[("good", &[usual; 2]), ("rare", &[usual])]);
    assert!(!Report::read("x", &all).page(None).unwrap().contains("not evaluated as"));
    evaluated(&all, "rare", &[(0, 0.0), (30, 3.0)]);
    let rare = &mut all[2];
    rare.label = Some("good".to_owned());
    let config = crate::folder::read_config::<toml::Table>(&rare.folder).unwrap();
    let plan =
        crate::Plan { run: crate::RunSettings { seed: 2, ..config.plan.run }, ..config.plan };
    let config = crate::config::RunConfig { plan, ..config };
    crate::config::write(&rare.folder.join("config.toml"), &config).unwrap();
    let page = Report::read("x", &all).page(None).unwrap();
    assert!(
        page.contains("good-s0, the same method: 1 evaluations before step 30, not 3 evaluations")
    );
}

/// A run that has come further than a sweep wants counts as far as it is wanted.
#[test]
fn a_longer_run_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = runs(folder.path(), &[("good", &[&[0.0, 1.0, 2.0, 3.0]])]);
    let config = crate::folder::read_config::<toml::Table>(&all[0].folder).unwrap();
    let mut plan = config.plan;
    plan.run.steps = 20;
    all[0].planned = Some((plan, config.settings));
    let report = Report::read("x", &all);
    let table = &report.tables()[0];
    assert_eq!((table.columns[0].as_str(), table.rows[0].1[0].mean), ("b/hopper at 20", Some(2.0)));
}

/// A run that is done with fewer steps than a sweep wants is not done for the sweep.
#[test]
fn a_shorter_run_is_not_done() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = runs(folder.path(), &[("good", &[&[0.0, 1.0, 2.0, 3.0]])]);
    std::fs::write(all[0].folder.join("DONE"), "a fingerprint\n").unwrap();
    assert!(Report::read("x", &all).summary().starts_with("1 runs: 1 done;"));
    let config = crate::folder::read_config::<toml::Table>(&all[0].folder).unwrap();
    for (steps, state) in [(20, "done"), (30, "done"), (31, "stopped")] {
        let mut plan = config.plan.clone();
        plan.run.steps = steps;
        all[0].planned = Some((plan, config.settings.clone()));
        let report = Report::read("x", &all);
        assert!(report.summary().starts_with(&format!("1 runs: 1 {state};")), "{steps}");
        let cells = format!("<td>{state}</td><td>0</td><td>{steps}</td>");
        assert!(report.page(None).unwrap().contains(&cells), "{steps}");
    }
}

/// With as many seeds as it says, two methods that are alike are seen to be near as often as it
/// says.
#[test]
fn so_many_seeds_tell_that_two_are_near() {
    use super::claims::Comparison;
    use crate::statistics::Sample;
    let near = claim(Relation::Near, "bad", Some(0.2));
    let mut rng = copq::Rng::new(5, copq::Stream::Custom);
    for (ours, std) in [(1.0, 0.2), (1.0, 0.1), (1.15, 0.1)] {
        let [ours, theirs] = [ours, 1.0].map(|mean| Sample { mean, std, seeds: 5 });
        let seeds = Comparison { ours, theirs }.seeds_to_decide(&near).unwrap();
        let experiments = 2_000;
        let seen = (0..experiments).filter(|_| {
            let mut draw = |mean: f64| {
                let values = (0..seeds).map(|_| mean + std * rng.normal());
                Sample::of(&values.collect::<Vec<_>>())
            };
            let [ours, theirs] = [ours, theirs].map(|sample| draw(sample.mean));
            Comparison { ours, theirs }.verdict(&near) == Verdict::Seen
        });
        let share = seen.count() as f64 / f64::from(experiments);
        assert!((0.77..0.93).contains(&share), "{seeds} seeds: {share}");
    }
}

/// What is said of a paper that no run is of; nothing of one that some are of.
fn complaint(paper: Paper) -> Option<String> {
    report(&METHODS, paper).err().map(|error| error.to_string())
}

fn assert_refused(wrong: Vec<(Paper, &str)>) {
    for (paper, words) in wrong {
        let said = complaint(paper).unwrap();
        assert!(said.contains(words), "wanted '{words}' in: {said}");
    }
}

#[test]
fn a_claim_of_what_no_run_has_is_an_error() {
    let with = |change: &dyn Fn(&mut Claim)| {
        let mut claim = claim(Relation::Above, "bad", None);
        change(&mut claim);
        Paper { claims: vec![claim], ..Paper::default() }
    };
    let swing_to_limit = |claim: &mut Claim| {
        claim.of = Measure::Swing;
        claim.than = one("limit");
    };
    assert_eq!(complaint(with(&|_| ())), None);
    assert_refused(vec![
        (
            with(&|claim| claim.than = one("bed")),
            "than of the claim that it does: wanted bad or broken",
        ),
        (with(&|claim| claim.than = one("good")), "another than the method"),
        (with(&|claim| claim.than = OneOrMore::More(Vec::new())), "one name at least"),
        (with(&|claim| claim.than = one("limit")), "a cost under a limit"),
        (with(&|claim| claim.of = Measure::Exceeded), "a cost under a limit"),
        (with(&swing_to_limit), "a method's number"),
        (with(&|claim| claim.of = Measure::BestOfMean), "a number of a seed"),
        (with(&|claim| claim.method = one("god")), "got god"),
        (with(&|claim| claim.task = one("b/hoper")), "got b/hoper"),
        (with(&|claim| claim.quantity = Some("cots".to_owned())), "wanted cost, got cots"),
        (with(&|claim| claim.is = Relation::Near), "a share between 0 and 1, got none"),
        (with(&|claim| claim.within = Some(0.1)), "none but for near and not-below"),
    ]);
}

#[test]
fn numbers_of_what_no_run_has_are_an_error() {
    let published = |change: &str| {
        let text = format!(
            "[[published]]\nsource = \"Table 2\"\ntask = \"b/hopper\"\nof = \"final\"\nseeds = 5\n\
             scores = {{ good = [5185, 465] }}\n{change}"
        );
        toml::from_str::<Paper>(&text).unwrap()
    };
    let mut twice = published("");
    twice.published.push(twice.published[0].clone());
    let score = |score| {
        let mut paper = published("");
        paper.published[0].scores.insert("good".to_owned(), score);
        paper
    };
    assert_eq!(complaint(published("")), None);
    assert_refused(vec![
        (published("quantity = \"cost\""), "an objective for last-five"),
        (twice, "a second one"),
        (score(Score::WithStd([1.0, -2.0])), "the deviation at least 0"),
        (score(Score::Mean(f64::NAN)), "wanted numbers"),
    ]);
}

/// The paper's method is called alike on tasks for which it is made otherwise; the report tells
/// them apart, a claim need not.
#[test]
fn a_name_may_be_short_where_it_is_clear() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, task: &str, method: &str, label: &str| {
        let change = |plan: &mut crate::Plan| {
            plan.task = task.to_owned();
            plan.method = method.to_owned();
        };
        let run = stored(folder.path(), name, change, &[0.0, 1.0]);
        ReportRun { label: Some(label.to_owned()), ..run }
    };
    let mut runs = vec![
        run("1", "a/hopper", "cop-td3", "cop-q"),
        run("2", "b/hopper", "cop-cal", "cop-q"),
        run("3", "a/hopper", "td3", "td3"),
    ];
    let claim = Claim {
        method: one("cop-q"),
        task: one("a/hopper"),
        ..claim(Relation::Above, "td3", None)
    };
    let paper = Paper { claims: vec![claim], ..Paper::default() };
    let report = Report::read("x", &runs).paper(paper.clone()).unwrap();
    assert!(report.judged()[0].runs.is_some());
    runs.push(run("4", "a/hopper", "sac", "cop-q"));
    let said = Report::read("x", &runs).paper(paper).unwrap_err().to_string();
    assert!(said.contains("wanted cop-q cop-td3 or cop-q sac or td3, got cop-q"), "{said}");
}
