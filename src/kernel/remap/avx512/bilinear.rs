//! Bilinear: bytes and single channels.

use super::{Block, Kernel, LANES};
use std::arch::x86_64::*;

/// 2^23 in the bits of a float: an integer below it in the low bits makes the float 2^23 + that integer.
const MAGIC_BITS: i32 = 0x4b00_0000;
const MAGIC: f32 = 8_388_608.0;

/// The bilinear sum of four texels a lane, each raised by `raised`.
#[inline]
#[target_feature(enable = "avx512f")]
fn blend(a: __m512, b: __m512, c: __m512, d: __m512, raised: __m512, block: &Block) -> __m512 {
    let left = _mm512_mul_ps(block.fy, _mm512_sub_ps(c, a));
    let right = _mm512_mul_ps(block.fy, _mm512_sub_ps(d, b));
    let left = _mm512_add_ps(_mm512_sub_ps(a, raised), left);
    let right = _mm512_add_ps(_mm512_sub_ps(b, raised), right);
    _mm512_add_ps(left, _mm512_mul_ps(block.fx, _mm512_sub_ps(right, left)))
}

/// Integers in the low bits of each lane.
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn rounded(x: __m512) -> __m512i {
    _mm512_castps_si512(_mm512_add_ps(x, _mm512_set1_ps(MAGIC)))
}

/// Eight bytes from each offset: eight pixels in each vector.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn eights(p: *const u8, at: &[u64; LANES]) -> [__m512i; 2] {
    // SAFETY: the caller vouches for the bytes.
    let two = |i: usize| unsafe {
        let first = _mm_loadl_epi64(p.add(at[i] as usize).cast());
        _mm_insert_epi64::<1>(first, p.add(at[i + 1] as usize).cast::<i64>().read_unaligned())
    };
    [0, 8].map(|i| {
        let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(i)), two(i + 2));
        let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(i + 4)), two(i + 6));
        _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
    })
}

/// Bytes of three or four channels.
pub(super) struct Bytes<const C: usize>;

/// Selects byte `byte` of each pixel's eight into the low byte of a lane that is otherwise 2^23.
const fn picks(byte: usize) -> [i32; LANES] {
    let mut lanes = [0; LANES];
    let mut i = 0;
    while i < LANES {
        lanes[i] = MAGIC_BITS | (8 * i + byte) as i32;
        i += 1;
    }
    lanes
}

/// Every fourth byte.
const LOW_BYTES: u64 = 0x1111_1111_1111_1111;

impl<const C: usize> Kernel<u8> for Bytes<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u8, stride: usize, block: &Block, out: *mut u8) {
        // SAFETY: eight bytes are readable in both rows.
        let (upper, lower) =
            unsafe { (eights(rows, &block.offsets), eights(rows.add(stride), &block.offsets)) };
        let magic = _mm512_set1_ps(MAGIC);
        let channel = |c: usize| {
            let pick = |texels: &[__m512i; 2], byte: usize| {
                let lanes = picks(byte);
                // SAFETY: the table is 64 bytes.
                let index = unsafe { _mm512_loadu_si512(lanes.as_ptr().cast()) };
                _mm512_castsi512_ps(_mm512_mask2_permutex2var_epi8(texels[0], index, LOW_BYTES, texels[1]))
            };
            let (a, b) = (pick(&upper, c), pick(&upper, C + c));
            rounded(blend(a, b, pick(&lower, c), pick(&lower, C + c), magic, block))
        };
        let table = |f: fn(usize) -> u8| {
            let bytes: [u8; 64] = std::array::from_fn(f);
            // SAFETY: the table is 64 bytes.
            unsafe { _mm512_loadu_si512(bytes.as_ptr().cast()) }
        };
        let (r, g, b) = (channel(0), channel(1), channel(2));
        if C == 3 {
            // Bytes of r and g at their places, then b between them.
            let pairs = table(|i| (i / 3 * 4 + 64 * usize::from(i % 3 == 1)) as u8);
            let thirds = table(|i| if i % 3 == 2 { (i / 3 * 4 + 64) as u8 } else { i as u8 });
            let all = _mm512_permutex2var_epi8(_mm512_permutex2var_epi8(r, pairs, g), thirds, b);
            // SAFETY: the output has 48 bytes.
            unsafe {
                _mm256_storeu_si256(out.cast(), _mm512_castsi512_si256(all));
                _mm_storeu_si128(out.add(32).cast(), _mm512_extracti32x4_epi32::<2>(all));
            }
        } else {
            let a = channel(3);
            let pairs = table(|i| ((i & !3) + 64 * (i & 1)) as u8);
            let (rg, ba) = (_mm512_permutex2var_epi8(r, pairs, g), _mm512_permutex2var_epi8(b, pairs, a));
            // SAFETY: the output has 64 bytes.
            unsafe { _mm512_storeu_si512(out.cast(), _mm512_mask_blend_epi16(0xaaaa_aaaa, rg, ba)) };
        }
    }
}

