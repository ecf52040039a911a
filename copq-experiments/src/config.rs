//! `config.toml`: everything needed to repeat a run.

use std::path::Path;
use std::sync::LazyLock;

use copq::{Error, Result, files};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::fingerprint::table;
use crate::older;
use crate::plan::Plan;

const HEADING: &str = "# What made this run. `copq resume` with this folder goes on with it.\n\n";

/// The content of `config.toml`: the plan, the caller's own settings, and the program and machine
/// that made the run.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("first");
/// use copq::{Config, Method};
/// use copq_experiments::{Plan, RunConfig, RunFolder, read_config};
///
/// let method = Method::cop_td3();
/// RunFolder::create(&path, &Plan::new(&method), &method.config)?;
/// let read: RunConfig<Config> = read_config(&path)?;
/// assert_eq!((read.plan.method.as_str(), read.settings), ("cop-td3", method.config));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunConfig<S> {
    /// The run's parts and length.
    pub plan: Plan,
    /// The caller's settings, usually the learner's.
    pub settings: S,
    /// Versions and machine.
    pub made_with: MadeWith,
}

/// What made a run: enough to repeat it.
///
/// ```
/// let made = copq_experiments::MadeWith::here();
/// assert!(made.rustc.starts_with("rustc ") && !made.command.is_empty());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeWith {
    /// The command line; the program without its path.
    pub command: Vec<String>,
    /// copq's version.
    pub copq: String,
    /// The compiler.
    pub rustc: String,
    /// Operating system and architecture.
    pub system: String,
    /// The processor; it decides how long a run takes, not its bits.
    pub processor: String,
    /// The program's own checksum: equal checksums mean the same build.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub build: Option<String>,
}

