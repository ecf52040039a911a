//! The program as a process: what people call, read, stop and go on with.

#[cfg(unix)]
mod changes;
mod common;
#[cfg(unix)]
mod everyday;
mod export;
#[cfg(unix)]
mod python;
mod report;
mod run;
mod sweep;
