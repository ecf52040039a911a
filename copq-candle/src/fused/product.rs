//! The matrix products of all layers but the last ([`super::last`]): as fast as the processor
//! multiplies, and the same bits on every processor.
//!
//! A tile of the result stays in registers while the products of its elements are added one after
//! another by fused multiply-adds, in an order that never varies. Wider vectors compute more
//! elements at once, never parts of one.

#[cfg(test)]
mod tests;

use pulp::{Arch, Simd};

use super::panels::{PanelRow, Panels, WIDTH};
use super::threads::Threads;
use super::tiles::{
    ByLanes, Kernel, Sums, Tiles, add_products, array, block, cover, put, vectors, vectors_mut,
};

/// What is done to a product's elements before they are stored.
#[derive(Clone, Copy, Debug)]
pub(super) enum Finish<T> {
    /// Nothing.
    Keep,
    /// max(0, x); a NaN stays a NaN, as in PyTorch.
    Relu,
    /// Backward through ReLU: 0 wherever this activation is not positive (so also at 0, as in
    /// PyTorch).
    Mask(T),
}

impl<T> Finish<T> {
    pub fn map<U>(self, activation: impl FnOnce(T) -> U) -> Finish<U> {
        match self {
            Self::Keep => Finish::Keep,
            Self::Relu => Finish::Relu,
            Self::Mask(mask) => Finish::Mask(activation(mask)),
        }
    }
}

/// The inputs of a map: all, or some of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs<'a> {
    values: &'a Panels,
    from: usize,
    to: usize,
    /// The sums over the inputs before `from`, including the bias.
    sums: Option<&'a Panels>,
}

impl<'a> Inputs<'a> {
    /// All inputs.
    pub fn all(values: &'a Panels) -> Self {
        Self { values, from: 0, to: values.cols(), sums: None }
    }

    /// The first `count` inputs.
    pub fn first(values: &'a Panels, count: usize) -> Self {
        Self { to: count, ..Self::all(values) }
    }

    /// All but the first `count` inputs, which have added up to `sums`.
    pub fn rest(values: &'a Panels, count: usize, sums: &'a Panels) -> Self {
        Self { from: count, sums: Some(sums), ..Self::all(values) }
    }
}

/// `out = finish(inputs * map + start)`. A map of `cols` columns is panels with a line for every
/// input and one more, from which every row of the result starts.
///
/// # Panics
/// If the shapes do not match, as in all of this module. Layers are fixed, and batches are checked
/// before.
pub(super) fn affine(
    inputs: Inputs<'_>,
    map: &[PanelRow],
    cols: usize,
    finish: Finish<&Panels>,
    out: &mut Panels,
    threads: &Threads,
) {
    let rows = inputs.values.rows();
    let lines = inputs.values.cols() + 1;
    assert_eq!(map.len(), cols.div_ceil(WIDTH) * lines, "lines of a map");
    if let Some(sums) = inputs.sums {
        assert_eq!((sums.rows(), sums.cols()), (rows, cols), "shape of sums");
    }
    if let Finish::Mask(activation) = finish {
        assert_eq!((activation.rows(), activation.cols()), (rows, cols), "shape of an activation");
    }
    let share = threads.share(cols.div_ceil(WIDTH), rows * lines * cols);
    let parts =
        map.chunks(share * lines).zip(out.reshape(rows, cols).chunks_mut(share * rows)).enumerate();
    threads.each(parts, |(i, (map, out))| {
        let first = i * share * rows;
        Arch::new().dispatch(ByLanes(Affine {
            inputs,
            sums: inputs.sums.map(|sums| &sums.lines()[first..]),
            map,
            cols: (cols - i * share * WIDTH).min(share * WIDTH),
            finish: finish.map(|activation| &activation.lines()[first..]),
            out,
        }));
    });
}

/// Some panels of [`affine`]'s result, and the number of columns in them.
struct Affine<'a> {
    inputs: Inputs<'a>,
    sums: Option<&'a [PanelRow]>,
    map: &'a [PanelRow],
    cols: usize,
    finish: Finish<&'a [PanelRow]>,
    out: &'a mut [PanelRow],
}

impl Kernel for Affine<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let Self { inputs, sums, map, cols, finish, out } = self;
        let rows = inputs.values.rows();
        let before = sums.map(vectors::<S, V>);
        let from = Products { inputs, before, map: vectors::<S, V>(map) };
        let finish = finish.map(vectors::<S, V>);
        let out = vectors_mut::<S, V>(out);
        cover::<S, V>(rows, cols, &mut AffineTiles { simd, from, rows, finish, out });
    }
}

