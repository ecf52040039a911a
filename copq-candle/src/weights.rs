//! Weight files: online parameters as named tensors in safetensors format, for candle, Python and
//! other tools.

use std::path::Path;

use copq::{Error, Result, files};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::shape::Array;

/// Writes networks of the same arrays to a file, whole or not at all: `critic.0.layer.0.weight`
/// (`output x input`) and so on, one prefix (`critic.0`) a network.
pub(crate) fn save(path: &Path, networks: &[(String, Vec<f32>)], arrays: &[Array]) -> Result<()> {
    let failed = |e: Box<dyn std::error::Error + Send + Sync>| {
        Error::other(format!("writing {}", path.display()), e)
    };
    let mut tensors = Vec::new();
    for (prefix, values) in networks {
        for Array { name, dims, range } in arrays {
            let values = &values[range.clone()];
            let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
            tensors.push((format!("{prefix}.{name}"), dims, bytes));
        }
    }
    let views = tensors
        .iter()
        .map(|(name, dims, bytes)| Ok((name, TensorView::new(Dtype::F32, dims.to_vec(), bytes)?)));
    let views = views
        .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|e| failed(e.into()))?;
    let bytes = safetensors::serialize(views, None).map_err(|e| failed(e.into()))?;
    files::replace(path, &bytes)
}

/// Reads the networks of these prefixes from a file that [`save`] or another tool wrote; their flat
/// parameters.
pub(crate) fn load(path: &Path, prefixes: &[String], arrays: &[Array]) -> Result<Vec<Vec<f32>>> {
    let what = || format!("reading {}", path.display());
    let bytes = std::fs::read(path).map_err(|e| Error::other(what(), e))?;
    let file = SafeTensors::deserialize(&bytes).map_err(|e| Error::other(what(), e))?;
    let one_more = format!("critic.{}.", prefixes.len());
    if prefixes[0] != actor_prefix() && file.names().iter().any(|name| name.starts_with(&one_more))
    {
        let what = format!("critics in {}", path.display());
        return Err(Error::invalid(what, prefixes.len(), "more"));
    }
    prefixes.iter().map(|prefix| read(&file, path, prefix, arrays)).collect()
}

fn read(file: &SafeTensors<'_>, path: &Path, prefix: &str, arrays: &[Array]) -> Result<Vec<f32>> {
    let mut values = vec![0.0; arrays.last().map_or(0, |last| last.range.end)];
    for Array { name, dims, range } in arrays {
        let name = format!("{prefix}.{name}");
        let what = format!("tensor '{name}' in {}", path.display());
        let wanted = format!("F32 {dims:?}");
        let Ok(tensor) = file.tensor(&name) else {
            return Err(Error::invalid(what, wanted, "no such tensor"));
        };
        if tensor.dtype() != Dtype::F32 || tensor.shape() != dims.as_slice() {
            return Err(Error::invalid(
                what,
                wanted,
                format!("{:?} {:?}", tensor.dtype(), tensor.shape()),
            ));
        }
        for (value, bytes) in values[range.clone()].iter_mut().zip(tensor.data().as_chunks::<4>().0)
        {
            *value = f32::from_le_bytes(*bytes);
        }
    }
    Ok(values)
}

/// The prefix of every critic's tensors.
pub(crate) fn critic_prefixes(critics: usize) -> Vec<String> {
    (0..critics).map(|k| format!("critic.{k}")).collect()
}

/// The prefix of the actor's tensors.
pub(crate) fn actor_prefix() -> String {
    "actor".into()
}
