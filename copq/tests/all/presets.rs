//! The constants of every preset, typed once more from the papers' tables.

use approx::assert_abs_diff_eq;
use copq::*;

/// What all presets share (paper Table D.3).
fn assert_common(name: &str, config: &Config) {
    let discount = if name == "cop_td3" { 0.995 } else { 0.99 };
    assert_eq!((config.discount, config.tau), (discount, 0.005), "{name}");
    let networks = Networks {
        hidden: vec![256, 256],
        critic_lr: 3e-4,
        actor_lr: 3e-4,
        init: if name == "cop_td3" { Init::Lecun } else { Init::Torch },
        activation: Activation::Relu,
        precision: Precision::F32,
    };
    assert_eq!(config.networks, networks, "{name}");
    assert_eq!(config.check().map_err(|e| e.to_string()), Ok(()), "{name}");
}

/// Batch, capacity, warm-up; updates a step, actor delay, target period.
fn sizes(config: &Config) -> ([usize; 3], [u64; 3]) {
    let Config {
        batch, capacity, start_steps, updates_per_step, actor_delay, target_period, ..
    } = *config;
    ([batch, capacity, start_steps as usize], [updates_per_step as u64, actor_delay, target_period])
}

#[test]
fn sizes_and_rhythms() {
    let rows: [(&str, Config, [usize; 3], [u64; 3]); 11] = [
        ("cop_td3", Method::cop_td3().config, [256, 1_000_000, 1_000], [1, 2, 1]),
        ("cop_td3_oac", Method::cop_td3_oac().config, [256, 1_000_000, 1_000], [1, 2, 1]),
        ("cop_td3_paper", Method::cop_td3_paper().config, [256, 1_000_000, 16_384], [1, 2, 1]),
        ("td3", Method::td3().config, [256, 1_000_000, 25_000], [1, 2, 2]),
        ("redq", Method::cop_td3_paper().redq().config, [256, 100_000, 5_000], [20, 20, 1]),
        ("redq on sac", Method::sac().redq().config, [256, 100_000, 5_000], [20, 20, 1]),
        ("sac", Method::sac().config, [256, 1_000_000, 10_000], [1, 2, 2]),
        ("sac_lagrangian", Method::sac_lagrangian().config, [256, 1_000_000, 10_000], [1, 2, 2]),
        ("cop_cal", Method::cop_cal().config, [256, 1_000_000, 10_000], [1, 2, 2]),
        ("cal", Method::cal().config, [256, 1_000_000, 10_000], [1, 2, 2]),
        ("cal_original", Method::cal_original().config, [12, 1_000_000, 5_000], [10, 1, 2]),
    ];
    for (name, config, wanted, rhythm) in rows {
        assert_common(name, &config);
        assert_eq!(sizes(&config), (wanted, rhythm), "{name}");
        let noise = if name == "cop_td3" { 0.3 } else { 0.1 };
        assert_eq!((config.pessimism, config.exploration_std), (1.0, noise), "{name}");
        let redq = name.starts_with("redq");
        assert_eq!(config.subset, redq.then_some(2), "{name}");
        assert_eq!(config.actor_pessimism, if redq { 0.0 } else { 1.0 }, "{name}");
        assert_eq!(config.own_cost_targets, name.starts_with("cal"), "{name}");
        assert_eq!(config.optimism.is_some(), name == "cop_td3_oac", "{name}");
        assert_eq!(
            config.famo.is_some(),
            ["cop_td3_oac", "cop_td3_paper", "redq"].contains(&name),
            "{name}"
        );
        assert_eq!(config.warm_up == WarmUp::Policy, name == "cop_td3_paper", "{name}");
        assert_eq!(config.normalise, name == "cop_td3", "{name}");
        let deterministic = name.starts_with("cop_td3") || ["td3", "redq"].contains(&name);
        assert_eq!(
            config.smoothing,
            deterministic.then_some(Smoothing { std: 0.2, clip: 0.5 }),
            "{name}"
        );
        assert_eq!(config.entropy.is_some(), !deterministic, "{name}");
    }
}

