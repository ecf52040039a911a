//! Products of sixteen-bit numbers (bf16), for which some processors have an instruction.
//!
//! One definition holds for every processor. Both factors are rounded to the nearest bf16, ties to
//! even. Factors below 2^-55 become zero, so that no sum is ever too small for a normal number.
//! Products of two bf16 are exact in f32. They are added by fused multiply-adds in pairs, the odd
//! one of a pair first: 1, 0, 3, 2 and so on, with a zero where one is missing. The instruction
//! does this, and so do the f32 products on rounded factors that lie in this order.

#[cfg(target_arch = "x86_64")]
mod packed;
#[cfg(test)]
mod tests;

use pulp::{Arch, Simd};

use super::gradient::{self, Descent};
use super::panels::{PanelRow, Panels, WIDTH};
use super::product::{self, Finish, Inputs};
use super::threads::Threads;
use super::tiles::{ByLanes, Kernel, vectors, vectors_mut};

/// The left factor of [`affine`]; its columns are summed over.
#[derive(Clone, Debug)]
pub(super) enum Across {
    /// Rounded, neighbouring columns exchanged.
    Rounded(Panels),
    /// Two neighbouring columns in a word.
    #[cfg(target_arch = "x86_64")]
    Packed(packed::Across),
}

/// A factor whose rows are summed over: the map of [`affine`], and both factors of [`descend`].
#[derive(Clone, Debug)]
pub(super) enum Down {
    /// Rounded, neighbouring rows exchanged.
    Rounded(Panels),
    /// Two neighbouring rows in a word.
    #[cfg(target_arch = "x86_64")]
    Packed(packed::Down),
}

impl Default for Across {
    /// The kind that is faster on this processor.
    fn default() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(bf16) = packed::where_faster() {
            return Self::Packed(packed::Across::new(bf16));
        }
        Self::Rounded(Panels::default())
    }
}

impl Default for Down {
    /// The kind that is faster on this processor.
    fn default() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(bf16) = packed::where_faster() {
            return Self::Packed(packed::Down::new(bf16));
        }
        Self::Rounded(Panels::default())
    }
}

impl Across {
    /// Takes the values of a matrix.
    pub fn set(&mut self, from: &Panels) {
        match self {
            Self::Rounded(to) => {
                let to = to.reshape(from.rows(), even(from.cols()));
                Arch::new().dispatch(ByLanes(Columns { from: from.lines(), to }));
            }
            #[cfg(target_arch = "x86_64")]
            Self::Packed(packed) => packed.set(from),
        }
    }
}

impl Down {
    /// Takes the values of a matrix.
    pub fn set(&mut self, from: &Panels) {
        match self {
            Self::Rounded(to) => {
                let rows = even(from.rows());
                let to = to.reshape(rows, from.cols());
                for (from, to) in from.lines().chunks(from.rows()).zip(to.chunks_mut(rows)) {
                    Arch::new().dispatch(ByLanes(Rows { from, to }));
                }
            }
            #[cfg(target_arch = "x86_64")]
            Self::Packed(packed) => packed.set(from),
        }
    }

    /// Takes the values of a map of `cols` columns. The last line of a panel, from which its result
    /// starts, is not rounded, but becomes zero below 2^-100.
    pub fn set_map(&mut self, map: &[PanelRow], cols: usize) {
        match self {
            Self::Rounded(to) => {
                let lines = map.len() / cols.div_ceil(WIDTH);
                let own = even(lines - 1) + 1;
                let to = to.reshape(own, cols);
                for (from, to) in map.chunks_exact(lines).zip(to.chunks_exact_mut(own)) {
                    to[own - 1] = start(&from[lines - 1]);
                    let (from, to) = (&from[..lines - 1], &mut to[..own - 1]);
                    Arch::new().dispatch(ByLanes(Rows { from, to }));
                }
            }
            #[cfg(target_arch = "x86_64")]
            Self::Packed(packed) => packed.set_map(map, cols),
        }
    }
}

