//! The page of many runs, its tables and figures, and the pictures of bounds.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::{TINY, copq_in, read, refused, run, wait_until};

/// A column's last number.
fn last(path: &Path, column: &str) -> f64 {
    let text = read(path);
    let index = text.lines().next().unwrap().split(',').position(|name| name == column).unwrap();
    text.lines().last().unwrap().split(',').nth(index).unwrap().parse().unwrap()
}

#[test]
fn a_page_its_tables_and_its_figures() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (name, line) in [
        ("a-s0", "--seed 0"),
        ("a-s1", "--seed 1"),
        ("b-s0", "--bound extremum --seed 0"),
        ("c-s0", "cop-cal --seed 0"),
    ] {
        run(folder, &format!("train {line} {TINY} --steps 250 --out runs/{name}"));
    }
    // A run whose evaluations are gone, one whose table is damaged, one that failed.
    for (name, file, text) in [
        ("d-s0", "evaluations.csv", ""),
        ("e-s0", "evaluations.csv", "step,weighted_total/mean\n0,1.5\n50.0,2\n100,3\n"),
        ("g-s0", "evaluations.csv", "step,weighted_total/mean\n0,1.5\n1,2\n2,l3\n"),
        ("h-s0", "metrics.csv", "step,clip_rate\n10,0.5\n20,0.5\n30,0.5\n40,O.5\n"),
        ("f-s0", "log.txt", "from step 0\nerror: the <disk> is full\n"),
    ] {
        let copy = folder.join("runs").join(name);
        std::fs::create_dir(&copy).unwrap();
        let config = read(folder.join("runs/a-s0/config.toml")).replace("seed = 0", "seed = 7");
        std::fs::write(copy.join("config.toml"), config).unwrap();
        std::fs::write(copy.join(file), text).unwrap();
    }
    let said = run(folder, "report runs --out page.html --parts parts --title A<b>&B");
    assert!(said.starts_with("page.html: 9 runs: 4 done"), "{said}");
    let page = read(folder.join("page.html"));
    for wanted in [
        "<title>A&lt;b&gt;&amp;B</title>",
        "cop-td3 cholesky",
        "cop-td3 extremum",
        "the &lt;disk&gt; is full",
        "is the same seed",
        "line 3 of ",
        "line 4 of ",
        "line 5 of ",
        "Reward against cost",
        "What the critics disagree about",
        "correlation/safety/velocity",
    ] {
        assert!(page.contains(wanted), "no {wanted}");
    }
    assert!(!page.contains("http-equiv") && !page.contains("src=\"http"));
    // The table's numbers are the files'.
    let ends = ["a-s0", "a-s1"].map(|run| {
        last(&folder.join("runs").join(run).join("evaluations.csv"), "weighted_total/mean")
    });
    let table = read(folder.join("parts/final.csv"));
    let row = table.lines().find(|line| line.starts_with("cop-td3 cholesky,")).unwrap();
    let mean: f64 = row.split(',').nth(1).unwrap().parse().unwrap();
    assert!((mean - 0.5 * (ends[0] + ends[1])).abs() < 1e-9, "{row} {ends:?}");
    assert!(read(folder.join("parts/reward-and-cost.tex")).contains("\\begin{tabular}"));
    let files =
        ["a-hopper-rapier-gym-v5.svg", "a-hopper-rapier-gym-v5.png", "all-tasks-column.svg"];
    assert!(files.iter().all(|name| folder.join("parts").join(name).is_file()));

    for (run, line) in [("e-s0", 3), ("g-s0", 4)] {
        let words = refused(&mut copq_in(folder, &format!("plot e=runs/{run} a=runs/a-s0")));
        let wanted = format!("line {line} of 'runs/{run}/evaluations.csv': wanted 2 cells");
        assert!(words.contains(&wanted), "{words}");
    }

    // A folder that says no seed counts once, too.
    std::fs::remove_file(folder.join("runs/a-s0/config.toml")).unwrap();
    for (line, wanted) in [
        ("plot a=runs/a-s0 a=runs/../runs/a-s0", "wanted each seed once, got "),
        ("plot a=runs/a-s0 --limit nonsense=3", "--out <FILE>"),
        ("plot a=runs/a-s0 --limit nonsense=3 --out a.svg", "objective of a limit: wanted"),
        ("report parts", "'parts': wanted runs in it, got none"),
    ] {
        let words = refused(&mut copq_in(folder, line));
        assert!(words.contains(wanted), "{line}: {words}");
    }
}

