//! The matrix products of a network: as fast as the processor multiplies, and the same bits on
//! every processor.
//!
//! A tile of the result stays in registers while the products of its elements are added one after
//! another by fused multiply-adds, in an order that depends on nothing. Wider vectors compute more
//! elements at once, never parts of one.

use pulp::{Arch, Simd, WithSimd};

use super::panels::{PanelRow, Panels, WIDTH};
use super::threads::Threads;

/// What becomes of a product's elements before they are stored.
#[derive(Clone, Copy, Debug)]
pub(super) enum Finish<T> {
    /// Nothing.
    Keep,
    /// max(0, x); a NaN stays one, as in PyTorch.
    Relu,
    /// Backward through ReLU: 0 wherever this activation is not positive (so also at 0, as in
    /// PyTorch).
    Mask(T),
}

impl<T> Finish<T> {
    fn map<U>(self, activation: impl FnOnce(T) -> U) -> Finish<U> {
        match self {
            Self::Keep => Finish::Keep,
            Self::Relu => Finish::Relu,
            Self::Mask(mask) => Finish::Mask(activation(mask)),
        }
    }
}

/// `out = finish(left * map + start)`. A map of `cols` columns is panels of `left.cols() + 1`
/// lines, the last of which is what every row of the result starts from.
///
/// # Panics
/// If the shapes do not fit together, as in all of this module: layers are fixed and batches are
/// checked before.
pub(super) fn affine(
    left: &Panels,
    map: &[PanelRow],
    cols: usize,
    finish: Finish<&Panels>,
    out: &mut Panels,
    threads: &Threads,
) {
    let rows = left.rows();
    let lines = left.cols() + 1;
    assert_eq!(map.len(), cols.div_ceil(WIDTH) * lines, "lines of a map");
    if let Finish::Mask(activation) = finish {
        assert_eq!((activation.rows(), activation.cols()), (rows, cols), "shape of an activation");
    }
    let share = threads.share(cols.div_ceil(WIDTH), rows * lines * cols);
    let parts =
        map.chunks(share * lines).zip(out.reshape(rows, cols).chunks_mut(share * rows)).enumerate();
    threads.each(parts, |(i, (map, out))| {
        let finish = finish.map(|activation| &activation.lines()[i * share * rows..]);
        Arch::new().dispatch(ByLanes(Affine {
            left,
            map,
            cols: cols - i * share * WIDTH,
            finish,
            out,
        }));
    });
}

/// `out = left^T right`, then the sums of `right`'s columns: the gradient of a map from inputs
/// `left` and the gradient `right` of its outputs, laid out as the map is.
pub(super) fn gradient(left: &Panels, right: &Panels, out: &mut [PanelRow], threads: &Threads) {
    let rows = left.rows();
    let lines = left.cols() + 1;
    let cols = right.cols();
    assert_eq!(right.rows(), rows, "rows of a gradient");
    assert_eq!(out.len(), cols.div_ceil(WIDTH) * lines, "lines of a gradient");
    let share = threads.share(cols.div_ceil(WIDTH), rows * lines * cols);
    let parts = right.lines().chunks(share * rows).zip(out.chunks_mut(share * lines)).enumerate();
    threads.each(parts, |(i, (right, out))| {
        Arch::new().dispatch(ByLanes(Gradient {
            left,
            right,
            cols: cols - i * share * WIDTH,
            out,
        }));
    });
}

/// A computation on lines as vectors.
trait Kernel {
    /// Runs with lines of `V` vectors each.
    fn run<S: Simd, const V: usize>(self, simd: S);
}

/// Finds how many vectors a line is.
struct ByLanes<K>(K);

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
fn vectors<S: Simd, const V: usize>(lines: &[PanelRow]) -> &[[S::f32s; V]] {
    S::as_simd_f32s(bytemuck::cast_slice(lines)).0.as_chunks().0
}

