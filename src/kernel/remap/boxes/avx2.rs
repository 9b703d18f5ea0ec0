//! Bytes, a box at a time: its four rows as vectors of 16 words.

use super::bytes::{Words, put};
use super::{Out, ROW, TAPS, Taps, gathered, inside};
use crate::kernel::remap::Job;
use std::arch::x86_64::*;

/// Means over the first `n` boxes, of one to four channels.
///
/// # Safety
/// The machine has AVX2.
#[target_feature(enable = "avx2")]
pub(super) unsafe fn bytes(job: &Job<'_, u8>, taps: &Taps, words: &Words, n: usize, out: Out<'_, u8>) {
    // SAFETY: the machine has AVX2.
    unsafe {
        match job.source.channels {
            1 => counted::<1>(job, taps, words, n, out),
            2 => counted::<2>(job, taps, words, n, out),
            3 => counted::<3>(job, taps, words, n, out),
            _ => counted::<4>(job, taps, words, n, out),
        }
    }
}

/// # Safety
/// The machine has AVX2; the source has `C` channels.
#[target_feature(enable = "avx2")]
unsafe fn counted<const C: usize>(
    job: &Job<'_, u8>,
    taps: &Taps,
    words: &Words,
    n: usize,
    mut out: Out<'_, u8>,
) {
    let stride = job.source.row_stride;
    let half = _mm_set1_epi16(64);
    for i in 0..n {
        let down = match inside(job, taps, i) {
            // SAFETY: `inside` has found ROW bytes from the start of each of the four rows.
            Some(start) => unsafe { columns(job.source.data.as_ptr().add(start), stride, words, i) },
            None => {
                let rows: [[u8; ROW]; TAPS] = gathered(job, taps, i, 0..C);
                // SAFETY: four rows of ROW bytes, one after the other.
                unsafe { columns(rows.as_ptr().cast(), ROW, words, i) }
            }
        };
        let (low, high) = (_mm256_castsi256_si128(down), _mm256_extracti128_si256::<1>(down));
        // The four texels, each in the lowest words.
        let [a, b, c, e] = match C {
            1 => [low, _mm_srli_si128::<2>(low), _mm_srli_si128::<4>(low), _mm_srli_si128::<6>(low)],
            2 => [low, _mm_srli_si128::<4>(low), _mm_srli_si128::<8>(low), _mm_srli_si128::<12>(low)],
            3 => [low, _mm_srli_si128::<6>(low), _mm_alignr_epi8::<12>(high, low), _mm_srli_si128::<2>(high)],
            _ => [low, _mm_srli_si128::<8>(low), high, _mm_srli_si128::<8>(high)],
        };
        let share = |x: __m128i, k: usize| {
            _mm_mulhrs_epi16(_mm_sub_epi16(x, b), _mm_set1_epi32(words[0][k][i] as i32))
        };
        let rest = _mm_add_epi16(_mm_add_epi16(share(a, 0), share(c, 1)), share(e, 2));
        let sum = _mm_add_epi16(b, rest);
        match &mut out {
            Out::Elements(out) => {
                let rounded = _mm_srai_epi16::<7>(_mm_add_epi16(sum, half));
                let bytes = _mm_cvtsi128_si32(_mm_packus_epi16(rounded, rounded)).to_le_bytes();
                out[i * C..(i + 1) * C].copy_from_slice(&bytes[..C]);
            }
            Out::Numbers(_) => {
                let four = _mm_cvtsi128_si64(sum).to_le_bytes();
                for c in 0..C {
                    put(&mut out, i * C + c, i16::from_le_bytes([four[2 * c], four[2 * c + 1]]));
                }
            }
        }
    }
}

/// Down the columns of box `i`.
///
/// # Safety
/// The machine has AVX2; ROW bytes at `rows` and at three more multiples of `stride` are readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn columns(rows: *const u8, stride: usize, words: &Words, i: usize) -> __m256i {
    let row = |k: usize| {
        // SAFETY: the caller vouches for the row.
        let bytes = unsafe { _mm_loadu_si128(rows.add(k * stride).cast()) };
        _mm256_slli_epi16::<7>(_mm256_cvtepu8_epi16(bytes))
    };
    let b = row(1);
    let share = |x: __m256i, k: usize| {
        _mm256_mulhrs_epi16(_mm256_sub_epi16(x, b), _mm256_set1_epi32(words[1][k][i] as i32))
    };
    let rest = _mm256_add_epi16(_mm256_add_epi16(share(row(0), 0), share(row(2), 1)), share(row(3), 2));
    _mm256_add_epi16(b, rest)
}
