//! Matrix products: a safe door to the `gemm` crate, which picks AVX-512, AVX2 or other kernels at run time.

use gemm::Parallelism;

/// A matrix in someone else's slice; element (i, j) is at `i * row_step + j * col_step`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matrix<'a> {
    values: &'a [f32],
    rows: usize,
    cols: usize,
    row_step: usize,
    col_step: usize,
}

impl<'a> Matrix<'a> {
    /// A row-major matrix that fills the slice.
    pub fn new(values: &'a [f32], rows: usize, cols: usize) -> Self {
        assert_eq!(values.len(), rows * cols, "a {rows} x {cols} matrix");
        Self { values, rows, cols, row_step: cols, col_step: 1 }
    }

    /// Its last columns, from `first` on.
    pub fn columns_from(self, first: usize) -> Self {
        assert!(first < self.cols, "column {first} of {}", self.cols);
        Self { values: &self.values[first * self.col_step..], cols: self.cols - first, ..self }
    }

    /// The transpose.
    pub fn t(self) -> Self {
        let Self { values, rows, cols, row_step, col_step } = self;
        Self { values, rows: cols, cols: rows, row_step: col_step, col_step: row_step }
    }

    /// Whether every element lies inside the slice.
    fn in_bounds(&self) -> bool {
        self.rows > 0
            && self.cols > 0
            && (self.rows - 1) * self.row_step + (self.cols - 1) * self.col_step < self.values.len()
    }
}

/// `out = left * right`, with `out` row-major.
///
/// # Panics
/// If the shapes do not fit together: the layers' shapes are fixed and batches are checked before they come here.
pub(super) fn matmul(out: &mut [f32], left: Matrix<'_>, right: Matrix<'_>) {
    assert!(left.cols == right.rows && out.len() == left.rows * right.cols, "shapes of a matrix product");
    assert!(left.in_bounds() && right.in_bounds(), "a matrix leaves its slice");
    let one_thread = Parallelism::None;
    // SAFETY: `gemm` reads left.rows x left.cols and right.rows x right.cols elements at the given steps, all inside
    // their slices (`in_bounds`), and writes left.rows x right.cols row-major elements, exactly `out`; `out` is a
    // `&mut`, so it overlaps neither. It does not read `out` (`read_dst` false), and a slice's length fits an `isize`.
    unsafe {
        gemm::gemm(
            left.rows,
            right.cols,
            left.cols,
            out.as_mut_ptr(),
            1,
            right.cols as isize,
            false,
            left.values.as_ptr(),
            left.col_step as isize,
            left.row_step as isize,
            right.values.as_ptr(),
            right.col_step as isize,
            right.row_step as isize,
            0.0,
            1.0,
            false,
            false,
            false,
            one_thread,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_views() {
        let (a, b) = ([1., 2., 3., 4., 5., 6.], [1., 0., 2., 1., 0., 3.]);
        let mut out = [0.0; 4];
        matmul(&mut out, Matrix::new(&a, 2, 3), Matrix::new(&b, 3, 2));
        assert_eq!(out, [5., 11., 14., 23.]);
        matmul(&mut out, Matrix::new(&a, 3, 2).t(), Matrix::new(&b, 3, 2));
        assert_eq!(out, [7., 18., 10., 22.]);
        let mut out = [0.0; 2];
        matmul(&mut out, Matrix::new(&a, 2, 3), Matrix::new(&b, 3, 2).columns_from(1));
        assert_eq!(out, [11., 23.]);
    }

    #[test]
    #[should_panic(expected = "shapes of a matrix product")]
    fn shapes_that_do_not_fit() {
        matmul(&mut [0.0; 4], Matrix::new(&[0.0; 6], 2, 3), Matrix::new(&[0.0; 4], 2, 2));
    }
}
