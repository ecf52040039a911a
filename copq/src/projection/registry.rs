//! Projections by name, for command lines and configuration files.

use std::sync::Arc;

use super::{
    Cholesky, Diagonal, Eigen, Extremum, IndependentMin, MeanStd, Projection, ScalarisedMin,
};
use crate::{Error, Result};

/// A name and what makes its projection.
type Entry = (&'static str, fn() -> Arc<dyn Projection>);

const ALL: [Entry; 7] = [
    ("cholesky", || Arc::new(Cholesky)),
    ("eigen", || Arc::new(Eigen)),
    ("extremum", || Arc::new(Extremum)),
    ("diagonal", || Arc::new(Diagonal)),
    ("scalarised-min", || Arc::new(ScalarisedMin)),
    ("independent-min", || Arc::new(IndependentMin)),
    ("mean-std", || Arc::new(MeanStd::default())),
];

const NAMES: [&str; ALL.len()] = {
    let mut names = [""; ALL.len()];
    let mut i = 0;
    while i < ALL.len() {
        names[i] = ALL[i].0;
        i += 1;
    }
    names
};

/// The names that [`by_name`] knows.
pub fn names() -> &'static [&'static str] {
    &NAMES
}

/// The projection of that name; the error for an unknown name lists the known ones, nearest first.
///
/// ```
/// use copq::projection::by_name;
///
/// assert_eq!(by_name("cholesky")?.name(), "cholesky");
/// let error = by_name("eigne").unwrap_err().to_string();
/// assert!(error.starts_with("unknown projection 'eigne'; known: eigen, "));
/// # Ok::<(), copq::Error>(())
/// ```
pub fn by_name(name: &str) -> Result<Arc<dyn Projection>> {
    let (_, make) = ALL
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| Error::unknown("projection", name, names()))?;
    Ok(make())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_to_its_projection() {
        for name in names() {
            assert_eq!(by_name(name).unwrap().name(), *name);
        }
    }
}
