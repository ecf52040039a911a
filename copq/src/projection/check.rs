//! A first check of a projection: is the gradient that of the bound?

use super::{BoundQuery, Projection, QView, Scratch};
use crate::error::check_count;
use crate::{Error, Result, Rng, Stream};

const ROWS: usize = 64;
/// Half the distance over which a slope is measured.
const NUDGE: f32 = 1e-2;
/// How far a gradient may be from the slope, whose own error is of this size.
const TOLERANCE: f32 = 1e-2;
/// How many of the rows may disagree: a bound may have kinks, and some rows lie on one.
const KINKS: usize = ROWS / 10;

/// Compares a projection's gradient with central differences, for 64 seeded rows of critics'
/// values, weights of both signs and both signs of the step. An error says where they differ. Up to
/// a tenth of the rows may differ, because a bound may have kinks, as a minimum does. Then a batch
/// of all rows, with separate weights or one set for all, must have the bounds and gradients that
/// the rows have one by one. Outputs hold NaN beforehand, as a learner's may.
///
/// ```
/// use copq::projection::{Cholesky, ScalarisedMin, check_projection};
///
/// check_projection(&Cholesky, 4, 3)?;
/// check_projection(&ScalarisedMin, 2, 3)?;
/// # Ok::<(), copq::Error>(())
/// ```
pub fn check_projection(
    projection: &dyn Projection,
    critics: usize,
    objectives: usize,
) -> Result<()> {
    for (what, count) in [("critics", critics), ("objectives", objectives)] {
        check_count(what, count)?;
    }
    let mut rng = Rng::new(0, Stream::Custom);
    let mut rows = Vec::new();
    let mut wrong = Vec::new();
    for row in 0..ROWS {
        let mut q = vec![0.0; critics * objectives];
        let mut grad_out = vec![0.0; objectives];
        rng.fill_normal(&mut q);
        rng.fill_normal(&mut grad_out);
        let mut weight = || {
            let size = rng.uniform_in(0.1, 1.0) as f32;
            // A quarter of them are a cost's.
            if rng.uniform_in(0.0, 1.0) < 0.25 { -size } else { size }
        };
        let weights: Vec<_> = (0..objectives).map(|_| weight()).collect();
        let step = if row % 2 == 0 { -1.0 } else { 1.0 };
        let point = Point { projection, objectives, weights: &weights, step };
        wrong.extend(point.compare(&q, &grad_out)?);
        rows.push((q, weights));
    }
    check_batch(projection, objectives, &rows)?;
    match wrong.first() {
        Some(Difference { index, gradient, slope }) if wrong.len() > KINKS => {
            let critic = index / objectives;
            let objective = index % objectives;
            Err(Error::invalid(
                format!(
                    "gradient of projection {} in {} of {ROWS} rows, first by critic {critic}'s \
                     objective {objective}",
                    projection.name(),
                    wrong.len()
                ),
                format!("{slope} (central differences)"),
                gradient,
            ))
        }
        _ => Ok(()),
    }
}

/// An error unless the rows of a batch give the same results as each of them alone, whether each
/// has its own weights or all have those of the first.
fn check_batch(
    projection: &dyn Projection,
    objectives: usize,
    rows: &[(Vec<f32>, Vec<f32>)],
) -> Result<()> {
    let critics = rows[0].0.len() / objectives;
    let of_critic =
        |k: usize| rows.iter().flat_map(move |(q, _)| &q[k * objectives..(k + 1) * objectives]);
    // In a batch, the values of a critic lie together.
    let q: Vec<f32> = (0..critics).flat_map(of_critic).copied().collect();
    let own: Vec<f32> = rows.iter().flat_map(|(_, weights)| weights).copied().collect();
    let one = rows[0].1.as_slice();
    for (whose, weights) in [("their own weights", own.as_slice()), ("one row's weights", one)] {
        let come_to = |q: &[f32], weights: &[f32]| {
            let q = QView::new(q, critics, objectives)?;
            bound_and_gradient(projection, BoundQuery { q, weights, step: -1.0 })
        };
        let (bounds, gradients) = come_to(&q, weights)?;
        for (row, (q, own)) in rows.iter().enumerate() {
            let alone = come_to(q, if weights.len() == one.len() { one } else { own })?;
            let at = row * objectives..(row + 1) * objectives;
            let of_row = |k: usize| &gradients[k * rows.len() * objectives..][at.clone()];
            let gradient: Vec<f32> = (0..critics).flat_map(of_row).copied().collect();
            let together = (bounds[at.clone()].to_vec(), gradient);
            if alone != together {
                let name = projection.name();
                let what = format!("projection {name} of row {row} in a batch with {whose}");
                let wanted = format!("bounds and gradient {alone:?}, as of that row alone");
                return Err(Error::invalid(what, wanted, format!("{together:?}")));
            }
        }
    }
    Ok(())
}

/// The bounds, and the gradient of their sum, written over NaN.
fn bound_and_gradient(
    projection: &dyn Projection,
    asked: BoundQuery<'_>,
) -> Result<(Vec<f32>, Vec<f32>)> {
    let (n, rows) = (asked.q.objectives(), asked.q.rows());
    let mut scratch = Scratch::default();
    let mut bounds = vec![f32::NAN; rows * n];
    projection.project(asked, &mut scratch, &mut bounds)?;
    let mut gradient = vec![f32::NAN; asked.q.critics() * rows * n];
    projection.vjp(asked, &mut scratch, &vec![1.0; rows * n], &mut gradient)?;
    for (what, values) in [("bounds", &bounds), ("gradient", &gradient)] {
        if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
            let what = format!("{what} of projection {}", projection.name());
            let wanted = "finite numbers, written over NaN";
            return Err(Error::invalid(what, wanted, bad));
        }
    }
    Ok((bounds, gradient))
}

