//! The runs that are kept under `results/` still open, as what they were.

use std::path::{Path, PathBuf};

use copq::{Config, Ensemble, on_policy};
use copq_experiments::{RunConfig, read_config, read_plan};

fn folder(run: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../results").join(run)
}

fn read(run: &Path) -> RunConfig<Config> {
    read_config(run).unwrap_or_else(|error| panic!("{}: {error}", run.display()))
}

#[test]
fn every_stored_run_opens() {
    let mut runs = 0;
    for group in
        std::fs::read_dir(folder("")).unwrap().flatten().filter(|entry| entry.path().is_dir())
    {
        for run in std::fs::read_dir(group.path()).unwrap().flatten() {
            let path = run.path();
            if !path.join("config.toml").exists() {
                continue;
            }
            if on_policy::Method::names().any(|name| name == read_plan(&path).unwrap().method) {
                read_config::<on_policy::Config>(&path).unwrap();
            } else {
                read(&path);
            }
            runs += 1;
        }
    }
    assert!(runs >= 40, "{runs}");
}

#[test]
fn old_words_become_todays() {
    let redq = Ensemble::Joint(10);
    let cal = Ensemble::Separate { cost: 4, reward: 2 };
    let pairs = Ensemble::Separate { cost: 2, reward: 2 };
    for (run, method, bound, critics) in [
        ("hopper-mujoco-redq/redq-s0", "redq", "scalarised-min", redq),
        ("hopper-mujoco-redq/redq-cop-oac-s0", "redq-oac", "scalarised-min", redq),
        ("hopper-mujoco-constrained/cal-s0", "cal", "mean-std", cal),
        ("hopper-mujoco-constrained/cop-cal-s0", "cop-cal", "cholesky", Ensemble::Spanning),
        ("hopper-mujoco-constrained/saclag-ucb-s0", "saclag-ucb", "independent-min", pairs),
        (
            "hopper-rapier-oac/scalarised-min-s0",
            "cop-td3-oac",
            "scalarised-min",
            Ensemble::Joint(2),
        ),
        ("hopper-rapier-oac/extremum-s0", "cop-td3-oac", "extremum", Ensemble::Spanning),
        ("hopper-search/norm-noise03-s11", "cop-td3", "cholesky", Ensemble::Spanning),
        ("hopper-search/norm-oac2-s10", "cop-td3-oac", "cholesky", Ensemble::Spanning),
        ("hopper-rapier-oac/independent-min-s0", "cop-td3-oac", "independent-min", pairs),
        ("robots/rapier-ant", "cop-td3-oac", "cholesky", Ensemble::Spanning),
    ] {
        let plan = read(&folder(run)).plan;
        assert_eq!(
            (plan.method.as_str(), plan.bound.as_deref(), plan.critics),
            (method, Some(bound), Some(critics)),
            "{run}"
        );
    }
    let famo = |run| read(&folder(run)).settings.famo;
    assert!(
        famo("hopper-rapier-oac/independent-min-s0").unwrap().separate,
        "its critics were balanced"
    );
    assert!(!famo("hopper-rapier-oac/extremum-s0").unwrap().separate);
    assert!(famo("hopper-mujoco-oac/independent-min-no-famo-s0").is_none());
    let explores = read(&folder("hopper-mujoco-redq/redq-cop-oac-s0")).settings.optimism.unwrap();
    assert_eq!(explores.projection.as_deref(), Some("cholesky"));
}
