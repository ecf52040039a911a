//! What a run is, as a short text that is the same for the same numbers.

use copq::{Error, Result, State, Value};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::plan::Plan;

/// Sixteen letters that are the same for two runs if everything that can change their numbers is
/// the same, as long as nothing interrupts them: plan and settings, but not threads, the folder,
/// which checkpoints and replays are kept, or what happens after an error of the environment.
///
/// ```
/// use copq::Method;
/// use copq_experiments::{Plan, RunSettings, fingerprint};
///
/// let method = Method::cop_td3();
/// let plan = Plan::new(&method);
/// let seed_1 = Plan { run: RunSettings { seed: 1, ..plan.run }, ..plan.clone() };
/// let threads = Plan { threads: 4, ..plan.clone() };
/// let of = |plan| fingerprint(plan, &method.config);
/// assert_eq!(of(&plan)?, of(&threads)?);
/// assert_ne!(of(&plan)?, of(&seed_1)?);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn fingerprint<S: Serialize>(plan: &Plan, settings: &S) -> Result<String> {
    let plan = table(&plan.without_keeping())?;
    // Tables are sorted by their keys, so equal tables give equal texts.
    let text = format!("{plan}\n{}", table(settings)?);
    Ok(letters(Sha256::new_with_prefix(text)))
}

/// Sixteen letters that stand for a text.
///
/// ```
/// assert_ne!(copq_experiments::letters_of("tau=0.1"), copq_experiments::letters_of("tau=0.2"));
/// assert_eq!(copq_experiments::letters_of("tau=0.1").len(), 16);
/// ```
pub fn letters_of(text: &str) -> String {
    letters(Sha256::new_with_prefix(text))
}

/// Sixteen letters that are the same for two policies if all that
/// [`read_policy`](crate::read_policy) finds in their files is the same, whatever the files'
/// format.
///
/// ```
/// use copq::State;
/// use copq_experiments::policy_checksum;
///
/// let policy = |weight: f32| {
///     let mut state = State::default();
///     state.child_mut("actor").put("weight", [weight]);
///     state
/// };
/// assert_eq!(policy_checksum(&policy(0.5)), policy_checksum(&policy(0.5)));
/// assert_ne!(policy_checksum(&policy(0.5)), policy_checksum(&policy(0.6)));
/// ```
pub fn policy_checksum(policy: &State) -> String {
    fn take_in(state: &State, digest: &mut Sha256) {
        for (name, value) in state.values() {
            digest.update(name);
            match value {
                Value::F32(values) => values.iter().for_each(|v| digest.update(v.to_le_bytes())),
                Value::F64(values) => values.iter().for_each(|v| digest.update(v.to_le_bytes())),
                Value::U64(values) => values.iter().for_each(|v| digest.update(v.to_le_bytes())),
                Value::U8(values) => digest.update(values),
            }
        }
        for (name, child) in state.children() {
            digest.update(name);
            take_in(child, digest);
        }
    }
    let mut digest = Sha256::new();
    take_in(policy, &mut digest);
    letters(digest)
}

fn letters(digest: Sha256) -> String {
    digest.finalize()[..8].iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Settings as a TOML table.
pub(crate) fn table<S: Serialize>(value: &S) -> Result<toml::Table> {
    toml::Table::try_from(value).map_err(|e| Error::other("encoding the settings", e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use copq::{Config, Method};

    #[test]
    fn every_number_counts_and_what_changes_none_does_not() {
        let method = Method::cop_td3();
        let base = Plan::new(&method);
        let of = |plan: &Plan, config: &Config| fingerprint(plan, config).unwrap();
        let usual = of(&base, &method.config);
        assert_eq!(usual.len(), 16);
        let mut kept = base.clone();
        (kept.run.keep, kept.run.checkpoint_every, kept.threads) = (7, 1, 3);
        assert_eq!(of(&kept, &method.config), usual);
        let mut plans = vec![base.clone(); 6];
        plans[0].run.steps += 1;
        plans[1].run.seed += 1;
        plans[2].task = "a/ant".to_owned();
        plans[3].order = Some("vsc".to_owned());
        plans[4].limits.insert("cost".to_owned(), 1.0);
        plans[5].init_checksum = Some("1a2b".to_owned());
        let mut all: Vec<_> = plans.iter().map(|plan| of(plan, &method.config)).collect();
        all.push(of(&base, &Config { tau: 0.006, ..method.config.clone() }));
        all.push(usual);
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 8);
    }
}
