//! `check_env` passes a sound environment and says what is wrong with each broken one.

use crate::toy;

use copq::*;
use toy::Toy;

/// A sound environment with one thing changed.
struct Broken {
    inner: Toy,
    fault: Fault,
    calls: u64,
    place: f32,
}

impl Broken {
    fn by(fault: Fault) -> Self {
        let inner = if fault == Fault::NegativeCost { Toy::constrained() } else { Toy::new() };
        Self { inner, fault, calls: 0, place: 0.0 }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Fault {
    ObsNotWritten,
    NanReward,
    Unseeded,
    TimeLimitTerminates,
    NeverEnds,
    ForgetsRng,
    SpecChanges,
    NegativeCost,
    ResetsItself,
    Huge,
}

impl Env for Broken {
    fn spec(&self) -> &EnvSpec {
        &self.inner.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.calls += 1;
        let seed = if self.fault == Fault::Unseeded { seed + self.calls } else { seed };
        self.place = 0.0;
        self.inner.reset(seed, obs)?;
        if self.fault == Fault::ResetsItself {
            obs[0] *= 0.001;
        }
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.calls += 1;
        let mut unseen = [0.0];
        let obs = if self.fault == Fault::ObsNotWritten { &mut unseen } else { obs };
        let outcome = self.inner.step(action, obs, reward)?;
        match self.fault {
            Fault::NanReward => reward[1] = f32::NAN,
            Fault::SpecChanges if self.calls == 100 => self.inner.spec.name.push('!'),
            Fault::TimeLimitTerminates if outcome == Outcome::Truncated => {
                return Ok(Outcome::Terminated);
            }
            Fault::NeverEnds => return Ok(Outcome::Running),
            Fault::NegativeCost => reward[0] = -0.1,
            Fault::ResetsItself => {
                // It moves away from where episodes begin, and is back there at the end.
                self.place = if outcome == Outcome::Running { self.place + 1.0 } else { 0.0 };
                obs[0] = 0.001 * obs[0] + self.place;
            }
            Fault::Huge => {
                obs[0] *= 1e10;
                reward[1] *= 1e5;
            }
            _ => {}
        }
        Ok(outcome)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("place", [self.place]);
        self.inner.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.place = state.get_one("place")?;
        let mut forgetful = state.clone();
        if self.fault == Fault::ForgetsRng {
            Rng::with_stream(1, 1).save("rng", &mut forgetful);
        }
        self.inner.load(&forgetful)
    }
}

#[test]
fn a_sound_environment_passes() {
    let report = check_env(&mut Toy::new()).unwrap();
    assert_eq!(report.lengths, [20; 5]);
    assert_eq!(report.outcomes, [Outcome::Truncated; 5]);
    assert!(report.reward_range.iter().all(|&(low, high)| low < high && high <= 0.0), "{report:?}");
}

/// A choice and its reward, and nothing after.
struct Bandit(EnvSpec, f32);

impl Env for Bandit {
    fn spec(&self) -> &EnvSpec {
        &self.0
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.1 = Rng::with_stream(seed, 0).normal() as f32;
        obs[0] = self.1;
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        reward[0] = -(action[0] - self.1).abs();
        obs[0] = self.1 + 1.0;
        Ok(Outcome::Terminated)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("wanted", [self.1]);
        Ok(())
    }

    fn load(&mut self, state: &State) -> Result<()> {
        self.1 = state.get_one("wanted")?;
        Ok(())
    }
}

#[test]
fn a_world_of_one_step_may_end_there() {
    let spec = EnvSpec::new("bandit", 1, 1).reward("gain", 1.0).horizon(1);
    assert_eq!(check_env(&mut Bandit(spec, 0.0)).unwrap().outcomes, [Outcome::Terminated; 5]);
}

#[test]
fn each_fault_is_named() {
    let cases = [
        (Fault::ObsNotWritten, "step 1: observation[0] is not finite, or was not written"),
        (Fault::NanReward, "step 1: reward[1] is not finite"),
        (Fault::Unseeded, "reset(seed) must decide everything"),
        (Fault::TimeLimitTerminates, "a time limit is Truncated"),
        (Fault::NeverEnds, "still Running after 20 steps"),
        (Fault::ForgetsRng, "saved after step 10 of seed 0 and loaded: step 11 differs"),
        (Fault::SpecChanges, "spec() changed while it ran"),
        (Fault::NegativeCost, "step 1: the cost 'cost' is -0.1; a cost is 0 or more"),
    ];
    for (fault, wanted) in cases {
        let error = check_env(&mut Broken::by(fault)).unwrap_err().to_string();
        assert!(error.contains(wanted), "wanted '{wanted}', got '{error}'");
    }
    let spec = Toy::new().spec.action_bounds(&[-2.0], &[-3.0]);
    let error = check_env(&mut Toy { spec, ..Toy::new() }).unwrap_err().to_string();
    assert!(
        error.contains("bounds of action 0: wanted finite, lower < upper, got [-2, -3]"),
        "{error}"
    );
}

#[test]
fn what_no_network_learns_well_is_a_warning() {
    let report = check_env(&mut Broken::by(Fault::ResetsItself)).unwrap();
    let [itself] = report.warnings.as_slice() else { panic!("{report}") };
    assert!(itself.contains("looks like a first one"), "{itself}");
    let report = check_env(&mut Broken::by(Fault::Huge)).unwrap();
    let [obs, reward] = report.warnings.as_slice() else { panic!("{report}") };
    assert!(obs.contains("observations reach") && obs.contains("Config::normalise"), "{obs}");
    assert!(reward.contains("rewards reach"), "{reward}");
    assert!(report.to_string().contains("warning: observations"), "{report}");
}

#[test]
fn descriptions_that_no_learner_takes_are_errors() {
    let error = |spec: EnvSpec| check_env(&mut Toy { spec, ..Toy::new() }).unwrap_err().to_string();
    let mut zero = Toy::new().spec;
    let mut lines = zero.clone();
    zero.objectives.iter_mut().for_each(|objective| objective.weight = 0.0);
    assert!(error(zero).contains("weights: wanted one at least that is not 0"));
    lines.objectives[0].name = "a\nb".to_owned();
    assert!(error(lines).contains("a name of one line"));
}

#[test]
fn an_episode_without_end_is_broken_off() {
    let spec = Toy::new().spec.horizon(usize::MAX);
    let mut endless = Broken::by(Fault::NeverEnds);
    endless.inner.spec = spec;
    let report = check_env(&mut endless).unwrap();
    assert_eq!((report.lengths[0], report.outcomes[0]), (100_000, Outcome::Running));
}
