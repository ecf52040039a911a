//! A method is a value: the learner built from it by a hand-written backend.

use crate::toy;

use copq::projection::{Cholesky, Extremum, IndependentMin, ScalarisedMin};
use copq::*;
use toy::{Linear, Toy};

/// What the learner of a method has learned with: critics as the learner sees them, and networks as
/// they are saved.
fn critics(mut method: Method, env: &Toy) -> usize {
    method.config = toy::small(method.config);
    let learner = Learner::new(method, &env.spec, &Linear, 0).unwrap();
    let mut state = State::default();
    learner.save(&mut state).unwrap();
    state.child("critic").unwrap().get::<f32>("online").unwrap().len() / 6
}

#[test]
fn critics_and_famo_follow_the_bound() {
    // Networks of one value each: 3 x 2 for Cholesky's, 2 x 2 for the minima.
    assert_eq!(critics(Method::cop_td3(), &Toy::new()), 6);
    assert_eq!(critics(Method::cop_td3().bound(Extremum), &Toy::new()), 6);
    assert_eq!(critics(Method::cop_td3().bound(ScalarisedMin), &Toy::new()), 4);
    assert_eq!(critics(Method::cop_td3().bound(IndependentMin), &Toy::new()), 4);
    assert_eq!(critics(Method::cop_td3().bound(IndependentMin).bound(Cholesky), &Toy::new()), 6);
    assert_eq!(critics(Method::cop_td3_paper().redq(), &Toy::new()), 20);
    assert_eq!(critics(Method::cal(), &Toy::constrained()), 6);
    assert_eq!(critics(Method::sac_lagrangian(), &Toy::constrained()), 3);

    let balanced = |mut method: Method| {
        method.config = toy::small(method.config);
        let learner = Learner::new(method, &Toy::new().spec, &Linear, 0).unwrap();
        let mut state = State::default();
        learner.save(&mut state).unwrap();
        state.child("famo").is_ok()
    };
    assert!(balanced(Method::cop_td3_oac()));
    assert!(
        !balanced(Method::cop_td3_oac().bound(IndependentMin)),
        "their losses share no network"
    );
    assert!(
        balanced(Method::cop_td3_oac().bound(IndependentMin).bound(Cholesky)),
        "FAMO is back with the networks"
    );
    assert!(
        balanced(Method::cop_td3_paper().bound(IndependentMin)),
        "the paper balances them, too"
    );
}

#[test]
fn redq_draws_from_equally_many_separate_critics() {
    let mut redq = Method::cop_td3_paper().redq();
    redq.bound = std::sync::Arc::new(IndependentMin);
    redq.config = toy::small(redq.config);
    let build = |cost, reward| {
        let redq = redq.clone().critics(Ensemble::Separate { cost, reward });
        Learner::new(redq, &Toy::constrained().spec, &Linear, 0)
    };
    let wanted = "a subset of the critics: wanted the same number of separate critics for every \
         objective, got [4, 2]";
    assert_eq!(build(4, 2).map(drop).unwrap_err().to_string(), wanted);

    let mut trainer = Trainer::new(Toy::constrained(), build(3, 3).unwrap()).unwrap();
    trainer.run(210, &mut Silent).unwrap();
    assert_eq!(trainer.agent().updates(), 11 * 20, "at step 200 and the ten after it");
}

#[test]
fn a_preset_is_its_composition() {
    let td3 = Method::td3().bound(Cholesky).warm_up(1_000);
    let mut oac = td3.balance(FamoConfig::default()).explore(Optimism::default());
    oac.config.target_period = 1;
    let preset = Method::cop_td3_oac();
    assert_eq!((&oac.config, oac.critics), (&preset.config, preset.critics));

    let lagrangian = Constraint::Lagrangian(LagrangianConfig::default());
    let cop_cal = Method::sac().bound(Cholesky).constrain(lagrangian);
    assert_eq!(
        (&cop_cal.config, cop_cal.critics),
        (&Method::cop_cal().config, Method::cop_cal().critics)
    );
}

#[test]
fn baselines_are_clipped_double_q_until_a_bound_is_swapped_in() {
    for method in [Method::td3(), Method::sac()] {
        let name = method.name.clone();
        assert_eq!(method.bound.name(), "scalarised-min", "{name}");
        assert_eq!(critics(method, &Toy::new()), 4, "{name}");
    }
    for method in [Method::cop_td3(), Method::cop_cal()] {
        assert_eq!((method.bound.name(), method.critics), ("cholesky", Ensemble::Spanning));
    }
}

#[test]
fn a_method_of_your_own_trains_and_evaluates() {
    let method = Method::new("mine", toy::config(), Extremum);
    let learner = Learner::new(method, &Toy::new().spec, &Linear, 1).unwrap();
    let mut trainer = Trainer::new(Toy::new(), learner).unwrap();
    trainer.run(2_000, &mut Silent).unwrap();
    let evaluation = trainer.evaluate(5).unwrap();
    let table = evaluation.to_string();
    assert!(
        table.starts_with("5 episodes of 20.0 steps")
            && table.contains("track")
            && table.contains("rest"),
        "{table}"
    );
    assert_eq!(trainer.evaluate(5).unwrap(), evaluation, "the same episodes every time");
    let stopped = || Err(Error::Unsupported { what: "stopped".to_owned() });
    assert_eq!(trainer.evaluate_while(5, stopped).unwrap_err().to_string(), "stopped");
    assert_eq!(trainer.evaluate(5).unwrap(), evaluation, "also after one that was cut short");
    let mut other =
        Trainer::new(Toy::new(), toy::learner(toy::method(toy::config()), 3, 1)).unwrap();
    let mut state = State::default();
    trainer.save(&mut state).unwrap();
    let refused = other.load(&state).unwrap_err().to_string();
    assert_eq!(refused, "method of the saved learner: wanted toy, got mine");
}

#[test]
fn bounds_of_any_size_are_reached_exactly() {
    for [low, high] in
        [[-1.0, 1.0], [0.1, 0.3], [-f32::MAX, f32::MAX], [0.0, f32::MAX], [-7.3, 1e-3]]
    {
        let spec = EnvSpec::new("any", 1, 1).reward("any", 1.0).action_bounds(&[low], &[high]);
        let scaled = |unit: f32| {
            let mut out = [0.0];
            spec.scale_action(&[unit], &mut out);
            out[0]
        };
        assert_eq!((scaled(-1.0), scaled(1.0)), (low, high));
        for i in -20..=20 {
            let scaled = scaled(i as f32 / 20.0);
            assert!((low..=high).contains(&scaled), "{scaled} in [{low}, {high}]");
        }
    }
    let mut out = [0.0];
    EnvSpec::new("unit", 1, 1).scale_action(&[0.123_456_79], &mut out);
    assert_eq!(out[0], 0.123_456_79);
}
