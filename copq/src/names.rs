//! Names typed by people: the known ones that are nearest to a wrong one.

use crate::Error;

/// The known names, nearest to `name` first; equally near ones keep their order.
pub(crate) fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let mut known = known.to_vec();
    known.sort_by_cached_key(|known| distance(name, known));
    known
}

/// The [`Error::Unknown`] for `name`.
pub(crate) fn unknown(kind: &'static str, name: &str, known: &[&str]) -> Error {
    Error::Unknown { kind, name: name.to_owned(), known: nearest(name, known).join(", ") }
}

/// Insertions, deletions and substitutions that turn one name into the other (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let mut line: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = i;
        line[0] = i + 1;
        for (j, b) in b.chars().enumerate() {
            let substituted = diagonal + usize::from(a != b);
            diagonal = line[j + 1];
            line[j + 1] = substituted.min(diagonal + 1).min(line[j] + 1);
        }
    }
    line[b.chars().count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_edits() {
        for (a, b, edits) in
            [("", "", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("same", "same", 0), ("ab", "ba", 2)]
        {
            assert_eq!(distance(a, b), edits, "{a} -> {b}");
            assert_eq!(distance(b, a), edits, "{b} -> {a}");
        }
    }

    #[test]
    fn the_nearest_name_comes_first() {
        assert_eq!(nearest("hoper", &["ant", "hopper", "humanoid"])[0], "hopper");
        assert_eq!(nearest("zzz", &["bbb", "aaa"]), ["bbb", "aaa"]);
    }
}
