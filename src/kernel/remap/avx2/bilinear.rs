//! Bilinear: bytes and single channels.

use super::{Kernel, Slot};
use crate::kernel::remap::block::MOST;
use std::arch::x86_64::*;

/// 2^23 in the bits of a float: an integer below it in the low bits makes the float 2^23 + that integer.
const MAGIC_BITS: i32 = 0x4b00_0000;
const MAGIC: f32 = 8_388_608.0;

/// The bilinear sum of four texels a lane, each raised by `raised`.
#[inline]
#[target_feature(enable = "avx2")]
fn blend(a: __m256, b: __m256, c: __m256, d: __m256, raised: __m256, slot: &Slot) -> __m256 {
    // SAFETY: both arrays have 64 bytes.
    let (fx, fy) = unsafe { (_mm256_loadu_ps(slot.fx.as_ptr()), _mm256_loadu_ps(slot.fy.as_ptr())) };
    let left = _mm256_mul_ps(fy, _mm256_sub_ps(c, a));
    let right = _mm256_mul_ps(fy, _mm256_sub_ps(d, b));
    let left = _mm256_add_ps(_mm256_sub_ps(a, raised), left);
    let right = _mm256_add_ps(_mm256_sub_ps(b, raised), right);
    _mm256_add_ps(left, _mm256_mul_ps(fx, _mm256_sub_ps(right, left)))
}

/// Integers in the low bits of each lane, 0x4b00 in the high ones.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn rounded(x: __m256) -> __m256i {
    _mm256_castps_si256(_mm256_add_ps(x, _mm256_set1_ps(MAGIC)))
}

/// Eight bytes from each of two offsets.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn two(p: *const u8, at: &[u64; MOST], i: usize) -> __m128i {
    // SAFETY: the caller vouches for the bytes.
    unsafe {
        let first = _mm_loadl_epi64(p.add(at[i] as usize).cast());
        _mm_insert_epi64::<1>(first, p.add(at[i + 1] as usize).cast::<i64>().read_unaligned())
    }
}

/// Eight bytes from each offset: the first four of each pixel, then the last four.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn eights(p: *const u8, at: &[u64; MOST]) -> [__m256i; 2] {
    // SAFETY: the caller vouches for the bytes.
    let (a, b) = unsafe {
        (
            _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(p, at, 0)), two(p, at, 4)),
            _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(p, at, 2)), two(p, at, 6)),
        )
    };
    let (even, odd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpackhi_epi32(a, b));
    [_mm256_unpacklo_epi32(even, odd), _mm256_unpackhi_epi32(even, odd)]
}

/// Bytes of three or four channels.
pub(super) struct Bytes<const C: usize>;

/// Byte `byte % 4` of each lane of half `byte / 4`, raised by 2^23.
#[inline]
#[target_feature(enable = "avx2")]
fn pick(texels: &[__m256i; 2], byte: usize) -> __m256 {
    // A negative index makes 0.
    let first =
        _mm256_setr_epi32(!0xff, !0xff | 4, !0xff | 8, !0xff | 12, !0xff, !0xff | 4, !0xff | 8, !0xff | 12);
    let index = _mm256_add_epi32(first, _mm256_set1_epi32((byte % 4) as i32));
    let picked = _mm256_shuffle_epi8(texels[byte / 4], index);
    _mm256_castsi256_ps(_mm256_or_si256(picked, _mm256_set1_epi32(MAGIC_BITS)))
}

impl<const C: usize> Bytes<C> {
    /// Channel `c` of a block: a byte in each lane.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn channel(c: usize, upper: &[__m256i; 2], lower: &[__m256i; 2], slot: &Slot) -> __m256i {
        let (a, b) = (pick(upper, c), pick(upper, C + c));
        let (c, d) = (pick(lower, c), pick(lower, C + c));
        rounded(blend(a, b, c, d, _mm256_set1_ps(MAGIC), slot))
    }
}

