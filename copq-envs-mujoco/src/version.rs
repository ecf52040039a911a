//! MuJoCo's version numbers.

use copq::{Error, Result};

/// A version as people write it; `mj_version` gives 2.2.2 as 222 and 3.17.0 as 3017000.
pub fn dotted(version: i32) -> String {
    let base = if version >= 1_000_000 { 1000 } else { 10 };
    format!("{}.{}.{}", version / (base * base), version / base % base, version % base)
}

/// An error unless the library has the version that the bindings were built for: other versions
/// have other layouts.
pub(crate) fn check_version(header: i32, library: i32, place: &str) -> Result<()> {
    if header == library {
        return Ok(());
    }
    let wanted =
        format!("{}, the version of the headers this program was built with", dotted(header));
    Err(Error::invalid("version of MuJoCo", wanted, format!("{} from {place}", dotted(library))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_count() {
        assert_eq!([222, 337, 3_017_000].map(dotted), ["2.2.2", "3.3.7", "3.17.0"]);
    }

    #[test]
    fn another_version_is_an_error_that_names_both() {
        assert!(check_version(222, 222, "here").is_ok());
        let error = check_version(3_017_000, 337, "libmujoco.so.3.3.7").unwrap_err().to_string();
        assert!(
            error.contains("wanted 3.17.0") && error.contains("got 3.3.7 from libmujoco.so.3.3.7"),
            "{error}"
        );
    }
}
