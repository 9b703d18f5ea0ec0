//! AVX-512 forms of the sRGB kernels; each returns how many numbers it has made.

use super::scalar::LIGHT;
use super::{FIRST, LAST, SrgbBytes};
use std::arch::x86_64::*;

/// Two tables of 128 bytes as four vectors.
#[inline]
#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn table(plane: &[u8; 256]) -> [__m512i; 4] {
    // SAFETY: 64 bytes from 0, 64, 128 and 192 lie in the array.
    std::array::from_fn(|k| unsafe { _mm512_loadu_si512(plane.as_ptr().add(64 * k).cast()) })
}

/// Bit `c` of every texel: whether lane `i` belongs to channel `channel`, for 64 lanes.
fn lanes_of(channel: usize, channels: usize, period: usize) -> u64 {
    (0..64).filter(|i| (i / period) % channels == channel).fold(0, |mask, i| mask | 1 << i)
}

/// # Safety
/// The machine has AVX-512 F, BW, VL, DQ and VBMI; `channels` is 1 to 4.
#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
pub unsafe fn halve_srgb(
    rows: [&[u8]; 2],
    channels: usize,
    linear_last: bool,
    srgb: &SrgbBytes,
    out: &mut [f32],
) -> usize {
    // Numbers made at a time: whole texels.
    let step = 16 / channels * channels;
    let groups = {
        let needed = 2 * step;
        let bytes = rows[0].len().min(rows[1].len());
        // Each load takes 32 bytes, each store 16 numbers.
        let by_load = if bytes < 32 { 0 } else { (bytes - 32) / needed + 1 };
        let by_store = if out.len() < 16 { 0 } else { (out.len() - 16) / step + 1 };
        by_load.min(by_store)
    };
    // Byte 4 i + k of the arranged vector is code k of number i: two of row a, two of row b.
    let arrange: [u8; 64] = std::array::from_fn(|lane| {
        let (i, k) = ((lane / 4).min(step - 1), lane % 4);
        let at = i / channels * 2 * channels + i % channels + (k % 2) * channels;
        (at + 32 * (k / 2)) as u8
    });
    let linear: u64 = if linear_last { lanes_of(channels - 1, channels, 4) } else { 0 };
    let scales: [f32; 16] = std::array::from_fn(|i| {
        let is_linear = linear_last && i % channels == channels - 1;
        // A linear code stands in the third byte: 2^16 times four.
        if is_linear { 0.25 / 65_536.0 } else { LIGHT }
    });
    // SAFETY: group g reads 32 bytes from 2 step g of each row and writes 16 numbers from step g; `groups`
    // is chosen so that both lie inside. The arrays have 64 bytes each.
    unsafe {
        let arrange = _mm512_loadu_si512(arrange.as_ptr().cast());
        let scale = _mm512_loadu_ps(scales.as_ptr());
        let [low, middle, high] = [table(&srgb.planes[0]), table(&srgb.planes[1]), table(&srgb.planes[2])];
        let (ones, ones16, shift8) = (_mm512_set1_epi8(1), _mm512_set1_epi16(1), _mm512_set1_epi16(256));
        for g in 0..groups {
            let a = _mm256_loadu_si256(rows[0].as_ptr().add(2 * step * g).cast());
            let b = _mm256_loadu_si256(rows[1].as_ptr().add(2 * step * g).cast());
            let codes =
                _mm512_permutexvar_epi8(arrange, _mm512_inserti64x4::<1>(_mm512_castsi256_si512(a), b));
            let upper = _mm512_movepi8_mask(codes);
            let (in_low, in_high) = (!upper & !linear, upper & !linear);
            let find = |t: &[__m512i; 4]| {
                let first = _mm512_maskz_permutex2var_epi8(in_low, t[0], codes, t[1]);
                let second = _mm512_maskz_permutex2var_epi8(in_high, t[2], codes, t[3]);
                _mm512_or_si512(first, second)
            };
            let pairs = |bytes: __m512i| _mm512_maddubs_epi16(bytes, ones);
            let low = _mm512_madd_epi16(pairs(find(&low)), ones16);
            let middle = _mm512_madd_epi16(pairs(find(&middle)), shift8);
            let high = _mm512_mask_mov_epi8(find(&high), linear, codes);
            let high = _mm512_slli_epi32::<16>(_mm512_madd_epi16(pairs(high), ones16));
            let sum = _mm512_add_epi32(_mm512_add_epi32(low, middle), high);
            let mean = _mm512_mul_ps(_mm512_cvtepi32_ps(sum), scale);
            _mm512_storeu_ps(out.as_mut_ptr().add(step * g), mean);
        }
    }
    groups * step
}

/// # Safety
/// The machine has AVX-512 F, BW, VL, DQ and VBMI; `channels` is 1 to 4.
#[target_feature(enable = "avx2,avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
pub unsafe fn to_srgb(
    numbers: &[f32],
    channels: usize,
    linear_last: bool,
    srgb: &SrgbBytes,
    out: &mut [u8],
) -> usize {
    let step = 16 / channels * channels;
    let count = numbers.len().min(out.len());
    let groups = if count < 16 { 0 } else { (count - 16) / step + 1 };
    let linear = if linear_last { lanes_of(channels - 1, channels, 1) as u16 } else { 0 };
    assert_eq!(srgb.codes.len(), (LAST - FIRST + 1) as usize);
    // SAFETY: group g reads and writes 16 elements from step g, which `groups` keeps inside. Gathered indices
    // are clamped to FIRST..=LAST, less FIRST, the table's own range.
    unsafe {
        let (least, one) = (_mm512_set1_ps(f32::from_bits(FIRST << 16)), _mm512_set1_ps(1.0));
        let (first, half) = (_mm512_set1_epi32(FIRST as i32), _mm512_set1_ps(0.5));
        let trailing = _mm512_set1_epi32(0xffff);
        let full = _mm512_set1_epi32(255);
        for g in 0..groups {
            let x = _mm512_loadu_ps(numbers.as_ptr().add(step * g));
            // The second operand is taken where the first is NaN.
            let bits = _mm512_castps_si512(_mm512_min_ps(_mm512_max_ps(x, least), one));
            let index = _mm512_sub_epi32(_mm512_srli_epi32::<16>(bits), first);
            let entry = _mm512_i32gather_epi32::<4>(index, srgb.codes.as_ptr().cast());
            let code = _mm512_srli_epi32::<16>(_mm512_add_epi32(entry, _mm512_and_si512(bits, trailing)));
            // Alpha: rounded half up; below zero and NaN become 0 by the max with zero.
            let plain = _mm512_max_ps(_mm512_add_ps(x, half), _mm512_setzero_ps());
            let plain = _mm512_min_epu32(_mm512_cvttps_epu32(plain), full);
            let code = _mm512_mask_mov_epi32(code, linear, plain);
            _mm_storeu_si128(out.as_mut_ptr().add(step * g).cast(), _mm512_cvtepi32_epi8(code));
        }
    }
    groups * step
}
