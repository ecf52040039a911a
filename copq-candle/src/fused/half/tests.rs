use copq::Rng;

use super::super::adam::{self, Adam};
use super::super::matrices::{self, SHAPES, panels};
use super::*;

/// Numbers of many sizes, and special ones.
fn values(count: usize, rng: &mut Rng) -> Vec<f32> {
    let draw = |i| {
        let x = rng.normal() as f32;
        match i % 13 {
            0 => 0.0,
            1 => x * 2f32.powi(-54),
            2 => x * 2f32.powi(-99),
            3 => x * 2f32.powi(20),
            4 => -0.0,
            _ => x,
        }
    };
    (0..count).map(draw).collect()
}

fn dense(panels: &Panels) -> Vec<u32> {
    matrices::dense(panels).iter().map(|x| x.to_bits()).collect()
}

/// Both factors, of every kind that this processor has.
fn kinds() -> Vec<(Across, Down)> {
    #[cfg(target_arch = "x86_64")]
    let packed = packed::Bf16::try_new().map(|bf16| {
        (Across::Packed(packed::Across::new(bf16)), Down::Packed(packed::Down::new(bf16)))
    });
    #[cfg(not(target_arch = "x86_64"))]
    let packed = None;
    let rounded = (Across::Rounded(Panels::default()), Down::Rounded(Panels::default()));
    std::iter::once(rounded).chain(packed).collect()
}

/// `left^T right`, then the sums of `right`'s columns.
fn gradient(left: &Down, right: &Down, out: &mut [PanelRow]) {
    match (left, right) {
        (Down::Rounded(left), Down::Rounded(right)) => {
            super::gradient::gradient(left, right, out, &Threads::default());
        }
        #[cfg(target_arch = "x86_64")]
        (Down::Packed(left), Down::Packed(right)) => {
            packed::gradient(left, right, super::gradient::Stored(out));
        }
        #[cfg(target_arch = "x86_64")]
        _ => panic!("two kinds"),
    }
}

fn down(kind: &Down, from: &Panels) -> Down {
    let mut down = kind.clone();
    down.set(from);
    down
}

fn rounded(x: f32) -> f32 {
    let mut to = [PanelRow::default(); 2];
    Arch::new().dispatch(ByLanes(Rows { from: &[PanelRow([x; WIDTH])], to: &mut to }));
    to[1].0[3]
}

/// The nearest bf16 in plain words.
fn nearest(x: f32) -> f32 {
    let down = f32::from_bits(x.to_bits() & 0xffff_0000);
    let up = f32::from_bits((x.to_bits() & 0xffff_0000).wrapping_add(0x1_0000));
    let [below, above] = [down, up].map(|y| (f64::from(y) - f64::from(x)).abs());
    let down_is_even = down.to_bits() & 0x1_0000 == 0;
    if below < above || (below == above && down_is_even) { down } else { up }
}

/// The definition: pairs of fused multiply-adds, the odd one first; a missing one is zero times the
/// factor that is there.
fn sum(start: f32, terms: &[(f32, f32)]) -> u32 {
    let sum = terms.chunks(2).fold(start, |sum, pair| {
        let (a, b) = *pair.get(1).unwrap_or(&(0.0, 0.0));
        let sum = rounded(a).mul_add(rounded(b), sum);
        rounded(pair[0].0).mul_add(rounded(pair[0].1), sum)
    });
    sum.to_bits()
}

/// Where roundings could differ, and what becomes of it.
fn edges() -> [(f32, f32); 10] {
    let near = 1.0 + 2f32.powi(-8); // Half way between two.
    [
        (1.0, 1.0),
        (near, 1.0),
        (f32::from_bits(near.to_bits() + 1), 1.0 + 2f32.powi(-7)),
        (1.0 + 3.0 * 2f32.powi(-8), 1.0 + 2f32.powi(-6)),
        (-near, -1.0),
        (TINY, TINY),
        (f32::from_bits(TINY.to_bits() - 1), 0.0),
        (-f32::MIN_POSITIVE, 0.0),
        (f32::MAX, f32::INFINITY),
        (f32::NEG_INFINITY, f32::NEG_INFINITY),
    ]
}

#[test]
fn every_kind_rounds_alike() {
    for (x, wanted) in edges().into_iter().chain([(f32::NAN, f32::NAN)]) {
        for (mut across, mut weights) in kinds() {
            // x times one, and one times x.
            for (left, map) in [(x, 1.0), (1.0, x)] {
                across.set(&panels(1, &[left]));
                weights.set_map(panels(2, &[map, 0.0]).lines(), 1);
                let mut out = Panels::default();
                affine(&across, &weights, Finish::Keep, &mut out, &Threads::default());
                let got = matrices::dense(&out)[0];
                assert!(got == wanted || got.is_nan() && wanted.is_nan(), "{x}: {got}");
            }
        }
    }
}

#[test]
fn rounding_is_to_the_nearest_and_to_even() {
    for (x, wanted) in edges() {
        assert_eq!(rounded(x).to_bits(), wanted.to_bits(), "{x}");
    }
    assert!(rounded(f32::NAN).is_nan());
    assert!(rounded(f32::from_bits(0x7fff_ffff)).is_nan());
    let mut rng = Rng::with_stream(0, 0);
    for x in values(10_000, &mut rng).into_iter().filter(|x| x.abs() >= TINY) {
        assert_eq!(rounded(x), nearest(x), "{x}");
    }
}

