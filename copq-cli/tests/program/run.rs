//! The program as people call it: every method trains, resumes, evaluates, shows and exports what
//! it has learned.

use std::path::Path;

use crate::common::{TINY, copq, printed, refused};

/// What it prints when all goes well.
fn run(arguments: &[&str]) -> String {
    printed(copq().args(arguments))
}

/// What it says when it fails.
fn complaint(line: &str) -> String {
    refused(copq().args(line.split(' ')))
}

/// Trains twice, the second time as a resumed run, and looks at the policy; returns the metrics'
/// names.
fn train(line: &str, start: u64, halves: [u64; 2]) -> String {
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let out = path.to_str().unwrap();
    let [half, whole] = halves.map(|steps| steps.to_string());
    let start = format!("start_steps={start}");
    let cadence = ["--eval-every", &half, "--eval-episodes", "1", "--log-every", "20"];
    let fresh = ["--out", out, "--steps", &half, "--set", &start];
    let words: Vec<&str> =
        ["train"].into_iter().chain(line.split(' ').filter(|word| !word.is_empty())).collect();
    run(&[&words, &cadence[..], &fresh].concat());
    run(&["resume", out, "--steps", &whole]);
    let film = temporary.path().join("rollout.GIF");
    run(&["rollout", out, "--steps", "3", "--out", film.to_str().unwrap()]);
    let metrics = std::fs::read_to_string(path.join("metrics.csv")).unwrap();
    metrics.lines().next().unwrap().to_owned()
}

#[test]
fn methods_on_td3() {
    for line in [
        "",
        "td3",
        "td3 --task gym/hopper",
        "td3 --bound cholesky",
        "--bound independent-min",
        "cop-td3-oac --order vsc",
        "cop-td3-paper --projection independent-min",
        "--set normalise=false --set networks.activation=silu",
    ] {
        let metrics = train(line, 150, [180, 200]);
        let first = if line.contains("gym/") { "reward" } else { "safety" };
        assert!(metrics.contains(&format!("critic_loss/{first}")), "{line}: {metrics}");
        let famo = ["cop-td3-paper", "cop-td3-oac"].iter().any(|method| line.contains(method));
        assert_eq!(metrics.contains("famo/"), famo, "{line}: {metrics}");
    }
}

/// Rewards or critics would be searched for a fault that they do not have.
#[test]
fn what_has_diverged_is_named() {
    let temporary = tempfile::tempdir().unwrap();
    for (method, step_size, wanted) in [
        ("sac", "actor_lr", "the actor's weights have diverged; lower its step size"),
        ("td3", "critic_lr", "the critics have diverged; lower their step size"),
    ] {
        let mut command = copq();
        command.args(["train", method, "--steps", "400"]).args(TINY.split(' '));
        command.args(["--set", &format!("networks.{step_size}=1e20"), "--out"]);
        let said = refused(command.arg(temporary.path().join(method)));
        assert!(said.contains(wanted) && !said.contains("[]"), "{said}");
    }
}

#[test]
fn doctor_says_what_to_do_about_an_interpreter_that_was_named() {
    let doctor = |arguments: &[&str], variable: &str| {
        let mut command = copq();
        let output = command.arg("doctor").args(arguments).env("COPQ_PYTHON", variable).output();
        let output = output.unwrap();
        assert!(!output.status.success());
        let says = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (says(output.stdout), says(output.stderr))
    };
    for (arguments, variable, named) in [
        (&["--python", "/no/python"][..], "python3", "--python /no/python"),
        (&[], "/no/other", "COPQ_PYTHON /no/other"),
    ] {
        let (out, error) = doctor(arguments, variable);
        assert!(!out.contains("it works") && !out.contains("next: nothing"), "{out}");
        assert!(error.contains(&format!("next: {named}: wanted an interpreter")), "{error}");
    }
}

