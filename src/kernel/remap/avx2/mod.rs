//! AVX2: blocks of eight pixels, built as the AVX-512 kernels are.

use super::block::{self, Frame, Kernel, Set, Slot};
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
const LANES: usize = 8;

struct Avx2;

/// Whole parts and fractions of the positions that a matrix gives to eight pixels, as [`super::Buffer::matrix`]
/// makes them. What is not finite or too large has a whole part that is outside of every picture.
#[inline]
#[target_feature(enable = "avx2")]
fn row_positions(row: &Row<'_>, i: usize, whole: bool) -> (__m256i, __m256i, __m256, __m256) {
    let m = row.matrix;
    let [cx, cy, cw] = [1, 4, 7].map(|k| _mm256_set1_pd(m[k] * row.y + m[k + 1]));
    let affine = m[6] == 0.0 && m[7] == 0.0 && m[8] == 1.0;
    let four = |first: f64| {
        let x = _mm256_add_pd(_mm256_set1_pd(row.x0 + first), _mm256_setr_pd(0.0, 1.0, 2.0, 3.0));
        let along = |k: usize, c: __m256d| _mm256_add_pd(_mm256_mul_pd(_mm256_set1_pd(m[k]), x), c);
        let (px, py) = (along(0, cx), along(3, cy));
        let (px, py) = if affine {
            (px, py)
        } else {
            // A zero divisor makes infinity or NaN, which is nowhere.
            let r = _mm256_div_pd(_mm256_set1_pd(1.0), along(6, cw));
            (_mm256_mul_pd(px, r), _mm256_mul_pd(py, r))
        };
        [px, py].map(|p| {
            // Rounding modes 8 and 9: nearest even and down, without exceptions.
            let w = if whole { _mm256_round_pd::<8>(p) } else { _mm256_round_pd::<9>(p) };
            (_mm256_cvttpd_epi32(w), _mm256_cvtpd_ps(_mm256_sub_pd(p, w)))
        })
    };
    let ([(x0, fx0), (y0, fy0)], [(x1, fx1), (y1, fy1)]) = (four(i as f64), four((i + 4) as f64));
    (_mm256_set_m128i(x1, x0), _mm256_set_m128i(y1, y0), _mm256_set_m128(fx1, fx0), _mm256_set_m128(fy1, fy0))
}

/// One bit a lane: unsigned `a < limit`.
#[inline]
#[target_feature(enable = "avx2")]
fn below(a: __m256i, limit: u32) -> __m256i {
    let flip = _mm256_set1_epi32(i32::MIN);
    _mm256_cmpgt_epi32(_mm256_set1_epi32((limit ^ 0x8000_0000) as i32), _mm256_xor_si256(a, flip))
}

/// One bit a lane.
#[inline]
#[target_feature(enable = "avx2")]
fn bits(mask: __m256i) -> u32 {
    _mm256_movemask_ps(_mm256_castsi256_ps(mask)) as u32
}

impl Set for Avx2 {
    const ISA: Isa = Isa::Avx2;
    const LANES: usize = LANES;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn take(points: &Points<'_, f32>, i: usize, whole: bool, frame: &Frame, slot: &mut Slot) {
        // SAFETY: the caller vouches for the number of positions.
        let (x, y, fx, fy) = unsafe {
            match points {
                Points::Row(row) => row_positions(row, i, whole),
                Points::Plain(x, y) => {
                    let (x, y) = (_mm256_loadu_ps(x.as_ptr().add(i)), _mm256_loadu_ps(y.as_ptr().add(i)));
                    let floor = |v| if whole { _mm256_round_ps::<8>(v) } else { _mm256_round_ps::<9>(v) };
                    let (wx, wy) = (floor(x), floor(y));
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
        };
        let set = |v: i32| _mm256_set1_epi32(v);
        let (x0, y0) = (_mm256_sub_epi32(x, set(frame.before)), _mm256_sub_epi32(y, set(frame.before)));
        let inside = _mm256_and_si256(below(x0, frame.limit[0]), below(y0, frame.limit[1]));
        let near = _mm256_and_si256(
            below(_mm256_add_epi32(x, set(frame.reach)), frame.span[0]),
            below(_mm256_add_epi32(y, set(frame.reach)), frame.span[1]),
        );
        (slot.inside, slot.near) = (bits(inside), bits(near));
        let first = _mm256_broadcastd_epi32(_mm256_castsi256_si128(y));
        let apart = _mm256_abs_epi32(_mm256_sub_epi32(y, first));
        slot.scattered = bits(_mm256_cmpgt_epi32(apart, set(32))) != 0;
        let [stride, pixel] = frame.bytes.map(|n| _mm256_set1_epi64x(n as i64));
        let half = |x: __m128i, y: __m128i| {
            let row = _mm256_mul_epu32(_mm256_cvtepu32_epi64(y), stride);
            _mm256_add_epi64(row, _mm256_mul_epu32(_mm256_cvtepu32_epi64(x), pixel))
        };
        let (x0, y0) = (_mm256_and_si256(inside, x0), _mm256_and_si256(inside, y0));
        let low = half(_mm256_castsi256_si128(x0), _mm256_castsi256_si128(y0));
        let high = half(_mm256_extracti128_si256::<1>(x0), _mm256_extracti128_si256::<1>(y0));
        // SAFETY: the arrays have room for eight.
        unsafe {
            _mm256_storeu_si256(slot.offsets.as_mut_ptr().cast(), low);
            _mm256_storeu_si256(slot.offsets.as_mut_ptr().add(4).cast(), high);
            _mm256_storeu_ps(slot.fx.as_mut_ptr(), fx);
            _mm256_storeu_ps(slot.fy.as_mut_ptr(), fy);
        }
    }

    #[inline(always)]
    fn fetch(at: *const u8) {
        // SAFETY: prefetching has no other effect for any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(at.cast()) };
    }
}

/// Runs a kernel over all blocks.
#[target_feature(enable = "avx2")]
fn drive<T: Sample<Acc = f32>, K: Kernel<T>>(
    kernel: &K,
    job: &Job<'_, T>,
    points: &Points<'_, f32>,
    out: &mut [T],
) {
    // SAFETY: this function is compiled for the set, and called where the machine has it.
    unsafe { block::drive::<Avx2, T, K>(kernel, job, points, out) };
}

/// Nearest, and kernels of more than two taps; `false` for a format that has none.
#[inline]
#[target_feature(enable = "avx2")]
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
