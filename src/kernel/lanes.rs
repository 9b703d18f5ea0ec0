//! Eight singles as one value: the same operations, in the same order, on every instruction set.
//!
//! An algorithm is written once, over [`Lanes`]; with [`Portable`] it is its own scalar twin. Every operation is one
//! rounding of each lane, so results are equal bit for bit.

use super::Isa;
use super::spot::Spot;
use super::taps::Taps;

/// Eight singles.
pub trait Lanes: Copy + Spot + Taps {
    /// `x` in all lanes.
    fn splat(x: f32) -> Self;
    /// The eight numbers.
    fn load(from: &[f32; 8]) -> Self;
    /// Eight bytes as numbers.
    fn load_u8(from: &[u8; 8]) -> Self;
    /// Eight words as numbers.
    fn load_u16(from: &[u16; 8]) -> Self;
    /// The lanes as an array.
    fn store(self) -> [f32; 8];
    /// `self + other`
    fn add(self, other: Self) -> Self;
    /// `self - other`
    fn sub(self, other: Self) -> Self;
    /// `self * other`
    fn mul(self, other: Self) -> Self;
    /// The lesser of the two; neither may be NaN.
    fn min(self, other: Self) -> Self;
    /// The greater of the two; neither may be NaN.
    fn max(self, other: Self) -> Self;
    /// Without sign.
    fn abs(self) -> Self;
    /// `a` in the first four lanes, `b` in the others.
    fn halves(a: f32, b: f32) -> Self;
    /// Lane `2 PAIR` four times, then lane `2 PAIR + 1` four times.
    fn spread<const PAIR: usize>(self) -> Self;
    /// `self` where `mask` is not zero, else zero.
    fn where_not_zero(self, mask: Self) -> Self;
    /// The first four lanes of both, and the other four of both.
    fn regrouped(self, other: Self) -> [Self; 2];
    /// `a + fraction (b - a)`, `a` the first four lanes and `b` the others.
    fn met(self, fraction: f32) -> [f32; 4];
}

/// Work that is written over lanes. What is inlined into it is compiled for their instruction set; no closure may touch lanes,
/// for one that is not inlined makes each operation a call.
pub trait LaneWork {
    /// What it gives.
    type Output;
    /// Does it; to be marked `#[inline(always)]`.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Does `work` with the lanes of `isa`.
#[inline(always)]
pub fn with_lanes<W: LaneWork>(isa: Isa, work: W) -> W::Output {
    match isa {
        // SAFETY: a set beyond `Neon` is in use only where the machine has it, and all of them have AVX2.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 | Isa::Avx512 if isa.is_supported() => unsafe { with_avx2(work) },
        #[cfg(target_arch = "aarch64")]
        Isa::Neon => work.run::<Neon>(),
        _ => work.run::<Portable>(),
    }
}

/// # Safety
/// The machine must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn with_avx2<W: LaneWork>(work: W) -> W::Output {
    work.run::<Avx2>()
}

/// Asks for the element at `at` ahead of time; where there is none, nothing happens.
#[inline(always)]
pub fn prefetch<T>(data: &[T], at: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: prefetching has no other effect for any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(data.as_ptr().wrapping_add(at).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (data, at);
}

/// Lanes in plain Rust: the definition.
#[derive(Clone, Copy)]
pub struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }
    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn load_u8(from: &[u8; 8]) -> Self {
        Self(from.map(f32::from))
    }
    #[inline(always)]
    fn load_u16(from: &[u16; 8]) -> Self {
        Self(from.map(f32::from))
    }
    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn halves(a: f32, b: f32) -> Self {
        Self([a, a, a, a, b, b, b, b])
    }
    #[inline(always)]
    fn spread<const PAIR: usize>(self) -> Self {
        Self(std::array::from_fn(|k| self.0[2 * PAIR + k / 4]))
    }
    #[inline(always)]
    fn where_not_zero(self, mask: Self) -> Self {
        self.zip(mask, |a, m| if m != 0.0 { a } else { 0.0 })
    }
    #[inline(always)]
    fn regrouped(self, other: Self) -> [Self; 2] {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (self.0, other.0);
        [Self([a, b, c, d, i, j, k, l]), Self([e, f, g, h, m, n, o, p])]
    }
    #[inline(always)]
    fn met(self, fraction: f32) -> [f32; 4] {
        std::array::from_fn(|k| self.0[k] + fraction * (self.0[k + 4] - self.0[k]))
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::Avx2;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Lanes;
    use std::arch::x86_64::*;

    /// Lanes in one AVX register. To be used only inside functions compiled for AVX2 on a machine that has it.
    #[derive(Clone, Copy)]
    pub struct Avx2(__m256);

    // SAFETY, for every block below: values of this type exist only inside functions that are called where the machine
    // has AVX2, and the intrinsics need nothing else; loads read exactly the arrays they are given.
    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(from: &[f32; 8]) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
        }
        #[inline(always)]
        fn load_u8(from: &[u8; 8]) -> Self {
            // SAFETY: see above; the load reads the low eight bytes.
            Self(unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(from.as_ptr().cast()))) })
        }
        #[inline(always)]
        fn load_u16(from: &[u16; 8]) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(from.as_ptr().cast()))) })
        }
        #[inline(always)]
        fn store(self) -> [f32; 8] {
            let mut out = [0.0; 8];
            // SAFETY: see above.
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn halves(a: f32, b: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_set_m128(_mm_set1_ps(b), _mm_set1_ps(a)) })
        }
        #[inline(always)]
        fn spread<const PAIR: usize>(self) -> Self {
            let (even, odd) = (2 * PAIR as i32, 2 * PAIR as i32 + 1);
            // SAFETY: see above.
            Self(unsafe {
                let places = _mm256_setr_epi32(even, even, even, even, odd, odd, odd, odd);
                _mm256_permutevar8x32_ps(self.0, places)
            })
        }
        #[inline(always)]
        fn where_not_zero(self, mask: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe {
                let is = _mm256_cmp_ps::<_CMP_NEQ_UQ>(mask.0, _mm256_setzero_ps());
                _mm256_and_ps(self.0, is)
            })
        }
        #[inline(always)]
        fn regrouped(self, other: Self) -> [Self; 2] {
            // SAFETY: see above.
            unsafe {
                [
                    Self(_mm256_permute2f128_ps::<0x20>(self.0, other.0)),
                    Self(_mm256_permute2f128_ps::<0x31>(self.0, other.0)),
                ]
            }
        }
        #[inline(always)]
        fn met(self, fraction: f32) -> [f32; 4] {
            let mut out = [0.0; 4];
            // SAFETY: see above.
            unsafe {
                let (a, b) = (_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                let moved = _mm_mul_ps(_mm_set1_ps(fraction), _mm_sub_ps(b, a));
                _mm_storeu_ps(out.as_mut_ptr(), _mm_add_ps(a, moved));
            }
            out
        }
    }
}

