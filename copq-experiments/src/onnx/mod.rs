//! Policies as ONNX files: messages, the graph, and reading them back.

mod graph;
mod layers;
mod messages;
mod policy;
mod read;
#[cfg(test)]
mod tests;

use std::path::Path;

use copq::{Error, Policy, Result, State, Value, files};
use prost::Message;

use messages::{Entry, Model, Opset};

const PRODUCER: &str = "copq";
/// The last entry of the metadata: a CRC-32C of all bytes before it.
const CHECKSUM: &str = "checksum";

/// ONNX 1.12's format and operators: onnxruntime on a CPU must give Rust's numbers.
const IR_VERSION: i64 = 8;
const OPSET: i64 = 17;

/// Writes a policy as an ONNX file that does not need copq: raw observations in, the environment's
/// own actions out.
///
/// The input is `obs`, f32, `[batch, obs_len]`, with a free batch. The output `action`, f32,
/// `[batch, action_len]`, is the best guess in the environment's units, never beyond its bounds and
/// exactly there at the ends: normaliser, squashing and scaling are inside. A stochastic policy
/// also has the outputs `mean` and `std` of its Gaussian, `[batch, action_len]`: before the tanh
/// (`gaussian`), or before the clamp to [-1, 1] (`normal`); both before the scaling.
///
/// The initializers are the arrays of [`Policy`]'s own file, under the same names; the metadata
/// gives its `task`, `method`, `objectives` (one name per line), `kind` and `activation`, and last
/// a `checksum` of the file.
///
/// Errors: a network that is not copq's own, and a file that cannot be written; an existing file
/// then stays as it is.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("policy.onnx");
/// use copq::{EnvSpec, Learner, Method, Policy};
/// use copq_candle::Candle;
/// use copq_experiments::{read_policy, write_onnx};
///
/// let spec = EnvSpec::new("cart", 4, 1).action_bounds(&[-3.0], &[3.0]).reward("safety", 1.0);
/// let learner = Learner::new(Method::cop_td3(), &spec, &Candle::default(), 0)?;
/// # let saved = folder.path().join("policy.safetensors");
/// learner.save_policy(&saved)?;
/// let policy = Policy::read(&saved, &Candle::default())?;
/// write_onnx(&policy, &path)?;
///
/// // The file holds the whole policy.
/// assert_eq!(read_policy(&path)?, policy.to_state()?);
/// # Ok::<(), copq::Error>(())
/// ```
pub fn write_onnx(policy: &Policy, path: impl AsRef<Path>) -> Result<()> {
    files::replace(path.as_ref(), &encode(&policy.to_state()?)?)
}

/// Reads the content of a policy's file: safetensors, as [`State::read_file`] does, or what
/// [`write_onnx`] wrote. [`Policy::from_state`] makes a policy from it.
///
/// Errors: a file that cannot be read, one that is damaged, and an ONNX file that is not copq's.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("policy.onnx");
/// # std::fs::write(&path, "no ONNX").expect("a file");
/// let error = copq_experiments::read_policy(&path).unwrap_err().to_string();
/// assert!(error.contains("policy.onnx' as ONNX (is it damaged?)"), "{error}");
/// ```
pub fn read_policy(path: impl AsRef<Path>) -> Result<State> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(files::failed("reading", path))?;
    let is_onnx = path.extension().is_some_and(|name| name.eq_ignore_ascii_case("onnx"));
    if is_onnx || read::looks_like_onnx(&bytes) {
        return read::decode(path, &bytes);
    }
    let what = || format!("reading '{}' as a policy file (safetensors or ONNX)", path.display());
    let state = State::read_file(path).map_err(|e| Error::other(what(), e))?;
    if state.child("trainer").is_ok() {
        let wanted = "a policy file (or the run's folder)";
        return Err(Error::invalid(format!("'{}'", path.display()), wanted, "a checkpoint"));
    }
    Ok(state)
}

/// The bytes of a policy's ONNX file.
fn encode(policy: &State) -> Result<Vec<u8>> {
    let about = policy.child("policy")?;
    let mut metadata_props = Vec::new();
    for (key, value) in about.values() {
        if matches!(value, Value::U8(_)) {
            let value = about.get_text(key)?.to_owned();
            metadata_props.push(Entry { key: key.to_owned(), value });
        }
    }
    let task = about.get_text("task")?;
    let model = Model {
        ir_version: IR_VERSION,
        opset_import: vec![Opset { domain: String::new(), version: OPSET }],
        producer_name: PRODUCER.to_owned(),
        producer_version: env!("CARGO_PKG_VERSION").to_owned(),
        doc_string: format!("A policy for {task}: raw observations in, actions out."),
        graph: Some(policy::graph(policy)?),
        metadata_props,
    };
    Ok(with_checksum(model.encode_to_vec()))
}

/// The same bytes with their checksum at the end. Messages one after another are one message, so
/// readers take the checksum as the last entry of the metadata.
fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    let value = format!("{:08x}", crc32c::crc32c(&bytes));
    let entry = Entry { key: CHECKSUM.to_owned(), value };
    let last = Model { metadata_props: vec![entry], ..Model::default() };
    bytes.extend(last.encode_to_vec());
    bytes
}
