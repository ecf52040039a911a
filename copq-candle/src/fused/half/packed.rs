//! Two bf16 in a word: the products for processors with AVX512-BF16.
//!
//! The two instructions that `pulp` does not wrap are the only unsafe code.
#![allow(unsafe_code)]

mod products;

use std::arch::x86_64::{
    __cpuid, __m256bh, __m512, __m512bh, __m512i, _mm512_dpbf16_ps, _mm512_maskz_cvtneps_pbh,
};
use std::mem::transmute;

use bytemuck::{Pod, Zeroable};
use pulp::x86::V4;
use pulp::{NullaryFnOnce, Simd, f32x16, u16x16, u32x16};

use super::super::panels::{PanelRow, Panels, WIDTH};
use super::super::tiles::vectors;
use super::{TINY, start};
pub use products::{affine, gradient};

pulp::simd_type! {
    /// A processor with the instruction and everything that [`V4`] has.
    pub struct Bf16 {
        sse: "sse",
        sse2: "sse2",
        fxsr: "fxsr",
        sse3: "sse3",
        ssse3: "ssse3",
        sse4_1: "sse4.1",
        sse4_2: "sse4.2",
        popcnt: "popcnt",
        avx: "avx",
        avx2: "avx2",
        bmi1: "bmi1",
        bmi2: "bmi2",
        fma: "fma",
        lzcnt: "lzcnt",
        avx512f: "avx512f",
        avx512bw: "avx512bw",
        avx512cd: "avx512cd",
        avx512dq: "avx512dq",
        avx512vl: "avx512vl",
        avx512bf16: "avx512bf16",
    }
}

/// Sixteen words of two values each; the even one of a pair is in the lower half.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(64))]
struct Words([u32; WIDTH]);

/// Eight words of a row, none of which lies in two cache lines.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
struct RowWords([u32; WIDTH / 2]);

/// The instruction, if this processor has it and gains from it. AMD's do twice as many
/// multiply-adds with it as in f32; Intel's Sapphire Rapids does half as many (bench/RESULTS.md).
pub fn where_faster() -> Option<Bf16> {
    let vendor = __cpuid(0);
    // "AuthenticAMD" in three registers.
    let is_amd = [vendor.ebx, vendor.edx, vendor.ecx] == [0x6874_7541, 0x6974_6e65, 0x444d_4163];
    Bf16::try_new().filter(|&bf16| is_amd && is_as_defined(bf16))
}

/// Whether the instruction does what [`super`] defines. Added to 2^24, a one is lost and a two is
/// not, which reveals the order within a pair.
fn is_as_defined(bf16: Bf16) -> bool {
    let large = 2f32.powi(24);
    [(1.0, 1.0), (1.0, 2.0), (2.0, 1.0)].into_iter().all(|(even, odd)| {
        let ones = Words([1f32.to_bits() >> 16 | 1f32.to_bits(); WIDTH]);
        let pair = f32::to_bits(even) >> 16 | f32::to_bits(odd);
        let got: [f32; WIDTH] = pulp::cast(dot(bf16, pulp::cast([large; WIDTH]), pair, &ones));
        got == [large + odd + even; WIDTH]
    })
}

/// See [`super::Across`]: panel by panel, each row's eight pairs of columns.
#[derive(Clone, Debug)]
pub(in super::super) struct Across {
    bf16: Bf16,
    rows: usize,
    cols: usize,
    words: Vec<RowWords>,
}

impl Across {
    pub fn new(bf16: Bf16) -> Self {
        Self { bf16, rows: 0, cols: 0, words: Vec::new() }
    }

    pub fn set(&mut self, from: &Panels) {
        (self.rows, self.cols) = (from.rows(), from.cols());
        self.words.resize(from.lines().len(), RowWords::default());
        let to = &mut self.words;
        self.bf16.vectorize(PackAcross { bf16: self.bf16, from: from.lines(), to });
    }
}

struct PackAcross<'a> {
    bf16: Bf16,
    from: &'a [PanelRow],
    to: &'a mut [RowWords],
}

impl NullaryFnOnce for PackAcross<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (from, to) in vectors::<V4, 1>(self.from).iter().zip(self.to) {
            *to = RowWords(pulp::cast(round(self.bf16, from[0])));
        }
    }
}

/// See [`super::Down`]: panel by panel, sixteen columns of each pair of rows.
#[derive(Clone, Debug)]
pub(in super::super) struct Down {
    bf16: Bf16,
    rows: usize,
    cols: usize,
    words: Vec<Words>,
    /// What a map's result starts from.
    starts: Vec<PanelRow>,
}

