//! Weighted sums of 2 x 2 texels of bytes, in whole numbers: what lines of probes are made of.

use super::lanes::Portable;

/// A weight of one, for a probe whose four weights sum to that: small enough for the sums of a thousand probes.
pub const ONE: f32 = 8192.0;

/// A way of summing. Sums are exact, so that their order does not matter.
pub trait Taps {
    /// Sums under construction.
    type Sums: Copy;
    /// None yet.
    fn no_taps() -> Self::Sums;
    /// Adds two neighbours of a row and of the row below. Words of weights are for the upper texel, then for the lower one.
    fn add_taps(sums: Self::Sums, rows: [&[u8; 8]; 2], left: u32, right: u32) -> Self::Sums;
    /// Four channels.
    fn taps_total(sums: Self::Sums) -> [i32; 4];
}

/// Weights of a column's two texels, both below 2^15.
#[inline(always)]
pub fn pair(upper: i32, lower: i32) -> u32 {
    (upper as u32 & 0xffff) | ((lower as u32) << 16)
}

impl Taps for Portable {
    type Sums = [i32; 4];

    #[inline(always)]
    fn no_taps() -> Self::Sums {
        [0; 4]
    }

    #[inline(always)]
    fn add_taps(sums: Self::Sums, [upper, lower]: [&[u8; 8]; 2], left: u32, right: u32) -> Self::Sums {
        let words = |pair: u32| [i32::from(pair as i16), i32::from((pair >> 16) as i16)];
        let ([a, b], [c, d]) = (words(left), words(right));
        std::array::from_fn(|k| {
            let column = |i: usize, a: i32, b: i32| a * i32::from(upper[i]) + b * i32::from(lower[i]);
            sums[k] + column(k, a, b) + column(k + 4, c, d)
        })
    }

    #[inline(always)]
    fn taps_total(sums: Self::Sums) -> [i32; 4] {
        sums
    }
}

#[cfg(target_arch = "aarch64")]
impl Taps for super::lanes::Neon {
    type Sums = [i32; 4];

    #[inline(always)]
    fn no_taps() -> Self::Sums {
        Portable::no_taps()
    }

    #[inline(always)]
    fn add_taps(sums: Self::Sums, rows: [&[u8; 8]; 2], left: u32, right: u32) -> Self::Sums {
        Portable::add_taps(sums, rows, left, right)
    }

    #[inline(always)]
    fn taps_total(sums: Self::Sums) -> [i32; 4] {
        sums
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::lanes::Avx2;
    use super::Taps;
    use std::arch::x86_64::*;

    // SAFETY, for every block below: the type is used only inside functions compiled for AVX2 on a machine that has it; loads
    // are of eight bytes, and the store of a whole array.
    impl Taps for Avx2 {
        type Sums = __m256i;

        #[inline(always)]
        fn no_taps() -> Self::Sums {
            // SAFETY: see above.
            unsafe { _mm256_setzero_si256() }
        }

        #[inline(always)]
        fn add_taps(sums: Self::Sums, [upper, lower]: [&[u8; 8]; 2], left: u32, right: u32) -> Self::Sums {
            // SAFETY: see above.
            unsafe {
                let upper = _mm_loadl_epi64(upper.as_ptr().cast());
                let lower = _mm_loadl_epi64(lower.as_ptr().cast());
                let texels = _mm256_cvtepu8_epi16(_mm_unpacklo_epi8(upper, lower));
                let (left, right) = (_mm256_set1_epi32(left as i32), _mm256_set1_epi32(right as i32));
                let weights = _mm256_blend_epi32::<0b1111_0000>(left, right);
                _mm256_add_epi32(sums, _mm256_madd_epi16(texels, weights))
            }
        }

        #[inline(always)]
        fn taps_total(sums: Self::Sums) -> [i32; 4] {
            let mut out = [0; 4];
            // SAFETY: see above.
            unsafe {
                let both = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256::<1>(sums));
                _mm_storeu_si128(out.as_mut_ptr().cast(), both);
            }
            out
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Isa;
    use crate::kernel::lanes::{LaneWork, Lanes, with_lanes};

    struct Two<'a>([&'a [u8; 8]; 2], [i32; 4]);

    impl LaneWork for Two<'_> {
        type Output = [i32; 4];
        #[inline(always)]
        fn run<L: Lanes>(self) -> [i32; 4] {
            let [a, b, c, d] = self.1;
            let once = L::add_taps(L::no_taps(), self.0, pair(a, b), pair(c, d));
            L::taps_total(L::add_taps(once, self.0, pair(a, b), pair(c, d)))
        }
    }

    #[test]
    fn sums_are_equal_on_every_instruction_set() {
        for seed in 0..200u32 {
            let byte = |i: u32| (seed.wrapping_mul(2_654_435_761).wrapping_add(i * 40_503) >> 7) as u8;
            let upper: [u8; 8] = std::array::from_fn(|i| byte(i as u32));
            let lower: [u8; 8] = std::array::from_fn(|i| byte(i as u32 + 8));
            let w: [i32; 4] = std::array::from_fn(|i| i32::from(byte(i as u32 + 16)) * 32);
            let want: [i32; 4] = std::array::from_fn(|k| {
                let at = |row: &[u8; 8], i: usize| i32::from(row[i]);
                let left = w[0] * at(&upper, k) + w[1] * at(&lower, k);
                2 * (left + w[2] * at(&upper, k + 4) + w[3] * at(&lower, k + 4))
            });
            for isa in Isa::available() {
                assert_eq!(with_lanes(isa, Two([&upper, &lower], w)), want, "{isa:?}");
            }
        }
    }
}
