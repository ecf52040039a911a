//! Where an axis has ticks, and what they say.

/// Positions at a round distance (1, 2 or 5 times a power of ten), about `count` of them, from low
/// to high.
pub(crate) fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let distance = round_distance((high - low) / count as f64);
    // A hair of tolerance again, for ends that are round themselves.
    let first = (low / distance - 1e-9).ceil() as i64;
    let last = (high / distance + 1e-9).floor() as i64;
    (first..=last).map(|i| i as f64 * distance).collect()
}

fn round_distance(distance: f64) -> f64 {
    let power = 10f64.powf(distance.log10().floor());
    let rounds = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    // A hair of tolerance: 0.2 must not become 0.5 by a rounding error.
    rounds.into_iter().find(|&round| round >= distance * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A short label: 500, 20k, 1.5M, 2e-5, with a real minus sign.
pub(crate) fn label(value: f64, largest: f64) -> String {
    let (unit, suffix) = match largest.abs() {
        // A million as 1M, but 200k to 800k beside it.
        l if l >= 1e6 && value.abs() >= 1e6 => (1e6, "M"),
        l if l >= 1e4 => (1e3, "k"),
        _ => (1.0, ""),
    };
    let size = (value / unit).abs();
    let is_extreme = largest.abs() < 1e-3 || largest.abs() >= 1e9;
    let (size, suffix) = if is_extreme { (value.abs(), "") } else { (size, suffix) };
    let digits = if is_extreme { format!("{size:.1e}") } else { format!("{size:.6}") };
    let digits = if is_extreme {
        digits.replace(".0e", "e").replace("e-", "e\u{2212}")
    } else {
        digits.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    if size == 0.0 || digits == "0" {
        return "0".to_owned();
    }
    format!("{}{digits}{suffix}", if value < 0.0 { "\u{2212}" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        let labels = |values: &[f64]| {
            let largest = values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            values.iter().map(|&v| label(v, largest)).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(labels(&[0.0, 5_000.0, 20_000.0]), "0 5k 20k");
        assert_eq!(labels(&[0.0, 200_000.0, 1_000_000.0, 1_500_000.0]), "0 200k 1M 1.5M");
        assert_eq!(labels(&[-500.0, 0.0, 1_500.0]), "\u{2212}500 0 1500");
        assert_eq!(labels(&[-0.05, 0.1 + 0.2]), "\u{2212}0.05 0.3");
        assert_eq!(labels(&[1e6, 1_000_100.0]), "1M 1.0001M");
        assert_eq!(labels(&[1e6, 1_000_050.0]), "1M 1.00005M");
        assert_eq!(labels(&[0.0, 5e21, 1e22]), "0 5e21 1e22");
        assert_eq!(labels(&[0.0, -2e-5, 1.5e-4]), "0 \u{2212}2e\u{2212}5 1.5e\u{2212}4");
    }

    #[test]
    fn ticks_are_round_and_inside_the_range() {
        assert_eq!(ticks(0.0, 1e6, 5), [0.0, 2e5, 4e5, 6e5, 8e5, 1e6]);
        assert_eq!(ticks(-130.0, 20.0, 4), [-100.0, -50.0, 0.0]);
        assert_eq!(ticks(2.9, 4.1, 3), [3.0, 3.5, 4.0]);
    }
}
