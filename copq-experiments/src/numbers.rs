//! Named numbers: what a row of a CSV and a step of TensorBoard are made of.

/// Names and numbers, in the order of a row's columns.
pub type Numbers = Vec<(String, f64)>;

/// The returns' scalar product with the task's weights.
pub(crate) fn weighted_total(returns: &[f64], weights: &[f32]) -> f64 {
    returns.iter().zip(weights).map(|(value, &weight)| value * f64::from(weight)).sum()
}

/// A whole number with separated thousands: 12,345.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands() {
        let texts = [0, 999, 1_000, 1_234_567].map(super::grouped);
        assert_eq!(texts, ["0", "999", "1,000", "1,234,567"]);
    }
}
