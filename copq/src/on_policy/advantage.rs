//! Generalised advantages and the critics' targets.

/// Writes the advantages of one signal's rows and its critic's targets (Schulman et al. 2016,
/// eq. 16). Paths of rows end before the rows listed in `ends`, in order; each end has the value of
/// what comes after it.
pub(super) fn generalised(
    signal: &[f32],
    value: &[f32],
    ends: impl DoubleEndedIterator<Item = (usize, f32)>,
    [discount, lambda]: [f64; 2],
    advantage: &mut [f32],
    target: &mut [f32],
) {
    let mut last = signal.len();
    let mut next = 0.0;
    let mut sum = 0.0;
    let mut ends = ends.rev().peekable();
    while last > 0 {
        if let Some((_, after)) = ends.next_if(|(end, _)| *end == last) {
            next = f64::from(after);
            sum = 0.0;
        }
        last -= 1;
        let now = f64::from(value[last]);
        let delta = f64::from(signal[last]) + discount * next - now;
        sum = delta + discount * lambda * sum;
        advantage[last] = sum as f32;
        target[last] = (sum + now) as f32;
        next = now;
    }
}

/// Mean and standard deviation, the latter over n.
pub(super) fn moments(values: &[f32]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    let variance = values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / n;
    [mean, variance.sqrt()]
}

/// Subtracts the mean.
pub(super) fn centre(values: &mut [f32]) {
    let [mean, _] = moments(values);
    values.iter_mut().for_each(|x| *x = (f64::from(*x) - mean) as f32);
}

/// Subtracts the mean and divides by the deviation.
pub(super) fn standardise(values: &mut [f32]) {
    let [mean, std] = moments(values);
    values.iter_mut().for_each(|x| *x = ((f64::from(*x) - mean) / (std + 1e-8)) as f32);
}