/// `out = finish(left * map + start)`; the packed kind runs on one thread.
///
/// # Panics
/// If the shapes do not match or the two factors are of different kinds, as in all of this module.
pub(super) fn affine(
    left: &Across,
    map: &Down,
    finish: Finish<&Panels>,
    out: &mut Panels,
    threads: &Threads,
) {
    match (left, map) {
        (Across::Rounded(left), Down::Rounded(map)) => {
            product::affine(Inputs::all(left), map.lines(), map.cols(), finish, out, threads);
        }
        #[cfg(target_arch = "x86_64")]
        (Across::Packed(left), Down::Packed(map)) => packed::affine(left, map, finish, out),
        #[cfg(target_arch = "x86_64")]
        _ => unreachable!("all factors of a process are of one kind"),
    }
}

/// One step of a map along `left^T right` and the sums of `right`'s columns; the packed kind runs
/// on one thread.
pub(super) fn descend(left: &Down, right: &Down, map: Descent<'_>, threads: &Threads) {
    match (left, right) {
        (Down::Rounded(left), Down::Rounded(right)) => {
            gradient::descend(left, right, map, threads);
        }
        #[cfg(target_arch = "x86_64")]
        (Down::Packed(left), Down::Packed(right)) => packed::gradient(left, right, map),
        #[cfg(target_arch = "x86_64")]
        _ => unreachable!("all factors of a process are of one kind"),
    }
}

/// Factors below this become zero, so that every product is a multiple of 2^-124.
const TINY: f32 = f32::from_bits((127 - 55) << 23);

/// Starts below this become zero.
const TINY_START: f32 = f32::from_bits((127 - 100) << 23);

/// The nearest bf16, ties to even; zero below 2^-55. NaN stays NaN.
#[inline(always)]
fn round<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let bits = simd.transmute_u32s_f32s(x);
    let last = simd.wrapping_dyn_shr_u32s(bits, simd.splat_u32s(16));
    let last = simd.and_u32s(last, simd.splat_u32s(1));
    let up = simd.add_u32s(simd.add_u32s(bits, simd.splat_u32s(0x7fff)), last);
    let nearest = simd.transmute_f32s_u32s(simd.and_u32s(up, simd.splat_u32s(0xffff_0000)));
    let is_tiny = simd.less_than_f32s(simd.abs_f32s(x), simd.splat_f32s(TINY));
    let rounded = simd.select_f32s(is_tiny, simd.splat_f32s(0.0), nearest);
    simd.select_f32s(simd.equal_f32s(x, x), rounded, simd.splat_f32s(f32::NAN))
}

/// A line that a result starts from, with small values set to zero.
fn start(line: &PanelRow) -> PanelRow {
    PanelRow(line.0.map(|x| if x.abs() < TINY_START { 0.0 } else { x }))
}

/// Rounds up to an even number.
fn even(count: usize) -> usize {
    count.next_multiple_of(2)
}

/// Rounds lines and exchanges neighbouring ones, with zeros after an odd number of lines.
struct Rows<'a> {
    from: &'a [PanelRow],
    to: &'a mut [PanelRow],
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        let from = vectors::<S, V>(self.from).chunks(2);
        let zeros = [simd.splat_f32s(0.0); V];
        for (from, to) in from.zip(vectors_mut::<S, V>(self.to).chunks_exact_mut(2)) {
            let odd = from.get(1).unwrap_or(&zeros);
            for v in 0..V {
                to[0][v] = round(simd, odd[v]);
                to[1][v] = round(simd, from[0][v]);
            }
        }
    }
}

/// Rounds lines and exchanges neighbouring values in each.
struct Columns<'a> {
    from: &'a [PanelRow],
    to: &'a mut [PanelRow],
}

impl Kernel for Columns<'_> {
    #[inline(always)]
    fn run<S: Simd, const V: usize>(self, simd: S) {
        for (from, to) in vectors::<S, V>(self.from).iter().zip(self.to) {
            let mut line = [PanelRow::default()];
            for (to, from) in vectors_mut::<S, V>(&mut line)[0].iter_mut().zip(from) {
                *to = round(simd, *from);
            }
            let pairs: [u64; WIDTH / 2] = bytemuck::cast(line);
            *to = bytemuck::cast(pairs.map(|two| two.rotate_left(32)));
        }
    }
}
