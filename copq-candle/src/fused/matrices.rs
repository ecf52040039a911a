//! Matrices for tests of products.

use super::panels::Panels;

/// Rows, inputs and columns: odd and even sizes, whole and partial panels, tiles of every height.
pub(super) const SHAPES: [(usize, usize, usize); 12] = [
    (1, 1, 1),
    (3, 16, 17),
    (37, 23, 5),
    (13, 40, 32),
    (64, 3, 16),
    (29, 18, 101),
    (70, 40, 3),
    (131, 33, 8),
    (1, 1, 64),
    (3, 3, 64),
    (4, 4, 64),
    (256, 64, 64),
];

pub(super) fn panels(rows: usize, dense: &[f32]) -> Panels {
    let mut panels = Panels::default();
    panels.set(rows, &[dense]);
    panels
}

pub(super) fn dense(panels: &Panels) -> Vec<f32> {
    let mut out = vec![0.0; panels.rows() * panels.cols()];
    panels.get(0, &mut out);
    out
}
