//! Bytes, a box at a time: its four rows as vectors of 16 words.

use super::bytes::UNIT;
use super::{
    ACROSS, DOWN, Out, ROW, SLOPE_ACROSS, SLOPE_DOWN, TAPS, Taps, all_inside, gathered, inside, start,
};
use crate::kernel::remap::Job;
use std::arch::x86_64::*;

/// Means over boxes of one to four channels.
///
/// # Safety
/// The machine has AVX2.
#[target_feature(enable = "avx2")]
pub(super) unsafe fn bytes(job: &Job<'_, u8>, taps: &Taps, out: Out<'_, u8>) {
    // SAFETY: the machine has AVX2.
    unsafe {
        match (job.source.channels, taps.leans) {
            (1, false) => counted::<1, false>(job, taps, out),
            (2, false) => counted::<2, false>(job, taps, out),
            (3, false) => counted::<3, false>(job, taps, out),
            (4, false) => counted::<4, false>(job, taps, out),
            (1, true) => counted::<1, true>(job, taps, out),
            (2, true) => counted::<2, true>(job, taps, out),
            (3, true) => counted::<3, true>(job, taps, out),
            _ => counted::<4, true>(job, taps, out),
        }
    }
}

/// # Safety
/// The machine has AVX2; the source has `C` channels.
#[target_feature(enable = "avx2")]
unsafe fn counted<const C: usize, const LEANS: bool>(job: &Job<'_, u8>, taps: &Taps, mut out: Out<'_, u8>) {
    let stride = job.source.row_stride;
    let half = _mm_set1_epi16(64);
    let all = all_inside(job, taps);
    for i in 0..taps.n {
        let found = if all { Some(start(job, taps, i)) } else { inside(job, taps, i) };
        let rows = match found {
            // SAFETY: `inside` or `all_inside` has found ROW bytes from the start of each of the four rows.
            Some(start) => unsafe { load(job.source.data.as_ptr().add(start), stride) },
            None => {
                let rows: [[u8; ROW]; TAPS] = gathered(job, taps, i, 0..C);
                // SAFETY: four rows of ROW bytes, one after the other.
                unsafe { load(rows.as_ptr().cast(), ROW) }
            }
        };
        let differences = rows.map(|row| _mm256_sub_epi16(row, rows[1]));
        let down = |which: usize| {
            let share = |row: usize, k: usize| {
                _mm256_mulhrs_epi16(differences[row], _mm256_set1_epi32(taps.words[which][k][i] as i32))
            };
            _mm256_add_epi16(_mm256_add_epi16(share(0, 0), share(2, 1)), share(3, 2))
        };
        let across = |which: usize, [a, b, c, e]: [__m128i; 4]| {
            let share = |x: __m128i, k: usize| {
                _mm_mulhrs_epi16(_mm_sub_epi16(x, b), _mm_set1_epi32(taps.words[which][k][i] as i32))
            };
            _mm_add_epi16(_mm_add_epi16(share(a, 0), share(c, 1)), share(e, 2))
        };
        let four = texels::<C>(_mm256_add_epi16(rows[1], down(DOWN)));
        let mut sum = _mm_add_epi16(four[1], across(ACROSS, four));
        if LEANS {
            sum = _mm_adds_epi16(sum, across(SLOPE_ACROSS, texels::<C>(down(SLOPE_DOWN))));
        }
        match &mut out {
            Out::Elements(out) => {
                let rounded = _mm_srai_epi16::<7>(_mm_adds_epi16(sum, half));
                let bytes = _mm_cvtsi128_si32(_mm_packus_epi16(rounded, rounded)).to_le_bytes();
                out[i * C..(i + 1) * C].copy_from_slice(&bytes[..C]);
            }
            Out::Numbers(out) => {
                let numbers = _mm_cvtepi32_ps(_mm_cvtepi16_epi32(sum));
                let mut four = [0.0; 4];
                // SAFETY: room for four numbers.
                unsafe { _mm_storeu_ps(four.as_mut_ptr(), _mm_mul_ps(numbers, _mm_set1_ps(1.0 / UNIT))) };
                out[i * C..(i + 1) * C].copy_from_slice(&four[..C]);
            }
        }
    }
}

/// The four texels of a row of words, each in the lowest words.
#[inline]
#[target_feature(enable = "avx2")]
fn texels<const C: usize>(row: __m256i) -> [__m128i; 4] {
    let (low, high) = (_mm256_castsi256_si128(row), _mm256_extracti128_si256::<1>(row));
    match C {
        1 => [low, _mm_srli_si128::<2>(low), _mm_srli_si128::<4>(low), _mm_srli_si128::<6>(low)],
        2 => [low, _mm_srli_si128::<4>(low), _mm_srli_si128::<8>(low), _mm_srli_si128::<12>(low)],
        3 => [low, _mm_srli_si128::<6>(low), _mm_alignr_epi8::<12>(high, low), _mm_srli_si128::<2>(high)],
        _ => [low, _mm_srli_si128::<8>(low), high, _mm_srli_si128::<8>(high)],
    }
}

/// Four rows of bytes in units of 1/128.
///
/// # Safety
/// The machine has AVX2; ROW bytes at `rows` and at three more multiples of `stride` are readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn load(rows: *const u8, stride: usize) -> [__m256i; TAPS] {
    let row = |k: usize| {
        // SAFETY: the caller vouches for the row.
        let bytes = unsafe { _mm_loadu_si128(rows.add(k * stride).cast()) };
        _mm256_slli_epi16::<7>(_mm256_cvtepu8_epi16(bytes))
    };
    [row(0), row(1), row(2), row(3)]
}
