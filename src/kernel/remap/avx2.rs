//! AVX2: blocks of eight pixels whose taps all lie inside the picture, built as the AVX-512 kernels are.

use super::block::{Rest, bounds};
use super::sample::Sample;
use super::scalar::lanczos_table;
use super::weights::{Table, cubic, look_up};
use super::{Interpolation, Job, Points};
use crate::kernel::Isa;
use std::arch::x86_64::*;

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
    let mut rest = Rest::new(Isa::Avx2, job, LANES);
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

/// 2^23 in the bits of a float: an integer below it in the low bits makes the float 2^23 + that integer.
const MAGIC_BITS: i32 = 0x4b00_0000;
const MAGIC: f32 = 8_388_608.0;

/// The bilinear sum of four texels a lane, each raised by `raised`.
#[inline]
#[target_feature(enable = "avx2")]
fn blend(a: __m256, b: __m256, c: __m256, d: __m256, raised: __m256, block: &Block) -> __m256 {
    let left = _mm256_mul_ps(block.fy, _mm256_sub_ps(c, a));
    let right = _mm256_mul_ps(block.fy, _mm256_sub_ps(d, b));
    let left = _mm256_add_ps(_mm256_sub_ps(a, raised), left);
    let right = _mm256_add_ps(_mm256_sub_ps(b, raised), right);
    _mm256_add_ps(left, _mm256_mul_ps(block.fx, _mm256_sub_ps(right, left)))
}

/// Integers in the low bits of each lane, 0x4b00 in the high ones.
#[inline]
#[target_feature(enable = "avx2")]
fn rounded(x: __m256) -> __m256i {
    _mm256_castps_si256(_mm256_add_ps(x, _mm256_set1_ps(MAGIC)))
}

/// Eight bytes from each offset: the first four of each pixel, then the last four.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn eights(p: *const u8, at: &[u64; LANES]) -> [__m256i; 2] {
    // SAFETY: the caller vouches for the bytes.
    let two = |i: usize| unsafe {
        let first = _mm_loadl_epi64(p.add(at[i] as usize).cast());
        _mm_insert_epi64::<1>(first, p.add(at[i + 1] as usize).cast::<i64>().read_unaligned())
    };
    let a = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(0)), two(4));
    let b = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(2)), two(6));
    let (even, odd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpackhi_epi32(a, b));
    [_mm256_unpacklo_epi32(even, odd), _mm256_unpackhi_epi32(even, odd)]
}

/// Bytes of three or four channels.
struct Bytes<const C: usize>;

impl<const C: usize> Kernel<u8> for Bytes<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const u8, stride: usize, block: &Block, out: *mut u8) {
        // SAFETY: eight bytes are readable in both rows.
        let (upper, lower) =
            unsafe { (eights(rows, &block.offsets), eights(rows.add(stride), &block.offsets)) };
        let magic = _mm256_set1_epi32(MAGIC_BITS);
        let channel = |c: usize| {
            let pick = |texels: &[__m256i; 2], byte: usize| {
                // Byte `byte % 4` of each lane into the low one; a negative index makes 0.
                let lane = |i: i32| !0xff | (4 * i + (byte % 4) as i32);
                let index =
                    _mm256_setr_epi32(lane(0), lane(1), lane(2), lane(3), lane(0), lane(1), lane(2), lane(3));
                let picked = _mm256_shuffle_epi8(texels[byte / 4], index);
                _mm256_castsi256_ps(_mm256_or_si256(picked, magic))
            };
            let (a, b) = (pick(&upper, c), pick(&upper, C + c));
            let (c, d) = (pick(&lower, c), pick(&lower, C + c));
            rounded(blend(a, b, c, d, _mm256_set1_ps(MAGIC), block))
        };
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
struct Single;

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
fn words(v: __m256i) -> __m128i {
    let v = _mm256_and_si256(v, _mm256_set1_epi32(0xffff));
    _mm_packus_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256::<1>(v))
}

