//! What an epoch's learning did.

/// How one epoch's learning changed the policy and its critics.
///
/// ```
/// use copq::on_policy::Report;
///
/// let mut report = Report::default();
/// report.kl = vec![0.004, 0.011]; // after each of two passes
/// assert!(report.kl.last() < Some(&0.02));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// KL(old || new) after every pass, summed over action components, averaged over the rows; for
    /// a natural step, once after it.
    pub kl: Vec<f64>,
    /// KL(first step's || new) after every pass of a second step.
    pub second_kl: Vec<f64>,
    /// Share of the rows whose ratio was clipped in the last pass.
    pub clip_share: f64,
    /// Each critic's mean squared error in the last pass.
    pub critic_losses: Vec<f64>,
}
