//! AVX2 forms of the kernels of plain bytes; each returns how many numbers it has made.

use std::arch::x86_64::*;

/// # Safety
/// The machine has AVX2.
#[target_feature(enable = "avx2")]
pub unsafe fn to_bytes(numbers: &[f32], out: &mut [u8]) -> usize {
    let (half, zero, full) = (_mm256_set1_ps(0.5), _mm256_setzero_ps(), _mm256_set1_ps(255.0));
    // The packs work in halves of vectors: this puts their quarters in order.
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    let (blocks, _) = numbers.as_chunks::<32>();
    let (outs, _) = out.as_chunks_mut::<32>();
    for (numbers, out) in blocks.iter().zip(&mut *outs) {
        let eight = |k: usize| {
            // SAFETY: eight numbers from 0, 8, 16 and 24 are in the block.
            let x = _mm256_add_ps(unsafe { _mm256_loadu_ps(numbers.as_ptr().add(8 * k)) }, half);
            // The second operand is taken where the first is NaN.
            _mm256_cvttps_epi32(_mm256_min_ps(_mm256_max_ps(x, zero), full))
        };
        let (low, high) = (_mm256_packs_epi32(eight(0), eight(1)), _mm256_packs_epi32(eight(2), eight(3)));
        let bytes = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(low, high), order);
        // SAFETY: the output has 32 bytes.
        unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), bytes) };
    }
    32 * blocks.len().min(outs.len())
}

/// Four channels.
///
/// # Safety
/// The machine has AVX2.
#[target_feature(enable = "avx2")]
pub unsafe fn halve_bytes_4(a: &[u8], b: &[u8], out: &mut [f32]) -> usize {
    let quarter = _mm256_set1_ps(0.25);
    let (rows_a, _) = a.as_chunks::<16>();
    let (rows_b, _) = b.as_chunks::<16>();
    let (outs, _) = out.as_chunks_mut::<8>();
    let count = rows_a.len().min(rows_b.len()).min(outs.len());
    for ((a, b), out) in rows_a.iter().zip(rows_b).zip(outs) {
        // SAFETY: the rows have 16 bytes each, the output eight numbers.
        unsafe {
            let four = |row: &[u8; 16]| _mm256_cvtepu8_epi16(_mm_loadu_si128(row.as_ptr().cast()));
            let down = _mm256_add_epi16(four(a), four(b));
            // The low half of each half is a texel's sum.
            let sums = _mm256_add_epi16(down, _mm256_srli_si256::<8>(down));
            let both = _mm256_castsi256_si128(_mm256_permute4x64_epi64::<0b1000>(sums));
            let sums = _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(both));
            _mm256_storeu_ps(out.as_mut_ptr(), _mm256_mul_ps(sums, quarter));
        }
    }
    8 * count
}

/// Means of 2 x 2 texels of 1 to 4 channels, halves up.
///
/// # Safety
/// The machine has AVX2.
#[target_feature(enable = "avx2")]
pub unsafe fn halve_codes(a: &[u8], b: &[u8], channels: usize, out: &mut [u8]) -> usize {
    // Bytes read for what half a vector holds, and made of them: whole texels.
    let read = 16 / (2 * channels) * 2 * channels;
    let made = read / 2;
    // The two codes of each mean side by side.
    let order: [u8; 16] = std::array::from_fn(|k| {
        let (i, second) = (k / 2, k % 2);
        if i < made { (i / channels * 2 * channels + i % channels + second * channels) as u8 } else { 0x80 }
    });
    let bytes = a.len().min(b.len());
    // A step reads 16 bytes from 0 and from `read`, and writes 8 from 0 and from `made`.
    let by_load = if bytes < read + 16 { 0 } else { (bytes - read - 16) / (2 * read) + 1 };
    let by_store = if out.len() < made + 8 { 0 } else { (out.len() - made - 8) / (2 * made) + 1 };
    let steps = by_load.min(by_store);
    let (ones, half) = (_mm256_set1_epi8(1), _mm256_set1_epi16(2));
    // SAFETY: `steps` keeps loads and stores inside, see above; the array has 16 bytes.
    unsafe {
        let order = _mm256_broadcastsi128_si256(_mm_loadu_si128(order.as_ptr().cast()));
        for step in 0..steps {
            let pairs = |row: &[u8]| {
                let at = row.as_ptr().add(2 * read * step);
                let codes = _mm256_loadu2_m128i(at.add(read).cast(), at.cast());
                _mm256_maddubs_epi16(_mm256_shuffle_epi8(codes, order), ones)
            };
            let sum = _mm256_add_epi16(_mm256_add_epi16(pairs(a), pairs(b)), half);
            let mean = _mm256_srli_epi16::<2>(sum);
            let packed = _mm256_packus_epi16(mean, mean);
            let to = out.as_mut_ptr().add(2 * made * step);
            _mm_storel_epi64(to.cast(), _mm256_castsi256_si128(packed));
            _mm_storel_epi64(to.add(made).cast(), _mm256_extracti128_si256::<1>(packed));
        }
    }
    steps * 2 * made
}