impl Down {
    pub fn new(bf16: Bf16) -> Self {
        Self { bf16, rows: 0, cols: 0, words: Vec::new(), starts: Vec::new() }
    }

    pub fn set(&mut self, from: &Panels) {
        self.pack(from.lines(), from.rows(), from.rows(), from.cols());
    }

    pub fn set_map(&mut self, map: &[PanelRow], cols: usize) {
        let lines = map.len() / cols.div_ceil(WIDTH);
        self.pack(map, lines, lines - 1, cols);
        self.starts.clear();
        self.starts.extend(map.chunks_exact(lines).map(|panel| start(&panel[lines - 1])));
    }

    /// Packs the first `rows` of every `lines` lines.
    fn pack(&mut self, from: &[PanelRow], lines: usize, rows: usize, cols: usize) {
        (self.rows, self.cols) = (rows, cols);
        let pairs = self.pairs();
        self.words.resize(cols.div_ceil(WIDTH) * pairs, Words::default());
        for (from, to) in from.chunks_exact(lines).zip(self.words.chunks_exact_mut(pairs)) {
            self.bf16.vectorize(PackDown { bf16: self.bf16, from: &from[..rows], to });
        }
    }

    fn pairs(&self) -> usize {
        self.rows.div_ceil(2)
    }

    fn panel(&self, panel: usize) -> &[Words] {
        &self.words[panel * self.pairs()..][..self.pairs()]
    }
}

struct PackDown<'a> {
    bf16: Bf16,
    from: &'a [PanelRow],
    to: &'a mut [Words],
}

impl NullaryFnOnce for PackDown<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let simd = v4(self.bf16);
        let wide = |line: &[f32x16; 1]| -> u32x16 {
            simd.convert_u16x16_to_u32x16(round(self.bf16, line[0]))
        };
        for (from, to) in vectors::<V4, 1>(self.from).chunks(2).zip(self.to) {
            let odd = from.get(1).map_or(simd.splat_u32s(0), wide);
            let words = simd.or_u32s(wide(&from[0]), simd.shl_const_u32x16::<16>(odd));
            *to = Words(pulp::cast(words));
        }
    }
}

/// Everything in [`Bf16`] except the instruction itself.
#[inline(always)]
fn v4(bf16: Bf16) -> V4 {
    let Bf16 { sse, sse2, fxsr, sse3, ssse3, sse4_1, sse4_2, popcnt, avx, avx2, .. } = bf16;
    let Bf16 { bmi1, bmi2, fma, lzcnt, avx512f, avx512bw, avx512cd, avx512dq, avx512vl, .. } = bf16;
    V4 {
        sse,
        sse2,
        fxsr,
        sse3,
        ssse3,
        sse4_1,
        sse4_2,
        popcnt,
        avx,
        avx2,
        bmi1,
        bmi2,
        fma,
        lzcnt,
        avx512f,
        avx512bw,
        avx512cd,
        avx512dq,
        avx512vl,
    }
}

/// sum + the odd products, then + the even ones, lane by lane.
#[inline(always)]
fn dot(_: Bf16, sum: f32x16, pair: u32, words: &Words) -> f32x16 {
    // SAFETY: the token proves that the processor has the instruction. All types are 64 bytes of
    // plain numbers, for which every bit pattern is valid.
    unsafe {
        let pair: __m512bh = transmute::<[u32; WIDTH], _>([pair; WIDTH]);
        let words: __m512bh = transmute::<__m512i, _>(transmute::<Words, __m512i>(*words));
        transmute::<__m512, f32x16>(_mm512_dpbf16_ps(transmute::<f32x16, __m512>(sum), pair, words))
    }
}

/// [`super::round`], but only the upper halves. A NaN keeps its sign and what fits of its payload.
#[inline(always)]
fn round(bf16: Bf16, x: f32x16) -> u16x16 {
    let simd = v4(bf16);
    let is_tiny = simd.less_than_f32s(simd.abs_f32s(x), simd.splat_f32s(TINY));
    // SAFETY: the token proves that the processor has the instruction. Both types are plain numbers
    // of the size that they become, for which every bit pattern is valid.
    unsafe {
        let x = transmute::<f32x16, __m512>(x);
        transmute::<__m256bh, u16x16>(_mm512_maskz_cvtneps_pbh(!is_tiny.0, x))
    }
}
