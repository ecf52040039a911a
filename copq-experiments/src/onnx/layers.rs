//! The layers of a policy's network, which must be copq's own.

use copq::{Error, Result, State};

/// What a policy's network is made of: linear layers with one activation between them.
#[derive(Debug)]
pub struct Layers {
    /// The number of inputs, the widths between the layers, the number of outputs.
    pub widths: Vec<usize>,
    /// Components of an action.
    pub action_len: usize,
    /// `deterministic`, `gaussian` or `normal`.
    pub kind: String,
    /// `relu`, `tanh` or `silu`.
    pub activation: String,
}

impl Layers {
    /// The layers of a policy, from its file's content. An error for a user's own modules, whose
    /// arrays do not say what they compute.
    pub fn of(policy: &State) -> Result<Self> {
        let about = policy.child("policy")?;
        let kind = known(about, "kind", &["deterministic", "gaussian", "normal"])?;
        let action_len = about.get::<f32>("action_low")?.len();
        let mut widths = vec![about.get_one::<u64>("obs_len")? as usize];
        widths.extend(about.get::<u64>("hidden")?.iter().map(|&width| width as usize));
        widths.push(if kind == "gaussian" { 2 * action_len } else { action_len });
        let activation = known(about, "activation", &["relu", "tanh", "silu"])?;
        let layers = Self { widths, action_len, kind, activation };
        layers.check(policy.child("actor")?)?;
        Ok(layers)
    }

    /// Numbers in an observation.
    pub fn obs_len(&self) -> usize {
        self.widths[0] // There are at least two.
    }

    /// How many linear layers there are.
    pub fn count(&self) -> usize {
        self.widths.len() - 1
    }

    /// The dimensions of a layer's weight, output x input.
    pub fn weight(&self, layer: usize) -> [usize; 2] {
        [self.widths[layer + 1], self.widths[layer]]
    }

    /// An error unless an actor's arrays are those of these layers.
    fn check(&self, actor: &State) -> Result<()> {
        let mut wanted = Vec::new();
        for layer in 0..self.count() {
            let weight = self.weight(layer);
            wanted.push((format!("layer.{layer}.weight"), weight.to_vec()));
            wanted.push((format!("layer.{layer}.bias"), vec![weight[0]]));
        }
        if self.kind == "normal" {
            wanted.push(("log_std".to_owned(), vec![self.action_len]));
        }
        wanted.sort();
        let mut got = Vec::new();
        for (name, _) in actor.values() {
            let dims = match actor.shape(name) {
                Some(dims) => dims.to_vec(),
                None => vec![actor.get::<f32>(name)?.len()],
            };
            got.push((name.to_owned(), dims));
        }
        got.sort();
        if wanted == got {
            return Ok(());
        }
        let what = "the policy's network, for export to ONNX";
        let wanted = format!("copq's own layers, {}", listed(&wanted));
        let got = format!("different arrays, {} (are they from your own modules?)", listed(&got));
        Err(Error::invalid(what, wanted, got))
    }
}

/// A name that a policy's file gives, and for which ONNX has operators.
fn known(about: &State, what: &'static str, names: &[&str]) -> Result<String> {
    let name = about.get_text(what)?;
    if names.contains(&name) {
        return Ok(name.to_owned());
    }
    Err(Error::unknown(what, name, names))
}

/// Arrays in words.
fn listed(arrays: &[(String, Vec<usize>)]) -> String {
    let described = arrays.iter().map(|(name, dims)| format!("{name} {dims:?}"));
    described.collect::<Vec<_>>().join(", ")
}
