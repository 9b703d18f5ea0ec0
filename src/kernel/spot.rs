//! Where a probe stands on two levels at once: both axes of both in the four lanes of a vector of doubles.

use super::lanes::Portable;

/// Two levels of a texture, as places on them are found. Numbers 0 and 1 of each are for x and y of the first, 2 and 3 for those
/// of the second.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Texels of the level per texel of level 0.
    pub scale: [f64; 4],
    /// Edges beyond which nothing changes: places are cut to `-1..=most`.
    pub most: [f64; 4],
    /// First and last texel that can be read together with the one after it.
    pub first: [i32; 4],
    /// See `first`.
    pub last: [i32; 4],
    /// Elements from one texel to the next.
    pub stride: [i32; 4],
}

/// The texels left of and above a place on two levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spots {
    /// How far the place is from the texel's centre.
    pub fraction: [f32; 4],
    /// The texel.
    pub texel: [i32; 4],
    /// Elements from texel (0, 0) of each level to it.
    pub offset: [i32; 2],
    /// Whether it can be read, with the three after it.
    pub inside: [bool; 2],
}

impl Spots {
    /// None found yet.
    pub const NONE: Self = Self { fraction: [0.0; 4], texel: [0; 4], offset: [0; 2], inside: [false; 2] };
}

/// A way of finding places.
pub trait Spot {
    /// Finds a finite place, in texels of level 0, `x = s scale - 1/2` on each level.
    fn spots(place: [f64; 2], grid: &Grid) -> Spots;
}

impl Spot for Portable {
    #[inline(always)]
    fn spots([s, t]: [f64; 2], grid: &Grid) -> Spots {
        let mut spots = Spots { inside: [true; 2], ..Spots::NONE };
        for (k, place) in [s, t, s, t].into_iter().enumerate() {
            let x = place * grid.scale[k];
            let x = if x < grid.most[k] { x } else { grid.most[k] };
            let x = if x > -1.0 { x } else { -1.0 };
            let x = x - 0.5;
            let whole = x.floor();
            spots.fraction[k] = (x - whole) as f32;
            let texel = whole as i32;
            spots.texel[k] = texel;
            spots.inside[k / 2] &= texel >= grid.first[k] && texel <= grid.last[k];
            let offset = &mut spots.offset[k / 2];
            *offset = offset.wrapping_add(texel.wrapping_mul(grid.stride[k]));
        }
        spots
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::lanes::Avx2;
    use super::{Grid, Spot, Spots};
    use std::arch::x86_64::*;

    impl Spot for Avx2 {
        #[inline(always)]
        fn spots([s, t]: [f64; 2], grid: &Grid) -> Spots {
            let mut spots = Spots::NONE;
            // SAFETY: the type is used only inside functions compiled for AVX2 on a machine that has it; loads and stores
            // are of whole arrays of four.
            unsafe {
                let place = _mm_set_pd(t, s);
                let x = _mm256_mul_pd(_mm256_set_m128d(place, place), _mm256_loadu_pd(grid.scale.as_ptr()));
                let x = _mm256_min_pd(x, _mm256_loadu_pd(grid.most.as_ptr()));
                let x = _mm256_sub_pd(_mm256_max_pd(x, _mm256_set1_pd(-1.0)), _mm256_set1_pd(0.5));
                let whole = _mm256_floor_pd(x);
                _mm_storeu_ps(spots.fraction.as_mut_ptr(), _mm256_cvtpd_ps(_mm256_sub_pd(x, whole)));
                let texel = _mm256_cvttpd_epi32(whole);
                _mm_storeu_si128(spots.texel.as_mut_ptr().cast(), texel);
                let load = |from: &[i32; 4]| _mm_loadu_si128(from.as_ptr().cast());
                let below = _mm_cmpgt_epi32(load(&grid.first), texel);
                let above = _mm_cmpgt_epi32(texel, load(&grid.last));
                let outside = _mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(below, above)));
                spots.inside = [outside & 0b0011 == 0, outside & 0b1100 == 0];
                let along = _mm_mullo_epi32(texel, load(&grid.stride));
                let both = _mm_add_epi32(along, _mm_shuffle_epi32::<0b10_11_00_01>(along));
                spots.offset = [_mm_cvtsi128_si32(both), _mm_extract_epi32::<2>(both)];
            }
            spots
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Isa;
    use crate::kernel::lanes::{LaneWork, Lanes, with_lanes};

    struct At<'a>([f64; 2], &'a Grid);

    impl LaneWork for At<'_> {
        type Output = Spots;
        #[inline(always)]
        fn run<L: Lanes>(self) -> Spots {
            L::spots(self.0, self.1)
        }
    }

    #[test]
    fn places_are_equal_on_every_instruction_set() {
        let grid = Grid {
            scale: [1.0, 1.0, 0.5, 0.4],
            most: [9.0, 6.0, 5.0, 3.0],
            first: [-1, 0, -1, 0],
            last: [7, 3, 3, 0],
            stride: [4, 40, 4, 24],
        };
        for s in [-1e30, -1.0, -0.5, -0.0, 0.25, 0.5, 3.999_999_999, 4.0, 7.5, 8.0, 8.49, 8.5, 1e30] {
            for t in [-7.0, 0.5, 1.5 - 1e-12, 2.0, 4.4, 5.1, 77.0] {
                let want = with_lanes(Isa::Scalar, At([s, t], &grid));
                // By definition, one level and axis.
                let x = (s * 0.5f64).clamp(-1.0, 5.0) - 0.5;
                assert_eq!((want.texel[2], want.fraction[2]), (x.floor() as i32, (x - x.floor()) as f32));
                let [a, b, c, d] = want.texel;
                assert_eq!(want.offset, [4 * a + 40 * b, 4 * c + 24 * d]);
                let inside = (-1..=7).contains(&a) && (0..=3).contains(&b);
                assert_eq!(want.inside, [inside, (-1..=3).contains(&c) && d == 0]);
                for isa in Isa::available() {
                    assert_eq!(with_lanes(isa, At([s, t], &grid)), want, "{isa:?} {s} {t}");
                }
            }
        }
    }
}