/// A method over a task's limit is marked, and the step at which a total is passed told.
#[test]
fn a_table_with_limits_and_thresholds() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let line = format!("train cop-cal --task b/hopper {TINY} --steps 250");
    run(folder, &format!("{line} --limit cost=0 --out a"));
    run(folder, &format!("{line} --limit cost=1000000 --out b"));
    let table = run(folder, "plot over=a under=b --passes -1000000");
    for wanted in ["| over* | 1 |", "| under | 1 |", "| passes -1000000 at |", "| 250 |\n"] {
        assert!(table.contains(wanted), "no {wanted}: {table}");
    }
    assert!(
        table.ends_with("\n`*`: the mean cost of the last five evaluations exceeds its limit.\n")
    );
}

/// However deep it lies, and behind links too, which may lead round in circles.
#[cfg(unix)]
#[test]
fn runs_are_found_wherever_they_lie() {
    use std::os::unix::fs::symlink;
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let run_in = |path: &str| {
        let run = folder.join(path);
        std::fs::create_dir_all(&run).unwrap();
        std::fs::write(run.join("evaluations.csv"), "step,weighted_total/mean\n0,1.5\n").unwrap();
    };
    run_in("runs/1/2/3/4/5/6/deep");
    run_in("runs/run");
    run_in("disk/outside");
    for (to, link) in [("disk", "runs/disk"), ("runs", "runs/circle"), ("runs/run", "runs/last")] {
        symlink(folder.join(to), folder.join(link)).unwrap();
    }
    let said = run(folder, "report runs --out page.html");
    assert!(said.starts_with("page.html: 3 runs: "), "{said}");
    let page = read(folder.join("page.html"));
    let shown = |name: &str| page.contains(&format!("<td>{name}</td>"));
    assert!(shown("deep") && shown("outside") && shown("run") && !shown("last"));
}

/// While a run goes on the page is written again and loads itself again; then it is the last one.
#[cfg(unix)]
#[test]
fn a_page_of_what_goes_on() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let line = format!("train {TINY} --steps 1000000 --out runs/a-s0");
    let quiet =
        |mut command: Command| command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut training = quiet(copq_in(folder, &line));
    wait_for(&folder.join("runs/a-s0/evaluations.csv"), |text| text.lines().count() > 2);
    let mut report = quiet(copq_in(folder, "report runs --out page.html --every 1"));
    wait_for(&folder.join("page.html"), |page| {
        page.contains("http-equiv=\"refresh\" content=\"1\"")
    });
    let id = training.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
    assert_eq!(training.wait().unwrap().code(), Some(75));
    assert!(report.wait().unwrap().success());
    assert!(!read(folder.join("page.html")).contains("http-equiv"));
}

fn wait_for(file: &Path, holds: impl Fn(&str) -> bool) {
    let is_so = || std::fs::read_to_string(file).is_ok_and(|text| holds(&text));
    wait_until(&file.to_string_lossy(), is_so);
}

#[test]
fn pictures_of_bounds() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    run(folder, "bounds --out paper");
    for name in ["figure-1a", "figure-1b", "figure-1c", "figure-2a", "figure-2b", "figure-b1a"] {
        assert!(read(folder.join(format!("paper/{name}.svg"))).contains("</svg>"), "{name}");
    }
    let film = std::fs::read(folder.join("paper/clip.gif")).unwrap();
    assert!(film.starts_with(b"GIF89a"));
    run(folder, "bounds --out own --std 1,2 --correlation -0.5 --weights 1,3");
    assert!(read(folder.join("own/bounds.svg")).contains("correlation of -0.5"));
    for (line, wanted) in [
        ("bounds --correlation 0.5", "--std"),
        ("bounds --std 1,0 --correlation 0", "--std: wanted two numbers above 0"),
        ("bounds --std 1,1 --correlation 2", "--correlation: wanted -1 to 1"),
        ("bounds --weights 1", "--weights: wanted two numbers, as 1,2, got 1 numbers"),
    ] {
        let words = refused(&mut copq_in(folder, line));
        assert!(words.contains(wanted), "{line}: {words}");
    }
}
