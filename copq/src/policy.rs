//! A trained policy on its own: what acts when learning is over.

use std::path::Path;

use crate::error::check_len;
use crate::learner::check_made_by;
use crate::{
    Activation, Actor, ActorKind, Backend, EnvSpec, Error, Net, Networks, Normaliser, Result, Rng,
    State, Stream, Value,
};

/// An actor with the normaliser of its observations, if it learned with one, and the bounds of its
/// actions; all frozen.
///
/// ```
/// # use copq::*;
/// # fn show(backend: &dyn Backend, obs: &[f32]) -> Result<()> {
/// // What `Learner::save_policy` or the program `copq export` has written.
/// let mut policy = Policy::read("hopper.safetensors", backend)?;
/// let mut action = vec![0.0; policy.action_len()];
/// policy.act(obs, &mut action)?; // in [-1, 1]
/// policy.scale(&mut action)?; // in the robot's own units
/// # Ok(())
/// # }
/// ```
///
/// The file is safetensors, for any reader: `actor/layer.0.weight` (output x input),
/// `actor/layer.0.bias` and so on, hidden layers followed by `policy/activation`, the output by what
/// `policy/kind` says: tanh (`deterministic`), tanh of its first half, the means (`gaussian`), or
/// nothing but a clamp to [-1, 1] (`normal`, which has `actor/log_std` besides); `policy/action_low` and
/// `policy/action_high`; and of the normaliser, if there is one, `normaliser/mean`,
/// `normaliser/squares` and `normaliser/count`, so that x becomes (x - mean) / max(sqrt(squares /
/// (count - 1)), 0.01), clipped at 5, but for the last `normaliser/raw` components, which stay as
/// they are. Texts (`policy/task`, `policy/kind`, `policy/activation`) are
/// UTF-8 bytes; `policy/hidden` and `policy/obs_len` are the layers' widths. A policy of modules
/// ([`Backend`]) has their own paths instead, and is read back by the same backend.
pub struct Policy {
    actor: Box<dyn Actor>,
    normaliser: Option<Normaliser>,
    spec: EnvSpec,
    networks: Networks,
    kind: ActorKind,
    /// What the actor sees.
    obs: Vec<f32>,
}

impl std::fmt::Debug for Policy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Policy")
            .field("kind", &self.kind)
            .field("normaliser", &self.normaliser)
            .finish_non_exhaustive()
    }
}

impl Policy {
    /// The policy in the saved state of an agent (the child `agent` of a trainer's) that learned a
    /// policy of some kind with such networks; one of another task is refused.
    pub fn load(
        agent: &State,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        backend: &dyn Backend,
    ) -> Result<Self> {
        check_made_by(agent, "task", &spec.name)?;
        // What was saved takes the place of these weights.
        let mut actor = backend.actor(spec, networks, kind, &mut Rng::new(0, Stream::Init))?;
        actor.load(agent.child("actor")?)?;
        Ok(Self {
            actor,
            normaliser: Normaliser::of(agent, spec.obs_len)?,
            spec: spec.clone(),
            networks: networks.clone(),
            kind,
            obs: Vec::new(),
        })
    }

    /// Reads a policy's file.
    pub fn read(path: impl AsRef<Path>, backend: &dyn Backend) -> Result<Self> {
        let state = State::read_file(path)?;
        let about = state.child("policy")?;
        let obs_len = about.get_one::<u64>("obs_len")? as usize;
        let low = about.get("action_low")?;
        let high = about.get("action_high")?;
        check_len("the policy's upper action bounds", high.len(), low.len())?;
        // A policy knows nothing of rewards, but a description needs one.
        let spec = EnvSpec::new(about.get_text("task")?, obs_len, low.len())
            .action_bounds(low, high)
            .reward("any", 1.0);
        let networks = Networks {
            hidden: about.get::<u64>("hidden")?.iter().map(|&width| width as usize).collect(),
            activation: activation(about.get_text("activation")?)?,
            ..Networks::default()
        };
        let kind = kind(about.get_text("kind")?)?;
        let mut actor = backend.actor(&spec, &networks, kind, &mut Rng::new(0, Stream::Init))?;
        actor.import(state.child("actor")?)?;
        let normaliser = Normaliser::of(&state, obs_len)?;
        Ok(Self { actor, normaliser, spec, networks, kind, obs: Vec::new() })
    }

    /// Writes the policy to a small file.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        let Self { actor, normaliser, spec, networks, kind, .. } = self;
        exported(actor.as_ref(), normaliser.as_ref(), spec, networks, *kind)?.write_file(path)
    }

    /// Length of an action.
    pub fn action_len(&self) -> usize {
        self.actor.action_len()
    }

    /// Writes the policy's best guess for one observation, or for each of a batch, in [-1, 1].
    pub fn act(&mut self, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.obs.clear();
        self.obs.extend_from_slice(obs);
        if let Some(normaliser) = &self.normaliser {
            normaliser.normalise(&mut self.obs)?;
        }
        self.actor.mode(Net::Online, &self.obs, action)
    }

    /// Maps one action from [-1, 1] to the environment's bounds.
    pub fn scale(&self, action: &mut [f32]) -> Result<()> {
        check_len("action", action.len(), self.action_len())?;
        let unit = action.to_vec();
        self.spec.scale_action(&unit, action);
        Ok(())
    }
}

