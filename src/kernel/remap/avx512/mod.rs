//! AVX-512: blocks of sixteen pixels.
//!
//! Bilinear, bytes and single channels: the texels of a pixel come by one scalar load a row and are inserted
//! into vectors; arithmetic has one vector a channel. Bilinear, other formats: two pixels a vector down the columns,
//! four along the rows. Wider kernels: one pixel at a time, four taps of up to four channels in a vector.
//! Gathers were 10 to 40 % slower, buffers of texels on the stack 5 to 10 %, stores past the caches 1 to 14 %.

use super::block::{self, Frame, Kernel, MOST, Set, Slot};
use super::copy::Copy;
use super::sample::Sample;
use super::scalar::lanczos_table;
use super::weights::{Cubic, Lanczos};
use super::{Interpolation, Job, Points, Row};
use crate::kernel::Isa;
use bilinear::{Bytes, Single};
use std::arch::x86_64::*;
use wide::{Pairs, Separable, Wide};

mod bilinear;
mod wide;

/// Pixels of a block.
const LANES: usize = MOST;

struct Avx512;

/// Whole parts and fractions of the positions that a matrix gives to sixteen pixels, as [`super::Buffer::matrix`]
/// makes them. What is not finite or too large has a whole part that is outside of every picture.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn row_positions(row: &Row<'_>, i: usize, whole: bool) -> (__m512i, __m512i, __m512, __m512) {
    let m = row.matrix;
    let [cx, cy, cw] = [1, 4, 7].map(|k| _mm512_set1_pd(m[k] * row.y + m[k + 1]));
    let affine = m[6] == 0.0 && m[7] == 0.0 && m[8] == 1.0;
    let eight = |first: f64| {
        let x = _mm512_add_pd(_mm512_set1_pd(row.x0 + first), _mm512_setr_pd(0., 1., 2., 3., 4., 5., 6., 7.));
        let along = |k: usize, c: __m512d| _mm512_add_pd(_mm512_mul_pd(_mm512_set1_pd(m[k]), x), c);
        let (px, py) = (along(0, cx), along(3, cy));
        let (px, py) = if affine {
            (px, py)
        } else {
            // A zero divisor makes infinity or NaN, which is nowhere.
            let r = _mm512_div_pd(_mm512_set1_pd(1.0), along(6, cw));
            (_mm512_mul_pd(px, r), _mm512_mul_pd(py, r))
        };
        [px, py].map(|p| {
            // Rounding modes 8 and 9: nearest even and down, without exceptions.
            let w = if whole { _mm512_roundscale_pd::<8>(p) } else { _mm512_roundscale_pd::<9>(p) };
            (_mm512_cvttpd_epi32(w), _mm512_cvtpd_ps(_mm512_sub_pd(p, w)))
        })
    };
    let ([(x0, fx0), (y0, fy0)], [(x1, fx1), (y1, fy1)]) = (eight(i as f64), eight((i + 8) as f64));
    let ints = |low, high| _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high);
    let floats = |low, high| _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
    (ints(x0, x1), ints(y0, y1), floats(fx0, fx1), floats(fy0, fy1))
}

impl Set for Avx512 {
    const ISA: Isa = Isa::Avx512;
    const LANES: usize = LANES;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn take(points: &Points<'_, f32>, i: usize, whole: bool, frame: &Frame, slot: &mut Slot) {
        // SAFETY: the caller vouches for the number of positions.
        let (x, y, fx, fy) = unsafe {
            match points {
                Points::Row(row) => row_positions(row, i, whole),
                Points::Plain(x, y) => {
                    let (x, y) = (_mm512_loadu_ps(x.as_ptr().add(i)), _mm512_loadu_ps(y.as_ptr().add(i)));
                    let floor =
                        |v| if whole { _mm512_roundscale_ps::<8>(v) } else { _mm512_roundscale_ps::<9>(v) };
                    let (wx, wy) = (floor(x), floor(y));
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
        };
        let set = |v: i32| _mm512_set1_epi32(v);
        let (x0, y0) = (_mm512_sub_epi32(x, set(frame.before)), _mm512_sub_epi32(y, set(frame.before)));
        let below = |v, limit: u32| _mm512_cmplt_epu32_mask(v, set(limit as i32));
        let inside = below(x0, frame.limit[0]) & below(y0, frame.limit[1]);
        let near = below(_mm512_add_epi32(x, set(frame.reach)), frame.span[0])
            & below(_mm512_add_epi32(y, set(frame.reach)), frame.span[1]);
        (slot.inside, slot.near) = (inside.into(), near.into());
        let first = _mm512_broadcastd_epi32(_mm512_castsi512_si128(y));
        slot.scattered = _mm512_cmpgt_epi32_mask(_mm512_abs_epi32(_mm512_sub_epi32(y, first)), set(32)) != 0;
        let [stride, pixel] = frame.bytes.map(|n| _mm512_set1_epi64(n as i64));
        let half = |x: __m256i, y: __m256i| {
            let row = _mm512_mul_epu32(_mm512_cvtepu32_epi64(y), stride);
            _mm512_add_epi64(row, _mm512_mul_epu32(_mm512_cvtepu32_epi64(x), pixel))
        };
        let (x0, y0) = (_mm512_maskz_mov_epi32(inside, x0), _mm512_maskz_mov_epi32(inside, y0));
        let low = half(_mm512_castsi512_si256(x0), _mm512_castsi512_si256(y0));
        let high = half(_mm512_extracti64x4_epi64::<1>(x0), _mm512_extracti64x4_epi64::<1>(y0));
        // SAFETY: the arrays have 128 and 64 bytes.
        unsafe {
            _mm512_storeu_si512(slot.offsets.as_mut_ptr().cast(), low);
            _mm512_storeu_si512(slot.offsets.as_mut_ptr().add(8).cast(), high);
            _mm512_storeu_ps(slot.fx.as_mut_ptr(), fx);
            _mm512_storeu_ps(slot.fy.as_mut_ptr(), fy);
        }
    }

    #[inline(always)]
    fn fetch(at: *const u8) {
        // SAFETY: prefetching has no other effect for any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) };
    }
}

/// Runs a kernel over all blocks.
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn drive<T: Sample<Acc = f32>, K: Kernel<T>>(
    kernel: &K,
    job: &Job<'_, T>,
    points: &Points<'_, f32>,
    out: &mut [T],
) {
    // SAFETY: this function is compiled for the set, and called where the machine has it.
    unsafe { block::drive::<Avx512, T, K>(kernel, job, points, out) };
}

/// Nearest, and kernels of more than two taps; `false` for a format that has none.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn wide<T: Wide>(job: &Job<'_, T>, points: &Points<'_, f32>, out: &mut [T]) -> bool {
    match (job.interpolation, job.source.channels) {
        (Interpolation::Nearest, 1) => drive(&Copy::<1, LANES>, job, points, out),
        (Interpolation::Nearest, 2) => drive(&Copy::<2, LANES>, job, points, out),
        (Interpolation::Nearest, 3) => drive(&Copy::<3, LANES>, job, points, out),
        (Interpolation::Nearest, 4) => drive(&Copy::<4, LANES>, job, points, out),
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