impl<const C: usize> Kernel<u8> for Bytes<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const u8, stride: usize, slot: &Slot, out: *mut u8) {
        // SAFETY: eight bytes are readable in both rows.
        let (upper, lower) =
            unsafe { (eights(rows, &slot.offsets), eights(rows.add(stride), &slot.offsets)) };
        let channel = |c: usize| Self::channel(c, &upper, &lower, slot);
        // Shifting moves the 0x4b of the float out.
        let (g, b) = (_mm256_slli_epi32::<8>(channel(1)), _mm256_slli_epi32::<16>(channel(2)));
        let all = _mm256_or_si256(_mm256_or_si256(channel(0), g), b);
        // SAFETY: the output has `8 * C` bytes: 12 + 12 or 32.
        unsafe {
            if C == 3 {
                let index = _mm256_setr_epi8(
                    0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1, 0, 1, 2, 4, 5, 6, 8, 9, 10, 12,
                    13, 14, -1, -1, -1, -1,
                );
                let packed = _mm256_shuffle_epi8(all, index);
                let high = _mm256_extracti128_si256::<1>(packed);
                _mm_storeu_si128(out.cast(), _mm256_castsi256_si128(packed));
                _mm_storel_epi64(out.add(12).cast(), high);
                out.add(20).cast::<i32>().write_unaligned(_mm_extract_epi32::<2>(high));
            } else {
                let low = _mm256_and_si256(all, _mm256_set1_epi32(0x00ff_ffff));
                let a = _mm256_slli_epi32::<24>(channel(3));
                _mm256_storeu_si256(out.cast(), _mm256_or_si256(low, a));
            }
        }
    }
}

/// One channel of any type.
pub(super) struct Single;

/// Left and right texel of `BITS` bits in each lane, as 2^23 + value.
#[inline]
#[target_feature(enable = "avx2")]
fn split_pairs<const BITS: i32>(pairs: __m256i) -> (__m256, __m256) {
    let magic = _mm256_set1_epi32(MAGIC_BITS);
    let low = _mm256_set1_epi32((1 << BITS) - 1);
    let left = _mm256_or_si256(_mm256_and_si256(pairs, low), magic);
    let right = _mm256_or_si256(_mm256_srli_epi32::<BITS>(pairs), magic);
    (_mm256_castsi256_ps(left), _mm256_castsi256_ps(right))
}

/// The low 16 bits of the lanes.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn words(v: __m256i) -> __m128i {
    let v = _mm256_and_si256(v, _mm256_set1_epi32(0xffff));
    _mm_packus_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256::<1>(v))
}

impl Kernel<u8> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const u8, stride: usize, slot: &Slot, out: *mut u8) {
        let at = &slot.offsets;
        let row = |p: *const u8| {
            // SAFETY: two bytes are readable at every offset.
            let pair = |i: usize| unsafe { i32::from(p.add(at[i] as usize).cast::<u16>().read_unaligned()) };
            let v = _mm_cvtsi32_si128(pair(0));
            let v = _mm_insert_epi16::<1>(v, pair(1));
            let v = _mm_insert_epi16::<2>(v, pair(2));
            let v = _mm_insert_epi16::<3>(v, pair(3));
            let v = _mm_insert_epi16::<4>(v, pair(4));
            let v = _mm_insert_epi16::<5>(v, pair(5));
            let v = _mm_insert_epi16::<6>(v, pair(6));
            split_pairs::<8>(_mm256_cvtepu16_epi32(_mm_insert_epi16::<7>(v, pair(7))))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        let sum = words(rounded(blend(a, b, c, d, _mm256_set1_ps(MAGIC), slot)));
        // SAFETY: the output has 8 bytes.
        unsafe { _mm_storel_epi64(out.cast(), _mm_packus_epi16(sum, sum)) };
    }
}

impl Kernel<u16> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const u16, stride: usize, slot: &Slot, out: *mut u16) {
        let at = &slot.offsets;
        let row = |p: *const u16| {
            // SAFETY: two elements are readable at every offset.
            let pair = |i: usize| unsafe { p.byte_add(at[i] as usize).cast::<i32>().read_unaligned() };
            let four = |i: usize| {
                let v = _mm_cvtsi32_si128(pair(i));
                let v = _mm_insert_epi32::<1>(v, pair(i + 1));
                let v = _mm_insert_epi32::<2>(v, pair(i + 2));
                _mm_insert_epi32::<3>(v, pair(i + 3))
            };
            split_pairs::<16>(_mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(0)), four(4)))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        let sum = blend(a, b, c, d, _mm256_set1_ps(MAGIC), slot);
        // SAFETY: the output has 16 bytes.
        unsafe { _mm_storeu_si128(out.cast(), words(rounded(sum))) };
    }
}

impl Kernel<f32> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const f32, stride: usize, slot: &Slot, out: *mut f32) {
        // SAFETY: two floats are readable at every offset.
        let row = |p: *const f32| unsafe { eights(p.cast(), &slot.offsets) }.map(|v| _mm256_castsi256_ps(v));
        // SAFETY: the second row is inside the source.
        let ([a, b], [c, d]) = (row(rows), row(unsafe { rows.add(stride) }));
        // SAFETY: the output has 32 bytes. Nothing is raised: subtracting 0.0 changes no value.
        unsafe { _mm256_storeu_ps(out, blend(a, b, c, d, _mm256_setzero_ps(), slot)) };
    }
}
