//! `check_env` passes a sound environment and says what is wrong with each broken one.

use crate::toy;

use copq::*;
use toy::Toy;

/// A sound environment with one thing changed.
struct Broken {
    inner: Toy,
    fault: Fault,
    calls: u64,
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
}

impl Env for Broken {
    fn spec(&self) -> &EnvSpec {
        &self.inner.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        self.calls += 1;
        let seed = if self.fault == Fault::Unseeded { seed + self.calls } else { seed };
        self.inner.reset(seed, obs)
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
            _ => {}
        }
        Ok(outcome)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        self.inner.save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
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
    ];
    for (fault, wanted) in cases {
        let error =
            check_env(&mut Broken { inner: Toy::new(), fault, calls: 0 }).unwrap_err().to_string();
        assert!(error.contains(wanted), "wanted '{wanted}', got '{error}'");
    }
    let spec = Toy::new().spec.action_bounds(&[-2.0], &[-3.0]);
    let error = check_env(&mut Toy { spec, ..Toy::new() }).unwrap_err().to_string();
    assert!(
        error.contains("bounds of action 0: wanted finite, lower < upper, got [-2, -3]"),
        "{error}"
    );
}
