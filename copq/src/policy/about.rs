//! What a policy's file records besides its weights.

use crate::error::check_len;
use crate::{Activation, ActorKind, EnvSpec, Error, Networks, Result, State, Value};

/// What the policy was made for, and what is needed to build it.
#[derive(Clone, Debug)]
pub(crate) struct About {
    /// Its environment. Of the objectives, a file holds only the names.
    pub spec: EnvSpec,
    pub networks: Networks,
    pub kind: ActorKind,
    /// The method that it learned with, if known.
    pub method: Option<String>,
    /// Highest priority first; empty for files that do not record them.
    pub objectives: Vec<String>,
}

impl About {
    pub fn new(spec: &EnvSpec, networks: &Networks, kind: ActorKind, method: Option<&str>) -> Self {
        Self {
            spec: spec.clone(),
            networks: networks.clone(),
            kind,
            method: method.map(str::to_owned),
            objectives: spec.names().into_iter().map(str::to_owned).collect(),
        }
    }

    /// Reads what [`About::to_state`] wrote. Older versions recorded neither objectives nor method.
    pub fn read(about: &State) -> Result<Self> {
        let low = about.get("action_low")?;
        let high = about.get("action_high")?;
        check_len("the policy's upper action bounds", high.len(), low.len())?;
        let obs_len = about.get_one::<u64>("obs_len")? as usize;
        let objectives: Vec<String> = optional_text(about, "objectives")?
            .map_or(Vec::new(), |names| names.lines().map(str::to_owned).collect());
        let mut spec =
            EnvSpec::new(about.get_text("task")?, obs_len, low.len()).action_bounds(low, high);
        for name in &objectives {
            spec = spec.reward(name, 1.0);
        }
        if objectives.is_empty() {
            // A description needs at least one.
            spec = spec.reward("any", 1.0);
        }
        let networks = Networks {
            hidden: about.get::<u64>("hidden")?.iter().map(|&width| width as usize).collect(),
            activation: activation(about.get_text("activation")?)?,
            ..Networks::default()
        };
        let kind = kind(about.get_text("kind")?)?;
        let method = optional_text(about, "method")?.map(str::to_owned);
        Ok(Self { spec, networks, kind, method, objectives })
    }

    pub fn to_state(&self) -> State {
        let Self { spec, networks, kind, method, objectives } = self;
        let mut about = State::default();
        about.put_text("task", &spec.name);
        about.put("obs_len", [spec.obs_len as u64]);
        about.put("action_low", spec.action_low.as_slice());
        about.put("action_high", spec.action_high.as_slice());
        about.put("hidden", networks.hidden.iter().map(|&width| width as u64).collect::<Vec<_>>());
        about.put_text("activation", activation_name(networks.activation));
        about.put_text("kind", kind_name(*kind));
        if let Some(method) = method {
            about.put_text("method", method);
        }
        if !objectives.is_empty() {
            about.put_text("objectives", &objectives.join("\n"));
        }
        about
    }

    /// An error unless a policy's file describes these networks and a matching environment. Its
    /// task, objectives and method may differ.
    pub fn check_fits(&self, file: &State) -> Result<()> {
        let own = self.to_state();
        let mut differences: [Vec<String>; 2] = Default::default();
        for (name, wanted) in own.values().filter(|(name, _)| !MAY_DIFFER.contains(name)) {
            let got = file.values().find(|(known, _)| *known == name).map(|(_, value)| value);
            if got != Some(wanted) {
                let got = got.map_or("nothing".to_owned(), shown);
                differences[0].push(format!("{name} {}", shown(wanted)));
                differences[1].push(format!("{name} {got}"));
            }
        }
        if differences[0].is_empty() {
            return Ok(());
        }
        let [wanted, got] = differences.map(|parts| parts.join(", "));
        Err(Error::invalid("the policy to begin with", wanted, got))
    }
}

const MAY_DIFFER: [&str; 3] = ["task", "objectives", "method"];

/// A text that older files lack.
fn optional_text<'a>(about: &'a State, name: &str) -> Result<Option<&'a str>> {
    if about.values().any(|(known, _)| known == name) {
        about.get_text(name).map(Some)
    } else {
        Ok(None)
    }
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
