//! Bilinear of more than a byte a channel, cubic and Lanczos: one pixel at a time.

use super::bilinear::{rounded, words};
use super::{Kernel, LANES, Slot};
use crate::kernel::remap::sample::Sample;
use crate::kernel::remap::weights::Weights;
use std::arch::x86_64::*;

/// Numbers of a block of four channels, and three more that a store may spill.
pub(super) const BUFFER: usize = 4 * LANES + 4;

/// Loads of wider formats and the way back.
pub(super) trait Wide: Sample<Acc = f32> {
    /// The eight elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn eight(p: *const Self) -> __m256;
    /// Rounds and stores `count` numbers, a multiple of 8.
    /// # Safety
    /// `out` has room for them.
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut Self);
}

/// Clamps and rounds eight numbers into the low bits of the lanes.
#[inline]
#[target_feature(enable = "avx2")]
fn saturated(x: __m256, max: f32) -> __m256i {
    // The operands' order makes 0 of NaN.
    rounded(_mm256_min_ps(_mm256_max_ps(x, _mm256_setzero_ps()), _mm256_set1_ps(max)))
}

impl Wide for u8 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const u8) -> __m256 {
        // SAFETY: the caller vouches for eight bytes.
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(unsafe { _mm_loadl_epi64(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u8) {
        for i in (0..count).step_by(8) {
            // SAFETY: `count` is at most 32, and so is the room.
            unsafe {
                let v = words(saturated(_mm256_loadu_ps(from.as_ptr().add(i)), 255.0));
                _mm_storel_epi64(out.add(i).cast(), _mm_packus_epi16(v, v));
            }
        }
    }
}

impl Wide for u16 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const u16) -> __m256 {
        // SAFETY: the caller vouches for eight elements.
        _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u16) {
        for i in (0..count).step_by(8) {
            // SAFETY: `count` is at most 32, and so is the room.
            unsafe {
                let v = words(saturated(_mm256_loadu_ps(from.as_ptr().add(i)), 65_535.0));
                _mm_storeu_si128(out.add(i).cast(), v);
            }
        }
    }
}

impl Wide for f32 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const f32) -> __m256 {
        // SAFETY: the caller vouches for eight floats.
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut f32) {
        for i in (0..count).step_by(8) {
            // SAFETY: `count` is at most four blocks, and so is the room.
            unsafe { _mm256_storeu_ps(out.add(i), _mm256_loadu_ps(from.as_ptr().add(i))) };
        }
    }
}

/// Bilinear, three or four channels of more than a byte.
pub(super) struct Pairs<const C: usize>;

impl<T: Wide, const C: usize> Kernel<T> for Pairs<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const T, stride: usize, slot: &Slot, out: *mut T) {
        let mut buffer = [0f32; BUFFER];
        let second = _mm256_setr_epi32(3, 4, 5, 5, 3, 4, 5, 5);
        // SAFETY: eight elements are readable in both rows; the buffers are long enough.
        unsafe {
            for i in 0..LANES {
                let p = rows.byte_add(slot.offsets[i] as usize);
                let (upper, lower) = (T::eight(p), T::eight(p.add(stride)));
                let fy = _mm256_set1_ps(slot.fy[i]);
                let both = _mm256_add_ps(upper, _mm256_mul_ps(fy, _mm256_sub_ps(lower, upper)));
                let left = _mm256_castps256_ps128(both);
                let right = if C == 3 {
                    _mm256_castps256_ps128(_mm256_permutevar8x32_ps(both, second))
                } else {
                    _mm256_extractf128_ps::<1>(both)
                };
                let step = _mm_mul_ps(_mm_set1_ps(slot.fx[i]), _mm_sub_ps(right, left));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), _mm_add_ps(left, step));
            }
            T::store(&buffer, LANES * C, out);
        }
    }
}

/// `K` x `K` taps of three or four channels.
pub(super) struct Separable<W, const K: usize, const C: usize>(pub W);

impl<W, const K: usize, const C: usize> Separable<W, K, C> {
    /// Weighted sums of two columns from tap `first` on: one tap a half.
    ///
    /// # Safety
    /// In each of `K` rows eight elements are readable from that tap on; `first + 2 <= K`.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn columns<T: Wide>(
        p: *const T,
        stride: usize,
        wx: &[f32; K],
        wy: &[f32; K],
        first: usize,
    ) -> __m256 {
        let apart = _mm256_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5);
        // SAFETY: the caller vouches for the elements.
        unsafe {
            let p = p.add(first * C);
            let mut sum = _mm256_mul_ps(_mm256_set1_ps(wy[0]), T::eight(p));
            for (j, &w) in wy.iter().enumerate().skip(1) {
                let row = T::eight(p.add(j * stride));
                sum = _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(w), row));
            }
            // Only now are three channels put four lanes apart: the sums are the same.
            let placed = if C == 3 { _mm256_permutevar8x32_ps(sum, apart) } else { sum };
            let weights = _mm256_set_m128(_mm_set1_ps(wx[first + 1]), _mm_set1_ps(wx[first]));
            _mm256_mul_ps(weights, placed)
        }
    }
}

impl<T: Wide, W: Weights<K>, const K: usize, const C: usize> Kernel<T> for Separable<W, K, C> {
    const CHANNELS: usize = C;
    const TAPS: usize = K;
    const LOAD: usize = (K - 2) * C + 8;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const T, stride: usize, slot: &Slot, out: *mut T) {
        let (mut wx, mut wy) = ([[0f32; K]; LANES], [[0f32; K]; LANES]);
        for i in 0..LANES {
            wx[i] = self.0.at(slot.fx[i]);
            wy[i] = self.0.at(slot.fy[i]);
        }
        let mut buffer = [0f32; BUFFER];
        for i in 0..LANES {
            // SAFETY: `LOAD` elements are readable in each of `K` rows.
            unsafe {
                let p = rows.byte_add(slot.offsets[i] as usize);
                let (a, b) = (
                    Self::columns(p, stride, &wx[i], &wy[i], 0),
                    Self::columns(p, stride, &wx[i], &wy[i], 2),
                );
                let two = if K == 8 {
                    let c = Self::columns(p, stride, &wx[i], &wy[i], 4);
                    let d = Self::columns(p, stride, &wx[i], &wy[i], 6);
                    _mm256_add_ps(_mm256_add_ps(a, c), _mm256_add_ps(b, d))
                } else {
                    _mm256_add_ps(a, b)
                };
                let one = _mm_add_ps(_mm256_castps256_ps128(two), _mm256_extractf128_ps::<1>(two));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), one);
            }
        }
        // SAFETY: the output has room for the block.
        unsafe { T::store(&buffer, LANES * C, out) };
    }
}
