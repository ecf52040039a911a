//! Runs with one label: the seeds of one method.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use copq::{Error, Result, files};

use super::curves::{Evaluated, LAST, Quantity, common_end};
use crate::config::{RunConfig, complete, difference};
use crate::folder::read_config;
use crate::plan::Plan;
use crate::report::ReportRun;
use crate::statistics::mean;

/// A run's plan, and its settings whatever they are.
type Config = RunConfig<toml::Table>;

/// The runs with one label.
pub(super) struct Group {
    pub label: String,
    /// What made the first of them, if its folder says so.
    pub config: Option<Config>,
    pub seeds: Vec<Evaluated>,
    pub limits: BTreeMap<String, f64>,
    /// The seeds' numbers, for runs whose folders record them.
    numbers: Vec<u64>,
    folders: Vec<PathBuf>,
}

/// The runs, label by label; one without a label is named after its folder.
pub(super) fn group(runs: &[ReportRun]) -> Result<Vec<Group>> {
    let mut groups: Vec<Group> = Vec::new();
    for ReportRun { label, folder, limits, .. } in runs {
        let label = &label.clone().unwrap_or_else(|| name(folder));
        let seed = Evaluated::read(folder)?;
        let place = folder.canonicalize().map_err(files::failed("reading", folder))?;
        let config =
            if folder.join("config.toml").is_file() { Some(read_config(folder)?) } else { None };
        let number = config.as_ref().map(|config| config.plan.run.seed);
        match groups.iter_mut().find(|group| group.label == *label) {
            Some(group) => {
                check_same_method(label, group.config.as_ref(), config.as_ref())?;
                check_new_seed(group, &place, number)?;
                group.seeds.push(seed);
                group.limits.extend(limits.clone());
                group.numbers.extend(number);
                group.folders.push(place);
            }
            None => groups.push(Group {
                label: label.clone(),
                config,
                seeds: vec![seed],
                limits: limits.clone(),
                numbers: number.into_iter().collect(),
                folders: vec![place],
            }),
        }
    }
    if groups.is_empty() {
        Err(Error::invalid("runs to compare", "at least one", 0))
    } else {
        Ok(groups)
    }
}

impl Group {
    /// The step up to which all seeds are compared.
    pub fn end(&self) -> u64 {
        common_end(self.seeds.iter())
    }

    /// Whether the mean of a cost's last evaluations is above its limit.
    pub fn exceeds_a_limit(&self) -> bool {
        self.limits.iter().any(|(cost, &limit)| {
            let quantity = Quantity::Return(cost.clone());
            let last = |seed: &Evaluated| {
                let values = seed.trained(&quantity, self.end()).1;
                values.len().checked_sub(LAST).map_or(f64::NAN, |first| mean(&values[first..]))
            };
            mean(&self.seeds.iter().map(last).collect::<Vec<_>>()) > limit
        })
    }

    /// Seeds that are evaluated differently from the first one, in words.
    pub fn unlike(&self) -> Vec<String> {
        let seeds = self.seeds.iter().zip(&self.folders).skip(1);
        let words = |(seed, folder): (&Evaluated, &PathBuf)| {
            let words = seed.unlike(&self.seeds[0])?;
            let (label, first) = (&self.label, name(&self.folders[0]));
            Some(format!("{label}: {} is not evaluated as {first}: {words}.", name(folder)))
        };
        seeds.filter_map(words).collect()
    }
}

