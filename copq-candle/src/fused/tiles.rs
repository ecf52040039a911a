//! How products are computed: lines as vectors, and results in tiles that stay in registers.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::panels::{PanelRow, WIDTH};

/// A computation on lines as vectors.
pub(super) trait Kernel {
    /// Runs with lines of `V` vectors each.
    fn run<S: Simd, const V: usize>(self, simd: S);
}

/// Finds how many vectors a line takes.
pub(super) struct ByLanes<K>(pub K);

impl<K: Kernel> WithSimd for ByLanes<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match S::F32_LANES {
            16 => self.0.run::<S, 1>(simd),
            8 => self.0.run::<S, 2>(simd),
            4 => self.0.run::<S, 4>(simd),
            _ => self.0.run::<S, WIDTH>(simd),
        }
    }
}

/// Lines as vectors.
#[inline(always)]
pub(super) fn vectors<S: Simd, const V: usize>(lines: &[PanelRow]) -> &[[S::f32s; V]] {
    S::as_simd_f32s(bytemuck::cast_slice(lines)).0.as_chunks().0
}

/// The same, to write.
#[inline(always)]
pub(super) fn vectors_mut<S: Simd, const V: usize>(lines: &mut [PanelRow]) -> &mut [[S::f32s; V]] {
    S::as_mut_simd_f32s(bytemuck::cast_slice_mut(lines)).0.as_chunks_mut().0
}

/// A result that is computed in tiles of `HEIGHT` lines by `U` vectors. The vectors lie side by
/// side: in one panel where a line takes several, in several panels where it takes one.
pub(super) trait Tiles<S: Simd, const V: usize> {
    /// Computes a tile, from line `first` of a panel on, and stores it with [`put`].
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, panel: usize, first: usize);

    /// Takes lines of one panel, from `first` on.
    fn put<const HEIGHT: usize>(
        &mut self,
        panel: usize,
        first: usize,
        lines: [[S::f32s; V]; HEIGHT],
    );
}

/// Where a tile's sums come from.
pub(super) trait Sums<S: Simd, const V: usize> {
    /// The sums of a tile, from line `first` of a panel on.
    fn sums<const HEIGHT: usize, const U: usize>(
        &self,
        simd: S,
        panel: usize,
        first: usize,
    ) -> [[S::f32s; U]; HEIGHT];
}

/// Computes `count` lines of `cols` values in tiles.
///
/// With AVX-512 there are 32 registers, and 6 lines of four panels take 10 loads for 24
/// multiply-adds, fewer than a processor can do alongside. 16 lines of one panel take 17 for 16.
/// With 16 registers, 6 lines of two vectors fill 12.
#[inline(always)]
pub(super) fn cover<S: Simd, const V: usize>(
    count: usize,
    cols: usize,
    tiles: &mut impl Tiles<S, V>,
) {
    let mut panel = 0;
    while panel * WIDTH < cols {
        let left = cols - panel * WIDTH;
        panel += match left.div_ceil(WIDTH) {
            4.. if V == 1 => column::<S, V, 4, 4>(panel, count, 6, tiles),
            2.. if V == 1 => column::<S, V, 2, 2>(panel, count, 12, tiles),
            _ if V == 1 => column::<S, V, 1, 1>(panel, count, 16, tiles),
            _ if left <= S::F32_LANES => column::<S, V, 1, 1>(panel, count, 12, tiles),
            _ => column::<S, V, 1, V>(panel, count, 6, tiles),
        };
    }
}

