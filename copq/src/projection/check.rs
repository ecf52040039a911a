//! What the author of a projection runs first: is the gradient that of the bound?

use super::{BoundQuery, Projection, QView, Scratch};
use crate::error::check_count;
use crate::{Error, Result, Rng, Stream};

const ROWS: usize = 64;
/// Half the distance over which a slope is measured.
const NUDGE: f32 = 1e-2;
/// How far a gradient may be from the slope, whose own error is of this size.
const TOLERANCE: f32 = 1e-2;
/// Of the rows, how many may disagree: a bound may have kinks, and some rows lie on one.
const KINKS: usize = ROWS / 10;

/// Compares a projection's gradient with central differences, for 64 seeded rows of critics'
/// values, weights of both signs and both signs of the step; an error says where they differ. Up to
/// a tenth of the rows may, for a bound that has kinks, as a minimum has. Then a batch of all rows,
/// with weights of their own, must come to what they come to one by one.
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
            // A quarter are costs'.
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

/// An error unless a batch's rows come to what each of them comes to alone.
fn check_batch(
    projection: &dyn Projection,
    objectives: usize,
    rows: &[(Vec<f32>, Vec<f32>)],
) -> Result<()> {
    let critics = rows[0].0.len() / objectives;
    // Of a batch, a critic's values lie together.
    let of_critic = |k: usize| {
        rows.iter().flat_map(move |(q, _)| &q[k * objectives..(k + 1) * objectives]).copied()
    };
    let q: Vec<f32> = (0..critics).flat_map(of_critic).collect();
    let weights: Vec<f32> = rows.iter().flat_map(|(_, weights)| weights).copied().collect();
    let bounds = |q: &[f32], weights: &[f32]| {
        let q = QView::new(q, critics, objectives)?;
        let mut out = vec![0.0; q.rows() * objectives];
        let asked = BoundQuery { q, weights, step: -1.0 };
        projection.project(asked, &mut Scratch::default(), &mut out).map(|()| out)
    };
    let together = bounds(&q, &weights)?;
    for (row, ((q, weights), together)) in
        rows.iter().zip(together.chunks_exact(objectives)).enumerate()
    {
        let alone = bounds(q, weights)?;
        if alone != together {
            let what = format!("projection {} of row {row} in a batch", projection.name());
            let wanted = format!("{alone:?}, as of that row alone");
            return Err(Error::invalid(what, wanted, format!("{together:?}")));
        }
    }
    Ok(())
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
        let mut out = vec![0.0; self.objectives];
        self.projection.project(self.asked(q)?, &mut Scratch::default(), &mut out)?;
        Ok(out.iter().zip(grad_out).map(|(bound, grad)| bound * grad).sum())
    }

    /// Where the gradient first differs from the slope, if anywhere.
    fn compare(&self, q: &[f32], grad_out: &[f32]) -> Result<Option<Difference>> {
        let mut grad = vec![0.0; q.len()];
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

    /// Diagonal, with so many times its gradient, or with every row told the first one's bound.
    #[derive(Debug)]
    struct Wrong {
        factor: f32,
        is_first: bool,
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
            Diagonal.project(asked, scratch, out)?;
            if self.is_first {
                let (first, rest) = out.split_at_mut(asked.q.objectives());
                rest.chunks_exact_mut(first.len()).for_each(|row| row.copy_from_slice(first));
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
            Diagonal.vjp(asked, scratch, grad_out, grad_q)?;
            grad_q.iter_mut().for_each(|grad| *grad *= self.factor);
            Ok(())
        }
    }

    #[test]
    fn rows_that_do_not_stand_alone_and_nothing_to_look_at_are_errors() {
        let error =
            check_projection(&Wrong { factor: 1.0, is_first: true }, 3, 2).unwrap_err().to_string();
        assert!(error.starts_with("projection wrong of row 1 in a batch: wanted ["), "{error}");
        for (critics, objectives) in [(0, 2), (3, 0)] {
            assert!(check_projection(&Diagonal, critics, objectives).is_err());
        }
    }

    #[test]
    fn a_wrong_gradient_is_named() {
        let error = check_projection(&Wrong { factor: 2.0, is_first: false }, 3, 2)
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("gradient of projection wrong in 6"), "{error}");
    }
}