/// A policy as its file holds it.
pub(crate) fn exported(
    actor: &dyn Actor,
    normaliser: Option<&Normaliser>,
    spec: &EnvSpec,
    networks: &Networks,
    kind: ActorKind,
) -> Result<State> {
    let mut state = State::default();
    *state.child_mut("policy") = exported_about(spec, networks, kind);
    actor.export(state.child_mut("actor"))?;
    if let Some(normaliser) = normaliser {
        normaliser.save(state.child_mut("normaliser"));
    }
    Ok(state)
}

/// Begins with the policy in a file, of this or another task of the same robot: its weights and its
/// normaliser. An error for another kind of policy, or one of another world.
pub(crate) fn begin_with(
    path: &Path,
    spec: &EnvSpec,
    networks: &Networks,
    kind: ActorKind,
    actor: &mut dyn Actor,
    normaliser: &mut Option<Normaliser>,
) -> Result<()> {
    let policy = State::read_file(path)?;
    check_fits(&policy, spec, networks, kind)?;
    let has = policy.child("normaliser").is_ok();
    if has != normaliser.is_some() {
        let [own, other] = if has { ["without", "with"] } else { ["with", "without"] };
        let wanted = format!("one {own} a normaliser (or normalise = {has})");
        return Err(Error::invalid("policy to begin with", wanted, format!("one {other}")));
    }
    actor.import(policy.child("actor")?)?;
    Normaliser::restore(normaliser, &policy)
}

/// What a policy's file says of it.
fn exported_about(spec: &EnvSpec, networks: &Networks, kind: ActorKind) -> State {
    let mut about = State::default();
    about.put_text("task", &spec.name);
    about.put("obs_len", [spec.obs_len as u64]);
    about.put("action_low", spec.action_low.as_slice());
    about.put("action_high", spec.action_high.as_slice());
    about.put("hidden", networks.hidden.iter().map(|&width| width as u64).collect::<Vec<_>>());
    about.put_text("activation", activation_name(networks.activation));
    about.put_text("kind", kind_name(kind));
    about
}

/// An error unless an exported policy is of these networks and for such a world; its task may be
/// another one of the robot's.
fn check_fits(policy: &State, spec: &EnvSpec, networks: &Networks, kind: ActorKind) -> Result<()> {
    let about = policy.child("policy")?;
    let own = exported_about(spec, networks, kind);
    for (name, wanted) in own.values().filter(|(name, _)| *name != "task") {
        let what = format!("{name} of the policy to begin with");
        let got = about.values().find(|(known, _)| *known == name).map(|(_, value)| value);
        if got != Some(wanted) {
            let got = got.map_or("nothing".to_owned(), shown);
            return Err(Error::invalid(what, shown(wanted), got));
        }
    }
    Ok(())
}

/// A value of a policy's description; bytes are a text.
fn shown(value: &Value) -> String {
    match value {
        Value::U8(bytes) => String::from_utf8_lossy(bytes).into_owned(),
        Value::U64(numbers) => format!("{numbers:?}"),
        Value::F32(numbers) => format!("{numbers:?}"),
        Value::F64(numbers) => format!("{numbers:?}"),
    }
}

const ACTIVATIONS: [&str; 3] = ["relu", "tanh", "silu"];
const KINDS: [&str; 3] = ["deterministic", "gaussian", "normal"];

fn activation_name(activation: Activation) -> &'static str {
    match activation {
        Activation::Relu => "relu",
        Activation::Tanh => "tanh",
        Activation::Silu => "silu",
    }
}

fn kind_name(kind: ActorKind) -> &'static str {
    match kind {
        ActorKind::Deterministic => "deterministic",
        ActorKind::Gaussian => "gaussian",
        ActorKind::Normal => "normal",
    }
}

fn activation(name: &str) -> Result<Activation> {
    match name {
        "relu" => Ok(Activation::Relu),
        "tanh" => Ok(Activation::Tanh),
        "silu" => Ok(Activation::Silu),
        _ => Err(Error::unknown("activation", name, &ACTIVATIONS)),
    }
}

fn kind(name: &str) -> Result<ActorKind> {
    match name {
        "deterministic" => Ok(ActorKind::Deterministic),
        "gaussian" => Ok(ActorKind::Gaussian),
        "normal" => Ok(ActorKind::Normal),
        _ => Err(Error::unknown("kind of policy", name, &KINDS)),
    }
}