impl MadeWith {
    /// This program on this machine.
    pub fn here() -> Self {
        Self {
            command: command(),
            copq: env!("CARGO_PKG_VERSION").to_owned(),
            rustc: env!("COPQ_RUSTC").to_owned(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor().unwrap_or_else(|| "unknown".to_owned()),
            build: BUILD.clone(),
        }
    }

    /// The program in a few words: `copq 0.1.0 (build 1a2b3c4d)`.
    pub fn version(&self) -> String {
        let build = self.build.as_ref().map_or(String::new(), |build| format!(" (build {build})"));
        format!("copq {}{build}", self.copq)
    }
}

/// CRC-32C of the program's file, read once.
static BUILD: LazyLock<Option<String>> = LazyLock::new(|| {
    // Linux finds the file even if another has replaced it.
    let file = std::fs::read("/proc/self/exe");
    let file = file.or_else(|_| std::fs::read(std::env::current_exe()?)).ok()?;
    Some(format!("{:08x}", crc32c::crc32c(&file)))
});

fn command() -> Vec<String> {
    let mut args = std::env::args_os();
    let program = args.next().and_then(|path| Path::new(&path).file_name().map(ToOwned::to_owned));
    program.into_iter().chain(args).map(|arg| arg.to_string_lossy().into_owned()).collect()
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// A configuration as the text of its file; an error for a number that TOML cannot hold.
pub(crate) fn encode<S: Serialize>(config: &RunConfig<S>) -> Result<String> {
    let text = toml::to_string(config).map_err(|e| Error::other("encoding config.toml", e))?;
    Ok(format!("{HEADING}{text}"))
}

/// Writes a configuration, atomically.
#[cfg(test)]
pub(crate) fn write<S: Serialize>(path: &Path, config: &RunConfig<S>) -> Result<()> {
    files::replace(path, encode(config)?.as_bytes())
}

/// Reads a configuration; the error for a wrong or unknown key shows the line and the known keys.
pub(crate) fn read<S: DeserializeOwned>(path: &Path) -> Result<RunConfig<S>> {
    let failed = |e| Error::other(format!("reading '{}'", path.display()), e);
    let text = files::read_text(path)?;
    match older::modernised(&text) {
        Some(table) => table.try_into().map_err(failed),
        None => toml::from_str(&text).map_err(failed),
    }
}

/// An error that names the first of the caller's settings that differs from what the run was made
/// with.
pub(crate) fn check_same<S: Serialize>(path: &Path, what: &str, saved: &S, now: &S) -> Result<()> {
    match difference(what, &table(saved)?.into(), &table(now)?.into()) {
        None => Ok(()),
        Some((key, saved, now)) => {
            let what = format!("{key} (a run resumes with the settings in '{}')", path.display());
            Err(Error::invalid(what, saved, now))
        }
    }
}

/// The settings with some changes, each as KEY=VALUE. The key's parts are separated by dots. The
/// value is TOML or plain text, or `none`, which removes an optional setting.
pub fn with_changes<S: Serialize + DeserializeOwned>(
    settings: &S,
    changes: &[String],
) -> Result<S> {
    let mut changed = table(settings)?;
    let mut removed = Vec::new();
    for change in changes {
        let invalid =
            |wanted: &str, got: String| Error::invalid(format!("--set {change}"), wanted, got);
        let (key, value) =
            change.split_once('=').ok_or_else(|| invalid("KEY=VALUE", "no =".to_owned()))?;
        if key.split('.').any(str::is_empty) {
            return Err(invalid(
                "KEY=VALUE, with dots between the parts of KEY",
                format!("the key '{key}'"),
            ));
        }
        let (parents, name) = key.rsplit_once('.').unwrap_or(("", key));
        let mut at = &mut changed;
        for parent in parents.split('.').filter(|parent| !parent.is_empty()) {
            check_kind(at, parent, key)?;
            let inner = at.entry(parent).or_insert_with(|| toml::Table::new().into());
            let got = format!("{inner} at {parent}");
            at = inner.as_table_mut().ok_or_else(|| invalid("a setting that has parts", got))?;
        }
        check_kind(at, name, key)?;
        let old = at.remove(name);
        if value != "none" {
            at.insert(name.to_owned(), merged(old, parse_value(value)));
        } else if old.is_none() {
            return Err(invalid("an existing setting", format!("none at {key}")));
        } else {
            removed.push(key);
        }
    }
    // TOML's message ends with a newline.
    let said = |e: toml::de::Error| Error::other("--set", e.to_string().trim_end().to_owned());
    let settings: S = changed.try_into().map_err(said)?;
    let now = table(&settings)?;
    match removed.into_iter().find_map(|key| Some((key, value_at(&now, key)?))) {
        // It has a default, so the removed setting came back as that.
        Some((key, value)) => {
            let what = format!("--set {key}=none");
            let wanted = format!("one of its values, such as {}", shown(value));
            Err(Error::invalid(what, wanted, "none"))
        }
        None => Ok(settings),
    }
}

/// The value under a key whose parts are joined by dots.
fn value_at<'a>(table: &'a toml::Table, key: &str) -> Option<&'a toml::Value> {
    match key.split_once('.') {
        None => table.get(key),
        Some((parent, rest)) => value_at(table.get(parent)?.as_table()?, rest),
    }
}

/// A value as TOML, or else as plain text.
fn parse_value(text: &str) -> toml::Value {
    text.parse().unwrap_or_else(|_| toml::Value::String(text.to_owned()))
}

/// A new value in place of an old one. A table changes only the keys it names, unless it is of a
/// different kind. An integer in place of a float becomes a float.
fn merged(old: Option<toml::Value>, new: toml::Value) -> toml::Value {
    use toml::Value::{Float, Integer, Table};
    match (old, new) {
        (Some(Float(_)), Integer(integer)) => Float(integer as f64),
        (Some(Table(mut table)), Table(changes)) if !are_kinds(&table, &changes) => {
            for (key, value) in changes {
                let value = merged(table.remove(&key), value);
                table.insert(key, value);
            }
            Table(table)
        }
        (_, new) => new,
    }
}

/// Whether these are different kinds of one thing, such as `{ lagrangian = { .. } }` and
/// `{ pid = { .. } }`.
fn are_kinds(old: &toml::Table, new: &toml::Table) -> bool {
    kind(old).zip(kind(new)).is_some_and(|(old, new)| old != new)
}

/// The kind that a thing has, if there are several kinds of it.
fn kind(table: &toml::Table) -> Option<&String> {
    match table.iter().next() {
        Some((name, toml::Value::Table(_))) if table.len() == 1 => Some(name),
        _ => None,
    }
}

