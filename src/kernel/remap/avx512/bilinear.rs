//! Bilinear: bytes and single channels.

use super::{Kernel, LANES, Slot};
use std::arch::x86_64::*;

/// 2^23 in the bits of a float: an integer below it in the low bits makes the float 2^23 + that integer.
const MAGIC_BITS: i32 = 0x4b00_0000;
const MAGIC: f32 = 8_388_608.0;

/// The bilinear sum of four texels a lane, each raised by `raised`.
#[inline]
#[target_feature(enable = "avx512f")]
fn blend(a: __m512, b: __m512, c: __m512, d: __m512, raised: __m512, slot: &Slot) -> __m512 {
    // SAFETY: both arrays have 64 bytes.
    let (fx, fy) = unsafe { (_mm512_loadu_ps(slot.fx.as_ptr()), _mm512_loadu_ps(slot.fy.as_ptr())) };
    let left = _mm512_mul_ps(fy, _mm512_sub_ps(c, a));
    let right = _mm512_mul_ps(fy, _mm512_sub_ps(d, b));
    let left = _mm512_add_ps(_mm512_sub_ps(a, raised), left);
    let right = _mm512_add_ps(_mm512_sub_ps(b, raised), right);
    _mm512_add_ps(left, _mm512_mul_ps(fx, _mm512_sub_ps(right, left)))
}

/// Integers in the low bits of each lane.
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn rounded(x: __m512) -> __m512i {
    _mm512_castps_si512(_mm512_add_ps(x, _mm512_set1_ps(MAGIC)))
}

/// Eight bytes from each of two offsets.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn two(p: *const u8, at: &[u64; LANES], i: usize) -> __m128i {
    // SAFETY: the caller vouches for the bytes.
    unsafe {
        let first = _mm_loadl_epi64(p.add(at[i] as usize).cast());
        _mm_insert_epi64::<1>(first, p.add(at[i + 1] as usize).cast::<i64>().read_unaligned())
    }
}

/// Eight bytes from each of eight offsets.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn eight(p: *const u8, at: &[u64; LANES], i: usize) -> __m512i {
    // SAFETY: the caller vouches for the bytes.
    unsafe {
        let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(p, at, i)), two(p, at, i + 2));
        let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(two(p, at, i + 4)), two(p, at, i + 6));
        _mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high)
    }
}

/// Eight bytes from each offset: eight pixels in each vector.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn eights(p: *const u8, at: &[u64; LANES]) -> [__m512i; 2] {
    // SAFETY: the caller vouches for the bytes.
    unsafe { [eight(p, at, 0), eight(p, at, 8)] }
}

/// Bytes of three or four channels.
pub(super) struct Bytes<const C: usize>;

/// A table of a vector's size.
#[repr(align(64))]
pub(super) struct Table<T>(pub T);

/// `PICKS[byte]` selects that byte of each pixel's eight into the low byte of a lane that is otherwise 2^23.
static PICKS: [Table<[i32; LANES]>; 8] = {
    let mut table = [const { Table([0; LANES]) }; 8];
    let mut i = 0;
    while i < 8 * LANES {
        table[i / LANES].0[i % LANES] = MAGIC_BITS | (8 * (i % LANES) + i / LANES) as i32;
        i += 1;
    }
    table
};

/// Every fourth byte.
const LOW_BYTES: u64 = 0x1111_1111_1111_1111;

/// Places of the low bytes of a first and a second vector's lanes, `APART` bytes a pixel.
const fn places(apart: usize) -> Table<[u8; 64]> {
    let mut table = Table([0; 64]);
    let mut i = 0;
    while i < 64 {
        table.0[i] = (i / apart * 4 + if i % apart == 1 { 64 } else { 0 }) as u8;
        i += 1;
    }
    table
}

/// Keeps bytes but every third, which comes from the low bytes of the second vector's lanes.
const fn third() -> Table<[u8; 64]> {
    let mut table = Table([0; 64]);
    let mut i = 0;
    while i < 64 {
        table.0[i] = if i % 3 == 2 { 64 + i / 3 * 4 } else { i } as u8;
        i += 1;
    }
    table
}

