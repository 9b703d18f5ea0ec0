//! Bilinear of more than a byte a channel, cubic and Lanczos: one pixel at a time.

use super::bilinear::{Table, rounded, table};
use super::{Kernel, LANES, Slot};
use crate::kernel::remap::sample::Sample;
use crate::kernel::remap::weights::Weights;
use std::arch::x86_64::*;

/// Loads of wider formats and the way back.
pub(super) trait Wide: Sample<Acc = f32> {
    /// The sixteen elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn sixteen(p: *const Self) -> __m512;
    /// Rounds and stores `count` numbers of a buffer that has room for a multiple of 16.
    /// # Safety
    /// `out` has room for `count` elements, a multiple of 16.
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut Self);
}

/// Loads and stores of elements of more than a byte.
pub(super) trait Pair: Wide {
    /// The eight elements from each of two places on.
    /// # Safety
    /// They are readable.
    unsafe fn eights(p: *const Self, q: *const Self) -> __m512;
    /// Rounds and stores twice four packed pixels of `C` channels.
    /// # Safety
    /// `out` has room for them.
    unsafe fn pack<const C: usize>(pixels: [__m512; 2], out: *mut Self);
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

/// Places of the low words of two vectors' lanes, the first `used` of each.
const fn words(used: usize) -> Table<[u16; 32]> {
    let mut table = Table([0; 32]);
    let mut i = 0;
    while i < 2 * used {
        table.0[i] = (if i < used { 2 * i } else { 32 + 2 * (i - used) }) as u16;
        i += 1;
    }
    table
}

static WORDS_3: Table<[u16; 32]> = words(12);
static WORDS_4: Table<[u16; 32]> = words(16);

impl Pair for u16 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eights(p: *const u16, q: *const u16) -> __m512 {
        // SAFETY: the caller vouches for eight elements at both.
        unsafe {
            let low = _mm256_castsi128_si256(_mm_loadu_si128(p.cast()));
            let both = _mm256_inserti128_si256::<1>(low, _mm_loadu_si128(q.cast()));
            _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(both))
        }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn pack<const C: usize>(pixels: [__m512; 2], out: *mut u16) {
        let [low, high] = pixels.map(|v| rounded(v));
        // Sums of weights that are positive need no saturation.
        // SAFETY: the caller vouches for the room.
        unsafe {
            if C == 3 {
                let words = _mm512_permutex2var_epi16(low, table(&WORDS_3), high);
                _mm256_storeu_si256(out.cast(), _mm512_castsi512_si256(words));
                _mm_storeu_si128(out.add(16).cast(), _mm512_extracti32x4_epi32::<2>(words));
            } else {
                let words = _mm512_permutex2var_epi16(low, table(&WORDS_4), high);
                _mm512_storeu_si512(out.cast(), words);
            }
        }
    }
}

impl Pair for f32 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eights(p: *const f32, q: *const f32) -> __m512 {
        // SAFETY: the caller vouches for eight elements at both.
        unsafe {
            let low = _mm512_castps256_ps512(_mm256_loadu_ps(p));
            _mm512_insertf32x8::<1>(low, _mm256_loadu_ps(q))
        }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn pack<const C: usize>(pixels: [__m512; 2], out: *mut f32) {
        // SAFETY: the caller vouches for the room.
        unsafe {
            let [low, high] = pixels;
            if C == 3 {
                // The four lanes behind the pixels are written over by the next ones.
                _mm512_storeu_ps(out, low);
                let out = out.add(12);
                _mm256_storeu_ps(out, _mm512_castps512_ps256(high));
                _mm_storeu_ps(out.add(8), _mm512_extractf32x4_ps::<2>(high));
            } else {
                _mm512_storeu_ps(out, low);
                _mm512_storeu_ps(out.add(16), high);
            }
        }
    }
}

