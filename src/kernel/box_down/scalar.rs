//! The definition of each kernel.

use super::{FIRST, Float, LAST, SrgbBytes};

/// Calls `$run::<C>` with the number of channels as a constant where it is small.
macro_rules! by_channels {
    ($channels:expr, $C:ident => $run:expr, $other:expr) => {
        match $channels {
            1 => {
                const $C: usize = 1;
                $run
            }
            2 => {
                const $C: usize = 2;
                $run
            }
            3 => {
                const $C: usize = 3;
                $run
            }
            4 => {
                const $C: usize = 4;
                $run
            }
            _ => $other,
        }
    };
}

#[inline(always)]
pub fn halve_both<R: Float>(a: &[R], b: &[R], channels: usize, out: &mut [R]) {
    let mean = |a0: R, b0: R, a1: R, b1: R| {
        (a0 * R::QUARTER + b0 * R::QUARTER) + (a1 * R::QUARTER + b1 * R::QUARTER)
    };
    by_channels!(channels, C => {
        let (pairs_a, pairs_b) = (a.as_chunks::<{ 2 * C }>().0, b.as_chunks::<{ 2 * C }>().0);
        for ((out, a), b) in out.as_chunks_mut::<C>().0.iter_mut().zip(pairs_a).zip(pairs_b) {
            for c in 0..C {
                out[c] = mean(a[c], b[c], a[C + c], b[C + c]);
            }
        }
    }, {
        for (i, out) in out.iter_mut().enumerate() {
            let at = i / channels * 2 * channels + i % channels;
            *out = mean(a[at], b[at], a[at + channels], b[at + channels]);
        }
    });
}

#[inline(always)]
pub fn halve_rows<R: Float>(a: &[R], b: &[R], out: &mut [R]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = *a * R::HALF + *b * R::HALF;
    }
}

#[inline(always)]
pub fn halve_columns<R: Float>(row: &[R], channels: usize, out: &mut [R]) {
    by_channels!(channels, C => {
        for (out, pair) in out.as_chunks_mut::<C>().0.iter_mut().zip(row.as_chunks::<{ 2 * C }>().0) {
            for c in 0..C {
                out[c] = pair[c] * R::HALF + pair[C + c] * R::HALF;
            }
        }
    }, {
        for (i, out) in out.iter_mut().enumerate() {
            let at = i / channels * 2 * channels + i % channels;
            *out = row[at] * R::HALF + row[at + channels] * R::HALF;
        }
    });
}

#[inline(always)]
fn mix<R: Float>(a: R, b: R, c: R, w: [R; 3]) -> R {
    let sum = (a * w[0] + c * w[2]) + b * w[1];
    if a == b && b == c { a } else { sum }
}

#[inline(always)]
pub fn mix_rows<R: Float>(rows: [&[R]; 3], weights: [R; 3], out: &mut [R]) {
    for (((out, a), b), c) in out.iter_mut().zip(rows[0]).zip(rows[1]).zip(rows[2]) {
        *out = mix(*a, *b, *c, weights);
    }
}

#[inline(always)]
pub fn mix_columns<R: Float>(row: &[R], weights: &[R], channels: usize, out: &mut [R]) {
    let texels = out.chunks_exact_mut(channels).zip(weights.as_chunks::<3>().0);
    for (i, (out, w)) in texels.enumerate() {
        let three = &row[2 * i * channels..][..3 * channels];
        for (c, out) in out.iter_mut().enumerate() {
            *out = mix(three[c], three[channels + c], three[2 * channels + c], *w);
        }
    }
}

#[inline(always)]
pub fn halve_bytes(a: &[u8], b: &[u8], channels: usize, out: &mut [f32]) {
    let mean = |a0: u8, b0: u8, a1: u8, b1: u8| {
        let sum = u16::from(a0) + u16::from(b0) + u16::from(a1) + u16::from(b1);
        f32::from(sum) * 0.25
    };
    by_channels!(channels, C => {
        let (pairs_a, pairs_b) = (a.as_chunks::<{ 2 * C }>().0, b.as_chunks::<{ 2 * C }>().0);
        for ((out, a), b) in out.as_chunks_mut::<C>().0.iter_mut().zip(pairs_a).zip(pairs_b) {
            for c in 0..C {
                out[c] = mean(a[c], b[c], a[C + c], b[C + c]);
            }
        }
    }, {
        for (i, out) in out.iter_mut().enumerate() {
            let at = i / channels * 2 * channels + i % channels;
            *out = mean(a[at], b[at], a[at + channels], b[at + channels]);
        }
    });
}