static BY_THREE: Table<[u8; 64]> = places(3);
static THIRD: Table<[u8; 64]> = third();

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
pub(super) fn table<T>(table: &'static Table<T>) -> __m512i {
    const { assert!(size_of::<Table<T>>() == 64) };
    // SAFETY: the table is 64 bytes, and aligned so.
    unsafe { _mm512_load_si512(std::ptr::from_ref(table).cast()) }
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
fn pick(texels: &[__m512i; 2], byte: usize) -> __m512 {
    let index = table(&PICKS[byte]);
    _mm512_castsi512_ps(_mm512_mask2_permutex2var_epi8(texels[0], index, LOW_BYTES, texels[1]))
}

impl<const C: usize> Bytes<C> {
    /// Channel `c` of a block: a byte in each lane.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    fn channel(c: usize, upper: &[__m512i; 2], lower: &[__m512i; 2], slot: &Slot) -> __m512i {
        let (a, b) = (pick(upper, c), pick(upper, C + c));
        let (c, d) = (pick(lower, c), pick(lower, C + c));
        rounded(blend(a, b, c, d, _mm512_set1_ps(MAGIC), slot))
    }
}

impl<const C: usize> Kernel<u8> for Bytes<C> {
    const CHANNELS: usize = C;
    const TAPS: usize = 2;
    const LOAD: usize = 8;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u8, stride: usize, slot: &Slot, out: *mut u8) {
        // SAFETY: eight bytes are readable in both rows.
        let (upper, lower) =
            unsafe { (eights(rows, &slot.offsets), eights(rows.add(stride), &slot.offsets)) };
        let r = Self::channel(0, &upper, &lower, slot);
        let g = Self::channel(1, &upper, &lower, slot);
        let b = Self::channel(2, &upper, &lower, slot);
        if C == 3 {
            let pairs = _mm512_permutex2var_epi8(r, table(&BY_THREE), g);
            let all = _mm512_permutex2var_epi8(pairs, table(&THIRD), b);
            // SAFETY: the output has 48 bytes.
            unsafe {
                _mm256_storeu_si256(out.cast(), _mm512_castsi512_si256(all));
                _mm_storeu_si128(out.add(32).cast(), _mm512_extracti32x4_epi32::<2>(all));
            }
        } else {
            let a = Self::channel(3, &upper, &lower, slot);
            // Shifting moves the 0x4b of the float out.
            let (g, b) = (_mm512_slli_epi32::<8>(g), _mm512_slli_epi32::<16>(b));
            let low =
                _mm512_and_si512(_mm512_or_si512(_mm512_or_si512(r, g), b), _mm512_set1_epi32(0x00ff_ffff));
            // SAFETY: the output has 64 bytes.
            unsafe { _mm512_storeu_si512(out.cast(), _mm512_or_si512(low, _mm512_slli_epi32::<24>(a))) };
        }
    }
}

/// One channel of any type.
pub(super) struct Single;

impl Kernel<u8> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u8, stride: usize, slot: &Slot, out: *mut u8) {
        // SAFETY: two bytes are readable at every offset in both rows.
        let ((a, b), (c, d)) =
            unsafe { (byte_pairs(rows, &slot.offsets), byte_pairs(rows.add(stride), &slot.offsets)) };
        let sum = blend(a, b, c, d, _mm512_set1_ps(MAGIC), slot);
        // SAFETY: the output has 16 bytes.
        unsafe { _mm_storeu_si128(out.cast(), _mm512_cvtepi32_epi8(rounded(sum))) };
    }
}

/// Two bytes from each of eight offsets.
///
/// # Safety
/// The bytes are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn eight_pairs(p: *const u8, at: &[u64; LANES], i: usize) -> __m128i {
    // SAFETY: the caller vouches for the bytes.
    unsafe {
        let v = _mm_loadu_si16(p.add(at[i] as usize));
        let v = _mm_insert_epi16::<1>(v, p.add(at[i + 1] as usize).cast::<i16>().read_unaligned().into());
        let v = _mm_insert_epi16::<2>(v, p.add(at[i + 2] as usize).cast::<i16>().read_unaligned().into());
        let v = _mm_insert_epi16::<3>(v, p.add(at[i + 3] as usize).cast::<i16>().read_unaligned().into());
        let v = _mm_insert_epi16::<4>(v, p.add(at[i + 4] as usize).cast::<i16>().read_unaligned().into());
        let v = _mm_insert_epi16::<5>(v, p.add(at[i + 5] as usize).cast::<i16>().read_unaligned().into());
        let v = _mm_insert_epi16::<6>(v, p.add(at[i + 6] as usize).cast::<i16>().read_unaligned().into());
        _mm_insert_epi16::<7>(v, p.add(at[i + 7] as usize).cast::<i16>().read_unaligned().into())
    }
}

