//! A [`State`] as one safetensors file: a tree of named arrays.
//!
//! An array's name is its path in the tree, `trainer/agent/critic/weight`; a name that ends in `/`
//! marks a subtree without content. A `/` or `%` inside a name is written `%2F` or `%25`.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::{Error, Result, State, Value};
use safetensors::tensor::{Metadata, TensorInfo};
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use crate::files;

const FORMAT: &str = "copq checkpoint 1";

/// Writes a state to a file that any safetensors reader opens, matrices as matrices; the file that
/// was there stays until the new one is whole.
pub fn write(path: &Path, state: &State) -> Result<()> {
    let mut arrays = Vec::new();
    flatten(state, "", &mut arrays);
    // As the format recommends: wide numbers first, so that every array is aligned.
    arrays.sort_by_key(|array| std::cmp::Reverse(dtype(array.value).bitsize()));
    let header = header(&arrays).map_err(|e| Error::other("describing the checkpoint", e))?;
    files::replace_with(path, |part| {
        stream(part, &header, &arrays).map_err(files::failed("writing", part))
    })
}

/// Reads the state that [`write()`] wrote.
pub fn read(path: &Path) -> Result<State> {
    let bytes = std::fs::read(path).map_err(files::failed("reading", path))?;
    let broken = |e: SafeTensorError| {
        Error::other(format!("reading the checkpoint '{}'", path.display()), e)
    };
    let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(broken)?;
    check_format(path, &metadata)?;
    let arrays = SafeTensors::deserialize(&bytes).map_err(broken)?;
    let mut state = State::default();
    for (name, array) in arrays.iter() {
        insert(&mut state, name, array.shape(), decode(path, array.dtype(), array.data())?);
    }
    Ok(state)
}

/// An array with its path and its dimensions.
struct Array<'a> {
    path: String,
    shape: Vec<usize>,
    value: &'a Value,
}

fn flatten<'a>(state: &'a State, prefix: &str, arrays: &mut Vec<Array<'a>>) {
    const NOTHING: &Value = &Value::U8(Vec::new());
    if !prefix.is_empty() && state.values().next().is_none() && state.children().next().is_none() {
        arrays.push(Array { path: prefix.to_owned(), shape: vec![0], value: NOTHING });
    }
    for (name, value) in state.values() {
        let shape = state.shape(name).map_or_else(|| vec![length(value)], <[_]>::to_vec);
        arrays.push(Array { path: format!("{prefix}{}", escape(name)), shape, value });
    }
    for (name, child) in state.children() {
        flatten(child, &format!("{prefix}{}/", escape(name)), arrays);
    }
}

fn insert(state: &mut State, path: &str, shape: &[usize], value: Value) {
    match path.split_once('/') {
        Some((child, "")) => drop(state.child_mut(&unescape(child))),
        Some((child, rest)) => insert(state.child_mut(&unescape(child)), rest, shape, value),
        None => state.put_value(&unescape(path), shape, value),
    }
}

fn escape(name: &str) -> String {
    name.replace('%', "%25").replace('/', "%2F")
}

fn unescape(name: &str) -> String {
    name.replace("%2F", "/").replace("%25", "%")
}

fn header(arrays: &[Array<'_>]) -> Result<Vec<u8>, Box<dyn std::error::Error + Send + Sync>> {
    let mut end = 0;
    let mut infos = Vec::with_capacity(arrays.len());
    for Array { path, shape, value } in arrays {
        let start = end;
        end += length(value) * dtype(value).bitsize() / 8;
        let info =
            TensorInfo { dtype: dtype(value), shape: shape.clone(), data_offsets: (start, end) };
        infos.push((path.clone(), info));
    }
    // One entry only: the order of several would change from run to run.
    let metadata = HashMap::from([("format".to_owned(), FORMAT.to_owned())]);
    let mut json = serde_json::to_vec(&Metadata::new(Some(metadata), infos)?)?;
    json.resize(json.len().next_multiple_of(8), b' ');
    Ok(json)
}

fn stream(path: &Path, header: &[u8], arrays: &[Array<'_>]) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    out.write_all(&(header.len() as u64).to_le_bytes())?;
    out.write_all(header)?;
    for array in arrays {
        match array.value {
            Value::F32(values) => {
                values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?
            }
            Value::F64(values) => {
                values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?
            }
            Value::U64(values) => {
                values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?
            }
            Value::U8(values) => out.write_all(values)?,
        }
    }
    out.flush()
}

fn dtype(value: &Value) -> Dtype {
    match value {
        Value::F32(_) => Dtype::F32,
        Value::F64(_) => Dtype::F64,
        Value::U64(_) => Dtype::U64,
        Value::U8(_) => Dtype::U8,
    }
}

fn length(value: &Value) -> usize {
    match value {
        Value::F32(values) => values.len(),
        Value::F64(values) => values.len(),
        Value::U64(values) => values.len(),
        Value::U8(values) => values.len(),
    }
}

fn decode(path: &Path, dtype: Dtype, data: &[u8]) -> Result<Value> {
    Ok(match dtype {
        Dtype::F32 => {
            Value::F32(data.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect())
        }
        Dtype::F64 => {
            Value::F64(data.as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect())
        }
        Dtype::U64 => {
            Value::U64(data.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect())
        }
        Dtype::U8 => Value::U8(data.to_vec()),
        other => {
            let what = format!("array type in the checkpoint '{}'", path.display());
            return Err(Error::invalid(what, "F32, F64, U64 or U8", format!("{other:?}")));
        }
    })
}

fn check_format(path: &Path, metadata: &Metadata) -> Result<()> {
    let format = metadata.metadata().as_ref().and_then(|entries| entries.get("format"));
    if format.is_some_and(|format| format == FORMAT) {
        return Ok(());
    }
    let what = format!("format of the checkpoint '{}'", path.display());
    Err(Error::invalid(what, FORMAT, format.map_or("none", String::as_str)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> State {
        let mut state = State::default();
        state.put("steps", [u64::MAX, 3]);
        state.put("odd/name%2F", [1u8, 2, 3]);
        let agent = state.child_mut("agent");
        agent.put("weight", [1.5f32, -0.0, f32::NAN, f32::MIN_POSITIVE]);
        agent.put("empty", Vec::<f64>::new());
        agent.put_shaped("matrix", &[2, 3], [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0]);
        agent.child_mut("q/safety").put("moments", [std::f64::consts::PI]);
        state.child_mut("env").child_mut("stateless");
        state
    }

    #[test]
    fn a_tree_comes_back_bit_for_bit_and_the_file_is_the_same_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let first = folder.path().join("a");
        let second = folder.path().join("b");
        write(&first, &sample()).unwrap();
        let state = read(&first).unwrap();
        assert_eq!(format!("{state:?}"), format!("{:?}", sample()));
        write(&second, &state).unwrap();
        assert_eq!(std::fs::read(&first).unwrap(), std::fs::read(&second).unwrap());
    }

    #[test]
    fn a_torn_or_foreign_file_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        write(&path, &sample()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in [0, 4, 40, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(read(&path).unwrap_err().to_string().contains("checkpoint.safetensors"));
        }
        let foreign = safetensors::serialize(
            Vec::<(String, safetensors::tensor::TensorView<'_>)>::new(),
            None,
        )
        .unwrap();
        std::fs::write(&path, foreign).unwrap();
        assert!(
            read(&path).unwrap_err().to_string().contains("wanted copq checkpoint 1, got none")
        );
    }
}