/// An error for a part of a key that is not the kind that a thing has.
fn check_kind(table: &toml::Table, part: &str, key: &str) -> Result<()> {
    let thing = key.split('.').take_while(|known| *known != part).collect::<Vec<_>>().join(".");
    match kind(table) {
        Some(kind) if kind != part && !thing.is_empty() => {
            let wanted =
                format!("{thing}.{kind}.NAME, or {thing}={{KIND={{..}}}} for another kind");
            Err(Error::invalid("--set", wanted, key))
        }
        _ => Ok(()),
    }
}

/// A learner's settings, with defaults for those that its run did not know yet; other settings as
/// they are.
pub(crate) fn complete(settings: &toml::Table) -> toml::Table {
    fn of<S: Serialize + DeserializeOwned>(settings: &toml::Table) -> Option<toml::Table> {
        let learner: S = settings.clone().try_into().ok()?;
        toml::Table::try_from(learner).ok()
    }
    let completed =
        of::<copq::Config>(settings).or_else(|| of::<copq::on_policy::Config>(settings));
    completed.unwrap_or_else(|| settings.clone())
}

/// A value as its file shows it: a table of Rust's values has an f32 as the nearest f64, with more
/// digits.
fn shown(value: &toml::Value) -> String {
    match value.as_float() {
        Some(x) if f64::from(x as f32) == x => format!("{:?}", x as f32),
        _ => value.to_string(),
    }
}

