//! Element types of textures: `u8`, `u16`, `f16`, `f32`, `f64`.

use crate::kernel::lanes::Lanes;
use crate::num::Real;
pub use half::f16;

/// Element type of an image or texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DType {
    /// 8-bit integer, full scale 255.
    U8,
    /// 16-bit integer, full scale 65535.
    U16,
    /// Half float.
    F16,
    /// Single float.
    F32,
    /// Double float.
    F64,
}

impl DType {
    /// NumPy's name of the type.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::F16 => "float16",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }

    /// Bytes of one element.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The code that stands for 1.0: 255, 65535, or 1 for floats.
    pub fn full_scale(self) -> f64 {
        match self {
            Self::U8 => 255.0,
            Self::U16 => 65_535.0,
            Self::F16 | Self::F32 | Self::F64 => 1.0,
        }
    }

    /// Whether codes are integers.
    pub fn is_integer(self) -> bool {
        matches!(self, Self::U8 | Self::U16)
    }
}

/// One stored number of a texture.
pub trait Texel: Copy + Default + PartialEq + Send + Sync + 'static {
    /// What values are computed in: `f64` for `f64`, else `f32`.
    type Real: Real;
    /// Its run-time tag.
    const DTYPE: DType;
    /// The code as a number (an integer stays 0..=255 or 0..=65535).
    fn to_f64(self) -> f64;
    /// The code as a single; exact but for `f64`.
    fn to_f32(self) -> f32;
    /// The nearest code: `floor(x + 1/2)` clamped to the type's range, NaN to 0, for integers;
    /// round to nearest even for floats.
    fn from_f64(x: f64) -> Self;
    /// As [`Texel::from_f64`], with the sum `x + 1/2` rounded to single.
    fn from_f32(x: f32) -> Self;
    /// The code as a number to compute with.
    fn to_real(self) -> Self::Real;
    /// The nearest code, by the rule of [`Texel::from_f64`] or [`Texel::from_f32`].
    fn from_real(x: Self::Real) -> Self;
    /// The code as an index into a table of all codes; 0 for floats.
    fn index(self) -> usize;
    /// Eight codes as singles.
    fn lanes<L: Lanes>(codes: &[Self; 8]) -> L;
}

macro_rules! integer_texel {
    ($type:ty, $variant:ident, $load:ident) => {
        impl Texel for $type {
            type Real = f32;
            const DTYPE: DType = DType::$variant;
            #[inline(always)]
            fn lanes<L: Lanes>(codes: &[Self; 8]) -> L {
                L::$load(codes)
            }
            #[inline(always)]
            fn index(self) -> usize {
                usize::from(self)
            }
            #[inline(always)]
            fn to_real(self) -> f32 {
                f32::from(self)
            }
            #[inline(always)]
            fn from_real(x: f32) -> Self {
                Self::from_f32(x)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn to_f32(self) -> f32 {
                f32::from(self)
            }
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                // Below zero `as` saturates and above it truncation is floor; NaN becomes 0.
                (x + 0.5) as $type
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                // As above.
                (x + 0.5) as $type
            }
        }
    };
}

integer_texel!(u8, U8, load_u8);
integer_texel!(u16, U16, load_u16);

macro_rules! float_texel {
    ($type:ty, $variant:ident, $real:ty, $to64:expr, $to32:expr, $from64:expr, $from32:expr, $to:ident, $from:ident) => {
        impl Texel for $type {
            type Real = $real;
            const DTYPE: DType = DType::$variant;
            #[inline(always)]
            fn lanes<L: Lanes>(codes: &[Self; 8]) -> L {
                L::load(&codes.map(Texel::to_f32))
            }
            #[inline(always)]
            fn index(self) -> usize {
                0
            }
            #[inline(always)]
            fn to_real(self) -> $real {
                Texel::$to(self)
            }
            #[inline(always)]
            fn from_real(x: $real) -> Self {
                <Self as Texel>::$from(x)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                $to64(self)
            }
            #[inline(always)]
            fn to_f32(self) -> f32 {
                $to32(self)
            }
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                $from64(x)
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                $from32(x)
            }
        }
    };
}

float_texel!(f16, F16, f32, f16::to_f64, f16::to_f32, f16::from_f64, f16::from_f32, to_f32, from_f32);
float_texel!(f32, F32, f32, f64::from, |x| x, |x| x as f32, |x| x, to_f32, from_f32);
float_texel!(f64, F64, f64, |x| x, |x| x as f32, |x| x, f64::from, to_f64, from_f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_round_to_nearest_and_saturate() {
        for code in 0..=255u8 {
            let x = f64::from(code);
            assert_eq!(u8::from_f64(x), code);
            assert_eq!(u8::from_f64(x + 0.499), code);
            assert_eq!(u8::from_f32(code as f32 - 0.5), code);
        }
        assert_eq!((u8::from_f64(-3.0), u8::from_f64(1e9), u8::from_f64(f64::NAN)), (0, 255, 0));
        assert_eq!((u16::from_f32(-3.0), u16::from_f32(1e9), u16::from_f32(f32::NAN)), (0, 65_535, 0));
    }
}
