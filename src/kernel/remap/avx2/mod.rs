//! AVX2: blocks of eight pixels whose taps all lie inside the picture, built as the AVX-512 kernels are.

use super::block::{Rest, bounds};
use super::sample::Sample;
use super::scalar::lanczos_table;
use super::weights::{Cubic, Lanczos};
use super::{Interpolation, Job, Points};
use crate::kernel::Isa;
use bilinear::{Bytes, Single};
use std::arch::x86_64::*;
use wide::{Pairs, Separable, Wide};

mod bilinear;
mod wide;

/// Pixels of a block.
const LANES: usize = 8;

/// Blocks between a prefetch and its use where positions are scattered.
const AHEAD: usize = 5;

/// A block's fractions and the elements' indices of its first taps.
struct Block {
    offsets: [u64; LANES],
    fx: __m256,
    fy: __m256,
}

/// A block kernel. `rows` points at element 0 of the source.
trait Kernel<T> {
    /// Channels.
    const CHANNELS: usize;
    /// Taps an axis.
    const TAPS: usize;
    /// Elements that may be read from a row's first tap on.
    const LOAD: usize;
    /// # Safety
    /// AVX2 is there. `rows[offset + j * stride..][..LOAD]` is readable for every offset and `j < TAPS`;
    /// `out` has room for `LANES * CHANNELS` elements.
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T);
}

/// Whole parts and fractions of the positions from `i` on.
///
/// # Safety
/// AVX2 is there and `i + LANES` positions exist.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn positions(points: &Points<'_, f32>, i: usize) -> (__m256i, __m256i, __m256, __m256) {
    // SAFETY: the caller vouches for the length, of all slices alike.
    unsafe {
        match points {
            Points::Plain(x, y) => {
                let (x, y) = (_mm256_loadu_ps(x.as_ptr().add(i)), _mm256_loadu_ps(y.as_ptr().add(i)));
                let (wx, wy) = (_mm256_floor_ps(x), _mm256_floor_ps(y));
                let fractions = (_mm256_sub_ps(x, wx), _mm256_sub_ps(y, wy));
                (_mm256_cvttps_epi32(wx), _mm256_cvttps_epi32(wy), fractions.0, fractions.1)
            }
            Points::Split(s) => (
                _mm256_loadu_si256(s.x.as_ptr().add(i).cast()),
                _mm256_loadu_si256(s.y.as_ptr().add(i).cast()),
                _mm256_loadu_ps(s.fx.as_ptr().add(i)),
                _mm256_loadu_ps(s.fy.as_ptr().add(i)),
            ),
        }
    }
}

/// `y * stride + x * channels` in 64 bits.
#[inline]
#[target_feature(enable = "avx2")]
fn offsets(x: __m256i, y: __m256i, stride: __m256i, channels: __m256i) -> [u64; LANES] {
    let half = |x: __m128i, y: __m128i| {
        let row = _mm256_mul_epu32(_mm256_cvtepu32_epi64(y), stride);
        _mm256_add_epi64(row, _mm256_mul_epu32(_mm256_cvtepu32_epi64(x), channels))
    };
    let low = half(_mm256_castsi256_si128(x), _mm256_castsi256_si128(y));
    let high = half(_mm256_extracti128_si256::<1>(x), _mm256_extracti128_si256::<1>(y));
    let mut all = [0u64; LANES];
    // SAFETY: both halves of the array are 32 bytes.
    unsafe {
        _mm256_storeu_si256(all.as_mut_ptr().cast(), low);
        _mm256_storeu_si256(all.as_mut_ptr().add(4).cast(), high);
    }
    all
}

/// One bit a lane: unsigned `a < limit`, where `last` is `limit - 1`.
#[inline]
#[target_feature(enable = "avx2")]
fn below(a: __m256i, last: __m256i) -> i32 {
    _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_min_epu32(a, last), a)))
}

