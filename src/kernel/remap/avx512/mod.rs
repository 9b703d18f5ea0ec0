//! AVX-512: blocks of sixteen pixels whose taps all lie inside the picture.
//!
//! Bilinear, bytes and single channels: the texels of a pixel come by one scalar load a row and are inserted
//! into vectors; arithmetic has one vector a channel. Bilinear, other formats: one pixel at a time, a row of
//! both texels in a vector. Wider kernels: one pixel at a time, four taps of up to four channels in a vector.
//! Gathers were 10 to 40 % slower, buffers of texels on the stack 5 to 10 %.

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
const LANES: usize = 16;

/// Blocks between a prefetch and its use where positions are scattered.
const AHEAD: usize = 3;

/// A block's fractions and the elements' indices of its first taps.
struct Block {
    offsets: [u64; LANES],
    fx: __m512,
    fy: __m512,
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
    /// AVX-512 F, BW, VL, DQ and VBMI are there. `rows[offset + j * stride..][..LOAD]` is readable for every
    /// offset and `j < TAPS`; `out` has room for `LANES * CHANNELS` elements.
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T);
}

/// Whole parts and fractions of the positions from `i` on.
///
/// # Safety
/// AVX-512 F is there and `i + LANES` positions exist.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn positions(points: &Points<'_, f32>, i: usize) -> (__m512i, __m512i, __m512, __m512) {
    // SAFETY: the caller vouches for the length, of all slices alike.
    unsafe {
        match points {
            Points::Plain(x, y) => {
                let (x, y) = (_mm512_loadu_ps(x.as_ptr().add(i)), _mm512_loadu_ps(y.as_ptr().add(i)));
                // Rounding mode 9: down, without exceptions.
                let (wx, wy) = (_mm512_roundscale_ps::<9>(x), _mm512_roundscale_ps::<9>(y));
                let fractions = (_mm512_sub_ps(x, wx), _mm512_sub_ps(y, wy));
                (_mm512_cvttps_epi32(wx), _mm512_cvttps_epi32(wy), fractions.0, fractions.1)
            }
            Points::Split(s) => (
                _mm512_loadu_si512(s.x.as_ptr().add(i).cast()),
                _mm512_loadu_si512(s.y.as_ptr().add(i).cast()),
                _mm512_loadu_ps(s.fx.as_ptr().add(i)),
                _mm512_loadu_ps(s.fy.as_ptr().add(i)),
            ),
        }
    }
}

/// `y * stride + x * channels` in 64 bits.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn offsets(x: __m512i, y: __m512i, stride: __m512i, channels: __m512i) -> [u64; LANES] {
    let half = |x: __m256i, y: __m256i| {
        let row = _mm512_mul_epu32(_mm512_cvtepu32_epi64(y), stride);
        _mm512_add_epi64(row, _mm512_mul_epu32(_mm512_cvtepu32_epi64(x), channels))
    };
    let low = half(_mm512_castsi512_si256(x), _mm512_castsi512_si256(y));
    let high = half(_mm512_extracti64x4_epi64::<1>(x), _mm512_extracti64x4_epi64::<1>(y));
    let mut all = [0u64; LANES];
    // SAFETY: both halves of the array are 64 bytes.
    unsafe {
        _mm512_storeu_si512(all.as_mut_ptr().cast(), low);
        _mm512_storeu_si512(all.as_mut_ptr().add(8).cast(), high);
    }
    all
}

/// Runs a kernel over all whole interior blocks and the scalar code over the rest.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn drive<T: Sample<Acc = f32>, K: Kernel<T>>(
    kernel: &K,
    job: &Job<'_, T>,
    points: &Points<'_, f32>,
    out: &mut [T],
) {
    let source = &job.source;
    let count = out.len() / K::CHANNELS;
    let mut rest = Rest::new(Isa::Avx512, job);
    let bounds = bounds(source, K::TAPS, K::LOAD);
    let before = _mm512_set1_epi32(K::TAPS as i32 / 2 - 1);
    let limit = bounds.map(|b| _mm512_set1_epi32(b as i32));
    // A pixel at -taps/2 - 1 or at the side + taps/2 - 1 and beyond has no tap inside.
    let reach = _mm512_set1_epi32(K::TAPS as i32 / 2);
    let span = [source.width, source.height].map(|n| _mm512_set1_epi32((n + K::TAPS - 1) as i32));
    let stride = _mm512_set1_epi64(source.row_stride as i64);
    let channels = _mm512_set1_epi64(K::CHANNELS as i64);
    let far = _mm512_set1_epi32(32);
    let base = source.data.as_ptr();
    let mut start = 0;
    while start + LANES <= count {
        // SAFETY: `start + LANES <= count`, the length of all slices of positions.
        let (x, y, fx, fy) = unsafe { positions(points, start) };
        let (x0, y0) = (_mm512_sub_epi32(x, before), _mm512_sub_epi32(y, before));
        let inside = _mm512_cmplt_epu32_mask(x0, limit[0]) & _mm512_cmplt_epu32_mask(y0, limit[1]);
        if inside == u16::MAX {
            let spread =
                _mm512_abs_epi32(_mm512_sub_epi32(y, _mm512_broadcastd_epi32(_mm512_castsi512_si128(y))));
            if _mm512_cmpgt_epi32_mask(spread, far) != 0 && start + (AHEAD + 1) * LANES <= count {
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
            // has `count * CHANNELS` elements; this function has the instruction sets.
            unsafe {
                kernel.block(base, source.row_stride, &block, out.as_mut_ptr().add(start * K::CHANNELS));
            }
        } else {
            let near = _mm512_cmplt_epu32_mask(_mm512_add_epi32(x, reach), span[0])
                & _mm512_cmplt_epu32_mask(_mm512_add_epi32(y, reach), span[1]);
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
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
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
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
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
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
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
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
pub(super) fn run_f32(job: &Job<'_, f32>, points: &Points<'_, f32>, out: &mut [f32]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Bilinear, 1) => drive(&Single, job, points, out),
        (Interpolation::Bilinear, 3) => drive(&Pairs::<3>, job, points, out),
        (Interpolation::Bilinear, 4) => drive(&Pairs::<4>, job, points, out),
        _ => return wide(job, points, out),
    }
    true
}
