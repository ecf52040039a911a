//! The known names most like a mistyped one.

const SHOWN: usize = 5;

/// At most five of the known names, those with the fewest differences first.
pub(super) fn nearest<'a>(name: &str, known: &[&'a str]) -> Vec<&'a str> {
    let mut sorted = known.to_vec();
    sorted.sort_by_key(|candidate| distance(name, candidate));
    sorted.truncate(SHOWN);
    sorted
}

/// How many characters to insert, delete or change (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, to) in b.chars().enumerate() {
            let changed = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.chars().count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_and_order() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("a/hoper", "a/hopper"), 1);
        assert_eq!(nearest("b/antt", &["a/hopper", "b/ant", "a/ant"]), ["b/ant", "a/ant", "a/hopper"]);
    }
}