#[test]
fn redq() {
    assert!(train("redq", 280, [283, 285]).contains("q_std/safety"));
    train("redq-oac", 280, [281, 282]);
    for line in ["redq-sac", "redq-sac-oac", "redq-sac-oac --set optimism.projection=extremum"] {
        assert!(train(line, 280, [281, 282]).contains("actor/temperature"));
    }
}

#[test]
fn methods_under_a_limit() {
    for line in [
        "cop-cal",
        "cal",
        "cal-original",
        "saclag-ucb",
        "sac-lagrangian",
        "sac-pid",
        "cal --order rc",
    ] {
        let metrics = train(line, 150, [200, 240]);
        let multiplier = [
            "multiplier/cost",
            "multiplier_effective/cost",
            "cost_estimate/cost",
            "cost_violation/cost",
        ];
        for name in multiplier.into_iter().chain(["actor/temperature"]) {
            assert!(metrics.contains(name), "{line}: {metrics}");
        }
    }
}

#[test]
fn sac_without_a_limit_and_without_an_entropy_bonus() {
    assert!(!train("sac", 150, [180, 200]).contains("multiplier"));
    let metrics = train("cop-cal --set entropy=none", 150, [180, 200]);
    assert!(metrics.contains("multiplier/cost") && !metrics.contains("actor/entropy"), "{metrics}");
}

#[test]
fn a_run_is_evaluated_exported_and_compared() {
    let temporary = tempfile::tempdir().unwrap();
    let path = |name: &str| temporary.path().join(name).to_str().unwrap().to_owned();
    let short = "--steps 200 --set start_steps=150 --eval-every 100 --eval-episodes 2";
    for seed in ["0", "1"] {
        let out = path(seed);
        printed(copq().args(["train", "--seed", seed, "--out", &out]).args(short.split(' ')));
    }
    let best = run(&["evaluate", &path("0"), "--episodes", "2", "--best"]);
    let film = path("best.gif");
    run(&["rollout", &path("0"), "--best", "--steps", "3", "--out", &film]);
    // The best policy's file lies in its folder under the last one's name, too.
    std::fs::create_dir(path("as-last")).unwrap();
    for (name, copy) in
        [("config.toml", "config.toml"), ("policy-best.safetensors", "policy.safetensors")]
    {
        std::fs::copy(format!("{}/{name}", path("0")), format!("{}/{copy}", path("as-last")))
            .unwrap();
    }
    assert_eq!(best, run(&["evaluate", &path("as-last"), "--episodes", "2"]));
    let error = complaint(&format!("evaluate {} --best", path("as-last")));
    assert!(error.contains("wanted policy-best.safetensors"), "{error}");
    let error = complaint(&format!("rollout {}", path("typo")));
    assert!(error.contains("got nothing of that name"), "{error}");
    let table = run(&["evaluate", &path("0"), "--episodes", "2"]);
    for words in [
        "cop-td3 on a/hopper (rapier), 2 episodes of seed 0",
        "| steps |",
        "| safety |",
        "| weighted total |",
    ] {
        assert!(table.contains(words), "{table}");
    }
    // The run's own seed begins with the episodes of its evaluations.
    let json: serde_json::Value =
        serde_json::from_str(&run(&["evaluate", &path("0"), "--episodes", "2", "--json"])).unwrap();
    let evaluations = std::fs::read_to_string(temporary.path().join("0/evaluations.csv")).unwrap();
    let last =
        evaluations.lines().last().unwrap().split(',').nth(2).unwrap().parse::<f64>().unwrap();
    let total = json["quantities"]
        .as_array()
        .unwrap()
        .iter()
        .find(|q| q["name"] == "weighted total")
        .unwrap();
    assert!((total["mean"].as_f64().unwrap() - last).abs() < 1e-9, "{json}");

    // What its critics' bound is worth, once for each checkpoint that is kept.
    let args = |more: &[&'static str]| {
        let zero = path("0");
        let args = [&["coverage", &zero, "--episodes", "2", "--stride", "1"], more].concat();
        run(&args)
    };
    let rows = args(&["--bare", "--csv"]);
    let rows: Vec<Vec<&str>> = rows.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 4, "{rows:?}");
    let names = ["safety", "velocity", "control", "weighted total"];
    for (row, objective) in rows[1..].iter().zip(names) {
        assert_eq!((row[0], row[1], row[5]), ("200", "2", objective), "{row:?}");
        let numbers: Vec<f64> = row[6..].iter().map(|number| number.parse().unwrap()).collect();
        let [discounted, q_mean, bound, q_std, rmse, coverage, se, nominal] = numbers[..] else {
            panic!("{row:?}")
        };
        assert!(bound.is_finite() && q_std > 0.0 && se >= 0.0, "{row:?}");
        assert!([coverage, nominal].iter().all(|share| (0.0..=1.0).contains(share)), "{row:?}");
        assert!(rmse >= (discounted - q_mean).abs(), "{row:?}");
    }
    let table = args(&[]);
    for words in ["the policy as it is valued", "step 200", "| safety |", "| weighted total |"] {
        assert!(table.contains(words), "{table}");
    }

    let said = run(&["export", &path("0")]);
    assert!(
        said.contains("policy.safetensors")
            && temporary.path().join("0/policy.safetensors").exists(),
        "{said}"
    );

    let label = |seed: &str| format!("cop={}", path(seed));
    let table = run(&["plot", "--out", &path("curves.svg"), &label("0"), &label("1")]);
    assert!(
        table.contains("| cop | 2 | 200 |") && Path::new(&path("curves.svg")).exists(),
        "{table}"
    );
}

