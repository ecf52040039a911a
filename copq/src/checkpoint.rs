//! A [`State`] as one safetensors file: a tree of named arrays.
//!
//! An array's name is its path in the tree, `trainer/agent/critic/weight`; a name that ends in `/`
//! marks a subtree without content. A `/` or `%` inside a name is written `%2F` or `%25`.
//!
//! One more array, [`CHECKSUMS`], holds the CRC-32C of the file's header and of every array, in the
//! order in which they lie in the file. All are compared before anything is used.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use crate::{Error, Result, State, Value};
use safetensors::tensor::{Metadata, TensorInfo};
use safetensors::{Dtype, SafeTensorError, SafeTensors};

use crate::files;

const FORMAT: &str = "copq checkpoint 2";
/// The name of the array of checksums. No tree contains it, because `%` is escaped there.
const CHECKSUMS: &str = "%checksums";

/// Writes a state to a file that any safetensors reader opens, with matrices as matrices. The
/// previous file stays until the new one has been read back and verified.
pub fn write(path: &Path, state: &State) -> Result<()> {
    let mut arrays = Vec::new();
    flatten(state, "", &mut arrays);
    // As the format recommends: wide numbers first, so that every array is aligned.
    arrays.sort_by_key(|array| std::cmp::Reverse(dtype(array.value).bitsize()));
    // The checksums come first: their number is known already.
    let mut sums = vec![0; arrays.len() + 1];
    let header = header(&arrays).map_err(|e| Error::other("describing the checkpoint", e))?;
    sums[0] = u64::from(crc32c::crc32c(&header));
    for (sum, array) in sums[1..].iter_mut().zip(&arrays) {
        *sum = u64::from(checksum(array.value));
    }
    files::replace_with(path, |part| {
        let written = stream(part, &header, &Value::U64(sums), &arrays);
        let written = written.map_err(files::failed("writing", part))?;
        let on_disk = file_checksum(part).map_err(files::failed("reading back", part))?;
        if written == on_disk {
            return Ok(());
        }
        let what = format!("what was written to '{}'", part.display());
        Err(Error::invalid(
            what,
            format!("bytes of checksum {written:08x}"),
            format!("{on_disk:08x}"),
        ))
    })
}

/// Reads the state that [`write()`] wrote.
pub fn read(path: &Path) -> Result<State> {
    decode(path, &std::fs::read(path).map_err(files::failed("reading", path))?)
}

/// Reads the state in a file's bytes.
pub fn decode(path: &Path, bytes: &[u8]) -> Result<State> {
    let broken = |e: SafeTensorError| {
        Error::other(format!("reading the checkpoint '{}'", path.display()), e)
    };
    let (header, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
    let arrays = SafeTensors::deserialize(bytes).map_err(broken)?;
    check_format(path, &metadata)?;
    check_sums(path, &bytes[8..8 + header], &metadata, &arrays)?;
    let mut state = State::default();
    for (name, array) in arrays.iter().filter(|(name, _)| *name != CHECKSUMS) {
        insert(&mut state, name, array.shape(), value(path, array.dtype(), array.data())?);
    }
    Ok(state)
}

/// An error that names the first part that does not match its checksum.
fn check_sums(
    path: &Path,
    header: &[u8],
    metadata: &Metadata,
    arrays: &SafeTensors<'_>,
) -> Result<()> {
    let damaged = |part: &str| {
        let what = format!("{part} of the checkpoint '{}'", path.display());
        Error::invalid(what, "the bytes that were written", "different bytes: the file is damaged")
    };
    let sums = arrays.tensor(CHECKSUMS).map_err(|_| damaged("the list of checksums"))?;
    let mut sums = sums.data().as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes));
    if sums.next() != Some(u64::from(crc32c::crc32c(header))) {
        return Err(damaged("the header"));
    }
    let mut infos: Vec<_> = metadata.tensors().into_iter().collect();
    infos.retain(|(name, _)| name != CHECKSUMS);
    infos.sort_by_key(|(_, info)| info.data_offsets);
    for (name, _) in infos {
        let data = arrays.tensor(&name).map_err(|_| damaged(&format!("array '{name}'")))?.data();
        if sums.next() != Some(u64::from(crc32c::crc32c(data))) {
            return Err(damaged(&format!("array '{name}'")));
        }
    }
    Ok(())
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
    let sums = arrays.len() + 1;
    let mut end = 8 * sums;
    let mut infos = Vec::with_capacity(sums);
    let checksums = TensorInfo { dtype: Dtype::U64, shape: vec![sums], data_offsets: (0, end) };
    infos.push((CHECKSUMS.to_owned(), checksums));
    for Array { path, shape, value } in arrays {
        let start = end;
        end += length(value) * dtype(value).bitsize() / 8;
        let info =
            TensorInfo { dtype: dtype(value), shape: shape.clone(), data_offsets: (start, end) };
        infos.push((path.clone(), info));
    }
    // Only one entry: the order of several would change from run to run.
    let metadata = HashMap::from([("format".to_owned(), FORMAT.to_owned())]);
    let mut json = serde_json::to_vec(&Metadata::new(Some(metadata), infos)?)?;
    json.resize(json.len().next_multiple_of(8), b' ');
    Ok(json)
}

