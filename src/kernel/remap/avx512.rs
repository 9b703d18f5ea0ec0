//! AVX-512: blocks of sixteen pixels whose taps all lie inside the picture.
//!
//! Bilinear, bytes and single channels: the texels of a pixel come by one scalar load a row and are inserted
//! into vectors; arithmetic has one vector a channel. Bilinear, other formats: one pixel at a time, a row of
//! both texels in a vector. Wider kernels: one pixel at a time, four taps of up to four channels in a vector.
//! Gathers were 10 to 40 % slower, buffers of texels on the stack 5 to 10 %.

use super::block::{Rest, bounds};
use super::sample::Sample;
use super::scalar::lanczos_table;
use super::weights::{Table, cubic, look_up};
use super::{Interpolation, Job, Points};
use crate::kernel::Isa;
use std::arch::x86_64::*;

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
    let mut rest = Rest::new(Isa::Avx512, job, LANES);
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
fn rounded(x: __m512) -> __m512i {
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
struct Bytes<const C: usize>;

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
            let pairs = table(|i| (i / 3 * 4 + 64 * (i % 3 & 1)) as u8);
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
struct Single;

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

/// Loads of wider formats and the way back.
trait Wide: Sample<Acc = f32> {
    /// The eight elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn eight(p: *const Self) -> __m256;
    /// The sixteen elements from `p` on.
    /// # Safety
    /// They are readable.
    unsafe fn sixteen(p: *const Self) -> __m512;
    /// Rounds and stores `count` numbers of a buffer that has room for a multiple of 16.
    /// # Safety
    /// `out` has room for `count` elements, a multiple of 16.
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut Self);
}

/// Numbers of a block of four channels, and three more that a store may spill.
const BUFFER: usize = 4 * LANES + 4;

/// Clamps and rounds sixteen numbers into the low bits of the lanes.
#[inline]
#[target_feature(enable = "avx512f")]
fn saturated(x: __m512, max: f32) -> __m512i {
    // The operands' order makes 0 of NaN.
    rounded(_mm512_min_ps(_mm512_max_ps(x, _mm512_setzero_ps()), _mm512_set1_ps(max)))
}

impl Wide for u8 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const u8) -> __m256 {
        // SAFETY: the caller vouches for eight bytes.
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(unsafe { _mm_loadl_epi64(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const u8) -> __m512 {
        // SAFETY: the caller vouches for sixteen bytes.
        _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u8) {
        for i in (0..count).step_by(16) {
            // SAFETY: `count` is at most 64, and so is the room.
            unsafe {
                let v = saturated(_mm512_loadu_ps(from.as_ptr().add(i)), 255.0);
                _mm_storeu_si128(out.add(i).cast(), _mm512_cvtepi32_epi8(v));
            }
        }
    }
}

impl Wide for u16 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const u16) -> __m256 {
        // SAFETY: the caller vouches for eight elements.
        _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(unsafe { _mm_loadu_si128(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const u16) -> __m512 {
        // SAFETY: the caller vouches for sixteen elements.
        _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(unsafe { _mm256_loadu_si256(p.cast()) }))
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut u16) {
        for i in (0..count).step_by(16) {
            // SAFETY: `count` is at most 64, and so is the room.
            unsafe {
                let v = saturated(_mm512_loadu_ps(from.as_ptr().add(i)), 65_535.0);
                _mm256_storeu_si256(out.add(i).cast(), _mm512_cvtepi32_epi16(v));
            }
        }
    }
}

impl Wide for f32 {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn eight(p: *const f32) -> __m256 {
        // SAFETY: the caller vouches for eight floats.
        unsafe { _mm256_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn sixteen(p: *const f32) -> __m512 {
        // SAFETY: the caller vouches for sixteen floats.
        unsafe { _mm512_loadu_ps(p) }
    }
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn store(from: &[f32; BUFFER], count: usize, out: *mut f32) {
        // SAFETY: `count` is at most 64, and so is the room.
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
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        let mut buffer = [0f32; BUFFER];
        let second = _mm256_setr_epi32(3, 4, 5, 5, 3, 4, 5, 5);
        // SAFETY: eight elements are readable in both rows; the buffers are long enough.
        unsafe {
            _mm512_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm512_storeu_ps(fy.as_mut_ptr(), block.fy);
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
    const LOAD: usize = (K - 4) * C + 16;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const T, stride: usize, block: &Block, out: *mut T) {
        let (mut fx, mut fy) = ([0f32; LANES], [0f32; LANES]);
        // SAFETY: the arrays are 64 bytes.
        unsafe {
            _mm512_storeu_ps(fx.as_mut_ptr(), block.fx);
            _mm512_storeu_ps(fy.as_mut_ptr(), block.fy);
        }
        let (wx, wy) = (fx.map(|f| self.0.at(f)), fy.map(|f| self.0.at(f)));
        let mut buffer = [0f32; BUFFER];
        let apart = _mm512_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 8, 8, 9, 10, 11, 11);
        let spread = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
        for i in 0..LANES {
            // SAFETY: `LOAD` elements are readable in each of `K` rows; four weights are at each multiple of
            // four below `K`.
            unsafe {
                let p = rows.add(block.offsets[i] as usize);
                // Four taps, four lanes each; the sum does not depend on where three channels are put apart.
                let column = |group: usize| {
                    let p = p.add(4 * group * C);
                    let mut sum = _mm512_mul_ps(_mm512_set1_ps(wy[i][0]), T::sixteen(p));
                    for (j, &w) in wy[i].iter().enumerate().skip(1) {
                        sum = _mm512_add_ps(
                            sum,
                            _mm512_mul_ps(_mm512_set1_ps(w), T::sixteen(p.add(j * stride))),
                        );
                    }
                    let four = _mm_loadu_ps(wx[i].as_ptr().add(4 * group));
                    let placed = if C == 3 { _mm512_permutexvar_ps(apart, sum) } else { sum };
                    _mm512_mul_ps(_mm512_permutexvar_ps(spread, _mm512_castps128_ps512(four)), placed)
                };
                let four = if K == 8 { _mm512_add_ps(column(0), column(1)) } else { column(0) };
                let high = _mm512_extractf32x8_ps::<1>(four);
                let two = _mm256_add_ps(_mm512_castps512_ps256(four), high);
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