#[test]
fn lists() {
    let methods = run(&["methods"]);
    for name in copq::Method::names() {
        assert!(methods.contains(&format!("| {name} |")), "{methods}");
    }
    assert!(methods.contains("| cal | 4 a cost, 2 a reward | mean-std |"), "{methods}");
    assert!(
        run(&["tasks"]).contains("a/hopper")
            && run(&["tasks", "--preset", "paper"]).contains("a/hopper")
    );
    assert!(run(&["completions", "bash"]).contains("complete"));
    assert!(run(&["--help"]).contains("copq train"));
}

/// A method's own bound takes nothing away, such as REDQ's subset.
#[test]
fn a_methods_own_bound_is_the_method_itself() {
    let temporary = tempfile::tempdir().unwrap();
    let settings = |method: &str, bound: &[&str]| {
        let out = temporary.path().join(format!("{method}{}", bound.len()));
        let out = out.to_str().unwrap();
        let tiny = ["--steps", "10", "--eval-every", "0", "--set", "networks.hidden=[8]"];
        run(&[&["train", method, "--out", out, "--task", "b/hopper"], bound, &tiny].concat());
        let config = std::fs::read_to_string(Path::new(out).join("config.toml")).unwrap();
        // All but the command.
        config.split_once("[made_with]").unwrap().0.to_owned()
    };
    for (method, bound) in [("redq", "scalarised-min"), ("cal", "mean-std")] {
        assert_eq!(settings(method, &["--bound", bound]), settings(method, &[]));
    }
}

#[test]
fn wrong_words_are_readable_errors() {
    for (line, wanted) in [
        (
            "train cop-cal --task a/hopper",
            "Error: a constraint on 'a/hopper': wanted a task with a cost under a limit",
        ),
        (
            "train redq --bound cholesky",
            "Error: --bound cholesky: wanted none, for redq has its own, scalarised-min",
        ),
        (
            "train --set optimism.shift=1",
            "cop-td3 would be another method; choose cop-td3-oac, which explores towards the upper",
        ),
        ("train redq-oac --set optimism=none", "choose redq, which explores by noise alone"),
        (
            "train redq-oac --set optimism.projection=choleski",
            "unknown projection 'choleski'; known: cholesky",
        ),
        (
            "train --limit cost=1 --limit cost=2",
            "Error: --limit cost=2: wanted one limit of a cost, got two",
        ),
        ("train --set bach=3", "unknown field `bach`, expected one of `discount`"),
        ("train --seed -1", "invalid value '-1' for '--seed <N>': wanted a whole number from 0 on"),
        ("train --steps 0", "invalid value '0' for '--steps <N>': wanted a whole number from 1 on"),
        ("train cop-tdr", "invalid value 'cop-tdr' for '[METHOD]'"),
        ("train --bound eigne", "a similar value exists: 'eigen'"),
        (
            "resume nowhere",
            "run folder 'nowhere': wanted the folder of a run, got nothing of that name",
        ),
    ] {
        let error = complaint(line);
        assert!(error.contains(wanted), "copq {line}: {error}");
    }
}