#[test]
fn balancing_and_optimism() {
    let paper = Method::cop_td3_paper().config;
    let famo =
        FamoConfig { lr: 0.025, weight_decay: 0.001, decay: FamoDecay::Decoupled, separate: true };
    assert_eq!((paper.famo, paper.optimism), (Some(famo), None));
    let config = Method::cop_td3_oac().config;
    assert_eq!(config.famo, Some(FamoConfig { separate: false, ..famo }));
    assert_eq!(
        config.optimism,
        Some(Optimism { beta: 4.66, shift: 6.86, projection: None, until: None })
    );
    // 6.86 is the root of twice the KL bound 23.53, whose 4.66 is the radius: both to three digits.
    assert_abs_diff_eq!(0.5 * 6.86f64.powi(2), 23.53, epsilon = 0.005);
}

#[test]
fn entropy_and_multipliers() {
    let entropy = |lr| Some(Entropy { temperature: 1.0, lr, target: None, objective: None });
    let lagrangian = |multiplier, lr, augmentation| {
        Some(Constraint::Lagrangian(LagrangianConfig { multiplier, lr, augmentation, cap: 1e6 }))
    };
    for (config, wanted_entropy, constraint) in [
        (Method::sac().config, entropy(5e-4), None),
        (Method::sac_lagrangian().config, entropy(5e-4), lagrangian(1.0, 5e-4, 0.0)),
        (Method::cop_cal().config, entropy(5e-4), lagrangian(1.0, 5e-4, 10.0)),
        (Method::cal().config, entropy(5e-4), lagrangian(1.0, 5e-4, 10.0)),
        (Method::cal_original().config, entropy(3e-4), lagrangian(2.0f64.ln(), 3e-4, 10.0)),
    ] {
        assert_eq!((config.entropy, config.constraint), (wanted_entropy, constraint));
    }
    let pid = PidConfig {
        proportional: 1e-6,
        integral: 1e-7,
        derivative: 1e-7,
        multiplier: 0.001,
        delay: 10,
        cap: 100.0,
        integral_cap: f64::INFINITY,
    };
    assert_eq!(PidConfig::default(), pid);
}

/// Before a world or a network is made.
#[test]
fn settings_that_cannot_be_used_are_named() {
    let error = |change: &dyn Fn(&mut Config)| {
        let mut config = Method::sac_lagrangian().config;
        change(&mut config);
        config.check().unwrap_err().to_string()
    };
    let lagrangian = LagrangianConfig { cap: 0.5, multiplier: 1.0, ..LagrangianConfig::default() };
    let pid = PidConfig { cap: 0.5, multiplier: 1.0, ..PidConfig::default() };
    let famo = FamoConfig { lr: -1.0, ..FamoConfig::default() };
    let entropy = Entropy { temperature: 0.0, ..Entropy::default() };
    for (wanted, got) in [
        ("capacity: wanted at least 1", error(&|config| config.capacity = 0)),
        (
            "lagrangian.multiplier: wanted at most the cap",
            error(&|config| config.constraint = Some(Constraint::Lagrangian(lagrangian))),
        ),
        (
            "pid.multiplier: wanted at most the cap, 0.5, got 1",
            error(&|config| config.constraint = Some(Constraint::Pid(pid))),
        ),
        ("famo.lr: wanted a finite number", error(&|config| config.famo = Some(famo))),
        (
            "entropy.temperature: wanted a positive number",
            error(&|config| config.entropy = Some(entropy.clone())),
        ),
        (
            "unknown projection 'cholsky'; known: cholesky",
            error(&|config| config.optimism = Some(Optimism::by("cholsky"))),
        ),
        ("discount: wanted a number from 0 to 1", error(&|config| config.discount = 1.5)),
    ] {
        assert!(got.starts_with(wanted), "wanted '{wanted}', got '{got}'");
    }
}
