//! `evaluations.csv`: what the policy returns without exploration, and what its critics expected.

use copq::{EnvSpec, Evaluation};

use crate::numbers::{Numbers, grouped, weighted_total};
use crate::statistics::{max, mean, min, std};

/// Returns of one objective, or weighted totals, over the episodes.
fn spread(name: &str, values: &[f64]) -> [(String, f64); 4] {
    [("mean", mean(values)), ("std", std(values)), ("min", min(values)), ("max", max(values))]
        .map(|(statistic, value)| (format!("{name}/{statistic}"), value))
}

pub(crate) fn totals(evaluation: &Evaluation, spec: &EnvSpec) -> Vec<f64> {
    evaluation.returns.iter().map(|returns| weighted_total(returns, &spec.weights())).collect()
}

/// A row of the file.
pub(crate) fn columns(evaluation: &Evaluation, spec: &EnvSpec) -> Numbers {
    let mut numbers = vec![("episodes".to_owned(), evaluation.returns.len() as f64)];
    numbers.extend(spread("weighted_total", &totals(evaluation, spec)));
    for (i, name) in spec.names().into_iter().enumerate() {
        let returns: Vec<f64> = evaluation.returns.iter().map(|returns| returns[i]).collect();
        numbers.extend(spread(&format!("return/{name}"), &returns));
    }
    numbers.push(("length/mean".to_owned(), evaluation.mean_length()));
    numbers.extend(values(evaluation, spec));
    numbers
}

/// Q-values at the first step against the discounted returns observed from there.
fn values<'a>(
    evaluation: &'a Evaluation,
    spec: &'a EnvSpec,
) -> impl Iterator<Item = (String, f64)> + 'a {
    let pairs = evaluation.q_start.iter().zip(&evaluation.discounted);
    spec.names().into_iter().zip(pairs).flat_map(|(name, (&q_start, &discounted))| {
        [(format!("q_start/{name}"), q_start), (format!("discounted/{name}"), discounted)]
    })
}

/// What TensorBoard gets.
pub(crate) fn scalars(evaluation: &Evaluation, spec: &EnvSpec) -> Numbers {
    let mut numbers =
        vec![("evaluation/weighted_total".to_owned(), mean(&totals(evaluation, spec)))];
    let returns = spec.names().into_iter().zip(evaluation.mean());
    numbers.extend(returns.map(|(name, value)| (format!("evaluation/return/{name}"), value)));
    numbers.push(("evaluation/length".to_owned(), evaluation.mean_length()));
    numbers.extend(
        values(evaluation, spec).map(|(name, value)| (format!("evaluation/{name}"), value)),
    );
    numbers
}

/// One line for the terminal: returns, length, and Q-values against what was observed.
pub(crate) fn describe(step: u64, evaluation: &Evaluation, spec: &EnvSpec) -> String {
    let named = |values: &[f64]| {
        let pairs = spec.names().into_iter().zip(values);
        pairs.map(|(name, value)| format!("{name} {value:.1}")).collect::<Vec<_>>().join(", ")
    };
    format!(
        "{:>9} steps: total {:.1} ({}), episodes of {:.0} steps",
        grouped(step),
        mean(&totals(evaluation, spec)),
        named(&evaluation.mean()),
        evaluation.mean_length(),
    )
}
