//! What crosses the crates of copq: composed agents, engines, golden data, resume.
