//! Bilinear of more than a byte a channel, cubic and Lanczos: one pixel at a time.

use super::bilinear::rounded;
use super::{Block, Kernel, LANES};
use crate::kernel::remap::sample::Sample;
use crate::kernel::remap::weights::Weights;
use std::arch::x86_64::*;

/// Loads of wider formats and the way back.
pub(super) trait Wide: Sample<Acc = f32> {
    /// The eight elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn eight(p: *const Self) -> __m256;
    /// The sixteen elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn sixteen(p: *const Self) -> __m512;
    /// Rounds and stores `count` numbers of a buffer that has room for a multiple of 16.
    /// # Safety
    /// `out` has room for `count` elements, a multiple of 16.
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut Self);
}

/// Numbers of a block of four channels, and three more that a store may spill.
pub(super) const BUFFER: usize = 4 * LANES + 4;

/// Clamps and rounds sixteen numbers into the low bits of the lanes.
#[inline]
#[target_feature(enable = "avx512f")]
fn saturated(x: __m512, max: f32) -> __m512i {
    // The operands' order makes 0 of NaN.
    rounded(_mm512_min_ps(_mm512_max_ps(x, _mm512_setzero_ps()), _mm512_set1_ps(max)))
}

impl Wide for u8 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const u8) -> __m256 {
        // SAFETY: the caller vouches for eight bytes.
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(unsafe { _mm_loadl_epi64(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const u8) -> __m512 {
        // SAFETY: the caller vouches for sixteen bytes.
        _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u8) {
        for i in (0..count).step_by(16) {
            // SAFETY: `count` is at most 64, and so is the room.
            unsafe {
                let v = saturated(_mm512_loadu_ps(from.as_ptr().add(i)), 255.0);
                _mm_storeu_si128(out.add(i).cast(), _mm512_cvtepi32_epi8(v));
            }
        }
    }
}

impl Wide for u16 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const u16) -> __m256 {
        // SAFETY: the caller vouches for eight elements.
        _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const u16) -> __m512 {
        // SAFETY: the caller vouches for sixteen elements.
        _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(unsafe { _mm256_loadu_si256(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u16) {
        for i in (0..count).step_by(16) {
            // SAFETY: `count` is at most 64, and so is the room.
            unsafe {
                let v = saturated(_mm512_loadu_ps(from.as_ptr().add(i)), 65_535.0);
                _mm256_storeu_si256(out.add(i).cast(), _mm512_cvtepi32_epi16(v));
            }
        }
    }
}

impl Wide for f32 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const f32) -> __m256 {
        // SAFETY: the caller vouches for eight floats.
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const f32) -> __m512 {
        // SAFETY: the caller vouches for sixteen floats.
        unsafe { _mm512_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut f32) {
        for i in (0..count).step_by(16) {
            // SAFETY: `count` is at most four blocks, and so is the room.
            unsafe { _mm512_storeu_ps(out.add(i), _mm512_loadu_ps(from.as_ptr().add(i))) };
        }
    }
}

/// Bilinear, three or four channels of more than a byte.
pub(super) struct Pairs<const C: usize>;

impl<T: Wide, const C: usize> Kernel<T> for Pairs<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        let mut buffer = [0f32; BUFFER];
        let second = _mm256_setr_epi32(3, 4, 5, 5, 3, 4, 5, 5);
        // SAFETY: eight elements are readable in both rows; the buffers are long enough.
        unsafe {
            _mm512_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm512_storeu_ps(fy.as_mut_ptr(), block.fy);
            for i in 0..LANES {
                let p = rows.add(block.offsets[i] as usize);
                let (upper, lower) = (T::eight(p), T::eight(p.add(stride)));
                let fy = _mm256_set1_ps(fy[i]);
                let both = _mm256_add_ps(upper, _mm256_mul_ps(fy, _mm256_sub_ps(lower, upper)));
                let left = _mm256_castps256_ps128(both);
                let right = if C == 3 {
                    _mm256_castps256_ps128(_mm256_permutevar8x32_ps(both, second))
                } else {
                    _mm256_extractf128_ps::<1>(both)
                };
                let step = _mm_mul_ps(_mm_set1_ps(fx[i]), _mm_sub_ps(right, left));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), _mm_add_ps(left, step));
            }
            T::store(&buffer, LANES * C, out);
        }
    }
}

/// `K` x `K` taps of three or four channels.
pub(super) struct Separable<W, const K: usize, const C: usize>(pub W);

impl<W, const K: usize, const C: usize> Separable<W, K, C> {
    /// Weighted sums of four columns from tap `first` on: one tap a quarter.
    ///
    /// # Safety
    /// In each of `K` rows sixteen elements are readable from that tap on; `first + 4 <= K`.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn columns<T: Wide>(
        p: *const T,
        stride: usize,
        wx: &[f32; K],
        wy: &[f32; K],
        first: usize,
    ) -> __m512 {
        let apart = _mm512_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 8, 8, 9, 10, 11, 11);
        let spread = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
        // SAFETY: the caller vouches for the elements and the weights.
        unsafe {
            let p = p.add(first * C);
            let mut sum = _mm512_mul_ps(_mm512_set1_ps(wy[0]), T::sixteen(p));
            for (j, &w) in wy.iter().enumerate().skip(1) {
                let row = T::sixteen(p.add(j * stride));
                sum = _mm512_add_ps(sum, _mm512_mul_ps(_mm512_set1_ps(w), row));
            }
            // Only now are three channels put four lanes apart: the sums are the same.
            let placed = if C == 3 { _mm512_permutexvar_ps(apart, sum) } else { sum };
            let four = _mm512_castps128_ps512(_mm_loadu_ps(wx.as_ptr().add(first)));
            _mm512_mul_ps(_mm512_permutexvar_ps(spread, four), placed)
        }
    }
}

impl<T: Wide, W: Weights<K>, const K: usize, const C: usize> Kernel<T> for Separable<W, K, C> {
    const CHANNELS: usize = C;
    const TAPS: usize = K;
    const LOAD: usize = (K - 4) * C + 16;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        // SAFETY: the arrays are 64 bytes.
        unsafe {
            _mm512_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm512_storeu_ps(fy.as_mut_ptr(), block.fy);
        }
        let (mut wx, mut wy) = ([[0f32; K]; LANES], [[0f32; K]; LANES]);
        for i in 0..LANES {
            wx[i] = self.0.at(fx[i]);
            wy[i] = self.0.at(fy[i]);
        }
        let mut buffer = [0f32; BUFFER];
        for i in 0..LANES {
            // SAFETY: `LOAD` elements are readable in each of `K` rows; four weights are at each multiple of
            // four below `K`.
            unsafe {
                let p = rows.add(block.offsets[i] as usize);
                let first = Self::columns(p, stride, &wx[i], &wy[i], 0);
                let four = if K == 8 {
                    _mm512_add_ps(first, Self::columns(p, stride, &wx[i], &wy[i], 4))
                } else {
                    first
                };
                let high = _mm512_extractf32x8_ps::<1>(four);
                let two = _mm256_add_ps(_mm512_castps512_ps256(four), high);
                let one = _mm_add_ps(_mm256_castps256_ps128(two), _mm256_extractf128_ps::<1>(two));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), one);
            }
        }
        // SAFETY: the output has room for the block.
        unsafe { T::store(&buffer, LANES * C, out) };
    }
}
