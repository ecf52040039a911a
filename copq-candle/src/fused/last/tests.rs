use copq::Rng;

use super::super::adam::{self, Adam};
use super::super::layout::Layout;
use super::super::matrices::{SHAPES, panels};
use super::*;
use crate::shape::Shape;

fn values(count: usize, rng: &mut Rng) -> Vec<f32> {
    (0..count).map(|_| rng.normal() as f32).collect()
}

/// A layer, its parameters as PyTorch lays them out, and its map.
fn layer(inputs: usize, outputs: usize, rng: &mut Rng) -> (Layer, Vec<f32>, Vec<PanelRow>) {
    let shape = Shape::new(inputs, &[], outputs);
    let flat = values(shape.len(), rng);
    let map = Layout::new(shape.clone()).pack(&flat);
    (shape.layers()[0].clone(), flat, map)
}

/// The definition: sixteen sums of every sixteenth product, then halves of them, then the bias.
fn dot(a: &[f32], b: &[f32], bias: f32) -> f32 {
    let mut sums = [0f32; WIDTH];
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        sums[i % WIDTH] = a.mul_add(*b, sums[i % WIDTH]);
    }
    for half in [8, 4, 2, 1] {
        (0..half).for_each(|i| sums[i] += sums[i + half]);
    }
    sums[0] + bias
}

/// A forward pass and a gradient by one kind of vectors.
fn both<S: Simd>(simd: S, input: &Panels, map: &[PanelRow], right: &Panels) -> [Vec<f32>; 2] {
    let count = right.cols();
    let mut out = vec![0.0; input.rows() * count];
    let (weight, bias) = map.split_at(weight_lines(input.cols(), count));
    let bias = bytemuck::cast_slice(bias);
    simd.vectorize(ByLanes(Affine { input, map: weight, bias, count, out: &mut out }));
    let mut grad = vec![PanelRow::default(); map.len()];
    simd.vectorize(ByLanes(Gradient { input, right, sink: Stored(&mut grad) }));
    [out, bytemuck::cast_slice(&grad).to_vec()]
}

#[test]
fn both_passes_are_their_sums_to_the_bit_by_vectors_of_any_width() {
    let mut rng = Rng::with_stream(0, 0);
    for (rows, inputs, outputs) in SHAPES {
        let (layer, flat, map) = layer(inputs, outputs, &mut rng);
        let input = values(rows * inputs, &mut rng);
        let grad = values(rows * outputs, &mut rng);
        let (left, right) = (panels(rows, &input), panels(rows, &grad));

        let row = |row: usize| &input[row * inputs..][..inputs];
        let weight = |output: usize| &flat[layer.weight()][output * inputs..][..inputs];
        let element = |at: usize| {
            let (r, output) = (at / outputs, at % outputs);
            dot(row(r), weight(output), flat[layer.bias()][output])
        };
        let wanted: Vec<_> = (0..rows * outputs).map(element).collect();
        let mut out = vec![0.0; wanted.len()];
        affine(&left, &map, &mut out);
        assert_eq!(out, wanted, "{rows} {inputs} {outputs}");

        let column = |output: usize| (0..rows).map(move |row| row * outputs + output);
        let mut slopes = vec![0f32; flat.len()];
        for output in 0..outputs {
            for i in 0..inputs {
                let terms = column(output).enumerate().map(|(r, at)| (grad[at], row(r)[i]));
                let sum = terms.fold(0.0, |sum, (a, b)| f32::mul_add(a, b, sum));
                slopes[layer.weight()][output * inputs + i] = sum;
            }
            slopes[layer.bias()][output] = column(output).fold(0.0, |sum, at| sum + grad[at]);
        }
        let wanted = Layout::new(Shape::new(inputs, &[], outputs)).pack(&slopes);
        let mut got = vec![PanelRow::default(); map.len()];
        gradient(&left, &right, &mut got);
        assert_eq!(got, wanted, "{rows} {inputs} {outputs}");

        let scalars = both(pulp::Scalar, &left, &map, &right);
        assert_eq!(scalars, [out, bytemuck::cast_slice(&got).to_vec()]);
        assert_eq!(both(pulp::Scalar128b, &left, &map, &right), scalars);
        assert_eq!(both(pulp::Scalar256b, &left, &map, &right), scalars);
        assert_eq!(both(pulp::Scalar512b, &left, &map, &right), scalars);
    }
}

#[test]
fn a_step_in_registers_is_the_step_in_memory_and_padding_stays_zero() {
    let mut rng = Rng::with_stream(1, 0);
    for (rows, inputs, outputs) in SHAPES {
        let (layer, flat, online) = layer(inputs, outputs, &mut rng);
        let input = panels(rows, &values(rows * inputs, &mut rng));
        let right = panels(rows, &values(rows * outputs, &mut rng));
        let zeros = vec![PanelRow::default(); online.len()];
        let mut here = [online.clone(), online, zeros.clone(), zeros.clone()];
        let mut there = here.clone();
        let map = |parts: &mut [Vec<PanelRow>; 4], run: &mut dyn FnMut(Descent<'_>)| {
            let [online, target, m, v] = parts.each_mut().map(Vec::as_mut_slice);
            run(Descent { online, target, m, v, adam: Adam::new(1e-3, 1, 0.005) });
        };
        let mut grad = zeros;
        gradient(&input, &right, &mut grad);
        map(&mut here, &mut |map| adam::step(map, &grad));
        map(&mut there, &mut |map| descend(&input, &right, map));
        assert_eq!(here, there);

        // All that is no parameter is where a flat buffer of ones leaves zeros.
        let ones = Layout::new(Shape::new(inputs, &[], outputs)).pack(&vec![1.0; flat.len()]);
        assert_eq!(ones.len(), lines(&layer));
        for part in &here {
            for (line, one) in part.iter().zip(&ones) {
                assert!(line.0.iter().zip(&one.0).all(|(x, one)| *one == 1.0 || *x == 0.0));
            }
        }
    }
}
