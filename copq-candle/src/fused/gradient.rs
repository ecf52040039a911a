//! The gradient of a layer's map, tile by tile: stored, or applied as a step of the parameters
//! while it is still in registers.

use pulp::{Arch, Simd};

use super::adam::Adam;
use super::panels::{PanelRow, Panels, WIDTH};
use super::threads::Threads;
use super::tiles::{
    ByLanes, Kernel, Sums, Tiles, add_products, array, block, cover, put, vectors, vectors_mut,
};

/// `out = left^T right`, then the sums of `right`'s columns: the gradient of a map, given its
/// inputs `left` and the gradient `right` of its outputs. It is laid out like the map.
pub(super) fn gradient(left: &Panels, right: &Panels, out: &mut [PanelRow], threads: &Threads) {
    let lines = left.cols() + 1;
    check(left, right, out.len());
    let share = threads.share(right.cols().div_ceil(WIDTH), left.rows() * lines * right.cols());
    let sinks = out.chunks_mut(share * lines).map(Stored);
    by_panels(left, right, share, sinks, threads);
}

/// What a step down a gradient changes in a map: the parameters, their slow copy, and Adam's
/// moments.
pub(super) struct Descent<'a> {
    pub online: &'a mut [PanelRow],
    pub target: &'a mut [PanelRow],
    pub m: &'a mut [PanelRow],
    pub v: &'a mut [PanelRow],
    pub adam: Adam,
}

/// One step of a map along what [`gradient`] would write. The gradient never reaches memory.
pub(super) fn descend(left: &Panels, right: &Panels, map: Descent<'_>, threads: &Threads) {
    let lines = left.cols() + 1;
    check(left, right, map.online.len());
    let share = threads.share(right.cols().div_ceil(WIDTH), left.rows() * lines * right.cols());
    let Descent { online, target, m, v, adam } = map;
    let parameters = online.chunks_mut(share * lines).zip(target.chunks_mut(share * lines));
    let moments = m.chunks_mut(share * lines).zip(v.chunks_mut(share * lines));
    let sinks = parameters.zip(moments).map(|((online, target), (m, v))| Descent {
        online,
        target,
        m,
        v,
        adam,
    });
    by_panels(left, right, share, sinks, threads);
}

fn check(left: &Panels, right: &Panels, len: usize) {
    assert_eq!(right.rows(), left.rows(), "rows of a gradient");
    assert_eq!(len, right.cols().div_ceil(WIDTH) * (left.cols() + 1), "lines of a gradient");
}

/// Computes the gradient's panels, `share` of them for each sink.
fn by_panels<T: Sink + Send>(
    left: &Panels,
    right: &Panels,
    share: usize,
    sinks: impl Iterator<Item = T>,
    threads: &Threads,
) {
    let parts = right.lines().chunks(share * right.rows()).zip(sinks).enumerate();
    threads.each(parts, |(i, (rights, sink))| {
        let cols = (right.cols() - i * share * WIDTH).min(share * WIDTH);
        Arch::new().dispatch(ByLanes(Gradient { left, right: rights, cols, sink }));
    });
}

/// Where a gradient's lines go.
pub(super) trait Sink {
    /// Takes lines from `first` on.
    fn take<S: Simd, const V: usize, const HEIGHT: usize>(
        &mut self,
        simd: S,
        first: usize,
        lines: [[S::f32s; V]; HEIGHT],
    );
}

/// Stores the lines.
pub(super) struct Stored<'a>(pub &'a mut [PanelRow]);

impl Sink for Stored<'_> {
    #[inline(always)]
    fn take<S: Simd, const V: usize, const HEIGHT: usize>(
        &mut self,
        _: S,
        first: usize,
        lines: [[S::f32s; V]; HEIGHT],
    ) {
        let out = &mut vectors_mut::<S, V>(self.0)[first..first + HEIGHT];
        for (out, line) in out.iter_mut().zip(lines) {
            *out = line;
        }
    }
}