/// Computes `count` lines of neighbouring panels in tiles of at most `highest` lines. A tile of few
/// lines waits for its few sums, so the last two tiles share the lines that are left.
#[inline(always)]
fn column<S: Simd, const V: usize, const PANELS: usize, const U: usize>(
    panel: usize,
    count: usize,
    highest: usize,
    tiles: &mut impl Tiles<S, V>,
) -> usize {
    let mut first = 0;
    while first < count {
        let left = count - first;
        let height = if (7..12).contains(&left) { left.div_ceil(2) } else { left };
        first += match height.min(highest) {
            16.. => tile::<S, V, 16, U>(panel, first, tiles),
            12.. => tile::<S, V, 12, U>(panel, first, tiles),
            6.. => tile::<S, V, 6, U>(panel, first, tiles),
            5 => tile::<S, V, 5, U>(panel, first, tiles),
            4 => tile::<S, V, 4, U>(panel, first, tiles),
            3 => tile::<S, V, 3, U>(panel, first, tiles),
            2 => tile::<S, V, 2, U>(panel, first, tiles),
            _ => tile::<S, V, 1, U>(panel, first, tiles),
        };
    }
    PANELS
}

#[inline(always)]
fn tile<S: Simd, const V: usize, const HEIGHT: usize, const U: usize>(
    panel: usize,
    first: usize,
    tiles: &mut impl Tiles<S, V>,
) -> usize {
    tiles.tile::<HEIGHT, U>(panel, first);
    HEIGHT
}

/// Makes an array from its indices. The standard library's function is not always inlined, and a
/// call cannot use vectors of this width.
#[inline(always)]
pub(super) fn array<T: Copy, const N: usize>(element: impl Fn(usize) -> T) -> [T; N] {
    let mut array = [element(0); N];
    for (i, to) in array.iter_mut().enumerate() {
        *to = element(i);
    }
    array
}

/// For each vector of a tile, some lines of the panel that it is in. Vector `u` is the `u % V`-th
/// of a line.
#[inline(always)]
pub(super) fn block<T, const U: usize, const V: usize>(
    matrix: &[[T; V]],
    rows: usize,
    panel: usize,
    lines: Range<usize>,
) -> [&[[T; V]]; U] {
    array(|u| &matrix[(panel + u / V) * rows..][lines.clone()])
}

/// sums <- sums + left column line
#[inline(always)]
pub(super) fn add_products<S: Simd, const HEIGHT: usize, const U: usize>(
    simd: S,
    sums: &mut [[S::f32s; U]; HEIGHT],
    left: impl Fn(usize) -> f32,
    line: [S::f32s; U],
) {
    for (h, sum) in sums.iter_mut().enumerate() {
        let x = simd.splat_f32s(left(h));
        for (sum, vector) in sum.iter_mut().zip(line) {
            *sum = simd.mul_add_f32s(x, vector, *sum);
        }
    }
}

/// Stores a tile, with zeros where its sums do not reach.
///
/// The panels are written out one by one, because sums that a loop reaches by index would live in
/// memory.
#[inline(always)]
pub(super) fn put<S: Simd, const V: usize, const U: usize, const HEIGHT: usize>(
    simd: S,
    sums: &[[S::f32s; U]; HEIGHT],
    panel: usize,
    first: usize,
    to: &mut impl Tiles<S, V>,
) {
    to.put(panel, first, lines::<S, V, U, HEIGHT, 0>(simd, sums));
    if U > V {
        to.put(panel + 1, first, lines::<S, V, U, HEIGHT, 1>(simd, sums));
    }
    if U > 2 * V {
        to.put(panel + 2, first, lines::<S, V, U, HEIGHT, 2>(simd, sums));
        to.put(panel + 3, first, lines::<S, V, U, HEIGHT, 3>(simd, sums));
    }
}

/// A tile's `I`-th panel.
#[inline(always)]
fn lines<S: Simd, const V: usize, const U: usize, const HEIGHT: usize, const I: usize>(
    simd: S,
    sums: &[[S::f32s; U]; HEIGHT],
) -> [[S::f32s; V]; HEIGHT] {
    let mut lines = [[simd.splat_f32s(0.0); V]; HEIGHT];
    for (line, sum) in lines.iter_mut().zip(sums) {
        for (v, vector) in line.iter_mut().enumerate() {
            if I * V + v < U {
                *vector = sum[I * V + v];
            }
        }
    }
    lines
}