#[inline(always)]
pub fn halve_codes(a: &[u8], b: &[u8], channels: usize, out: &mut [u8]) {
    let mean = |a0: u8, b0: u8, a1: u8, b1: u8| {
        ((u16::from(a0) + u16::from(b0) + u16::from(a1) + u16::from(b1) + 2) >> 2) as u8
    };
    by_channels!(channels, C => {
        let (pairs_a, pairs_b) = (a.as_chunks::<{ 2 * C }>().0, b.as_chunks::<{ 2 * C }>().0);
        for ((out, a), b) in out.as_chunks_mut::<C>().0.iter_mut().zip(pairs_a).zip(pairs_b) {
            for c in 0..C {
                out[c] = mean(a[c], b[c], a[C + c], b[C + c]);
            }
        }
    }, {
        for (i, out) in out.iter_mut().enumerate() {
            let at = i / channels * 2 * channels + i % channels;
            *out = mean(a[at], b[at], a[at + channels], b[at + channels]);
        }
    });
}

#[inline(always)]
pub fn to_bytes(numbers: &[f32], out: &mut [u8]) {
    for (out, x) in out.iter_mut().zip(numbers) {
        *out = (x + 0.5) as u8;
    }
}

#[inline(always)]
pub fn to_words(numbers: &[f32], out: &mut [u16]) {
    for (out, x) in out.iter_mut().zip(numbers) {
        *out = (x + 0.5) as u16;
    }
}

/// One over 2^26: four lights of 24 bits.
pub const LIGHT: f32 = 1.0 / 67_108_864.0;

pub fn halve_srgb(rows: [&[u8]; 2], channels: usize, linear_last: bool, srgb: &SrgbBytes, out: &mut [f32]) {
    let [a, b] = rows;
    let light = |code: u8| srgb.light[usize::from(code)];
    let mean =
        |a0: u8, b0: u8, a1: u8, b1: u8| (light(a0) + light(b0) + light(a1) + light(b1)) as f32 * LIGHT;
    let plain = |a0: u8, b0: u8, a1: u8, b1: u8| {
        f32::from(u16::from(a0) + u16::from(b0) + u16::from(a1) + u16::from(b1)) * 0.25
    };
    by_channels!(channels, C => {
        let (pairs_a, pairs_b) = (a.as_chunks::<{ 2 * C }>().0, b.as_chunks::<{ 2 * C }>().0);
        let colours = if linear_last { C - 1 } else { C };
        for ((out, a), b) in out.as_chunks_mut::<C>().0.iter_mut().zip(pairs_a).zip(pairs_b) {
            for c in 0..colours {
                out[c] = mean(a[c], b[c], a[C + c], b[C + c]);
            }
            for c in colours..C {
                out[c] = plain(a[c], b[c], a[C + c], b[C + c]);
            }
        }
    }, {
        for (i, out) in out.iter_mut().enumerate() {
            let at = i / channels * 2 * channels + i % channels;
            let codes = [a[at], b[at], a[at + channels], b[at + channels]];
            let is_linear = linear_last && i % channels == channels - 1;
            let of = |f: &dyn Fn(u8, u8, u8, u8) -> f32| f(codes[0], codes[1], codes[2], codes[3]);
            *out = if is_linear { of(&plain) } else { of(&mean) };
        }
    });
}

/// The nearest code of one number.
#[inline(always)]
pub fn nearest(x: f32, codes: &[u32]) -> u8 {
    // In this order NaN becomes the lower limit.
    let x = if x > f32::from_bits(FIRST << 16) { x } else { f32::from_bits(FIRST << 16) };
    let x = if x < 1.0 { x } else { 1.0 };
    let bits = x.to_bits();
    debug_assert!((FIRST..=LAST).contains(&(bits >> 16)));
    ((codes[(bits >> 16) as usize - FIRST as usize] + (bits & 0xffff)) >> 16) as u8
}

pub fn to_srgb(numbers: &[f32], channels: usize, linear_last: bool, srgb: &SrgbBytes, out: &mut [u8]) {
    let colours = if linear_last { channels - 1 } else { channels };
    for (out, numbers) in out.chunks_exact_mut(channels).zip(numbers.chunks_exact(channels)) {
        for (out, x) in out[..colours].iter_mut().zip(numbers) {
            *out = nearest(*x, &srgb.codes);
        }
        for (out, x) in out[colours..].iter_mut().zip(&numbers[colours..]) {
            *out = (x + 0.5) as u8;
        }
    }
}
