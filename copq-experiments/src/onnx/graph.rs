//! A graph that grows node by node, and arrays as its initializers.

use copq::{Error, Result, Value};

use super::messages::{Attribute, DOUBLE, FLOAT, Graph, INT64, Node, Tensor, UINT64, ValueInfo};

/// A node is named after its first output.
impl Graph {
    /// Adds a node without attributes that has one output.
    pub fn node(&mut self, op: &str, inputs: &[&str], output: &str) {
        self.node_with(op, inputs, &[output], &[]);
    }

    /// Adds a node with attributes that are whole numbers.
    pub fn node_with(
        &mut self,
        op: &str,
        inputs: &[&str],
        outputs: &[&str],
        attributes: &[(&str, i64)],
    ) {
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        let attribute = attributes.iter().map(|&(name, value)| Attribute::int(name, value));
        self.node.push(Node {
            input: owned(inputs),
            output: owned(outputs),
            name: outputs.first().map_or(String::new(), |&name| name.to_owned()),
            op_type: op.to_owned(),
            attribute: attribute.collect(),
        });
    }

    /// Adds an array of f32, with its dimensions; without any it is a single number.
    pub fn floats(&mut self, name: &str, dims: &[usize], values: &[f32]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.tensor(name, dims, FLOAT, bytes.collect());
    }

    /// Adds an array of f64, with its dimensions; without any it is a single number.
    pub fn doubles(&mut self, name: &str, dims: &[usize], values: &[f64]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.tensor(name, dims, DOUBLE, bytes.collect());
    }

    /// Adds an array of one whole number.
    pub fn count(&mut self, name: &str, count: u64) {
        self.tensor(name, &[1], UINT64, count.to_le_bytes().to_vec());
    }

    /// Adds two lengths, as `Split` wants them.
    pub fn lengths(&mut self, name: &str, lengths: [usize; 2]) {
        let bytes = lengths.map(|length| (length as i64).to_le_bytes());
        self.tensor(name, &[2], INT64, bytes.concat());
    }

    fn tensor(&mut self, name: &str, dims: &[usize], data_type: i32, raw_data: Vec<u8>) {
        let dims = dims.iter().map(|&dim| dim as i64).collect();
        self.initializer.push(Tensor { dims, data_type, name: name.to_owned(), raw_data });
    }

    /// Adds the input `[batch, width]`.
    pub fn input(&mut self, name: &str, width: usize, doc: &str) {
        self.input.push(ValueInfo::rows(name, width, doc));
    }

    /// Makes a node's result an output of the graph, `[batch, width]`.
    pub fn output(&mut self, name: &str, width: usize, doc: &str) {
        self.output.push(ValueInfo::rows(name, width, doc));
    }
}

/// The array of a tensor and its dimensions. An error says what in it is not ours.
pub fn read_array(tensor: &Tensor) -> Result<(Vec<usize>, Value)> {
    let bytes = &tensor.raw_data;
    let value = match tensor.data_type {
        FLOAT => Value::F32(numbers(bytes, f32::from_le_bytes)),
        DOUBLE => Value::F64(numbers(bytes, f64::from_le_bytes)),
        UINT64 => Value::U64(numbers(bytes, u64::from_le_bytes)),
        other => {
            let what = format!("type of '{}'", tensor.name);
            return Err(Error::invalid(what, "float, double or uint64 (1, 11, 13)", other));
        }
    };
    let width = if tensor.data_type == FLOAT { 4 } else { 8 };
    let mut dims = Vec::with_capacity(tensor.dims.len());
    let mut length = Some(width);
    for &dim in &tensor.dims {
        let dim = usize::try_from(dim).unwrap_or(usize::MAX);
        length = length.and_then(|length: usize| length.checked_mul(dim));
        dims.push(dim);
    }
    if length != Some(bytes.len()) {
        let what = format!("'{}' of dimensions {:?}", tensor.name, tensor.dims);
        return Err(Error::invalid(what, "data of that size", format!("{} bytes", bytes.len())));
    }
    Ok((dims, value))
}

fn numbers<T, const N: usize>(bytes: &[u8], number: fn([u8; N]) -> T) -> Vec<T> {
    bytes.as_chunks().0.iter().map(|&bytes| number(bytes)).collect()
}