/// The same, to write.
#[inline(always)]
fn vectors_mut<S: Simd, const V: usize>(lines: &mut [PanelRow]) -> &mut [[S::f32s; V]] {
    S::as_mut_simd_f32s(bytemuck::cast_slice_mut(lines)).0.as_chunks_mut().0
}

/// sum <- sum + x line
#[inline(always)]
fn add_product<S: Simd, const U: usize, const V: usize>(
    simd: S,
    sum: &mut [S::f32s; U],
    x: f32,
    line: &[S::f32s; V],
) {
    let x = simd.splat_f32s(x);
    for (sum, &vector) in sum.iter_mut().zip(line) {
        *sum = simd.mul_add_f32s(x, vector, *sum);
    }
}

/// Stores sums vector by vector (a slice's copy would go through memory), and zeros where they do
/// not reach.
#[inline(always)]
fn store<S: Simd, const U: usize, const V: usize>(
    simd: S,
    sums: &[[S::f32s; U]],
    out: &mut [[S::f32s; V]],
) {
    for (line, sum) in out.iter_mut().zip(sums) {
        for (v, vector) in line.iter_mut().enumerate() {
            *vector = if v < U { sum[v] } else { simd.splat_f32s(0.0) };
        }
    }
}

/// One panel of a result, computed in tiles.
trait Tiles {
    /// Computes and stores `HEIGHT` lines from `first` on, the first `U` vectors of each.
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, first: usize);
}

/// Computes `count` lines, of which `cols` values are wanted, in tiles as high as the registers
/// hold. A low tile waits for its few sums, so the last two share what is left.
#[inline(always)]
fn cover<S: Simd, const V: usize>(count: usize, cols: usize, tiles: &mut impl Tiles) {
    let narrow = V > 1 && cols <= S::F32_LANES;
    let mut first = 0;
    while first < count {
        let left = count - first;
        first += match if (7..12).contains(&left) { left.div_ceil(2) } else { left } {
            16.. if V == 1 => tile::<16, 1>(first, tiles),
            12.. if narrow => tile::<12, 1>(first, tiles),
            6.. if narrow => tile::<6, 1>(first, tiles),
            6.. => tile::<6, V>(first, tiles),
            5 => tile::<5, V>(first, tiles),
            4 => tile::<4, V>(first, tiles),
            3 => tile::<3, V>(first, tiles),
            2 => tile::<2, V>(first, tiles),
            _ => tile::<1, V>(first, tiles),
        };
    }
}

#[inline(always)]
fn tile<const HEIGHT: usize, const U: usize>(first: usize, tiles: &mut impl Tiles) -> usize {
    tiles.tile::<HEIGHT, U>(first);
    HEIGHT
}

/// Some panels of [`affine`]'s result, and the columns from the first of them on.
struct Affine<'a> {
    left: &'a Panels,
    map: &'a [PanelRow],
    cols: usize,
    finish: Finish<&'a [PanelRow]>,
    out: &'a mut [PanelRow],
}

impl Kernel for Affine<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let left = self.left;
        let rows = self.left.rows();
        let maps = vectors::<S, V>(self.map).chunks_exact(left.cols() + 1);
        let outs = vectors_mut::<S, V>(self.out).chunks_exact_mut(rows);
        for (panel, (map, out)) in maps.zip(outs).enumerate() {
            let finish = self.finish.map(|activation| &vectors::<S, V>(activation)[panel * rows..]);
            cover::<S, V>(
                rows,
                self.cols - panel * WIDTH,
                &mut AffinePanel { simd, left, map, finish, out },
            );
        }
    }
}

/// One panel of [`affine`]'s result; its lines are rows.
struct AffinePanel<'a, S: Simd, const V: usize> {
    simd: S,
    left: &'a Panels,
    map: &'a [[S::f32s; V]],
    finish: Finish<&'a [[S::f32s; V]]>,
    out: &'a mut [[S::f32s; V]],
}

