//! States in files with one named array a line.

/// The numbers of the line that starts with this name.
pub fn row(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines().filter_map(|line| line.split_once(','));
    let (_, numbers) = lines.find(|(known, _)| *known == name).unwrap();
    numbers.split(',').map(|cell| cell.parse().unwrap()).collect()
}