/// Bilinear, three or four channels of more than a byte: two pixels a vector down the columns, four along the rows.
pub(super) struct Pairs<const C: usize>;

impl<const C: usize> Pairs<C> {
    /// Lane `i` of the packed results of four pixels comes from this lane of two vectors of two pixels each, whose
    /// eight lanes hold the left and then the right texel; `C` more is its neighbour to the right.
    const LEFT: [i32; LANES] = {
        let mut at = [0; LANES];
        let mut i = 0;
        while i < 4 * C {
            let pixel = i / C;
            at[i] = ((pixel / 2) * 16 + (pixel % 2) * 8 + i % C) as i32;
            i += 1;
        }
        at
    };
    /// The pixel of each lane of packed results.
    const PIXEL: [i32; LANES] = {
        let mut at = [0; LANES];
        let mut i = 0;
        while i < 4 * C {
            at[i] = (i / C) as i32;
            i += 1;
        }
        at
    };

    /// Four pixels from pixel `i` of a block on, packed.
    ///
    /// # Safety
    /// Eight elements are readable at every offset in both rows.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn four<T: Pair>(rows: *const T, stride: usize, slot: &Slot, i: usize) -> __m512 {
        // SAFETY: both arrays have 64 bytes.
        let (all_fx, all_fy) =
            unsafe { (_mm512_loadu_ps(slot.fx.as_ptr()), _mm512_loadu_ps(slot.fy.as_ptr())) };
        let halves = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
        let two = |i: usize| {
            // SAFETY: the caller vouches for the elements.
            let (upper, lower) = unsafe {
                let (p, q) =
                    (rows.byte_add(slot.offsets[i] as usize), rows.byte_add(slot.offsets[i + 1] as usize));
                (T::eights(p, q), T::eights(p.add(stride), q.add(stride)))
            };
            let lanes = _mm512_add_epi32(halves, _mm512_set1_epi32(i as i32));
            let fy = _mm512_permutexvar_ps(lanes, all_fy);
            _mm512_add_ps(upper, _mm512_mul_ps(fy, _mm512_sub_ps(lower, upper)))
        };
        let (a, b) = (two(i), two(i + 2));
        // SAFETY: the arrays are 64 bytes.
        let (left, pixel) = unsafe {
            (_mm512_loadu_si512(Self::LEFT.as_ptr().cast()), _mm512_loadu_si512(Self::PIXEL.as_ptr().cast()))
        };
        let right = _mm512_add_epi32(left, _mm512_set1_epi32(C as i32));
        let (left, right) = (_mm512_permutex2var_ps(a, left, b), _mm512_permutex2var_ps(a, right, b));
        let fx = _mm512_permutexvar_ps(_mm512_add_epi32(pixel, _mm512_set1_epi32(i as i32)), all_fx);
        _mm512_add_ps(left, _mm512_mul_ps(fx, _mm512_sub_ps(right, left)))
    }
}

impl<T: Pair, const C: usize> Kernel<T> for Pairs<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, slot: &Slot, out: *mut T) {
        // SAFETY: eight elements are readable in both rows; the output has `LANES * C` elements.
        unsafe {
            for i in [0, 8] {
                let low = Self::four(rows, stride, slot, i);
                let high = Self::four(rows, stride, slot, i + 4);
                T::pack::<C>([low, high], out.add(i * C));
            }
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
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, slot: &Slot, out: *mut T) {
        let (mut wx, mut wy) = ([[0f32; K]; LANES], [[0f32; K]; LANES]);
        for i in 0..LANES {
            wx[i] = self.0.at(slot.fx[i]);
            wy[i] = self.0.at(slot.fy[i]);
        }
        let mut buffer = [0f32; BUFFER];
        for i in 0..LANES {
            // SAFETY: `LOAD` elements are readable in each of `K` rows; four weights are at each multiple of
            // four below `K`.
            unsafe {
                let p = rows.byte_add(slot.offsets[i] as usize);
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