/// Writes everything and returns the checksum of the whole file.
fn stream(path: &Path, header: &[u8], sums: &Value, arrays: &[Array<'_>]) -> io::Result<u32> {
    let mut out = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let mut sum = 0;
    let mut put = |bytes: &[u8]| {
        sum = crc32c::crc32c_append(sum, bytes);
        out.write_all(bytes)
    };
    put(&(header.len() as u64).to_le_bytes())?;
    put(header)?;
    each_chunk(sums, &mut put)?;
    for array in arrays {
        each_chunk(array.value, &mut put)?;
    }
    // Synced to the disk, so that reading back comes from there as far as the system allows.
    out.into_inner()?.sync_all()?;
    Ok(sum)
}

fn file_checksum(path: &Path) -> io::Result<u32> {
    let mut file = File::open(path)?;
    let mut chunk = vec![0; 1 << 20];
    let mut sum = 0;
    loop {
        match file.read(&mut chunk)? {
            0 => return Ok(sum),
            n => sum = crc32c::crc32c_append(sum, &chunk[..n]),
        }
    }
}

fn checksum(value: &Value) -> u32 {
    let mut sum = 0;
    let summed = each_chunk(value, &mut |bytes| {
        sum = crc32c::crc32c_append(sum, bytes);
        Ok(())
    });
    // Computing a checksum does not fail.
    summed.map_or(0, |()| sum)
}

/// Passes on a value's bytes, some thousand at a time.
fn each_chunk(value: &Value, put: &mut dyn FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
    match value {
        Value::F32(values) => encoded(values, f32::to_le_bytes, put),
        Value::F64(values) => encoded(values, f64::to_le_bytes, put),
        Value::U64(values) => encoded(values, u64::to_le_bytes, put),
        Value::U8(values) => put(values),
    }
}

fn encoded<T: Copy, const N: usize>(
    values: &[T],
    bytes: fn(T) -> [u8; N],
    put: &mut dyn FnMut(&[u8]) -> io::Result<()>,
) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(N * values.len().min(CHUNK));
    for chunk in values.chunks(CHUNK) {
        buffer.clear();
        for &value in chunk {
            buffer.extend_from_slice(&bytes(value));
        }
        put(&buffer)?;
    }
    Ok(())
}

/// How many numbers are encoded at a time.
const CHUNK: usize = 4_096;

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

fn value(path: &Path, dtype: Dtype, data: &[u8]) -> Result<Value> {
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
    let got = match format.map_or("none", String::as_str) {
        FORMAT => return Ok(()),
        "copq checkpoint 1" => "copq checkpoint 1, which has no checksums: begin the run anew",
        other => other,
    };
    Err(Error::invalid(format!("format of the checkpoint '{}'", path.display()), FORMAT, got))
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
            read(&path).unwrap_err().to_string().contains("wanted copq checkpoint 2, got none")
        );
    }

    #[test]
    fn no_damaged_bit_is_believed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        write(&path, &sample()).unwrap();
        let sound = std::fs::read(&path).unwrap();
        let header = u64::from_le_bytes(sound[..8].try_into().unwrap()) as usize;
        for i in 0..8 * sound.len() {
            let mut damaged = sound.clone();
            damaged[i / 8] ^= 1 << (i % 8);
            std::fs::write(&path, &damaged).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains("checkpoint.safetensors"), "bit {i}: {error}");
            let named = error.contains("array '") || error.contains("the header");
            assert!(named || i / 8 < 8 + header, "bit {i}: {error}");
        }
    }

    /// Two bytes could make it of a sound file, and then nothing is compared.
    #[test]
    fn a_file_of_the_format_without_checksums_is_refused() {
        let values = 1.5f32.to_le_bytes();
        let view = safetensors::tensor::TensorView::new(Dtype::F32, vec![1], &values).unwrap();
        let metadata = HashMap::from([("format".to_owned(), "copq checkpoint 1".to_owned())]);
        let bytes = safetensors::serialize([("agent/weight", view)], Some(metadata)).unwrap();
        let error = decode(Path::new("old"), &bytes).unwrap_err().to_string();
        assert!(error.contains("wanted copq checkpoint 2, got copq checkpoint 1"), "{error}");
    }
}