impl<S: Simd, const V: usize> Tiles for AffinePanel<'_, S, V> {
    #[inline(always)]
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, row: usize) {
        let (map, start) = self.map.split_at(self.left.cols());
        let (whole, rest) = map.as_chunks::<WIDTH>();
        let mut panels = self.left.lines().chunks_exact(self.left.rows());
        let mut sums: [[S::f32s; U]; HEIGHT] = [std::array::from_fn(|v| start[0][v]); HEIGHT];
        // Whole panels have a loop of their own: of known length, it is unrolled and checks no
        // bounds.
        for (map, left) in whole.iter().zip(&mut panels) {
            let left = &left[row..row + HEIGHT];
            for (column, line) in map.iter().enumerate() {
                for (sum, left) in sums.iter_mut().zip(left) {
                    add_product(self.simd, sum, left.0[column], line);
                }
            }
        }
        for left in panels {
            let left = &left[row..row + HEIGHT];
            for (column, line) in rest.iter().enumerate() {
                for (sum, left) in sums.iter_mut().zip(left) {
                    add_product(self.simd, sum, left.0[column % WIDTH], line);
                }
            }
        }
        self.finish(row, &mut sums);
        store(self.simd, &sums, &mut self.out[row..row + HEIGHT]);
    }
}

impl<S: Simd, const V: usize> AffinePanel<'_, S, V> {
    #[inline(always)]
    fn finish<const HEIGHT: usize, const U: usize>(
        &self,
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
                // HEIGHT lines, not the rest of them: a long loop is unrolled only if its length is
                // known, and sums that a loop reaches by index live in memory. With AVX-512 an
                // update then takes three times as long.
                for (sum, activation) in sums.iter_mut().zip(&activation[row..row + HEIGHT]) {
                    for (sum, &activation) in sum.iter_mut().zip(activation) {
                        *sum =
                            simd.select_f32s(simd.greater_than_f32s(activation, zero), *sum, zero);
                    }
                }
            }
        }
    }
}

/// Some panels of [`gradient`]'s result, those of as many of `right`, and the columns from the
/// first of them on.
struct Gradient<'a> {
    left: &'a Panels,
    right: &'a [PanelRow],
    cols: usize,
    out: &'a mut [PanelRow],
}

impl Kernel for Gradient<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let rows = self.left.rows();
        let inputs = self.left.cols();
        let rights = vectors::<S, V>(self.right).chunks_exact(rows);
        let outs = vectors_mut::<S, V>(self.out).chunks_exact_mut(inputs + 1);
        for (panel, (right, out)) in rights.zip(outs).enumerate() {
            let (out, sums) = out.split_at_mut(inputs);
            for (left, out) in self.left.lines().chunks_exact(rows).zip(out.chunks_mut(WIDTH)) {
                let cols = self.cols - panel * WIDTH;
                cover::<S, V>(out.len(), cols, &mut GradientPanel { simd, left, right, out });
            }
            sums[0] = sum(simd, right);
        }
    }
}

/// Where a panel of inputs meets one of outputs in [`gradient`]'s result; its lines are inputs.
struct GradientPanel<'a, S: Simd, const V: usize> {
    simd: S,
    left: &'a [PanelRow],
    right: &'a [[S::f32s; V]],
    out: &'a mut [[S::f32s; V]],
}

impl<S: Simd, const V: usize> Tiles for GradientPanel<'_, S, V> {
    #[inline(always)]
    fn tile<const HEIGHT: usize, const U: usize>(&mut self, input: usize) {
        let mut sums = [[self.simd.splat_f32s(0.0); U]; HEIGHT];
        for (left, right) in self.left.iter().zip(self.right) {
            for (sum, &left) in sums.iter_mut().zip(&left.0[input..input + HEIGHT]) {
                add_product(self.simd, sum, left, right);
            }
        }
        store(self.simd, &sums, &mut self.out[input..input + HEIGHT]);
    }
}

