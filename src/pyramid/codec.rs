//! Rows of codes to rows of numbers that may be averaged, and back.
//!
//! Numbers are kept in the unit that makes integer data exact: linear integers as codes, normals as codes
//! from the neutral one, alpha as codes, straight colour as colour times alpha code; sRGB in linear light,
//! 0 to 1, that of bytes in whole 2^-24.

use crate::encode::{Alpha, Encoding, Format, linear_to_srgb, srgb_to_linear};
use crate::kernel::Isa;
use crate::kernel::box_down::{self, Float, SrgbBytes};
use crate::kernel::cast::{same, same_mut};
use crate::texel::{DType, Texel};
use std::ops::Div;
use std::sync::OnceLock;

/// Single or double precision: what the chain of levels is kept in.
pub(crate) trait Real: Float + PartialOrd + Send + Sync + Div<Output = Self> + 'static {
    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;
    fn decode<T: Texel>(code: T) -> Self;
    fn encode<T: Texel>(self) -> T;
}

macro_rules! real {
    ($type:ty, $to:ident, $from:ident) => {
        impl Real for $type {
            fn from_f64(x: f64) -> Self {
                x as $type
            }
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn decode<T: Texel>(code: T) -> Self {
                code.$to()
            }
            #[inline(always)]
            fn encode<T: Texel>(self) -> T {
                T::$from(self)
            }
        }
    };
}
real!(f32, to_f32, from_f32);
real!(f64, to_f64, from_f64);

fn srgb_bytes() -> &'static SrgbBytes {
    static TABLE: OnceLock<SrgbBytes> = OnceLock::new();
    TABLE.get_or_init(|| SrgbBytes::new(|code| srgb_to_linear(code / 255.0)))
}

/// Linear light of every 16-bit sRGB code, and where the nearest code changes.
struct SrgbWords {
    linear: Vec<f32>,
    /// `steps[c]` is the least number whose nearest code is above `c`.
    steps: Vec<f32>,
}

fn srgb_words() -> &'static SrgbWords {
    static TABLE: OnceLock<SrgbWords> = OnceLock::new();
    TABLE.get_or_init(|| {
        let light = |code: f64| srgb_to_linear(code / 65_535.0);
        let up = |x: f64| {
            let y = x as f32;
            if f64::from(y) < x { y.next_up() } else { y }
        };
        SrgbWords {
            linear: (0..=65_535).map(|c| light(f64::from(c)) as f32).collect(),
            steps: (0..65_535).map(|c| up(light(f64::from(c) + 0.5))).collect(),
        }
    })
}

/// Between the codes of a format and numbers.
pub(crate) struct Codec {
    pub format: Format,
    /// Numbers a texel: the format's channels, or four where three stand in texels of four.
    pub lanes: usize,
    dtype: DType,
}

impl Codec {
    /// For texels of `stored` elements.
    pub fn new(format: Format, stored: usize, dtype: DType) -> Self {
        let lanes = if format.channels == 3 && stored == 4 { 4 } else { format.channels };
        Self { format, lanes, dtype }
    }

    /// Whether codes are floats, which no rounding of codes forgives a last bit.
    pub fn is_float(&self) -> bool {
        !self.dtype.is_integer()
    }

    fn is_straight(&self) -> bool {
        self.format.alpha == Alpha::Straight
    }

    /// Encoding of a lane; those past the channels are nothing.
    fn encoding(&self, c: usize) -> Encoding {
        let is_plain = c >= self.format.channels || self.format.alpha_channel() == Some(c);
        if is_plain { Encoding::Linear } else { self.format.channel_encoding(c) }
    }

    /// Whether the last lane of sRGB texels is linear.
    fn linear_last(&self) -> bool {
        self.encoding(self.lanes - 1) == Encoding::Linear
    }