/// Left and right bytes of every pixel, raised by 2^23.
///
/// # Safety
/// Two bytes are readable at every offset.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn byte_pairs(p: *const u8, at: &[u64; LANES]) -> (__m512, __m512) {
    // SAFETY: the caller vouches for the bytes.
    let (low, high) = unsafe { (eight_pairs(p, at, 0), eight_pairs(p, at, 8)) };
    let all = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(low), high);
    split_pairs::<8>(_mm512_cvtepu16_epi32(all))
}

/// Two 16-bit elements from each of four offsets.
///
/// # Safety
/// They are readable.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn four_pairs(p: *const u16, at: &[u64; LANES], i: usize) -> __m128i {
    let p: *const u8 = p.cast();
    // SAFETY: the caller vouches for the elements.
    unsafe {
        let v = _mm_loadu_si32(p.add(at[i] as usize));
        let v = _mm_insert_epi32::<1>(v, p.add(at[i + 1] as usize).cast::<i32>().read_unaligned());
        let v = _mm_insert_epi32::<2>(v, p.add(at[i + 2] as usize).cast::<i32>().read_unaligned());
        _mm_insert_epi32::<3>(v, p.add(at[i + 3] as usize).cast::<i32>().read_unaligned())
    }
}

/// Left and right 16-bit elements of every pixel, raised by 2^23.
///
/// # Safety
/// Two elements are readable at every offset.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn word_pairs(p: *const u16, at: &[u64; LANES]) -> (__m512, __m512) {
    // SAFETY: the caller vouches for the elements.
    unsafe {
        let low = _mm256_castsi128_si256(four_pairs(p, at, 0));
        let high = _mm256_castsi128_si256(four_pairs(p, at, 8));
        let low = _mm256_inserti128_si256::<1>(low, four_pairs(p, at, 4));
        let high = _mm256_inserti128_si256::<1>(high, four_pairs(p, at, 12));
        split_pairs::<16>(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(low), high))
    }
}

/// Left and right floats of every pixel.
///
/// # Safety
/// Two floats are readable at every offset.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
unsafe fn float_pairs(p: *const f32, at: &[u64; LANES]) -> (__m512, __m512) {
    let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    // SAFETY: the caller vouches for the floats.
    let [low, high] = unsafe { eights(p.cast(), at) };
    let (low, high) = (_mm512_castsi512_ps(low), _mm512_castsi512_ps(high));
    (_mm512_permutex2var_ps(low, even, high), _mm512_permutex2var_ps(low, odd, high))
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
    const FETCHES: bool = true;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const u16, stride: usize, slot: &Slot, out: *mut u16) {
        // SAFETY: two elements are readable at every offset in both rows.
        let ((a, b), (c, d)) =
            unsafe { (word_pairs(rows, &slot.offsets), word_pairs(rows.add(stride), &slot.offsets)) };
        let sum = blend(a, b, c, d, _mm512_set1_ps(MAGIC), slot);
        // SAFETY: the output has 32 bytes.
        unsafe { _mm256_storeu_si256(out.cast(), _mm512_cvtepi32_epi16(rounded(sum))) };
    }
}

impl Kernel<f32> for Single {
    const CHANNELS: usize = 1;
    const TAPS: usize = 2;
    const LOAD: usize = 2;
    // So few operations a pixel that those to ask for memory cost more than they save: 465 against 537 Mpx/s.
    const FETCHES: bool = false;

    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,avx512vbmi")]
    unsafe fn block(&self, rows: *const f32, stride: usize, slot: &Slot, out: *mut f32) {
        // SAFETY: two floats are readable at every offset in both rows.
        let ((a, b), (c, d)) =
            unsafe { (float_pairs(rows, &slot.offsets), float_pairs(rows.add(stride), &slot.offsets)) };
        // SAFETY: the output has 64 bytes. Nothing is raised: subtracting 0.0 changes no value.
        unsafe { _mm512_storeu_ps(out, blend(a, b, c, d, _mm512_setzero_ps(), slot)) };
    }
}