#[test]
fn resume_lets_only_the_steps_grow() {
    let temporary = tempfile::tempdir().unwrap();
    let out = temporary.path().join("run").to_str().unwrap().to_owned();
    let short = ["--steps", "60", "--eval-every", "60", "--eval-episodes", "1"];
    run(&[&["train", "--out", &out], &short[..]].concat());
    let error = complaint(&format!("resume {out} --steps 40"));
    assert!(error.contains("wanted at least the planned 60, got 40"), "{error}");
    let error = complaint(&format!("train --out {out}"));
    assert!(error.contains(&format!("resume this run with copq resume {out}")), "{error}");
}

/// Several worlds take several steps at once, and pass the multiples of an interval: those rows are
/// kept by a run that goes on.
#[test]
fn a_run_of_several_worlds_goes_on_to_the_same_bytes() {
    let temporary = tempfile::tempdir().unwrap();
    let at = |name: &str| temporary.path().join(name);
    let train = |name: &str, steps: &str| {
        let line = "train ppo --task b/hopper --envs 3 --eval-every 50 --eval-episodes 1 \
                    --log-every 20 --checkpoint-every 70 --set steps_per_epoch=60 \
                    --set networks.hidden=[8,8] --set anneal_steps=none --out";
        printed(copq().args(line.split(' ')).arg(at(name)).args(["--steps", steps]));
    };
    train("whole", "300");
    // Both ends are off the intervals, and so is the checkpoint.
    train("half", "150");
    run(&["resume", at("half").to_str().unwrap(), "--steps", "300"]);
    for name in ["metrics.csv", "evaluations.csv", "checkpoint.safetensors"] {
        let bytes = |run: &str| std::fs::read(at(run).join(name)).unwrap();
        assert!(bytes("whole") == bytes("half"), "{name}");
    }
    let rows = std::fs::read_to_string(at("whole").join("evaluations.csv")).unwrap();
    let steps: Vec<&str> = rows.lines().skip(1).filter_map(|row| row.split(',').next()).collect();
    assert_eq!(steps, ["0", "51", "102", "150", "201", "252", "300"]);
}

#[test]
fn settings_do_not_make_another_on_policy_method() {
    for (line, wanted) in [
        ("ppo-lag --set constraint=none", "--set constraint: wanted adam in ppo-lag, got none"),
        ("rcpo --set natural=none", "--set natural: wanted one in rcpo, got none"),
        ("rcpo --set second.passes=40", "--set second: wanted none in rcpo, got one"),
        ("ppo-saute --set saute=none", "--set saute: wanted one in ppo-saute, got none"),
        ("ppo-saute --set saute.discount=0.5", "whose 1000th power is not too small for f32"),
        ("ppo --set anneal_steps=0", "anneal_steps: wanted at least 1"),
        ("ppo-lag --set constraint.adam.lr=-1", "constraint.lr: wanted"),
        ("td3 --task gym/hopper --envs 100000", "--envs: wanted 1 for td3"),
    ] {
        let out = tempfile::tempdir().unwrap();
        let line = format!("train {line} --out {}", out.path().join("run").display());
        let said = complaint(&line);
        assert!(said.contains(wanted), "{line}: {said}");
    }
}
