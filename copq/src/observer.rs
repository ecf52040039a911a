//! Where a run's numbers go: metrics files, TensorBoard, a progress bar, a test.

/// Receives the scalars that learners, trainers and evaluations report.
///
/// ```
/// use copq::Observer;
///
/// let mut seen = Vec::new();
/// let mut log = |step: u64, name: &str, value: f64| seen.push(format!("{step} {name} {value}"));
/// log.scalar(1_000, "q/safety", 0.5); // as Trainer::step(&mut log) would
/// assert_eq!(seen, ["1000 q/safety 0.5"]);
/// ```
pub trait Observer {
    /// Receives one number at one environment step. `name` is a path such as `q/safety`. A run
    /// folder has a column of that name, which must not be `step`, be empty or contain control
    /// characters.
    fn scalar(&mut self, step: u64, name: &str, value: f64);

    /// Receives a sentence for the person who trains, such as a warning that the scale of the
    /// observations leaves little hope. Ignored unless implemented.
    fn warn(&mut self, _step: u64, _text: &str) {}
}

/// Reports nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn scalar(&mut self, _step: u64, _name: &str, _value: f64) {}
}

/// Any closure is an observer.
impl<F: FnMut(u64, &str, f64)> Observer for F {
    fn scalar(&mut self, step: u64, name: &str, value: f64) {
        self(step, name, value);
    }
}
