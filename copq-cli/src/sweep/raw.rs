//! What a sweep's file says: lists of options, and their combinations.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use copq_experiments::paper::{Claim, Paper, Published};
use serde::Deserialize;

/// Options of copq train by their long names. `method` is the method; `set`, `limit` and `import`
/// are lists.
pub type Options = BTreeMap<String, toml::Value>;

/// Options that may be given several times, and are added up.
pub const REPEATED: [&str; 3] = ["set", "limit", "import"];

/// The key of a run's fingerprint at its submission, in a file that `copq sweep submit` writes.
pub const SUBMITTED: &str = "fingerprint";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Raw {
    /// The folder of all runs. [default: runs/ and the file's name]
    out: Option<PathBuf>,
    /// The product of these lists, option by option.
    #[serde(default)]
    grid: BTreeMap<String, Vec<toml::Value>>,
    /// Named variants, each with its own options; each is run over the whole grid.
    #[serde(default)]
    arm: Vec<Options>,
    /// Combinations to leave out: those that have all of an entry's options, which may be one `set`
    /// of several.
    #[serde(default)]
    exclude: Vec<Options>,
    /// Combinations to add: options over those of all runs.
    #[serde(default)]
    include: Vec<Options>,
    /// Options of all runs.
    #[serde(default)]
    all: Options,
    /// Other files, relative to this one's folder, whose runs are also this one's. A run that two
    /// of them have is run once.
    #[serde(default)]
    pub files: Vec<PathBuf>,
    /// The report's title. [default: the file's name]
    pub title: Option<String>,
    /// Tasks' scores that count as 1 where a report takes tasks together.
    #[serde(default)]
    reference: BTreeMap<String, f64>,
    /// A paper's numbers, which are shown beside the runs'.
    #[serde(default)]
    published: Vec<Published>,
    /// A paper's claims, which the report judges.
    #[serde(default)]
    claim: Vec<Claim>,
}

/// The options of a run, and the name of its arm.
pub struct Combination {
    pub name: Option<String>,
    /// Its fingerprint when it was submitted, if it was.
    pub submitted: Option<String>,
    pub options: Options,
}

impl Raw {
    /// The file and the folder of its runs.
    pub fn read(path: &Path) -> anyhow::Result<(Self, PathBuf)> {
        let shown = path.display();
        let text = std::fs::read_to_string(path).with_context(|| format!("reading '{shown}'"))?;
        let raw: Self = toml::from_str(&text).with_context(|| format!("'{shown}'"))?;
        let stem = path.file_stem().unwrap_or_default();
        let out = raw.out.clone().unwrap_or_else(|| Path::new("runs").join(stem));
        Ok((raw, out))
    }

    /// What it says about a paper.
    pub fn paper(&self) -> Paper {
        Paper {
            reference: self.reference.clone(),
            published: self.published.clone(),
            claims: self.claim.clone(),
        }
    }

    pub fn combinations(&self) -> anyhow::Result<Vec<Combination>> {
        let mut product = vec![self.all.clone()];
        for (option, values) in &self.grid {
            product = product
                .iter()
                .flat_map(|options| {
                    values.iter().map(|value| with(options, [(option.clone(), value.clone())]))
                })
                .collect();
        }
        let mut all = Vec::new();
        // Options of all runs by themselves make one run, unless the runs are named elsewhere.
        let is_one = !self.all.is_empty() && self.include.is_empty() && self.files.is_empty();
        let is_product = !self.grid.is_empty() || !self.arm.is_empty() || is_one;
        for options in product.iter().filter(|_| is_product) {
            for arm in self.arm.iter().map(Some).chain(self.arm.is_empty().then_some(None)) {
                let (name, arm) = named(arm)?;
                all.push(Combination { name, submitted: None, options: with(options, arm) });
            }
        }
        for excluded in &self.exclude {
            let before = all.len();
            all.retain(|combination| !combination.has_all(excluded));
            let shown = toml::Table::from_iter(excluded.clone());
            ensure!(
                !excluded.is_empty() && all.len() < before,
                "exclude: wanted options that some run has as the file writes them, got {{ {} }}",
                shown.to_string().trim().replace('\n', ", ")
            );
        }
        for include in &self.include {
            let (name, mut options) = named(Some(include))?;
            let submitted = options.remove(SUBMITTED);
            let submitted = submitted.as_ref().and_then(toml::Value::as_str).map(str::to_owned);
            all.push(Combination { name, submitted, options: with(&self.all, options) });
        }
        Ok(all)
    }
}

impl Combination {
    /// Whether it has all of these options, including its arm's `name`; of those that add up, it
    /// may have more.
    fn has_all(&self, options: &Options) -> bool {
        options.iter().all(|(option, value)| match option.as_str() {
            "name" => self.name.as_deref() == value.as_str(),
            option if REPEATED.contains(&option) => {
                let own = self.options.get(option).cloned().map_or(Vec::new(), listed);
                let wanted = listed(value.clone());
                !wanted.is_empty() && wanted.iter().all(|value| own.contains(value))
            }
            _ => self.options.get(option) == Some(value),
        })
    }
}

/// An arm's name and its options.
fn named(arm: Option<&Options>) -> anyhow::Result<(Option<String>, Options)> {
    let Some(mut options) = arm.cloned() else { return Ok((None, Options::new())) };
    let is_plain = |name: &str| {
        let letters = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        !name.is_empty() && name.chars().all(letters) && !name.starts_with('.')
    };
    match options.remove("name") {
        None => Ok((None, options)),
        Some(toml::Value::String(name)) if is_plain(&name) => Ok((Some(name), options)),
        Some(other) => bail!(
            "name of an arm: wanted plain letters, digits, -, _ and dots (it begins the folder's \
             name), got {other}"
        ),
    }
}

/// Options applied over others; those that may be given several times add up.
fn with(base: &Options, over: impl IntoIterator<Item = (String, toml::Value)>) -> Options {
    let mut options = base.clone();
    for (name, value) in over {
        if !REPEATED.contains(&name.as_str()) {
            options.insert(name, value);
            continue;
        }
        let mut values = options.remove(&name).map_or(Vec::new(), listed);
        values.extend(listed(value));
        options.insert(name, values.into());
    }
    options
}

/// A list's values, or the one that stands alone.
fn listed(value: toml::Value) -> Vec<toml::Value> {
    match value {
        toml::Value::Array(values) => values,
        value => vec![value],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_among_several_is_excluded() {
        let left = |excluded: &str| {
            let lists = "[all]\nset = ['batch=8']\n[grid]\nseed = [0, 1]\n\
                         set = ['tau=0.1', ['tau=0.2', 'actor_lr=0.1']]\n";
            let text = format!("exclude = [{{ {excluded} }}]\n{lists}");
            let raw: Raw = toml::from_str(&text).unwrap();
            raw.combinations().map(|all| all.len()).ok()
        };
        assert_eq!(left("set = 'tau=0.1'"), Some(2));
        assert_eq!(left("set = ['actor_lr=0.1', 'batch=8'], seed = 1"), Some(3));
        for nobodys in ["set = []", "set = 'tau=0.3'", "set = ['tau=0.1', 'tau=0.2']"] {
            assert_eq!(left(nobodys), None, "{nobodys}");
        }
    }
}