    /// The codes themselves, where they are numbers as they stand.
    pub fn as_numbers<'a, T: Texel, R: Real>(&self, codes: &'a [T], stride: usize) -> Option<&'a [R]> {
        let plain = self.format.encoding == Encoding::Linear && !self.is_straight() && stride == self.lanes;
        if plain { same(codes) } else { None }
    }

    /// Means of 2 x 2 texels straight from bytes, where there is a kernel for it.
    pub fn halve<T: Texel, R: Real>(&self, isa: Isa, rows: [&[T]; 2], out: &mut [R]) -> bool {
        let fits = rows[0].len() == 2 * out.len() && !self.is_straight();
        let (Some(a), Some(b), true) = (same::<T, u8>(rows[0]), same::<T, u8>(rows[1]), fits) else {
            return false;
        };
        let Some(out) = same_mut::<R, f32>(out) else { return false };
        match self.format.encoding {
            Encoding::Linear => box_down::halve_bytes(isa, a, b, self.lanes, out),
            Encoding::Srgb => {
                box_down::halve_srgb(isa, [a, b], self.lanes, self.linear_last(), srgb_bytes(), out);
            }
            Encoding::Normal => return false,
        }
        true
    }

    /// Decodes the texels of a row, `stride` elements apart, into `lanes` numbers each.
    pub fn decode_row<T: Texel, R: Real>(&self, codes: &[T], stride: usize, out: &mut [R]) {
        let lanes = self.lanes;
        for c in 0..lanes {
            let from = codes.iter().skip(c).step_by(stride);
            let pairs = out.iter_mut().skip(c).step_by(lanes).zip(from);
            match self.encoding(c) {
                Encoding::Linear => pairs.for_each(|(to, code)| *to = R::decode(*code)),
                Encoding::Normal if self.dtype.is_integer() => {
                    let half = (self.dtype.full_scale() + 1.0) / 2.0;
                    pairs.for_each(|(to, code)| *to = R::from_f64((code.to_f64() - half).max(1.0 - half)));
                }
                Encoding::Normal => pairs.for_each(|(to, code)| *to = R::from_f64(2.0 * code.to_f64() - 1.0)),
                Encoding::Srgb if self.dtype == DType::U8 => {
                    let light = srgb_bytes().light.map(|x| R::from_f64(f64::from(x) / 16_777_216.0));
                    pairs.for_each(|(to, code)| *to = light[usize::from(code.to_f32() as u8)]);
                }
                Encoding::Srgb if self.dtype == DType::U16 => {
                    let table = &srgb_words().linear;
                    pairs.for_each(|(to, code)| *to = R::from_f64(f64::from(table[code.to_f32() as usize])));
                }
                Encoding::Srgb => {
                    pairs.for_each(|(to, code)| *to = R::from_f64(srgb_to_linear(code.to_f64())));
                }
            }
        }
        if self.is_straight() {
            for texel in out.chunks_exact_mut(lanes) {
                let alpha = texel[lanes - 1];
                texel[..lanes - 1].iter_mut().for_each(|x| *x = *x * alpha);
            }
        }
    }

    /// Encodes the numbers of a row into texels of `stride` elements; the surplus ones become zero.
    /// `scratch` has room for the numbers.
    pub fn encode_row<T: Texel, R: Real>(
        &self,
        isa: Isa,
        numbers: &[R],
        stride: usize,
        codes: &mut [T],
        scratch: &mut [R],
    ) {
        let (lanes, channels) = (self.lanes, self.format.channels);
        let numbers = if self.is_straight() {
            let scratch = &mut scratch[..numbers.len()];
            divide(numbers, lanes, scratch);
            &*scratch
        } else {
            numbers
        };
        if stride == lanes && self.encode_fast(isa, numbers, codes) {
            if channels < lanes {
                codes.iter_mut().skip(channels).step_by(lanes).for_each(|code| *code = T::default());
            }
            return;
        }
        for c in 0..channels {
            let from = numbers.iter().skip(c).step_by(lanes);
            let pairs = codes.iter_mut().skip(c).step_by(stride).zip(from);
            match self.encoding(c) {
                Encoding::Linear => pairs.for_each(|(code, x)| *code = x.encode()),
                Encoding::Normal if self.dtype.is_integer() => {
                    let half = (self.dtype.full_scale() + 1.0) / 2.0;
                    pairs.for_each(|(code, x)| *code = T::from_f64(x.to_f64() + half));
                }
                Encoding::Normal => pairs.for_each(|(code, x)| *code = T::from_f64(0.5 * x.to_f64() + 0.5)),
                Encoding::Srgb if self.dtype == DType::U8 => pairs.for_each(|(code, x)| {
                    *code = T::from_f32(f32::from(srgb_bytes().nearest(x.to_f64() as f32)));
                }),
                Encoding::Srgb if self.dtype == DType::U16 => {
                    let steps = &srgb_words().steps;
                    pairs.for_each(|(code, x)| {
                        let x = x.to_f64() as f32;
                        *code = T::from_f32(steps.partition_point(|step| *step <= x) as f32);
                    });
                }
                Encoding::Srgb => pairs.for_each(|(code, x)| *code = T::from_f64(linear_to_srgb(x.to_f64()))),
            }
        }
        if channels < stride {
            codes.chunks_exact_mut(stride).for_each(|texel| texel[channels..].fill(T::default()));
        }
    }

    fn encode_fast<T: Texel, R: Real>(&self, isa: Isa, numbers: &[R], codes: &mut [T]) -> bool {
        let Some(numbers) = same::<R, f32>(numbers) else { return false };
        let linear = self.format.encoding == Encoding::Linear;
        if let Some(codes) = same_mut::<T, u8>(codes) {
            match self.format.encoding {
                Encoding::Linear => box_down::to_bytes(isa, numbers, codes),
                Encoding::Srgb => {
                    box_down::to_srgb(isa, numbers, self.lanes, self.linear_last(), srgb_bytes(), codes);
                }
                Encoding::Normal => return false,
            }
            return true;
        }
        match same_mut::<T, u16>(codes) {
            Some(codes) if linear => {
                box_down::to_words(isa, numbers, codes);
                true
            }
            _ => false,
        }
    }
}

/// Straight colour from colour times alpha. Hidden colour has no say, so nothing says what it is: zero.
fn divide<R: Real>(numbers: &[R], lanes: usize, out: &mut [R]) {
    let zero = R::default();
    for (out, texel) in out.chunks_exact_mut(lanes).zip(numbers.chunks_exact(lanes)) {
        let alpha = texel[lanes - 1];
        for (out, x) in out.iter_mut().zip(&texel[..lanes - 1]) {
            *out = if alpha > zero { *x / alpha } else { zero };
        }
        // Only a kernel with negative lobes comes below zero; NaN stays.
        out[lanes - 1] = if alpha < zero { zero } else { alpha };
    }
}
