//! A run's folder, read again: its method, environment and policy.

use std::path::{Path, PathBuf};

use copq::error::check_len;
use copq::on_policy::{self, SauteConfig};
use copq::{ActorKind, Config, Env, EnvSpec, Error, Networks, Policy};
use copq_candle::Candle;
use copq_experiments::{
    MadeWith, Plan, policy_checksum, read_checkpoint, read_config, read_plan, read_policy,
};

use crate::options::note;
use crate::recipe::{Recipe, is_on_policy};
use crate::world::make_env;

/// The plan and the method of the run in a folder.
pub fn run(folder: &Path) -> copq::Result<(Plan, Recipe)> {
    let plan = read_plan(folder)?;
    if is_on_policy(&plan.method) {
        let mut method = on_policy::Method::by_name(&plan.method)?;
        method.config = read_config(folder)?.settings;
        return Ok((plan, Recipe::OnPolicy(method)));
    }
    let method = plan.off_policy_method(read_config(folder)?.settings)?;
    Ok((plan, Recipe::OffPolicy(method)))
}

/// The policy of a run's best evaluation.
const BEST: &str = "policy-best.safetensors";

/// A run's own copy of the policy that it began with.
pub const INIT: &str = "policy-init.safetensors";

/// The policy that a run without a checkpoint begins with, if any: its copy, or the original if the
/// run was killed before there was a copy.
pub fn init(folder: &Path, plan: &Plan) -> copq::Result<Option<PathBuf>> {
    let copy = folder.join(INIT);
    if folder.join("checkpoint.safetensors").is_file() {
        return Ok(None);
    }
    match &plan.init_from {
        None => Ok(None),
        Some(_) if copy.is_file() => Ok(Some(copy)),
        Some(from) => policy_file(from).map(Some),
    }
}

/// The checksum of a policy file.
pub fn checksum(file: &Path) -> copq::Result<String> {
    Ok(policy_checksum(&read_policy(file)?))
}

/// An error if the policy that a run begins with is not the one in its plan.
pub fn check_init(file: &Path, plan: &Plan) -> copq::Result<()> {
    let Some(wanted) = &plan.init_checksum else { return Ok(()) };
    let got = checksum(file)?;
    if got == *wanted {
        return Ok(());
    }
    let what = format!("'{}', with which the run begins", file.display());
    Err(Error::invalid(what, format!("the policy of checksum {wanted}"), got))
}

/// The policy file of a run's folder, the best one if there is one; or the path itself if it is a
/// file.
pub fn policy_file(path: &Path) -> copq::Result<PathBuf> {
    if path.is_file() {
        return Ok(path.to_owned());
    }
    let names = [BEST, "policy.safetensors"];
    let files = names.map(|name| path.join(name));
    files.into_iter().find(|file| file.is_file()).ok_or_else(|| {
        let wanted = "a policy's file, or a run's folder with one (copq export writes it for \
             older runs)";
        Error::invalid(format!("'{}'", path.display()), wanted, "neither")
    })
}

/// What it takes to use a run's policy: its plan, its environment's budgets, its networks. Runs of
/// other programs' methods also have it.
pub struct Learned {
    pub plan: Plan,
    folder: PathBuf,
    saute: Option<SauteConfig>,
    networks: Networks,
    kind: ActorKind,
}

impl Learned {
    /// Reads it from a run's folder.
    pub fn read(folder: &Path) -> copq::Result<Self> {
        let plan = read_plan(folder)?;
        if is_on_policy(&plan.method) {
            let config: on_policy::Config = read_config(folder)?.settings;
            let on_policy::Config { saute, networks, .. } = config;
            let kind = ActorKind::Normal;
            return Ok(Self { plan, folder: folder.to_owned(), saute, networks, kind });
        }
        let config: Config = read_config(folder)?.settings;
        let kind = config.actor();
        let networks = config.networks;
        Ok(Self { plan, folder: folder.to_owned(), saute: None, networks, kind })
    }

    /// The run's environment.
    pub fn env(&self) -> copq::Result<Box<dyn Env>> {
        let env = make_env(&self.plan, self.saute.as_ref(), Some(&self.folder))?;
        note_other_versions(&self.plan, env.spec());
        Ok(env)
    }

    /// The budgets that its environment shows, if any.
    pub fn saute(&self) -> Option<&SauteConfig> {
        self.saute.as_ref()
    }

    /// The last policy, or the best one so far, for the run's environment.
    pub fn policy(&self, best: bool, spec: &EnvSpec) -> copq::Result<Policy> {
        let folder = &self.folder;
        let file = if best { Some(best_policy(folder)?) } else { newest_policy(folder) };
        if let Some(file) = file {
            let policy = Policy::from_state(&read_policy(&file)?, &Candle::default())?;
            check_len("the policy's observation", policy.obs_len(), spec.obs_len)?;
            check_len("the policy's action", policy.action_len(), spec.action_len())?;
            return Ok(policy);
        }
        let checkpoint = read_checkpoint(folder)?;
        let agent = checkpoint.child("trainer")?.child("agent")?;
        Policy::load(agent, spec, &self.networks, self.kind, &Candle::default())
    }
}

/// The file of the policy that a run's best evaluation saw.
fn best_policy(folder: &Path) -> copq::Result<PathBuf> {
    let file = folder.join(BEST);
    if file.is_file() {
        return Ok(file);
    }
    let what = format!("--best of '{}'", folder.display());
    Err(Error::invalid(what, format!("{BEST}, which evaluations write"), "a run without one"))
}

/// The file of a run's last policy, which every evaluation rewrites, unless the checkpoint is newer
/// by the files' modification times.
pub fn newest_policy(folder: &Path) -> Option<PathBuf> {
    let file = folder.join("policy.safetensors");
    is_as_new(&file, &folder.join("checkpoint.safetensors")).then_some(file)
}

/// Whether a file exists and is not older than another that may exist, by their modification times.
fn is_as_new(file: &Path, than: &Path) -> bool {
    let changed = |path: &Path| path.metadata().and_then(|about| about.modified()).ok();
    changed(file).is_some_and(|at| changed(than).is_none_or(|other| other <= at))
}

/// Whether the film in a run's folder is as new as its policy.
pub fn is_filmed(folder: &Path) -> bool {
    let film = folder.join("rollout.gif");
    ["policy.safetensors", "checkpoint.safetensors"]
        .iter()
        .all(|name| is_as_new(&film, &folder.join(name)))
}

/// Notes an environment whose versions differ from those that its run began with.
pub fn note_other_versions(plan: &Plan, spec: &EnvSpec) {
    if let (Some(then), Some(now)) = (&plan.versions, &spec.versions)
        && then != now
    {
        note(&format!("the run began with {then}, but its environment now has {now}"));
    }
}

/// Notes a run that was begun by another build of the program: the bits of the two may differ.
pub fn note_other_build(folder: &Path) {
    let Ok(config) = read_config::<toml::Table>(folder) else { return };
    let now = MadeWith::here();
    if config.made_with.build.is_some() && config.made_with.build != now.build {
        let shown = folder.display();
        let (then, now) = (config.made_with.version(), now.version());
        note(&format!("{shown} was begun by {then} and continues with {now}"));
    }
}
