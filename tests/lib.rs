//! What crosses the crates of copq: composed agents, engines, golden data, resume.

/// The README's own code, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
