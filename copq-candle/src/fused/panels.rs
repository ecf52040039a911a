//! Matrices in panels, laid out so that every product reads its factors in place, without packing
//! them first.

use bytemuck::{Pod, Zeroable};

/// Columns of a panel.
pub(super) const WIDTH: usize = 16;

/// Sixteen neighbouring values of one row: a cache line, and a whole number of vectors on every
/// processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct PanelRow(pub [f32; WIDTH]);

/// A matrix whose panel `p` has columns 16 p to 16 p + 15, with a [`PanelRow`] for each row. Lines
/// are filled up with zeros where the columns end.
#[derive(Clone, Debug, Default)]
pub(super) struct Panels {
    rows: usize,
    cols: usize,
    lines: Vec<PanelRow>,
}

impl Panels {
    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn cols(&self) -> usize {
        self.cols
    }

    /// The lines, panel after panel.
    pub fn lines(&self) -> &[PanelRow] {
        &self.lines[..self.rows * self.cols.div_ceil(WIDTH)]
    }

    /// The lines, panel after panel, to change in place.
    pub fn lines_mut(&mut self) -> &mut [PanelRow] {
        &mut self.lines[..self.rows * self.cols.div_ceil(WIDTH)]
    }

    /// Takes a new shape, and grows if it never had as much memory. The lines keep whatever they
    /// held before.
    pub fn reshape(&mut self, rows: usize, cols: usize) -> &mut [PanelRow] {
        (self.rows, self.cols) = (rows, cols);
        let len = rows * cols.div_ceil(WIDTH);
        if self.lines.len() < len {
            self.lines.resize(len, PanelRow::default());
        }
        &mut self.lines[..len]
    }

    /// Takes the values of dense row-major matrices of `rows` rows, side by side.
    pub fn set(&mut self, rows: usize, parts: &[&[f32]]) {
        let cols = parts.iter().map(|part| part.len() / rows).sum();
        self.reshape(rows, cols).fill(PanelRow::default());
        let mut first = 0;
        for part in parts {
            let width = part.len() / rows;
            for (row, mut values) in part.chunks_exact(width).enumerate() {
                for (panel, places) in runs(first, width) {
                    let (head, tail) = values.split_at(places.len());
                    self.lines[panel * rows + row].0[places].copy_from_slice(head);
                    values = tail;
                }
            }
            first += width;
        }
    }

    /// Whether the first columns equal a dense row-major matrix of `rows` rows, bit for bit.
    pub fn begins_with(&self, rows: usize, dense: &[f32]) -> bool {
        let width = dense.len() / rows;
        rows == self.rows
            && width <= self.cols
            && dense.chunks_exact(width).enumerate().all(|(row, mut values)| {
                runs(0, width).all(|(panel, places)| {
                    let (head, tail) = values.split_at(places.len());
                    values = tail;
                    let here = &self.lines[panel * rows + row].0[places];
                    bytemuck::cast_slice::<_, u32>(here) == bytemuck::cast_slice::<_, u32>(head)
                })
            })
    }

    /// Writes the columns from `first` on as a dense row-major matrix that fills `out`.
    pub fn get(&self, first: usize, out: &mut [f32]) {
        let width = out.len() / self.rows;
        for (row, mut out) in out.chunks_exact_mut(width).enumerate() {
            for (panel, places) in runs(first, width) {
                let (head, tail) = out.split_at_mut(places.len());
                head.copy_from_slice(&self.lines[panel * self.rows + row].0[places]);
                out = tail;
            }
        }
    }
}

/// The panels that hold `width` columns from `first` on, each with the places they take in its
/// lines.
fn runs(first: usize, width: usize) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    let end = first + width;
    (first / WIDTH..end.div_ceil(WIDTH)).map(move |panel| {
        let start = panel * WIDTH;
        (panel, first.max(start) - start..end.min(start + WIDTH) - start)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_go_in_and_columns_come_out() {
        let rows = 3;
        let left = 13;
        let right = 21;
        let part = |width: usize, sign: f32| {
            (0..rows * width).map(|i| sign * (i as f32 + 1.0)).collect::<Vec<_>>()
        };
        let a = part(left, 1.0);
        let b = part(right, -1.0);
        let mut panels = Panels::default();
        panels.reshape(7, 50).fill(PanelRow([9.0; WIDTH]));
        panels.set(rows, &[&a, &b]);
        assert_eq!((panels.rows(), panels.cols(), panels.lines().len()), (3, 34, 9));
        let mut out = vec![0.0; b.len()];
        panels.get(left, &mut out);
        assert_eq!(out, b);
        let mut out = vec![0.0; a.len()];
        panels.get(0, &mut out);
        assert_eq!(out, a);
        assert_eq!(panels.lines()[2].0[..3], [27.0, 28.0, 29.0]);
        assert!(panels.lines()[6..].iter().all(|line| line.0[2..] == [0.0; 14]));
    }
}