/// A bound of one row.
struct Point<'a> {
    projection: &'a dyn Projection,
    objectives: usize,
    weights: &'a [f32],
    step: f32,
}

struct Difference {
    index: usize,
    gradient: f32,
    slope: f32,
}

impl Point<'_> {
    fn asked<'q>(&'q self, q: &'q [f32]) -> Result<BoundQuery<'q>> {
        let q = QView::new(q, q.len() / self.objectives, self.objectives)?;
        Ok(BoundQuery { q, weights: self.weights, step: self.step })
    }

    /// The bound's product with `grad_out`.
    fn value(&self, q: &[f32], grad_out: &[f32]) -> Result<f32> {
        let mut out = vec![f32::NAN; self.objectives];
        self.projection.project(self.asked(q)?, &mut Scratch::default(), &mut out)?;
        Ok(out.iter().zip(grad_out).map(|(bound, grad)| bound * grad).sum())
    }

    /// Where the gradient first differs from the slope, if anywhere.
    fn compare(&self, q: &[f32], grad_out: &[f32]) -> Result<Option<Difference>> {
        let mut grad = vec![f32::NAN; q.len()];
        self.projection.vjp(self.asked(q)?, &mut Scratch::default(), grad_out, &mut grad)?;
        let mut nudged = q.to_vec();
        for (index, &gradient) in grad.iter().enumerate() {
            nudged[index] = q[index] + NUDGE;
            let up = self.value(&nudged, grad_out)?;
            nudged[index] = q[index] - NUDGE;
            let down = self.value(&nudged, grad_out)?;
            nudged[index] = q[index];
            let slope = (up - down) / (2.0 * NUDGE);
            let difference = (gradient - slope).abs();
            if difference.is_nan() || difference > TOLERANCE * (1.0 + slope.abs()) {
                return Ok(Some(Difference { index, gradient, slope }));
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Diagonal, by_name, names};

    #[test]
    fn every_projection_of_the_library_passes() {
        for name in names() {
            let projection = by_name(name).unwrap();
            for (critics, objectives) in [(2, 1), (4, 3), (6, 2)] {
                check_projection(projection.as_ref(), critics, objectives)
                    .unwrap_or_else(|error| panic!("{name}: {error}"));
            }
        }
    }

    /// Diagonal, but for a fault.
    #[derive(Debug, PartialEq)]
    enum Wrong {
        TwiceItsGradient,
        FirstBoundForAll,
        FirstGradientAlone,
        WeightsForEachRow,
        AddsToTheBound,
        AddsToTheGradient,
    }

    impl Projection for Wrong {
        fn name(&self) -> &'static str {
            "wrong"
        }

        fn project(
            &self,
            asked: BoundQuery<'_>,
            scratch: &mut Scratch,
            out: &mut [f32],
        ) -> Result<()> {
            let before = out[0];
            Diagonal.project(asked, scratch, out)?;
            let n = asked.q.objectives();
            match self {
                Self::FirstBoundForAll => {
                    let (first, rest) = out.split_at_mut(n);
                    rest.chunks_exact_mut(n).for_each(|row| row.copy_from_slice(first));
                }
                Self::WeightsForEachRow if asked.weights.len() < out.len() => out.fill(0.0),
                Self::AddsToTheBound => out[0] += before,
                _ => {}
            }
            Ok(())
        }

        fn vjp(
            &self,
            asked: BoundQuery<'_>,
            scratch: &mut Scratch,
            grad_out: &[f32],
            grad_q: &mut [f32],
        ) -> Result<()> {
            let before = grad_q[0];
            Diagonal.vjp(asked, scratch, grad_out, grad_q)?;
            match self {
                Self::TwiceItsGradient => grad_q.iter_mut().for_each(|grad| *grad *= 2.0),
                Self::FirstGradientAlone => {
                    let n = asked.q.objectives();
                    let of_critics = grad_q.chunks_exact_mut(n * asked.q.rows());
                    of_critics.for_each(|rows| rows[n..].fill(0.0));
                }
                Self::AddsToTheGradient => grad_q[0] += before,
                _ => {}
            }
            Ok(())
        }
    }

    #[test]
    fn every_fault_is_found() {
        let of_all = "gradient of projection wrong in 6";
        for (wrong, words) in [
            (Wrong::TwiceItsGradient, of_all),
            (Wrong::FirstBoundForAll, "projection wrong of row 1 in a batch with their own"),
            (Wrong::FirstGradientAlone, "projection wrong of row 1 in a batch with their own"),
            (Wrong::WeightsForEachRow, "projection wrong of row 0 in a batch with one row's"),
            (Wrong::AddsToTheBound, "bounds of projection wrong: wanted finite"),
            (Wrong::AddsToTheGradient, "gradient of projection wrong: wanted finite"),
        ] {
            let error = check_projection(&wrong, 3, 2).unwrap_err().to_string();
            assert!(error.starts_with(words), "{wrong:?}: {error}");
        }
    }

    #[test]
    fn nothing_to_look_at_is_an_error() {
        for (critics, objectives) in [(0, 2), (3, 0)] {
            assert!(check_projection(&Diagonal, critics, objectives).is_err());
        }
    }
}
