//! Named numbers: what a row of a CSV and a step of TensorBoard are made of.

/// Names and numbers, in the order of a row's columns.
pub(crate) type Numbers = Vec<(String, f64)>;

/// The returns' scalar product with the task's weights.
pub(crate) fn weighted_total(returns: &[f64], weights: &[f32]) -> f64 {
    returns.iter().zip(weights).map(|(value, &weight)| value * f64::from(weight)).sum()
}

/// A whole number with separated thousands: 12,345.
pub(crate) fn grouped(number: u64) -> String {
    indicatif::HumanCount(number).to_string()
}

/// Seconds in the unit that suits them: 40 s, 12 min, 3.2 h.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7_200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3_600.0),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn seconds_in_words() {
        let texts = [0.4, 119.0, 130.0, 7_300.0].map(super::duration);
        assert_eq!(texts, ["0 s", "119 s", "2 min", "2.0 h"]);
    }

    #[test]
    fn thousands() {
        let texts = [0, 999, 1_000, 1_234_567].map(super::grouped);
        assert_eq!(texts, ["0", "999", "1,000", "1,234,567"]);
    }
}
