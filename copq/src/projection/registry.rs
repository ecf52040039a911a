//! Projections by name, for command lines and configuration files.

use std::sync::Arc;

use super::{
    Cholesky, Diagonal, Eigen, Extremum, IndependentMin, MeanStd, Projection, ScalarisedMin,
};
use crate::{Error, Result};

const NAMES: &[&str] =
    &["cholesky", "eigen", "extremum", "diagonal", "scalarised-min", "independent-min", "mean-std"];

/// The names that [`by_name`] knows.
pub fn names() -> &'static [&'static str] {
    NAMES
}

/// The projection of that name; the error of an unknown one lists the known, nearest first.
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
    Ok(match name {
        "cholesky" => Arc::new(Cholesky),
        "eigen" => Arc::new(Eigen),
        "extremum" => Arc::new(Extremum),
        "diagonal" => Arc::new(Diagonal),
        "mean-std" => Arc::new(MeanStd::default()),
        "scalarised-min" => Arc::new(ScalarisedMin),
        "independent-min" => Arc::new(IndependentMin),
        _ => return Err(Error::unknown("projection", name, names())),
    })
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