impl Kernel<u8> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const u8, stride: usize, block: &Block, out: *mut u8) {
        let at = &block.offsets;
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
        let sum = words(rounded(blend(a, b, c, d, _mm256_set1_ps(MAGIC), block)));
        // SAFETY: the output has 8 bytes.
        unsafe { _mm_storel_epi64(out.cast(), _mm_packus_epi16(sum, sum)) };
    }
}

impl Kernel<u16> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx2")]
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
            split_pairs::<16>(_mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(0)), four(4)))
        };
        // SAFETY: the second row is inside the source.
        let ((a, b), (c, d)) = (row(rows), row(unsafe { rows.add(stride) }));
        let sum = blend(a, b, c, d, _mm256_set1_ps(MAGIC), block);
        // SAFETY: the output has 16 bytes.
        unsafe { _mm_storeu_si128(out.cast(), words(rounded(sum))) };
    }
}

impl Kernel<f32> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const f32, stride: usize, block: &Block, out: *mut f32) {
        let bytes = block.offsets.map(|o| 4 * o);
        // SAFETY: two floats are readable at every offset.
        let row = |p: *const f32| unsafe { eights(p.cast(), &bytes) }.map(|v| _mm256_castsi256_ps(v));
        // SAFETY: the second row is inside the source.
        let ([a, b], [c, d]) = (row(rows), row(unsafe { rows.add(stride) }));
        // SAFETY: the output has 32 bytes. Nothing is raised: subtracting 0.0 changes no value.
        unsafe { _mm256_storeu_ps(out, blend(a, b, c, d, _mm256_setzero_ps(), block)) };
    }
}

/// Numbers of a block of four channels, and three more that a store may spill.
const BUFFER: usize = 4 * LANES + 4;

/// Loads of wider formats and the way back.
trait Wide: Sample<Acc = f32> {
    /// The eight elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn eight(p: *const Self) -> __m256;
    /// Rounds and stores `count` numbers, a multiple of 8.
    /// # Safety
    /// `out` has room for them.
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut Self);
}

/// Clamps and rounds eight numbers into the low bits of the lanes.
#[inline]
#[target_feature(enable = "avx2")]
fn saturated(x: __m256, max: f32) -> __m256i {
    // The operands' order makes 0 of NaN.
    rounded(_mm256_min_ps(_mm256_max_ps(x, _mm256_setzero_ps()), _mm256_set1_ps(max)))
}

impl Wide for u8 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const u8) -> __m256 {
        // SAFETY: the caller vouches for eight bytes.
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(unsafe { _mm_loadl_epi64(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u8) {
        for i in (0..count).step_by(8) {
            // SAFETY: `count` is at most 32, and so is the room.
            unsafe {
                let v = words(saturated(_mm256_loadu_ps(from.as_ptr().add(i)), 255.0));
                _mm_storel_epi64(out.add(i).cast(), _mm_packus_epi16(v, v));
            }
        }
    }
}

impl Wide for u16 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const u16) -> __m256 {
        // SAFETY: the caller vouches for eight elements.
        _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u16) {
        for i in (0..count).step_by(8) {
            // SAFETY: `count` is at most 32, and so is the room.
            unsafe {
                let v = words(saturated(_mm256_loadu_ps(from.as_ptr().add(i)), 65_535.0));
                _mm_storeu_si128(out.add(i).cast(), v);
            }
        }
    }
}

impl Wide for f32 {
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn eight(p: *const f32) -> __m256 {
        // SAFETY: the caller vouches for eight floats.
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut f32) {
        // SAFETY: `count` is at most 32, and so is the room.
        unsafe { std::ptr::copy_nonoverlapping(from.as_ptr(), out, count) };
    }
}

/// Bilinear, three or four channels of more than a byte.
struct Pairs<const C: usize>;

