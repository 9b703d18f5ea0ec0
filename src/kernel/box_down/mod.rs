//! Rows of a level from rows of the level below, by boxes, and to codes.
//!
//! Plain loops over numbers are compiled once for each instruction set; nothing is fused or reordered, so
//! their bytes are equal. Bytes in sRGB have a hand-written AVX-512 form, plain bytes an AVX2 one.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod scalar;

use super::{Isa, compiled_for};
use std::ops::{Add, Mul};

/// Single or double precision.
pub trait Float: Copy + Default + PartialEq + Add<Output = Self> + Mul<Output = Self> {
    /// 1/2
    const HALF: Self;
    /// 1/4
    const QUARTER: Self;
}

impl Float for f32 {
    const HALF: Self = 0.5;
    const QUARTER: Self = 0.25;
}

impl Float for f64 {
    const HALF: Self = 0.5;
    const QUARTER: Self = 0.25;
}

/// Linear light of 8-bit codes in units of 2^-24, and the way back.
#[derive(Debug)]
pub struct SrgbBytes {
    /// Light of each code; below 2^24.
    pub light: [u32; 256],
    /// For the leading 16 bits of a single from 2^-13 on: the code there in the leading bits, and what
    /// makes the trailing 16 bits carry where the next code begins.
    pub codes: Vec<u32>,
    /// The three bytes of `light`, each as a table of 256.
    planes: [[u8; 256]; 3],
}

/// Leading bits of 2^-13 and of 1.
const FIRST: u32 = 0x3900;
const LAST: u32 = 0x3f80;

impl SrgbBytes {
    /// From the light of a code, which may be fractional.
    pub fn new(light_of: impl Fn(f64) -> f64) -> Self {
        let light = std::array::from_fn(|code| {
            let light = (light_of(code as f64) * 16_777_216.0).round();
            (light as u32).min(0x00ff_ffff)
        });
        let planes = std::array::from_fn(|p| std::array::from_fn(|code| light[code].to_le_bytes()[p]));
        // The least single whose nearest code is above `code`.
        let step = |code: usize| {
            let exact = light_of(code as f64 + 0.5);
            let single = exact as f32;
            if f64::from(single) < exact { single.next_up().to_bits() } else { single.to_bits() }
        };
        let steps: Vec<u32> = (0..255).map(step).collect();
        let codes = (FIRST..=LAST)
            .map(|leading| {
                let first = leading << 16;
                let code = steps.partition_point(|&s| s <= first) as u32;
                let next = steps.get(code as usize).copied().unwrap_or(u32::MAX);
                let carry = if next >> 16 == leading { 0x1_0000 - (next & 0xffff) } else { 0 };
                (code << 16) + carry
            })
            .collect();
        Self { light, codes, planes }
    }

    /// The nearest code of linear light, saturated; NaN is 0.
    pub fn nearest(&self, light: f32) -> u8 {
        scalar::nearest(light, &self.codes)
    }
}

