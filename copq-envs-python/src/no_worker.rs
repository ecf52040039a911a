//! What stands in for a worker where there are no Unix sockets: nothing can be started.

use std::path::Path;
use std::time::Duration;

use crate::hello::Hello;

/// An environment's process; there are none here.
#[derive(Debug)]
pub(crate) enum Worker {}

/// Why a worker has not answered; here none is ever asked.
#[allow(dead_code)]
#[derive(Debug)]
pub(crate) enum Failure {
    Raised(String),
    Lost(String),
}

impl Worker {
    pub fn start(_: &Path, _: &str, _: Duration) -> Result<(Self, Hello), String> {
        Err(format!("Python environments: wanted Unix, got {}", std::env::consts::OS))
    }

    pub fn ask(&mut self, _: &[u8], _: &mut [u8], _: &str) -> Result<u8, Failure> {
        match *self {}
    }

    pub fn read(&mut self, _: &mut [u8], _: &str) -> Result<(), Failure> {
        match *self {}
    }
}