#[cfg(target_arch = "aarch64")]
pub use neon::Neon;

#[cfg(target_arch = "aarch64")]
mod neon {
    use super::super::spot::{Grid, Spot, Spots};
    use super::{Lanes, Portable};
    use std::arch::aarch64::*;

    /// Lanes in two registers.
    #[derive(Clone, Copy)]
    pub struct Neon([float32x4_t; 2]);

    impl Neon {
        /// Half by half.
        #[inline(always)]
        fn zip(self, other: Self, f: impl Fn(float32x4_t, float32x4_t) -> float32x4_t) -> Self {
            Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
        }

        /// Eight words as numbers.
        #[inline(always)]
        fn of_words(words: uint16x8_t) -> Self {
            // SAFETY: every aarch64 has NEON.
            unsafe {
                Self([
                    vcvtq_f32_u32(vmovl_u16(vget_low_u16(words))),
                    vcvtq_f32_u32(vmovl_u16(vget_high_u16(words))),
                ])
            }
        }
    }

    impl Spot for Neon {
        #[inline(always)]
        fn spots(place: [f64; 2], grid: &Grid) -> Spots {
            Portable::spots(place, grid)
        }
    }

    // SAFETY, for every block below: every aarch64 has NEON, and the intrinsics need nothing else; loads and stores are of
    // the arrays they are given, as a whole or by halves.
    impl Lanes for Neon {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: see above.
            Self([unsafe { vdupq_n_f32(x) }; 2])
        }
        #[inline(always)]
        fn load(from: &[f32; 8]) -> Self {
            // SAFETY: see above.
            Self(unsafe { [vld1q_f32(from.as_ptr()), vld1q_f32(from.as_ptr().add(4))] })
        }
        #[inline(always)]
        fn load_u8(from: &[u8; 8]) -> Self {
            // SAFETY: see above.
            Self::of_words(unsafe { vmovl_u8(vld1_u8(from.as_ptr())) })
        }
        #[inline(always)]
        fn load_u16(from: &[u16; 8]) -> Self {
            // SAFETY: see above.
            Self::of_words(unsafe { vld1q_u16(from.as_ptr()) })
        }
        #[inline(always)]
        fn store(self) -> [f32; 8] {
            let mut out = [0.0; 8];
            // SAFETY: see above.
            unsafe {
                vst1q_f32(out.as_mut_ptr(), self.0[0]);
                vst1q_f32(out.as_mut_ptr().add(4), self.0[1]);
            }
            out
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: see above.
            self.zip(other, |a, b| unsafe { vaddq_f32(a, b) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: see above.
            self.zip(other, |a, b| unsafe { vsubq_f32(a, b) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: see above.
            self.zip(other, |a, b| unsafe { vmulq_f32(a, b) })
        }
        // By comparison, and not by the set's own minimum, which has its own mind about zeros.
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see above.
            self.zip(other, |a, b| unsafe { vbslq_f32(vcltq_f32(a, b), a, b) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see above.
            self.zip(other, |a, b| unsafe { vbslq_f32(vcgtq_f32(a, b), a, b) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: see above.
            Self(self.0.map(|x| unsafe { vabsq_f32(x) }))
        }
        #[inline(always)]
        fn halves(a: f32, b: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { [vdupq_n_f32(a), vdupq_n_f32(b)] })
        }
        #[inline(always)]
        fn spread<const PAIR: usize>(self) -> Self {
            let lanes = self.store();
            Self::halves(lanes[2 * PAIR], lanes[2 * PAIR + 1])
        }
        #[inline(always)]
        fn where_not_zero(self, mask: Self) -> Self {
            // SAFETY: see above.
            self.zip(mask, |a, m| unsafe {
                vreinterpretq_f32_u32(vbicq_u32(vreinterpretq_u32_f32(a), vceqzq_f32(m)))
            })
        }
        #[inline(always)]
        fn regrouped(self, other: Self) -> [Self; 2] {
            [Self([self.0[0], other.0[0]]), Self([self.0[1], other.0[1]])]
        }
        #[inline(always)]
        fn met(self, fraction: f32) -> [f32; 4] {
            let [a, b] = self.0;
            let mut out = [0.0; 4];
            // SAFETY: see above.
            unsafe {
                let moved = vmulq_f32(vdupq_n_f32(fraction), vsubq_f32(b, a));
                vst1q_f32(out.as_mut_ptr(), vaddq_f32(a, moved));
            }
            out
        }
    }
}
