//! A tree of named arrays: what every part writes into a checkpoint and reads back from it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::{Error, Result, checkpoint};

/// One saved array. Only plain numbers, so that any file format can hold it.
///
/// ```
/// use copq::{State, Value};
///
/// let mut state = State::default();
/// state.put("steps", [120_u64]);
/// let all: Vec<_> = state.values().collect();
/// assert_eq!(all, [("steps", &Value::U64(vec![120]))]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Network parameters, observations, rewards.
    F32(Vec<f32>),
    /// Physics states and other double-precision numbers.
    F64(Vec<f64>),
    /// Counters and indices.
    U64(Vec<u64>),
    /// Generators' positions, flags, opaque snapshots.
    U8(Vec<u8>),
}

/// Named arrays and named subtrees, in a fixed order.
///
/// ```
/// use copq::State;
///
/// let mut state = State::default();
/// state.put("steps", [120_u64]);
/// state.child_mut("actor").put("weight", [0.5_f32, -1.0]);
///
/// let mut weight = [0.0_f32; 2];
/// state.child("actor")?.read("weight", &mut weight)?;
/// assert_eq!((state.get_one::<u64>("steps")?, weight), (120, [0.5, -1.0]));
///
/// let error = state.get_one::<f32>("steps").unwrap_err();
/// assert_eq!(error.to_string(), "saved array 'steps': wanted f32, got another type");
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    values: BTreeMap<String, Value>,
    /// The dimensions of arrays that have several.
    shapes: BTreeMap<String, Vec<usize>>,
    children: BTreeMap<String, State>,
}

/// A number type that a [`State`] can hold.
pub trait Element: Sized {
    /// Moves an array into a value.
    fn wrap(values: Vec<Self>) -> Value;
    /// The array in a value, if it is of this type.
    fn unwrap(value: &Value) -> Option<&[Self]>;
    /// The type's name in error messages.
    const NAME: &'static str;
}

macro_rules! element {
    ($type:ty, $variant:ident, $name:literal) => {
        impl Element for $type {
            const NAME: &'static str = $name;
            fn wrap(values: Vec<Self>) -> Value {
                Value::$variant(values)
            }
            fn unwrap(value: &Value) -> Option<&[Self]> {
                if let Value::$variant(values) = value { Some(values) } else { None }
            }
        }
    };
}
element!(f32, F32, "f32");
element!(f64, F64, "f64");
element!(u64, U64, "u64");
element!(u8, U8, "u8");

impl State {
    /// Stores an array under a name, replacing what was there.
    pub fn put<T: Element>(&mut self, name: &str, values: impl Into<Vec<T>>) {
        self.put_value(name, &[], T::wrap(values.into()));
    }

    /// Stores an array of several dimensions under a name, row-major. The product of `shape` must
    /// be the array's length.
    pub fn put_shaped<T: Element>(
        &mut self,
        name: &str,
        shape: &[usize],
        values: impl Into<Vec<T>>,
    ) {
        let values: Vec<T> = values.into();
        debug_assert_eq!(shape.iter().product::<usize>(), values.len(), "shape of '{name}'");
        self.put_value(name, shape, T::wrap(values));
    }

    /// The dimensions of an array that has several.
    pub fn shape(&self, name: &str) -> Option<&[usize]> {
        self.shapes.get(name).map(Vec::as_slice)
    }

    /// Stores a text under a name, as its UTF-8 bytes.
    pub fn put_text(&mut self, name: &str, text: &str) {
        self.put(name, text.as_bytes());
    }

    /// The text under a name.
    pub fn get_text(&self, name: &str) -> Result<&str> {
        let bytes = self.get::<u8>(name)?;
        std::str::from_utf8(bytes).map_err(|e| Error::other(format!("saved text '{name}'"), e))
    }

    /// Writes the tree to a safetensors file, atomically: a crash leaves the old file or the new
    /// one.
    pub fn write_file(&self, path: impl AsRef<Path>) -> Result<()> {
        checkpoint::write(path.as_ref(), self)
    }

    /// Reads the tree that [`State::write_file`] wrote.
    pub fn read_file(path: impl AsRef<Path>) -> Result<Self> {
        checkpoint::read(path.as_ref())
    }

    /// Reads the tree from bytes that are already in memory; `path` is what errors call them.
    pub fn from_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<Self> {
        checkpoint::decode(path.as_ref(), bytes)
    }

    /// The array under a name; an error says which name or type was missing.
    pub fn get<T: Element>(&self, name: &str) -> Result<&[T]> {
        let value = self.values.get(name).ok_or_else(|| self.missing(name))?;
        T::unwrap(value)
            .ok_or_else(|| Error::invalid(format!("saved array '{name}'"), T::NAME, "another type"))
    }

    /// The single number under a name.
    pub fn get_one<T: Element + Copy>(&self, name: &str) -> Result<T> {
        match self.get(name)? {
            [one] => Ok(*one),
            many => Err(Error::invalid(format!("saved array '{name}'"), "1 value", many.len())),
        }
    }

    /// Copies the array under a name into `out`, whose length must match.
    pub fn read<T: Element + Copy>(&self, name: &str, out: &mut [T]) -> Result<()> {
        let values = self.get(name)?;
        crate::error::check_len(&format!("saved array '{name}'"), values.len(), out.len())?;
        out.copy_from_slice(values);
        Ok(())
    }

    /// The subtree under a name, created if it is not there.
    pub fn child_mut(&mut self, name: &str) -> &mut State {
        self.children.entry(name.to_owned()).or_default()
    }

    /// Removes and returns the subtree under a name, if it is there.
    pub fn remove_child(&mut self, name: &str) -> Option<State> {
        self.children.remove(name)
    }

    /// The subtree under a name.
    pub fn child(&self, name: &str) -> Result<&State> {
        self.children.get(name).ok_or_else(|| self.missing(name))
    }

    /// The arrays directly in this tree, by name.
    pub fn values(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.values.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// The subtrees directly in this tree, by name.
    pub fn children(&self) -> impl Iterator<Item = (&str, &State)> {
        self.children.iter().map(|(name, child)| (name.as_str(), child))
    }

    /// Stores an already wrapped value with its dimensions.
    pub fn put_value(&mut self, name: &str, shape: &[usize], value: Value) {
        if shape.len() > 1 {
            self.shapes.insert(name.to_owned(), shape.to_vec());
        } else {
            self.shapes.remove(name);
        }
        self.values.insert(name.to_owned(), value);
    }

    fn missing(&self, name: &str) -> Error {
        let known: Vec<_> = self.values.keys().chain(self.children.keys()).cloned().collect();
        Error::Unknown {
            kind: "entry of a saved state",
            name: name.to_owned(),
            known: known.join(", "),
        }
    }
}