/// Both layouts of a matrix by one kind of vectors.
fn both<S: Simd>(simd: S, from: &Panels) -> [Vec<u32>; 2] {
    let mut down = vec![PanelRow::default(); even(from.rows())];
    let mut across = vec![PanelRow::default(); from.rows()];
    simd.vectorize(ByLanes(Rows { from: from.lines(), to: &mut down }));
    simd.vectorize(ByLanes(Columns { from: from.lines(), to: &mut across }));
    [down, across].map(|lines| bytemuck::cast_slice(&lines).to_vec())
}

#[test]
fn vectors_of_any_width_round_alike() {
    let from = panels(37, &values(37 * WIDTH, &mut Rng::with_stream(4, 0)));
    let scalars = both(pulp::Scalar, &from);
    assert_eq!(both(pulp::Scalar128b, &from), scalars);
    assert_eq!(both(pulp::Scalar256b, &from), scalars);
    assert_eq!(both(pulp::Scalar512b, &from), scalars);
    let mut across = Across::Rounded(Panels::default());
    let mut down = Down::Rounded(Panels::default());
    across.set(&from);
    down.set(&from);
    let (Across::Rounded(across), Down::Rounded(down)) = (&across, &down) else { unreachable!() };
    let lines = |panels: &Panels| bytemuck::cast_slice::<_, u32>(panels.lines()).to_vec();
    assert_eq!([lines(down), lines(across)], scalars);
}

#[test]
fn a_product_is_its_sums_to_the_bit() {
    let mut rng = Rng::with_stream(1, 0);
    for (rows, inputs, cols) in SHAPES {
        let left = values(rows * inputs, &mut rng);
        let map = values((inputs + 1) * cols, &mut rng);
        let activation = panels(rows, &values(rows * cols, &mut rng));
        let wanted = |at: usize| {
            let (row, col) = (at / cols, at % cols);
            let terms: Vec<_> =
                (0..inputs).map(|k| (left[row * inputs + k], map[k * cols + col])).collect();
            let start = map[inputs * cols + col];
            sum(if start.abs() < TINY_START { 0.0 } else { start }, &terms)
        };
        let wanted: Vec<_> = (0..rows * cols).map(wanted).collect();
        let map = panels(inputs + 1, &map);
        for (mut across, mut weights) in kinds() {
            across.set(&panels(rows, &left));
            weights.set_map(map.lines(), cols);
            let mut out = Panels::default();
            affine(&across, &weights, Finish::Keep, &mut out, &Threads::default());
            assert_eq!(dense(&out), wanted, "{rows} {inputs} {cols}");
            affine(&across, &weights, Finish::Mask(&activation), &mut out, &Threads::default());
            let mask = dense(&activation);
            for ((out, wanted), mask) in dense(&out).iter().zip(&wanted).zip(mask) {
                assert_eq!(*out, if f32::from_bits(mask) > 0.0 { *wanted } else { 0 });
            }
        }
    }
}

#[test]
fn a_gradient_is_its_sums_to_the_bit() {
    let mut rng = Rng::with_stream(2, 0);
    for (rows, inputs, cols) in SHAPES {
        let left = values(rows * inputs, &mut rng);
        let right = values(rows * cols, &mut rng);
        let wanted = |at: usize| {
            let (input, col) = (at / cols, at % cols);
            let weight = |row: usize| if input < inputs { left[row * inputs + input] } else { 1.0 };
            let terms: Vec<_> =
                (0..rows).map(|row| (weight(row), right[row * cols + col])).collect();
            sum(0.0, &terms)
        };
        let wanted: Vec<_> = (0..(inputs + 1) * cols).map(wanted).collect();
        for (_, kind) in kinds() {
            let left = down(&kind, &panels(rows, &left));
            let right = down(&kind, &panels(rows, &right));
            let mut out = Panels::default();
            gradient(&left, &right, out.reshape(inputs + 1, cols));
            assert_eq!(dense(&out), wanted, "{rows} {inputs} {cols}");
        }
    }
}

#[test]
fn every_kind_takes_the_step_of_its_gradient() {
    let mut rng = Rng::with_stream(3, 0);
    let (rows, inputs, cols) = (67, 40, 37);
    let left = panels(rows, &values(rows * inputs, &mut rng));
    let right = panels(rows, &values(rows * cols, &mut rng));
    let map = panels(inputs + 1, &values((inputs + 1) * cols, &mut rng));
    let stepped = |descend: &dyn Fn(Descent<'_>)| {
        let mut parts = [(); 4].map(|()| map.clone());
        parts[3].lines_mut().iter_mut().flat_map(|line| &mut line.0).for_each(|v| *v *= *v);
        let [online, target, m, v] = parts.each_mut().map(Panels::lines_mut);
        descend(Descent { online, target, m, v, adam: Adam::new(1e-3, 7, 0.005) });
        parts.map(|part| dense(&part))
    };
    for (_, kind) in kinds() {
        let [left, right] = [&left, &right].map(|factor| down(&kind, factor));
        // The gradient in memory first, then Adam over it.
        let mut grad = Panels::default();
        gradient(&left, &right, grad.reshape(inputs + 1, cols));
        let wanted = stepped(&|map| adam::step(map, grad.lines()));
        assert!(stepped(&|map| descend(&left, &right, map, &Threads::default())) == wanted);
    }
}