/// A folder's own name.
fn name(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// An error for a seed that is already there: it would count twice.
fn check_new_seed(group: &Group, place: &Path, number: Option<u64>) -> Result<()> {
    let got = match number {
        Some(number) if group.numbers.contains(&number) => format!("seed {number} twice"),
        _ if group.folders.iter().any(|known| known == place) => {
            format!("{} twice", place.display())
        }
        _ => return Ok(()),
    };
    Err(Error::invalid(format!("runs called '{}'", group.label), "each seed once", got))
}

/// An error unless two runs differ only in seed, length and cadence.
fn check_same_method(label: &str, first: Option<&Config>, other: Option<&Config>) -> Result<()> {
    let (Some(first), Some(other)) = (first, other) else { return Ok(()) };
    let name = |plan: &Plan| {
        let name = Plan { run: first.plan.run, ..plan.clone() }.folder_name();
        let policy = plan.init_from.as_ref().map_or(String::new(), |from| {
            let checksum = plan.init_checksum.as_deref().unwrap_or("of no known checksum");
            format!(" from {} ({checksum})", from.display())
        });
        name + &policy
    };
    let differing = |wanted: String, got: String| {
        let wanted = format!("seeds of {wanted} (another label for another method)");
        Err(Error::invalid(format!("runs called '{label}'"), wanted, got))
    };
    if !first.plan.is_seed_of(&other.plan) {
        return differing(name(&first.plan), name(&other.plan));
    }
    match difference(
        "settings",
        &complete(&first.settings).into(),
        &complete(&other.settings).into(),
    ) {
        None => Ok(()),
        Some((key, wanted, got)) => {
            differing(format!("{} with {key} {wanted}", name(&first.plan)), got)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_one_label_differ_in_their_seeds_alone() {
        let folder = tempfile::tempdir().unwrap();
        let labelled = |name, plan: Plan, settings: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir(&path).unwrap();
            let rows = "step,weighted_total/mean\n0,1\n";
            std::fs::write(path.join("evaluations.csv"), rows).unwrap();
            let settings: toml::Table = settings.parse().unwrap();
            let config = RunConfig { plan, settings, made_with: crate::config::MadeWith::here() };
            crate::config::write(&path.join("config.toml"), &config).unwrap();
            ReportRun::new(path).called("td3")
        };
        let plan = |bound: &str, seed| {
            let mut plan =
                Plan { bound: Some(bound.to_owned()), ..Plan::new(&copq::Method::cop_td3()) };
            plan.run.seed = seed;
            plan
        };
        let first = labelled("first", plan("cholesky", 0), "tau = 0.005");
        let with = |other| {
            let groups = group(&[first.clone(), other]).map_err(|e| e.to_string())?;
            Ok::<_, String>(groups.len())
        };
        assert_eq!(with(labelled("seed", plan("cholesky", 1), "tau = 0.005")), Ok(1));
        let error = with(labelled("again", plan("cholesky", 0), "tau = 0.005")).unwrap_err();
        assert_eq!(error, "runs called 'td3': wanted each seed once, got seed 0 twice");
        let wanted = "runs called 'td3': wanted seeds of cop-td3-a-hopper-cholesky-s0";
        let error = with(labelled("projection", plan("eigen", 1), "tau = 0.005")).unwrap_err();
        assert_eq!(
            error,
            format!("{wanted} (another label for another method), got cop-td3-a-hopper-eigen-s0")
        );
        let error = with(labelled("setting", plan("cholesky", 1), "tau = 0.01")).unwrap_err();
        assert_eq!(
            error,
            format!(
                "{wanted} with settings.tau 0.005 (another label for another method), got 0.01"
            )
        );
    }

    /// A run from before a setting was there, and one of today with the setting's default.
    #[test]
    fn a_setting_that_an_old_run_did_not_know_has_its_default() {
        let today = toml::Table::try_from(copq::Method::td3().config).unwrap();
        let mut old = today.clone();
        for key in ["normalise", "warm_up"] {
            assert!(old.remove(key).is_some());
        }
        assert_eq!(complete(&old), complete(&today));
        let mut other = today.clone();
        other.insert("normalise".to_owned(), true.into());
        assert_ne!(complete(&other), complete(&today));
        let foreign: toml::Table = toml::from_str("rate = 0.1").unwrap();
        assert_eq!(complete(&foreign), foreign);
    }
}
