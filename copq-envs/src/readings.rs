//! The fields that an environment reads, and their latest values.

use copq::Result;

use crate::{Field, Physics, RobotSpec};

/// Values of some fields of an engine, each read once after every step.
///
/// ```
/// use copq_envs::{Field, Readings};
///
/// let hopper = copq_envs::task("a/hopper")?.robot;
/// let readings = Readings::new([Field::BodyCentre, Field::BodyCentre], &hopper);
/// assert_eq!(readings.get(Field::BodyCentre), [0.0; 4 * 3]);
/// assert!(readings.get(Field::Inertia).is_empty()); // nobody asked for it
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Readings {
    fields: Vec<(Field, Vec<f64>)>,
}

impl Readings {
    /// Space for these fields of this robot; duplicates are read once. Values are 0 before the
    /// first reading.
    pub fn new(fields: impl IntoIterator<Item = Field>, robot: &RobotSpec) -> Self {
        let mut readings = Self::default();
        for field in fields {
            if readings.fields.iter().all(|(known, _)| *known != field) {
                readings.fields.push((field, vec![0.0; field.len(robot)]));
            }
        }
        readings
    }

    /// Reads every field from the engine.
    pub fn read(&mut self, physics: &mut dyn Physics) -> Result<()> {
        self.fields.iter_mut().try_for_each(|(field, values)| physics.read(*field, values))
    }

    /// The latest values of a field; empty if it is not among those that are read.
    pub fn get(&self, field: Field) -> &[f64] {
        self.fields.iter().find(|(known, _)| *known == field).map_or(&[], |(_, values)| values)
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.fields.iter().all(|(_, values)| values.iter().all(|value| value.is_finite()))
    }
}