impl Sink for Descent<'_> {
    #[inline(always)]
    fn take<S: Simd, const V: usize, const HEIGHT: usize>(
        &mut self,
        simd: S,
        first: usize,
        lines: [[S::f32s; V]; HEIGHT],
    ) {
        let at = first..first + HEIGHT;
        let online = &mut vectors_mut::<S, V>(self.online)[at.clone()];
        let target = &mut vectors_mut::<S, V>(self.target)[at.clone()];
        let m = &mut vectors_mut::<S, V>(self.m)[at.clone()];
        let v = &mut vectors_mut::<S, V>(self.v)[at];
        for (h, line) in lines.iter().enumerate() {
            for (u, &grad) in line.iter().enumerate() {
                let at = [&mut online[h][u], &mut target[h][u], &mut m[h][u], &mut v[h][u]];
                self.adam.step(simd, grad, at);
            }
        }
    }
}

/// Some panels of a gradient, given the same panels of `right` and the number of columns in them.
pub(super) struct Gradient<'a, T> {
    pub left: &'a Panels,
    pub right: &'a [PanelRow],
    pub cols: usize,
    pub sink: T,
}

impl<T: Sink> Kernel for Gradient<'_, T> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(mut self, simd: S) {
        let Self { left, right, cols, ref mut sink } = self;
        let inputs = left.cols();
        for (panel, right) in vectors::<S, V>(right).chunks_exact(left.rows()).enumerate() {
            sink.take::<S, V, 1>(simd, panel * (inputs + 1) + inputs, [sum(simd, right)]);
        }
        weights::<S, V>(simd, left, right, cols, sink);
    }
}

/// Computes `left^T right` into panels with a line for every column of `left` and one more, which
/// is not touched.
#[inline(always)]
pub(super) fn weights<S: Simd, const V: usize>(
    simd: S,
    left: &Panels,
    right: &[PanelRow],
    cols: usize,
    sink: &mut impl Sink,
) {
    let columns = left.cols();
    let right = vectors::<S, V>(right);
    for (i, left) in left.lines().chunks_exact(left.rows()).enumerate() {
        let from = Products { left, right };
        let first = i * WIDTH;
        let tiles = &mut GradientTiles { simd, from, columns, first, sink };
        cover::<S, V>(WIDTH.min(columns - first), cols, tiles);
    }
}

/// The sums for the part of a gradient that belongs to one panel of `left`.
struct Products<'a, S: Simd, const V: usize> {
    left: &'a [PanelRow],
    right: &'a [[S::f32s; V]],
}

impl<S: Simd, const V: usize> Sums<S, V> for Products<'_, S, V> {
    #[inline(always)]
    fn sums<const HEIGHT: usize, const U: usize>(
        &self,
        simd: S,
        panel: usize,
        input: usize,
    ) -> [[S::f32s; U]; HEIGHT] {
        let rows = self.left.len();
        let rights: [_; U] = block(self.right, rows, panel, 0..rows);
        let mut sums = [[simd.splat_f32s(0.0); U]; HEIGHT];
        for (row, left) in self.left.iter().enumerate() {
            let left = &left.0[input..input + HEIGHT];
            let line = array(|u| rights[u][row][u % V]);
            add_products(simd, &mut sums, |h| left[h], line);
        }
        sums
    }
}

/// The part of a gradient that belongs to one panel of `left`, in tiles whose lines are its
/// columns.
pub(super) struct GradientTiles<'a, S, T, K> {
    pub simd: S,
    pub from: T,
    /// Number of columns of `left`.
    pub columns: usize,
    /// The first column of this panel.
    pub first: usize,
    pub sink: &'a mut K,
}

impl<S: Simd, T: Sums<S, V>, K: Sink, const V: usize> Tiles<S, V> for GradientTiles<'_, S, T, K> {
    #[inline(always)]
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, panel: usize, input: usize) {
        let sums: [[S::f32s; U]; HEIGHT] = self.from.sums(self.simd, panel, input);
        put(self.simd, &sums, panel, input, self);
    }

    #[inline(always)]
    fn put<const HEIGHT: usize>(
        &mut self,
        panel: usize,
        input: usize,
        lines: [[S::f32s; V]; HEIGHT],
    ) {
        let first = panel * (self.columns + 1) + self.first + input;
        self.sink.take::<S, V, HEIGHT>(self.simd, first, lines);
    }
}

/// The sum of lines.
#[inline(always)]
pub(super) fn sum<S: Simd, const V: usize>(simd: S, lines: &[[S::f32s; V]]) -> [S::f32s; V] {
    let mut sums = [simd.splat_f32s(0.0); V];
    for line in lines {
        for (sum, &vector) in sums.iter_mut().zip(line) {
            *sum = simd.add_f32s(*sum, vector);
        }
    }
    sums
}