macro_rules! dispatch {
    ($(#[$doc:meta])* $name:ident<$($g:ident: $b:path),*>($($arg:ident: $type:ty),* $(,)?)) => {
        $(#[$doc])*
        pub fn $name<$($g: $b),*>(isa: Isa, $($arg: $type),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2<$($g: $b),*>($($arg: $type),*) {
                    scalar::$name($($arg),*);
                }
                #[target_feature(enable = "avx2,avx512f,avx512bw,avx512vl,avx512dq")]
                fn avx512<$($g: $b),*>($($arg: $type),*) {
                    scalar::$name($($arg),*);
                }
                match isa {
                    // SAFETY: an `Isa` other than `Scalar` is only made where the machine has it.
                    Isa::Avx512 if isa.is_supported() => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    Isa::Avx2 if isa.is_supported() => return unsafe { avx2($($arg),*) },
                    _ => {}
                }
            }
            let _ = isa;
            scalar::$name($($arg),*);
        }
    };
}

dispatch! {
    /// Means of 2 x 2 texels: `(a0/4 + b0/4) + (a1/4 + b1/4)`.
    halve_both<R: Float>(a: &[R], b: &[R], channels: usize, out: &mut [R])
}
dispatch! {
    /// Means of two rows.
    halve_rows<R: Float>(a: &[R], b: &[R], out: &mut [R])
}
dispatch! {
    /// Means of pairs of texels.
    halve_columns<R: Float>(row: &[R], channels: usize, out: &mut [R])
}
dispatch! {
    /// `(a w0 + c w2) + b w1`, and exactly `a` where all three are equal.
    mix_rows<R: Float>(rows: [&[R]; 3], weights: [R; 3], out: &mut [R])
}
dispatch! {
    /// The same along a row of `2k + 1` texels: three weights for each of `k`.
    mix_columns<R: Float>(row: &[R], weights: &[R], channels: usize, out: &mut [R])
}
dispatch! {
    /// Nearest 16-bit codes likewise.
    to_words<>(numbers: &[f32], out: &mut [u16])
}

/// Sums of 2 x 2 integer codes over four, exact.
pub fn halve_bytes(isa: Isa, a: &[u8], b: &[u8], channels: usize, out: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if isa >= Isa::Avx2 && isa.is_supported() && channels == 4 {
        // SAFETY: the machine has AVX2.
        let done = unsafe { avx2::halve_bytes_4(a, b, out) };
        return scalar::halve_bytes(&a[2 * done..], &b[2 * done..], channels, &mut out[done..]);
    }
    compiled_for(isa, || scalar::halve_bytes(a, b, channels, out));
}

/// Means of 2 x 2 codes as codes, halves up.
pub fn halve_codes(isa: Isa, a: &[u8], b: &[u8], channels: usize, out: &mut [u8]) {
    #[cfg(target_arch = "x86_64")]
    if isa >= Isa::Avx2 && isa.is_supported() && channels <= 4 {
        // SAFETY: the machine has AVX2.
        let done = unsafe { avx2::halve_codes(a, b, channels, out) };
        return scalar::halve_codes(&a[2 * done..], &b[2 * done..], channels, &mut out[done..]);
    }
    let _ = isa;
    scalar::halve_codes(a, b, channels, out);
}

/// Nearest bytes, halves up, saturated; NaN is 0.
pub fn to_bytes(isa: Isa, numbers: &[f32], out: &mut [u8]) {
    #[cfg(target_arch = "x86_64")]
    if isa >= Isa::Avx2 && isa.is_supported() {
        // SAFETY: the machine has AVX2.
        let done = unsafe { avx2::to_bytes(numbers, out) };
        return scalar::to_bytes(&numbers[done..], &mut out[done..]);
    }
    let _ = isa;
    scalar::to_bytes(numbers, out);
}

/// Means of 2 x 2 sRGB texels in linear light, 0 to 1. With `linear_last` the last channel is summed as it is.
///
/// The sum of four lights of 24 bits is exact; it is rounded to a single once.
pub fn halve_srgb(
    isa: Isa,
    rows: [&[u8]; 2],
    channels: usize,
    linear_last: bool,
    srgb: &SrgbBytes,
    out: &mut [f32],
) {
    #[cfg(target_arch = "x86_64")]
    if isa == Isa::Avx512 && isa.is_supported() && channels <= 4 {
        // SAFETY: the machine has the set.
        let done = unsafe { avx512::halve_srgb(rows, channels, linear_last, srgb, out) };
        let rest = [&rows[0][2 * done..], &rows[1][2 * done..]];
        return scalar::halve_srgb(rest, channels, linear_last, srgb, &mut out[done..]);
    }
    let _ = isa;
    scalar::halve_srgb(rows, channels, linear_last, srgb, out);
}

/// Nearest sRGB bytes of linear light, saturated; NaN is 0. With `linear_last` the last channel is rounded.
pub fn to_srgb(
    isa: Isa,
    numbers: &[f32],
    channels: usize,
    linear_last: bool,
    srgb: &SrgbBytes,
    out: &mut [u8],
) {
    #[cfg(target_arch = "x86_64")]
    if isa == Isa::Avx512 && isa.is_supported() && channels <= 4 {
        // SAFETY: the machine has the set.
        let done = unsafe { avx512::to_srgb(numbers, channels, linear_last, srgb, out) };
        return scalar::to_srgb(&numbers[done..], channels, linear_last, srgb, &mut out[done..]);
    }
    let _ = isa;
    scalar::to_srgb(numbers, channels, linear_last, srgb, out);
}

#[cfg(test)]
mod tests;
