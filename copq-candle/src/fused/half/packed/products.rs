//! The products of words of two values.

use pulp::x86::V4;
use pulp::{NullaryFnOnce, Simd, f32x16};

use super::super::super::gradient::{GradientTiles, Sink};
use super::super::super::panels::{PanelRow, Panels, WIDTH};
use super::super::super::product::{AffineTiles, Finish};
use super::super::super::tiles::{Sums, array, cover, vectors, vectors_mut};
use super::{Across, Bf16, Down, Words, dot, v4};

/// sums <- sums + pairs words
#[inline(always)]
fn add_pairs<const HEIGHT: usize, const U: usize>(
    bf16: Bf16,
    sums: &mut [[f32x16; U]; HEIGHT],
    pair: impl Fn(usize) -> u32,
    words: [&Words; U],
) {
    for (h, sum) in sums.iter_mut().enumerate() {
        for (sum, words) in sum.iter_mut().zip(words) {
            *sum = dot(bf16, *sum, pair(h), words);
        }
    }
}

/// `out = finish(left * map + start)`.
pub fn affine(left: &Across, map: &Down, finish: Finish<&Panels>, out: &mut Panels) {
    let shape = (left.rows, map.cols);
    assert_eq!(map.rows, left.cols, "lines of a map");
    if let Finish::Mask(activation) = finish {
        assert_eq!((activation.rows(), activation.cols()), shape, "shape of an activation");
    }
    let out = out.reshape(left.rows, map.cols);
    let finish = finish.map(Panels::lines);
    left.bf16.vectorize(Affine { left, map, finish, out });
}

struct Affine<'a> {
    left: &'a Across,
    map: &'a Down,
    finish: Finish<&'a [PanelRow]>,
    out: &'a mut [PanelRow],
}

impl NullaryFnOnce for Affine<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { left, map, finish, out } = self;
        let simd = v4(left.bf16);
        let rows = left.rows;
        let finish = finish.map(vectors::<V4, 1>);
        let out = vectors_mut::<V4, 1>(out);
        let from = Rows { left, map };
        cover::<V4, 1>(rows, map.cols, &mut AffineTiles { simd, from, rows, finish, out });
    }
}

/// The sums of [`affine`]'s result.
struct Rows<'a> {
    left: &'a Across,
    map: &'a Down,
}

impl Sums<V4, 1> for Rows<'_> {
    #[inline(always)]
    fn sums<const HEIGHT: usize, const U: usize>(
        &self,
        _: V4,
        panel: usize,
        row: usize,
    ) -> [[f32x16; U]; HEIGHT] {
        let Across { bf16, rows, ref words, .. } = *self.left;
        let starts = vectors::<V4, 1>(&self.map.starts);
        let maps: [_; U] = array(|u| self.map.panel(panel + u));
        let mut sums = [array(|u| starts[panel + u][0]); HEIGHT];
        for (i, left) in words.chunks_exact(rows).enumerate() {
            let left = &left[row..row + HEIGHT];
            let first = i * WIDTH / 2;
            for pair in 0..(maps[0].len() - first).min(WIDTH / 2) {
                let words = array(|u| &maps[u][first + pair]);
                add_pairs(bf16, &mut sums, |h| left[h].0[pair], words);
            }
        }
        sums
    }
}

/// Computes the gradient of a map, panel by panel, for a sink as long as the map.
pub fn gradient(left: &Down, right: &Down, sink: impl Sink) {
    assert_eq!(right.rows, left.rows, "rows of a gradient");
    left.bf16.vectorize(Gradient { left, right, sink });
}

struct Gradient<'a, K> {
    left: &'a Down,
    right: &'a Down,
    sink: K,
}

impl<K: Sink> NullaryFnOnce for Gradient<'_, K> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let Down { bf16, cols: inputs, .. } = *self.left;
        let simd = v4(bf16);
        let right = self.right;
        let sink = &mut self.sink;
        let one = f32::to_bits(1.0);
        for panel in 0..right.cols.div_ceil(WIDTH) {
            let mut sums = [[simd.splat_f32s(0.0)]];
            for words in right.panel(panel) {
                add_pairs(bf16, &mut sums, |_| one >> 16 | one, [words]);
            }
            sink.take::<V4, 1, 1>(simd, panel * (inputs + 1) + inputs, sums);
        }
        for (i, first) in (0..inputs).step_by(WIDTH).enumerate() {
            let from = Columns { bf16, left: self.left.panel(i), right };
            let tiles = &mut GradientTiles { simd, from, columns: inputs, first, sink };
            cover::<V4, 1>(WIDTH.min(inputs - first), right.cols, tiles);
        }
    }
}

/// The sums for the part of a gradient that belongs to one panel of inputs.
struct Columns<'a> {
    bf16: Bf16,
    left: &'a [Words],
    right: &'a Down,
}

impl Sums<V4, 1> for Columns<'_> {
    #[inline(always)]
    fn sums<const HEIGHT: usize, const U: usize>(
        &self,
        simd: V4,
        panel: usize,
        input: usize,
    ) -> [[f32x16; U]; HEIGHT] {
        let rights: [_; U] = array(|u| self.right.panel(panel + u));
        let mut sums = [[simd.splat_f32s(0.0); U]; HEIGHT];
        for (pair, left) in self.left.iter().enumerate() {
            let left = &left.0[input..input + HEIGHT];
            let words = array(|u| &rights[u][pair]);
            add_pairs(self.bf16, &mut sums, |h| left[h], words);
        }
        sums
    }
}