/// Runs a kernel over all whole interior blocks and the scalar code over the rest.
#[target_feature(enable = "avx2")]
fn drive<T: Sample<Acc = f32>, K: Kernel<T>>(
    kernel: &K,
    job: &Job<'_, T>,
    points: &Points<'_, f32>,
    out: &mut [T],
) {
    let source = &job.source;
    let count = out.len() / K::CHANNELS;
    let mut rest = Rest::new(Isa::Avx2, job);
    let bounds = bounds(source, K::TAPS, K::LOAD);
    if bounds.contains(&0) {
        return rest.pixels(points, 0, count, out);
    }
    let before = _mm256_set1_epi32(K::TAPS as i32 / 2 - 1);
    let last = bounds.map(|b| _mm256_set1_epi32(b as i32 - 1));
    // A pixel at -taps/2 - 1 or at the side + taps/2 - 1 and beyond has no tap inside.
    let reach = _mm256_set1_epi32(K::TAPS as i32 / 2);
    let span = [source.width, source.height].map(|n| _mm256_set1_epi32((n + K::TAPS - 2) as i32));
    let stride = _mm256_set1_epi64x(source.row_stride as i64);
    let channels = _mm256_set1_epi64x(K::CHANNELS as i64);
    let far = _mm256_set1_epi32(32);
    let base = source.data.as_ptr();
    let mut start = 0;
    while start + LANES <= count {
        // SAFETY: `start + LANES <= count`, the length of all slices of positions.
        let (x, y, fx, fy) = unsafe { positions(points, start) };
        let (x0, y0) = (_mm256_sub_epi32(x, before), _mm256_sub_epi32(y, before));
        if below(x0, last[0]) & below(y0, last[1]) == 0xff {
            let first = _mm256_broadcastd_epi32(_mm256_castsi256_si128(y));
            let spread = _mm256_cmpgt_epi32(_mm256_abs_epi32(_mm256_sub_epi32(y, first)), far);
            if _mm256_testz_si256(spread, spread) == 0 && start + (AHEAD + 1) * LANES <= count {
                // SAFETY: the positions are there; prefetching has no other effect for any address.
                unsafe {
                    let (x, y, ..) = positions(points, start + AHEAD * LANES);
                    for offset in offsets(x, y, stride, channels) {
                        let first = base.wrapping_add(offset as usize);
                        _mm_prefetch::<_MM_HINT_T0>(first.cast());
                        for row in 1..K::TAPS {
                            _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(row * source.row_stride).cast());
                        }
                    }
                }
            }
            let block = Block { offsets: offsets(x0, y0, stride, channels), fx, fy };
            // SAFETY: the first taps are below `bounds`, which keeps every load inside the slice; the output
            // has `count * CHANNELS` elements; this function has the instruction set.
            unsafe {
                kernel.block(base, source.row_stride, &block, out.as_mut_ptr().add(start * K::CHANNELS));
            }
        } else {
            let near =
                below(_mm256_add_epi32(x, reach), span[0]) & below(_mm256_add_epi32(y, reach), span[1]);
            if near == 0 && rest.fills() {
                rest.fill(&mut out[start * K::CHANNELS..(start + LANES) * K::CHANNELS]);
            } else {
                rest.pixels(points, start, start + LANES, out);
            }
        }
        start += LANES;
    }
    rest.pixels(points, start, count, out);
}

/// Kernels of more than two taps; `false` for a format that has none.
#[inline]
#[target_feature(enable = "avx2")]
fn wide<T: Wide>(job: &Job<'_, T>, points: &Points<'_, f32>, out: &mut [T]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Bicubic(a), 3) => drive(&Separable::<_, 4, 3>(Cubic(a)), job, points, out),
        (Interpolation::Bicubic(a), 4) => drive(&Separable::<_, 4, 4>(Cubic(a)), job, points, out),
        (Interpolation::Lanczos4, 3) => {
            drive(&Separable::<_, 8, 3>(Lanczos(lanczos_table())), job, points, out)
        }
        (Interpolation::Lanczos4, 4) => {
            drive(&Separable::<_, 8, 4>(Lanczos(lanczos_table())), job, points, out)
        }
        _ => return false,
    }
    true
}

/// The kernels of bytes.
#[target_feature(enable = "avx2")]
pub(super) fn run_u8(job: &Job<'_, u8>, points: &Points<'_, f32>, out: &mut [u8]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Bilinear, 1) => drive(&Single, job, points, out),
        (Interpolation::Bilinear, 3) => drive(&Bytes::<3>, job, points, out),
        (Interpolation::Bilinear, 4) => drive(&Bytes::<4>, job, points, out),
        _ => return wide(job, points, out),
    }
    true
}

/// The kernels of 16-bit integers.
#[target_feature(enable = "avx2")]
pub(super) fn run_u16(job: &Job<'_, u16>, points: &Points<'_, f32>, out: &mut [u16]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Bilinear, 1) => drive(&Single, job, points, out),
        (Interpolation::Bilinear, 3) => drive(&Pairs::<3>, job, points, out),
        (Interpolation::Bilinear, 4) => drive(&Pairs::<4>, job, points, out),
        _ => return wide(job, points, out),
    }
    true
}

/// The kernels of singles.
#[target_feature(enable = "avx2")]
pub(super) fn run_f32(job: &Job<'_, f32>, points: &Points<'_, f32>, out: &mut [f32]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Bilinear, 1) => drive(&Single, job, points, out),
        (Interpolation::Bilinear, 3) => drive(&Pairs::<3>, job, points, out),
        (Interpolation::Bilinear, 4) => drive(&Pairs::<4>, job, points, out),
        _ => return wide(job, points, out),
    }
    true
}