/// The sums of [`affine`]'s result.
struct Products<'a, S: Simd, const V: usize> {
    inputs: Inputs<'a>,
    before: Option<&'a [[S::f32s; V]]>,
    map: &'a [[S::f32s; V]],
}

impl<S: Simd, const V: usize> Sums<S, V> for Products<'_, S, V> {
    #[inline(always)]
    fn sums<const HEIGHT: usize, const U: usize>(
        &self,
        simd: S,
        panel: usize,
        row: usize,
    ) -> [[S::f32s; U]; HEIGHT] {
        let Inputs { values, from, to, .. } = self.inputs;
        let lines = values.cols() + 1;
        let maps: [_; U] = block(self.map, lines, panel, 0..lines);
        let mut sums: [[S::f32s; U]; HEIGHT] = [array(|u| maps[u][lines - 1][u % V]); HEIGHT];
        if let Some(before) = self.before {
            let before: [_; U] = block(before, values.rows(), panel, row..row + HEIGHT);
            for (h, sum) in sums.iter_mut().enumerate() {
                *sum = array(|u| before[u][h][u % V]);
            }
        }
        let lefts = values.lines().chunks_exact(values.rows()).enumerate();
        for (i, left) in lefts.take(to.div_ceil(WIDTH)).skip(from / WIDTH) {
            let left = &left[row..row + HEIGHT];
            let columns = from.max(i * WIDTH)..to.min((i + 1) * WIDTH);
            // A whole panel has its own loop, which is of known length and checks no bounds.
            if columns.len() == WIDTH {
                let maps: [&[_; WIDTH]; U] = array(|u| &maps[u].as_chunks().0[i]);
                let line = |column: usize| array(|u| maps[u][column][u % V]);
                for column in 0..WIDTH {
                    add_products(simd, &mut sums, |h| left[h].0[column], line(column));
                }
            } else {
                for column in columns {
                    let line = array(|u| maps[u][column][u % V]);
                    add_products(simd, &mut sums, |h| left[h].0[column % WIDTH], line);
                }
            }
        }
        sums
    }
}

/// A result in tiles whose lines are rows.
pub(super) struct AffineTiles<'a, S: Simd, T, const V: usize> {
    pub simd: S,
    pub from: T,
    pub rows: usize,
    pub finish: Finish<&'a [[S::f32s; V]]>,
    pub out: &'a mut [[S::f32s; V]],
}

impl<S: Simd, T: Sums<S, V>, const V: usize> Tiles<S, V> for AffineTiles<'_, S, T, V> {
    #[inline(always)]
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, panel: usize, row: usize) {
        let mut sums = self.from.sums(self.simd, panel, row);
        self.finish::<HEIGHT, U>(panel, row, &mut sums);
        put(self.simd, &sums, panel, row, self);
    }

    #[inline(always)]
    fn put<const HEIGHT: usize>(
        &mut self,
        panel: usize,
        row: usize,
        lines: [[S::f32s; V]; HEIGHT],
    ) {
        let out = &mut self.out[panel * self.rows + row..][..HEIGHT];
        for (out, line) in out.iter_mut().zip(lines) {
            *out = line;
        }
    }
}

impl<S: Simd, T, const V: usize> AffineTiles<'_, S, T, V> {
    #[inline(always)]
    fn finish<const HEIGHT: usize, const U: usize>(
        &self,
        panel: usize,
        row: usize,
        sums: &mut [[S::f32s; U]; HEIGHT],
    ) {
        let simd = self.simd;
        let zero = self.simd.splat_f32s(0.0);
        match self.finish {
            Finish::Keep => {}
            Finish::Relu => {
                for sum in sums.as_flattened_mut() {
                    *sum = simd.select_f32s(simd.less_than_f32s(*sum, zero), zero, *sum);
                }
            }
            Finish::Mask(activation) => {
                // HEIGHT lines, not all that follow: a long loop is unrolled only if its length is
                // known, and sums that a loop reaches by index live in memory. With AVX-512, an
                // update then takes three times as long.
                let outputs: [_; U] = block(activation, self.rows, panel, row..row + HEIGHT);
                for (h, sum) in sums.iter_mut().enumerate() {
                    for (u, sum) in sum.iter_mut().enumerate() {
                        let open = simd.greater_than_f32s(outputs[u][h][u % V], zero);
                        *sum = simd.select_f32s(open, *sum, zero);
                    }
                }
            }
        }
    }
}
