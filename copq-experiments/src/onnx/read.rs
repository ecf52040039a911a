//! Reading back what copq has written.

use std::path::Path;

use copq::{Error, Result, State};
use prost::Message;

use super::graph::read_array;
use super::layers::Layers;
use super::messages::{Graph, Model};
use super::{CHECKSUM, IR_VERSION, PRODUCER, with_checksum};

/// Whether bytes begin like an ONNX file of copq's, with its version.
pub fn looks_like_onnx(bytes: &[u8]) -> bool {
    let start = Model { ir_version: IR_VERSION, ..Model::default() }.encode_to_vec();
    bytes.starts_with(&start) && bytes.get(8) != Some(&b'{')
}

/// The content of a policy's file, from the bytes of its ONNX file, which must be those that
/// `write_onnx` wrote.
pub fn decode(path: &Path, bytes: &[u8]) -> Result<State> {
    let shown = path.display();
    let model = Model::decode(bytes)
        .map_err(|e| Error::other(format!("reading '{shown}' as ONNX (is it damaged?)"), e))?;
    check_producer(path, &model)?;
    check_sum(path, bytes)?;
    content(&model).map_err(|e| Error::other(format!("the ONNX file '{shown}'"), e))
}

/// The content of a policy's file in a model.
fn content(model: &Model) -> Result<State> {
    let mut state = model.graph.as_ref().map_or(Ok(State::default()), arrays)?;
    let about = state.child_mut("policy");
    for entry in model.metadata_props.iter().filter(|entry| entry.key != CHECKSUM) {
        about.put_text(&entry.key, &entry.value);
    }
    // Whoever wrote it, all arrays must fit together.
    Layers::of(&state)?;
    Ok(state)
}

fn check_producer(path: &Path, model: &Model) -> Result<()> {
    if model.producer_name == PRODUCER {
        return Ok(());
    }
    let what = format!("producer of the ONNX file '{}'", path.display());
    let got = match model.producer_name.as_str() {
        "" => "none",
        other => other,
    };
    Err(Error::invalid(what, "copq (only its own policies can be read back)", got))
}

/// An error unless the file ends in the checksum of what comes before.
fn check_sum(path: &Path, bytes: &[u8]) -> Result<()> {
    let length = bytes.len().saturating_sub(with_checksum(Vec::new()).len());
    if with_checksum(bytes[..length].to_vec()) == bytes {
        return Ok(());
    }
    let what = format!("the ONNX file '{}'", path.display());
    let got = "different bytes: it is damaged, or another program has rewritten it (copq export writes a new one)";
    Err(Error::invalid(what, "the bytes that copq wrote", got))
}

/// The arrays of a graph that are the policy's own, and the widths that follow from them.
fn arrays(graph: &Graph) -> Result<State> {
    let mut state = State::default();
    for tensor in &graph.initializer {
        let Some((child, name)) = tensor.name.split_once('/') else { continue };
        if ["actor", "normaliser", "policy"].contains(&child) {
            let (dims, value) = read_array(tensor)?;
            state.child_mut(child).put_value(name, &dims, value);
        }
    }
    put_widths(&mut state)?;
    Ok(state)
}

/// Adds what a policy's file says about its layers' widths and its normaliser's length.
fn put_widths(state: &mut State) -> Result<()> {
    let actor = state.child("actor")?;
    let mut obs_len = 0;
    let mut outputs = Vec::new();
    for layer in 0.. {
        let Some(dims) = actor.shape(&format!("layer.{layer}.weight")) else { break };
        let &[output, input] = dims else {
            let what = format!("dimensions of 'actor/layer.{layer}.weight'");
            return Err(Error::invalid(what, "two", dims.len()));
        };
        if layer == 0 {
            obs_len = input;
        }
        outputs.push(output as u64);
    }
    outputs.pop(); // The last layer's are not hidden.
    if let Ok(normaliser) = state.child("normaliser") {
        let raw = obs_len.saturating_sub(normaliser.get::<f64>("mean")?.len());
        if raw > 0 {
            state.child_mut("normaliser").put("raw", [raw as u64]);
        }
    }
    let about = state.child_mut("policy");
    about.put("obs_len", [obs_len as u64]);
    about.put("hidden", outputs);
    Ok(())
}
