//! The matrix products of a network: as fast as the processor multiplies, and the same bits on
//! every processor.
//!
//! A tile of the result stays in registers while the products of its elements are added one after
//! another by fused multiply-adds, in an order that depends on nothing. Wider vectors compute more
//! elements at once, never parts of one.

use pulp::{Arch, Simd};

use super::panels::{PanelRow, Panels, WIDTH};
use super::threads::Threads;
use super::tiles::{
    ByLanes, Kernel, Sums, Tiles, add_products, array, block, cover, put, vectors, vectors_mut,
};

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
    /// What those before `from` have added up to, bias and all.
    sums: Option<&'a Panels>,
}

impl<'a> Inputs<'a> {
    /// All of them.
    pub fn all(values: &'a Panels) -> Self {
        Self { values, from: 0, to: values.cols(), sums: None }
    }

    /// The first `count`.
    pub fn first(values: &'a Panels, count: usize) -> Self {
        Self { to: count, ..Self::all(values) }
    }

    /// All but the first `count`, which have added up to `sums`.
    pub fn rest(values: &'a Panels, count: usize, sums: &'a Panels) -> Self {
        Self { from: count, sums: Some(sums), ..Self::all(values) }
    }
}

/// `out = finish(inputs * map + start)`. A map of `cols` columns is panels of a line for every input
/// and one more, which is what every row of the result starts from.
///
/// # Panics
/// If the shapes do not fit together, as in all of this module: layers are fixed and batches are
/// checked before.
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

/// Some panels of [`affine`]'s result, and the columns from the first of them on.
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
            // A whole panel has a loop of its own: it is of known length, and checks no bounds.
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
                // HEIGHT lines, not the rest of them: a long loop is unrolled only if its length is
                // known, and sums that a loop reaches by index live in memory. With AVX-512 an
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

#[cfg(test)]
mod tests {
    use copq::Rng;

    use super::super::adam::{self, Adam};
    use super::super::gradient::{Descent, Gradient, Stored, descend, gradient};
    use super::*;

    /// Shapes with whole and partial panels, and tiles of every height.
    const SHAPES: [(usize, usize, usize); 8] = [
        (1, 1, 1),
        (3, 16, 17),
        (37, 23, 5),
        (13, 40, 32),
        (64, 3, 16),
        (29, 18, 101),
        (70, 40, 3),
        (131, 33, 8),
    ];

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
            affine(
                Inputs::all(&left),
                map.lines(),
                cols,
                Finish::Keep,
                &mut out,
                &Threads::default(),
            );
            assert_eq!(dense(&out), wanted(|sum, _| sum));
            affine(
                Inputs::all(&left),
                map.lines(),
                cols,
                Finish::Relu,
                &mut out,
                &Threads::default(),
            );
            assert_eq!(dense(&out), wanted(|sum, _| sum.max(0.0)));
            affine(
                Inputs::all(&left),
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
    fn a_product_in_two_parts_is_the_same_to_the_bit() {
        let mut rng = Rng::with_stream(5, 0);
        let threads = Threads::default();
        for (rows, inputs, cols) in SHAPES {
            let left = panels(rows, &values(rows * inputs, &mut rng));
            let map = panels(inputs + 1, &values((inputs + 1) * cols, &mut rng));
            let mut whole = Panels::default();
            affine(Inputs::all(&left), map.lines(), cols, Finish::Relu, &mut whole, &threads);
            for count in 0..=inputs {
                let mut sums = Panels::default();
                let mut out = Panels::default();
                let first = Inputs::first(&left, count);
                affine(first, map.lines(), cols, Finish::Keep, &mut sums, &threads);
                let rest = Inputs::rest(&left, count, &sums);
                affine(rest, map.lines(), cols, Finish::Relu, &mut out, &threads);
                assert_eq!(out.lines(), whole.lines(), "{count} of {inputs} inputs");
            }
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
            inputs: Inputs::all(left),
            sums: None,
            map: map.lines(),
            cols,
            finish,
            out: out.reshape(rows, cols),
        }));
        let cols = right.cols();
        let lines = grad.reshape(left.cols() + 1, cols);
        let right = right.lines();
        simd.vectorize(ByLanes(Gradient { left, right, cols, sink: Stored(lines) }));
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
            affine(
                Inputs::all(&left),
                map.lines(),
                cols,
                Finish::Relu,
                &mut out,
                &Threads::default(),
            );
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
            affine(Inputs::all(&left), map.lines(), cols, Finish::Mask(&right), &mut out, &threads);
            gradient(&left, &right, grad.reshape(inputs + 1, cols), &threads);
            [dense(&out), dense(&grad)]
        };
        let one = run(1);
        assert_eq!(run(2), one);
        assert_eq!(run(3), one);
    }

    #[test]
    fn a_step_in_registers_is_the_step_in_memory() {
        let mut rng = Rng::with_stream(4, 0);
        let shapes = SHAPES.into_iter().chain([(257, 130, 74)]);
        for ((rows, inputs, cols), threads) in shapes.zip([1, 1, 1, 1, 1, 1, 1, 1, 3]) {
            let threads = Threads::new(threads).unwrap();
            let left = panels(rows, &values(rows * inputs, &mut rng));
            let right = panels(rows, &values(rows * cols, &mut rng));
            let part = |rng: &mut Rng| panels(inputs + 1, &values((inputs + 1) * cols, rng));
            let mut here = [(); 4].map(|()| part(&mut rng));
            here[3].lines_mut().iter_mut().flat_map(|line| &mut line.0).for_each(|v| *v *= *v);
            let mut there = here.clone();
            let adam = Adam::new(1e-3, 7, 0.005);
            let map = |parts: &mut [Panels; 4], run: &mut dyn FnMut(Descent<'_>)| {
                let [online, target, m, v] = parts.each_mut().map(Panels::lines_mut);
                run(Descent { online, target, m, v, adam });
            };
            let mut grad = Panels::default();
            gradient(&left, &right, grad.reshape(inputs + 1, cols), &threads);
            map(&mut here, &mut |map| adam::step(map, grad.lines()));
            map(&mut there, &mut |map| descend(&left, &right, map, &threads));
            for (here, there) in here.iter().zip(&there) {
                assert_eq!(here.lines(), there.lines());
            }
        }
    }

    #[test]
    fn relu_is_pytorchs_at_zero_and_at_nan() {
        let left = panels(4, &[-1.0, 0.0, f32::NAN, 2.0]);
        let map = panels(2, &[1.0, 0.0]);
        let mut out = Panels::default();
        affine(Inputs::all(&left), map.lines(), 1, Finish::Relu, &mut out, &Threads::default());
        let activation = dense(&out);
        assert!(activation[..2] == [0.0, 0.0] && activation[2].is_nan() && activation[3] == 2.0);
        let mut grad = Panels::default();
        affine(
            Inputs::all(&panels(4, &[1.0; 4])),
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
        affine(Inputs::all(&left), &map, 2, Finish::Keep, &mut out, &Threads::default());
    }
}