/// The first key at which two values differ, with both sides.
pub(crate) fn difference(
    key: &str,
    a: &toml::Value,
    b: &toml::Value,
) -> Option<(String, String, String)> {
    let (toml::Value::Table(a_table), toml::Value::Table(b_table)) = (a, b) else {
        return (a != b).then(|| (key.to_owned(), shown(a), shown(b)));
    };
    let nothing = toml::Value::String("nothing".to_owned());
    let mut names: Vec<&String> = a_table.keys().chain(b_table.keys()).collect();
    names.sort();
    names.iter().find_map(|&name| {
        let a = a_table.get(name).unwrap_or(&nothing);
        let b = b_table.get(name).unwrap_or(&nothing);
        difference(&format!("{key}.{name}"), a, b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Settings {
        tau: f32,
        hidden: Vec<usize>,
        limit: Option<f64>,
    }

    fn config() -> RunConfig<Settings> {
        let settings = Settings { tau: 0.005, hidden: vec![256, 256], limit: None };
        RunConfig {
            plan: Plan::new(&copq::Method::cop_td3()),
            settings,
            made_with: MadeWith::here(),
        }
    }

    #[test]
    fn a_configuration_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        write(&path, &config()).unwrap();
        assert_eq!(read::<Settings>(&path).unwrap(), config());
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("tau = 0.005\n") && text.contains("steps = 110000\n"), "{text}");
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_known_keys() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        write(&path, &config()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap().replace("eval_every", "eval_evry");
        std::fs::write(&path, text).unwrap();
        let message = read::<Settings>(&path).unwrap_err().to_string();
        for part in [
            "config.toml",
            "line 1",
            "unknown field `eval_evry`",
            "expected one of",
            "`eval_every`",
        ] {
            assert!(message.contains(part), "no {part:?} in {message}");
        }
    }

    #[test]
    fn a_changed_setting_is_named() {
        let path = Path::new("runs/x/config.toml");
        let saved = config().settings;
        check_same(path, "settings", &saved, &config().settings).unwrap();
        let message = |changed: Settings| {
            check_same(path, "settings", &saved, &changed).unwrap_err().to_string()
        };
        let limit = message(Settings { limit: Some(25.0), ..config().settings });
        assert!(limit.starts_with("settings.limit ") && limit.contains("got 25"), "{limit}");
        let tau = message(Settings { tau: 0.01, ..config().settings });
        assert!(tau.ends_with("wanted 0.005, got 0.01"), "{tau}");
    }

    #[test]
    fn a_setting_is_set_by_its_name_in_the_configuration() {
        let method = copq::Method::cop_td3_oac();
        let set = |changes: &str| {
            let changes: Vec<String> = changes.split(' ').map(str::to_owned).collect();
            with_changes(&method.config, &changes)
        };
        let config =
            set("batch=64 networks.hidden=[8,8] optimism.projection=extremum tau=1").unwrap();
        assert_eq!((config.batch, config.networks.hidden, config.tau), (64, vec![8, 8], 1.0));
        assert_eq!(config.optimism.unwrap().projection.as_deref(), Some("extremum"));
        let config = set("famo=none optimism.beta=2").unwrap();
        assert_eq!((config.famo, config.optimism.map(|optimism| optimism.beta)), (None, Some(2.0)));
        let message = |changes: &str| set(changes).unwrap_err().to_string();
        assert!(
            message("bath=64").contains("--set: unknown field `bath`, expected one of `discount`")
        );
        assert!(message("networks.hiden=3").contains("unknown field `hiden`"));
        assert!(message("batch=many").contains("invalid type: string \"many\", expected usize"));
        let wanted = "--set batch.size=1: wanted a setting that has parts, got 256 at batch";
        assert_eq!(message("batch.size=1"), wanted);
        assert_eq!(message("batch"), "--set batch: wanted KEY=VALUE, got no =");
        assert_eq!(
            message("batch=none"),
            "--set batch=none: wanted one of its values, such as 256, got none"
        );
        let wanted =
            "--set networks.activation=none: wanted one of its values, such as \"relu\", got none";
        assert_eq!(message("networks.activation=none"), wanted);
        for (key, known) in [
            ("networks.activation", "`relu`, `tanh`, `silu`"),
            ("networks.init", "`torch` or `lecun`"),
            ("warm_up", "`uniform` or `policy`"),
            ("famo.decay", "`decoupled` or `l2`"),
        ] {
            let message = message(&format!("{key}=other"));
            assert!(
                message.contains("unknown variant `other`") && message.contains(known),
                "{message}"
            );
        }
        assert_eq!(
            message("fmo=none"),
            "--set fmo=none: wanted an existing setting, got none at fmo"
        );
    }

    #[test]
    fn a_setting_that_was_not_there_yet_reads_with_its_default() {
        let config: copq::Config = toml::from_str("batch = 64\n[famo]\nlr = 0.1").unwrap();
        assert_eq!((config.batch, config.smoothing, config.normalise), (64, None, false));
        assert_eq!(config.famo.map(|famo| famo.lr), Some(0.1));
        for name in copq::Method::names() {
            let settings = copq::Method::by_name(name).unwrap().config;
            let text = toml::to_string(&settings).unwrap();
            assert_eq!(toml::from_str::<copq::Config>(&text).unwrap(), settings, "{name}");
        }
        for name in copq::on_policy::Method::names() {
            let mut settings = copq::on_policy::Method::by_name(name).unwrap().config;
            for anneal_steps in [settings.anneal_steps, None] {
                settings.anneal_steps = anneal_steps;
                let text = toml::to_string(&settings).unwrap();
                let read: copq::on_policy::Config = toml::from_str(&text).unwrap();
                assert_eq!(read, settings, "{name}");
            }
        }
    }

    /// Of a table only what is named is another.
    #[test]
    fn a_table_keeps_what_is_not_named() {
        let ppo = copq::on_policy::Method::ppo().config;
        let with = |change: &str| with_changes(&ppo, &[change.to_owned()]);
        let narrow = with("networks={hidden=[3], critic_lr=1}").unwrap();
        assert_eq!(narrow.networks.hidden, [3]);
        assert_eq!(narrow.networks.critic_lr, 1.0);
        assert_eq!(narrow.networks.activation, ppo.networks.activation);
        assert_eq!(narrow, with_changes(&narrow, &[]).unwrap());
        assert!(with("networks={hiden=[3]}").unwrap_err().to_string().contains("hiden"));
        // One kind in the place of another.
        let cal = copq::Method::cop_cal().config;
        let pid = with_changes(&cal, &["constraint={pid={integral=0.02}}".to_owned()]).unwrap();
        assert!(matches!(pid.constraint, Some(copq::Constraint::Pid(pid)) if pid.integral == 0.02));
        for key in ["constraint.lr", "constraint.pid.integral"] {
            let error = with_changes(&cal, &[format!("{key}=0.1")]).unwrap_err().to_string();
            let wanted = "--set: wanted constraint.lagrangian.NAME, or constraint={KIND={..}} for \
                          another kind, got ";
            assert_eq!(error, format!("{wanted}{key}"));
        }
    }
}