impl<T: Wide, const C: usize> Kernel<T> for Pairs<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        let mut buffer = [0f32; BUFFER];
        let second = _mm256_setr_epi32(3, 4, 5, 5, 3, 4, 5, 5);
        // SAFETY: eight elements are readable in both rows; the buffers are long enough.
        unsafe {
            _mm256_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm256_storeu_ps(fy.as_mut_ptr(), block.fy);
            for i in 0..LANES {
                let p = rows.add(block.offsets[i] as usize);
                let (upper, lower) = (T::eight(p), T::eight(p.add(stride)));
                let fy = _mm256_set1_ps(fy[i]);
                let both = _mm256_add_ps(upper, _mm256_mul_ps(fy, _mm256_sub_ps(lower, upper)));
                let left = _mm256_castps256_ps128(both);
                let right = if C == 3 {
                    _mm256_castps256_ps128(_mm256_permutevar8x32_ps(both, second))
                } else {
                    _mm256_extractf128_ps::<1>(both)
                };
                let step = _mm_mul_ps(_mm_set1_ps(fx[i]), _mm_sub_ps(right, left));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), _mm_add_ps(left, step));
            }
            T::store(&buffer, LANES * C, out);
        }
    }
}

/// Weights of the pixels of a block.
trait Weights<const K: usize> {
    /// Weights at fraction `f`.
    fn at(&self, f: f32) -> [f32; K];
}

/// Cubic convolution with this parameter.
struct Cubic(f32);

impl Weights<4> for Cubic {
    #[inline(always)]
    fn at(&self, f: f32) -> [f32; 4] {
        cubic(self.0, f)
    }
}

/// Lanczos weights from the table.
struct Lanczos(&'static Table<f32>);

impl Weights<8> for Lanczos {
    #[inline(always)]
    fn at(&self, f: f32) -> [f32; 8] {
        look_up(self.0, f)
    }
}

/// `K` x `K` taps of three or four channels.
struct Separable<W, const K: usize, const C: usize>(W);

impl<T: Wide, W: Weights<K>, const K: usize, const C: usize> Kernel<T> for Separable<W, K, C> {
    const CHANNELS: usize = C;
    const TAPS: usize = K;
    const LOAD: usize = (K - 2) * C + 8;

    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        // SAFETY: the arrays are 32 bytes.
        unsafe {
            _mm256_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm256_storeu_ps(fy.as_mut_ptr(), block.fy);
        }
        let (wx, wy) = (fx.map(|f| self.0.at(f)), fy.map(|f| self.0.at(f)));
        let mut buffer = [0f32; BUFFER];
        let apart = _mm256_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5);
        for i in 0..LANES {
            // SAFETY: `LOAD` elements are readable in each of `K` rows.
            unsafe {
                let p = rows.add(block.offsets[i] as usize);
                // Two taps, four lanes each; the sum does not depend on where three channels are put apart.
                let columns = |group: usize| {
                    let p = p.add(2 * group * C);
                    let mut sum = _mm256_mul_ps(_mm256_set1_ps(wy[i][0]), T::eight(p));
                    for (j, &w) in wy[i].iter().enumerate().skip(1) {
                        sum =
                            _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(w), T::eight(p.add(j * stride))));
                    }
                    let placed = if C == 3 { _mm256_permutevar8x32_ps(sum, apart) } else { sum };
                    let w = _mm256_set_m128(_mm_set1_ps(wx[i][2 * group + 1]), _mm_set1_ps(wx[i][2 * group]));
                    _mm256_mul_ps(w, placed)
                };
                let two = if K == 8 {
                    let first = _mm256_add_ps(columns(0), columns(2));
                    _mm256_add_ps(first, _mm256_add_ps(columns(1), columns(3)))
                } else {
                    _mm256_add_ps(columns(0), columns(1))
                };
                let one = _mm_add_ps(_mm256_castps256_ps128(two), _mm256_extractf128_ps::<1>(two));
                _mm_storeu_ps(buffer.as_mut_ptr().add(i * C), one);
            }
        }
        // SAFETY: the output has room for the block.
        unsafe { T::store(&buffer, LANES * C, out) };
    }
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
