//! What an epoch's learning did.

/// What became of the policy and its critics in one epoch's learning.
///
/// ```
/// use copq::on_policy::Report;
///
/// let report = Report { kl: vec![0.004, 0.011], ..Report::default() };
/// assert_eq!(report.kl.len(), 2); // passes
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// KL(old || new) after every pass, summed over action components, averaged over the rows; of a
    /// natural step after it.
    pub kl: Vec<f64>,
    /// KL(first step's || new) after every pass of a second step.
    pub second_kl: Vec<f64>,
    /// Share of the rows whose ratio was cut in the last pass.
    pub clip_share: f64,
    /// Each critic's mean squared error in the last pass.
    pub critic_losses: Vec<f64>,
}