/// The sum of lines.
#[inline(always)]
fn sum<S: Simd, const V: usize>(simd: S, lines: &[[S::f32s; V]]) -> [S::f32s; V] {
    let mut sums = [simd.splat_f32s(0.0); V];
    for line in lines {
        for (sum, &vector) in sums.iter_mut().zip(line) {
            *sum = simd.add_f32s(*sum, vector);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use copq::Rng;

    use super::*;

    /// Shapes with whole and partial panels, and tiles of every height.
    const SHAPES: [(usize, usize, usize); 5] =
        [(1, 1, 1), (3, 16, 17), (37, 23, 5), (13, 40, 32), (64, 3, 16)];

    fn values(count: usize, rng: &mut Rng) -> Vec<f32> {
        (0..count).map(|_| rng.normal() as f32).collect()
    }

    fn panels(rows: usize, dense: &[f32]) -> Panels {
        let mut panels = Panels::default();
        panels.set(rows, &[dense]);
        panels
    }

    fn dense(panels: &Panels) -> Vec<f32> {
        let mut out = vec![0.0; panels.rows() * panels.cols()];
        panels.get(0, &mut out);
        out
    }

    /// start + sum of products, one fused multiply-add after another.
    fn sum(start: f32, terms: impl Iterator<Item = (f32, f32)>) -> f32 {
        terms.fold(start, |sum, (a, b)| a.mul_add(b, sum))
    }

    #[test]
    fn affine_is_its_sums_to_the_bit() {
        let mut rng = Rng::with_stream(0, 0);
        for (rows, inputs, cols) in SHAPES {
            let left = values(rows * inputs, &mut rng);
            let map = values((inputs + 1) * cols, &mut rng);
            let activation: Vec<_> =
                values(rows * cols, &mut rng).iter().map(|x| x.max(0.0)).collect();
            let wanted = |finish: fn(f32, f32) -> f32| -> Vec<f32> {
                let element = |at: usize| {
                    let row = at / cols;
                    let col = at % cols;
                    let terms = (0..inputs).map(|k| (left[row * inputs + k], map[k * cols + col]));
                    finish(sum(map[inputs * cols + col], terms), activation[at])
                };
                (0..rows * cols).map(element).collect()
            };
            let left = panels(rows, &left);
            let map = panels(inputs + 1, &map);
            let activation = panels(rows, &activation);
            let mut out = Panels::default();
            affine(&left, map.lines(), cols, Finish::Keep, &mut out, &Threads::default());
            assert_eq!(dense(&out), wanted(|sum, _| sum));
            affine(&left, map.lines(), cols, Finish::Relu, &mut out, &Threads::default());
            assert_eq!(dense(&out), wanted(|sum, _| sum.max(0.0)));
            affine(
                &left,
                map.lines(),
                cols,
                Finish::Mask(&activation),
                &mut out,
                &Threads::default(),
            );
            assert_eq!(
                dense(&out),
                wanted(|sum, activation| if activation > 0.0 { sum } else { 0.0 })
            );
        }
    }

    #[test]
    fn gradient_is_its_sums_to_the_bit() {
        let mut rng = Rng::with_stream(1, 0);
        for (rows, inputs, cols) in SHAPES {
            let left = values(rows * inputs, &mut rng);
            let right = values(rows * cols, &mut rng);
            let element = |at: usize| {
                let input = at / cols;
                let col = at % cols;
                let weight =
                    |row: usize| if input < inputs { left[row * inputs + input] } else { 1.0 };
                sum(0.0, (0..rows).map(|row| (weight(row), right[row * cols + col])))
            };
            let wanted: Vec<_> = (0..(inputs + 1) * cols).map(element).collect();
            let mut out = Panels::default();
            gradient(
                &panels(rows, &left),
                &panels(rows, &right),
                out.reshape(inputs + 1, cols),
                &Threads::default(),
            );
            assert_eq!(dense(&out), wanted);
        }
    }

    /// A forward pass and a gradient by one kind of vectors.
    fn both<S: Simd>(simd: S, left: &Panels, map: &Panels, right: &Panels) -> [Vec<f32>; 2] {
        let mut out = Panels::default();
        let mut grad = Panels::default();
        let rows = left.rows();
        let cols = map.cols();
        let finish = Finish::Relu;
        simd.vectorize(ByLanes(Affine {
            left,
            map: map.lines(),
            cols,
            finish,
            out: out.reshape(rows, cols),
        }));
        let cols = right.cols();
        let lines = grad.reshape(left.cols() + 1, cols);
        let right = right.lines();
        simd.vectorize(ByLanes(Gradient { left, right, cols, out: lines }));
        [dense(&out), dense(&grad)]
    }

    #[test]
    fn vectors_of_any_width_give_the_same_bits() {
        let mut rng = Rng::with_stream(2, 0);
        for (rows, inputs, cols) in SHAPES {
            let left = panels(rows, &values(rows * inputs, &mut rng));
            let map = panels(inputs + 1, &values((inputs + 1) * cols, &mut rng));
            let right = panels(rows, &values(rows * cols, &mut rng));
            let scalars = both(pulp::Scalar, &left, &map, &right);
            assert_eq!(both(pulp::Scalar128b, &left, &map, &right), scalars);
            assert_eq!(both(pulp::Scalar256b, &left, &map, &right), scalars);
            assert_eq!(both(pulp::Scalar512b, &left, &map, &right), scalars);
            let mut out = Panels::default();
            let mut grad = Panels::default();
            affine(&left, map.lines(), cols, Finish::Relu, &mut out, &Threads::default());
            gradient(&left, &right, grad.reshape(inputs + 1, cols), &Threads::default());
            assert_eq!([dense(&out), dense(&grad)], scalars);
        }
    }

    #[test]
    fn threads_that_share_a_product_give_the_same_bits() {
        let rows = 257;
        let inputs = 130;
        let cols = 74;
        let mut rng = Rng::with_stream(3, 0);
        let left = panels(rows, &values(rows * inputs, &mut rng));
        let map = panels(inputs + 1, &values((inputs + 1) * cols, &mut rng));
        let right = panels(rows, &values(rows * cols, &mut rng));
        let run = |count| {
            let threads = Threads::new(count).unwrap();
            let shares = cols
                .div_ceil(WIDTH)
                .div_ceil(threads.share(cols.div_ceil(WIDTH), rows * inputs * cols));
            assert_eq!(shares, count, "the product is large enough to be shared");
            let mut out = Panels::default();
            let mut grad = Panels::default();
            affine(&left, map.lines(), cols, Finish::Mask(&right), &mut out, &threads);
            gradient(&left, &right, grad.reshape(inputs + 1, cols), &threads);
            [dense(&out), dense(&grad)]
        };
        let one = run(1);
        assert_eq!(run(2), one);
        assert_eq!(run(3), one);
    }

    #[test]
    fn relu_is_pytorchs_at_zero_and_at_nan() {
        let left = panels(4, &[-1.0, 0.0, f32::NAN, 2.0]);
        let map = panels(2, &[1.0, 0.0]);
        let mut out = Panels::default();
        affine(&left, map.lines(), 1, Finish::Relu, &mut out, &Threads::default());
        let activation = dense(&out);
        assert!(activation[..2] == [0.0, 0.0] && activation[2].is_nan() && activation[3] == 2.0);
        let mut grad = Panels::default();
        affine(
            &panels(4, &[1.0; 4]),
            map.lines(),
            1,
            Finish::Mask(&out),
            &mut grad,
            &Threads::default(),
        );
        assert_eq!(dense(&grad), [0.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    #[should_panic(expected = "lines of a map")]
    fn shapes_that_do_not_fit() {
        let left = panels(2, &[0.0; 6]);
        let map = [PanelRow::default(); 3];
        let mut out = Panels::default();
        affine(&left, &map, 2, Finish::Keep, &mut out, &Threads::default());
    }
}
