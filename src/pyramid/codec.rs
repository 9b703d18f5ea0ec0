//! Rows of codes to rows of numbers that may be averaged, and back.
//!
//! Numbers are kept in the unit that makes integer data exact: linear integers as codes, normals as codes
//! from the neutral one, alpha as codes, straight colour as colour times alpha code; sRGB in linear light,
//! 0 to 1.

use crate::encode::{Alpha, Encoding, Format, linear_to_srgb, srgb_to_linear};
use crate::texel::{DType, Texel};
use std::sync::OnceLock;

/// Single or double precision: what the chain of levels is kept in.
pub(super) trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + std::ops::Add<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
{
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

/// Linear light of every integer sRGB code, and where the nearest code changes.
struct SrgbTable {
    linear: Vec<f32>,
    /// `steps[c]` is the least number whose nearest code is above `c`.
    steps: Vec<f32>,
}

impl SrgbTable {
    fn new(full: u32) -> Self {
        let light = |code: f64| srgb_to_linear(code / f64::from(full));
        let up = |x: f64| {
            let y = x as f32;
            if f64::from(y) < x { y.next_up() } else { y }
        };
        Self {
            linear: (0..=full).map(|c| light(f64::from(c)) as f32).collect(),
            steps: (0..full).map(|c| up(light(f64::from(c) + 0.5))).collect(),
        }
    }

    fn of(dtype: DType) -> &'static Self {
        static BYTE: OnceLock<SrgbTable> = OnceLock::new();
        static WORD: OnceLock<SrgbTable> = OnceLock::new();
        match dtype {
            DType::U8 => BYTE.get_or_init(|| Self::new(255)),
            _ => WORD.get_or_init(|| Self::new(65_535)),
        }
    }

    /// The code whose light is nearest in sRGB's own scale; halves go up.
    fn nearest(&self, x: f32) -> usize {
        self.steps.partition_point(|step| *step <= x)
    }
}

pub(super) struct Codec {
    pub format: Format,
    dtype: DType,
}

impl Codec {
    pub fn new(format: Format, dtype: DType) -> Self {
        Self { format, dtype }
    }

    /// Whether codes are floats, which no rounding of codes forgives a last bit.
    pub fn is_float(&self) -> bool {
        !self.dtype.is_integer()
    }

    /// Decodes the texels of a row, `stride` elements apart, into `format.channels` numbers each.
    pub fn decode_row<T: Texel, R: Real>(&self, codes: &[T], stride: usize, out: &mut [R]) {
        let channels = self.format.channels;
        for c in 0..channels {
            let from = codes.iter().skip(c).step_by(stride);
            let to = out.iter_mut().skip(c).step_by(channels);
            let pairs = to.zip(from);
            match self.format.channel_encoding(c) {
                _ if self.is_plain(c) => pairs.for_each(|(to, code)| *to = R::decode(*code)),
                Encoding::Linear => pairs.for_each(|(to, code)| *to = R::decode(*code)),
                Encoding::Normal if self.dtype.is_integer() => {
                    let half = (self.dtype.full_scale() + 1.0) / 2.0;
                    pairs.for_each(|(to, code)| *to = R::from_f64((code.to_f64() - half).max(1.0 - half)));
                }
                Encoding::Normal => pairs.for_each(|(to, code)| *to = R::from_f64(2.0 * code.to_f64() - 1.0)),
                Encoding::Srgb if self.dtype.is_integer() => {
                    let table = &SrgbTable::of(self.dtype).linear;
                    pairs.for_each(|(to, code)| *to = R::from_f64(f64::from(table[code.to_f64() as usize])));
                }
                Encoding::Srgb => {
                    pairs.for_each(|(to, code)| *to = R::from_f64(srgb_to_linear(code.to_f64())));
                }
            }
        }
        if self.format.alpha == Alpha::Straight {
            for texel in out.chunks_exact_mut(channels) {
                let alpha = texel[channels - 1];
                texel[..channels - 1].iter_mut().for_each(|x| *x = *x * alpha);
            }
        }
    }

    /// Encodes the numbers of a row into texels of `lanes` elements; the surplus ones become zero.
    pub fn encode_row<T: Texel, R: Real>(&self, numbers: &[R], lanes: usize, codes: &mut [T]) {
        let channels = self.format.channels;
        let texels = numbers.chunks_exact(channels).zip(codes.chunks_exact_mut(lanes));
        if self.format.alpha == Alpha::Straight {
            let zero = R::default();
            for (numbers, codes) in texels {
                let alpha = numbers[channels - 1];
                for c in 0..channels - 1 {
                    // Hidden colour has no say, so nothing says what it is: zero.
                    codes[c] = self.encode(c, if alpha > zero { numbers[c] / alpha } else { zero });
                }
                // Only a kernel with negative lobes comes below zero; NaN stays.
                codes[channels - 1] = if alpha < zero { T::default() } else { alpha.encode() };
                codes[channels..].fill(T::default());
            }
        } else {
            for (numbers, codes) in texels {
                for c in 0..channels {
                    codes[c] = self.encode(c, numbers[c]);
                }
                codes[channels..].fill(T::default());
            }
        }
    }

    fn is_plain(&self, c: usize) -> bool {
        self.format.alpha_channel() == Some(c)
    }

    #[inline]
    fn encode<T: Texel, R: Real>(&self, c: usize, x: R) -> T {
        match self.format.channel_encoding(c) {
            _ if self.is_plain(c) => x.encode(),
            Encoding::Linear => x.encode(),
            Encoding::Normal if self.dtype.is_integer() => {
                T::from_f64(x.to_f64() + (self.dtype.full_scale() + 1.0) / 2.0)
            }
            Encoding::Normal => T::from_f64(0.5 * x.to_f64() + 0.5),
            Encoding::Srgb if self.dtype.is_integer() => {
                T::from_f64(SrgbTable::of(self.dtype).nearest(x.to_f64() as f32) as f64)
            }
            Encoding::Srgb => T::from_f64(linear_to_srgb(x.to_f64())),
        }
    }
}