/// One channel of any type.
pub(super) struct Single;

impl Kernel<u8> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u8, stride: usize, block: &Block, out: *mut u8) {
        let at = &block.offsets;
        let row = |p: *const u8| {
            // SAFETY: two bytes are readable at every offset.
            let pair = |i: usize| unsafe { i32::from(p.add(at[i] as usize).cast::<u16>().read_unaligned()) };
            let half = |i: usize| {
                let v = _mm_cvtsi32_si128(pair(i));
                let v = _mm_insert_epi16::<1>(v, pair(i + 1));
                let v = _mm_insert_epi16::<2>(v, pair(i + 2));
                let v = _mm_insert_epi16::<3>(v, pair(i + 3));
                let v = _mm_insert_epi16::<4>(v, pair(i + 4));
                let v = _mm_insert_epi16::<5>(v, pair(i + 5));
                let v = _mm_insert_epi16::<6>(v, pair(i + 6));
                _mm_insert_epi16::<7>(v, pair(i + 7))
            };
            let all = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(half(0)), half(8));
            split_pairs::<8>(_mm512_cvtepu16_epi32(all))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        let sum = blend(a, b, c, d, _mm512_set1_ps(MAGIC), block);
        // SAFETY: the output has 16 bytes.
        unsafe { _mm_storeu_si128(out.cast(), _mm512_cvtepi32_epi8(rounded(sum))) };
    }
}

/// Left and right texel of `BITS` bits in each lane, as 2^23 + value.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn split_pairs<const BITS: u32>(pairs: __m512i) -> (__m512, __m512) {
    let magic = _mm512_set1_epi32(MAGIC_BITS);
    let low = _mm512_set1_epi32((1 << BITS) - 1);
    let left = _mm512_or_si512(_mm512_and_si512(pairs, low), magic);
    let right = _mm512_or_si512(_mm512_srli_epi32::<BITS>(pairs), magic);
    (_mm512_castsi512_ps(left), _mm512_castsi512_ps(right))
}

impl Kernel<u16> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u16, stride: usize, block: &Block, out: *mut u16) {
        let at = &block.offsets;
        let row = |p: *const u16| {
            // SAFETY: two elements are readable at every offset.
            let pair = |i: usize| unsafe { p.add(at[i] as usize).cast::<i32>().read_unaligned() };
            let four = |i: usize| {
                let v = _mm_cvtsi32_si128(pair(i));
                let v = _mm_insert_epi32::<1>(v, pair(i + 1));
                let v = _mm_insert_epi32::<2>(v, pair(i + 2));
                _mm_insert_epi32::<3>(v, pair(i + 3))
            };
            let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(0)), four(4));
            let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(8)), four(12));
            split_pairs::<16>(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        let sum = blend(a, b, c, d, _mm512_set1_ps(MAGIC), block);
        // SAFETY: the output has 32 bytes.
        unsafe { _mm256_storeu_si256(out.cast(), _mm512_cvtepi32_epi16(rounded(sum))) };
    }
}

impl Kernel<f32> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const f32, stride: usize, block: &Block, out: *mut f32) {
        let bytes = block.offsets.map(|o| 4 * o);
        let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        let odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
        let row = |p: *const f32| {
            // SAFETY: two floats are readable at every offset.
            let [low, high] = unsafe { eights(p.cast(), &bytes) }.map(|v| _mm512_castsi512_ps(v));
            (_mm512_permutex2var_ps(low, even, high), _mm512_permutex2var_ps(low, odd, high))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        // SAFETY: the output has 64 bytes. Nothing is raised: subtracting 0.0 changes no value.
        unsafe { _mm512_storeu_ps(out, blend(a, b, c, d, _mm512_setzero_ps(), block)) };
    }
}
