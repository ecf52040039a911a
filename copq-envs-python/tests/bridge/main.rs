//! Python environments through the bridge, with the interpreters that scripts/python-worlds.sh
//! makes.

mod faults;
mod support;
mod witness;
