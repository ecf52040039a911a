use copq::Rng;

use super::super::adam::{self, Adam};
use super::super::gradient::{Descent, Gradient, Stored, descend, gradient};
use super::super::matrices::{SHAPES, dense, panels};
use super::*;

fn values(count: usize, rng: &mut Rng) -> Vec<f32> {
    (0..count).map(|_| rng.normal() as f32).collect()
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
        let activation: Vec<_> = values(rows * cols, &mut rng).iter().map(|x| x.max(0.0)).collect();
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
        affine(Inputs::all(&left), map.lines(), cols, Finish::Keep, &mut out, &Threads::default());
        assert_eq!(dense(&out), wanted(|sum, _| sum));
        affine(Inputs::all(&left), map.lines(), cols, Finish::Relu, &mut out, &Threads::default());
        assert_eq!(dense(&out), wanted(|sum, _| sum.max(0.0)));
        affine(
            Inputs::all(&left),
            map.lines(),
            cols,
            Finish::Mask(&activation),
            &mut out,
            &Threads::default(),
        );
        assert_eq!(dense(&out), wanted(|sum, activation| if activation > 0.0 { sum } else { 0.0 }));
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
            let weight = |row: usize| if input < inputs { left[row * inputs + input] } else { 1.0 };
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
        affine(Inputs::all(&left), map.lines(), cols, Finish::Relu, &mut out, &Threads::default());
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
    for ((rows, inputs, cols), threads) in shapes.zip([1; 12].into_iter().chain([3])) {
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
