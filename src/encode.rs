//! What stored codes mean: sRGB transfer, normal-map codes, straight and premultiplied alpha.
//!
//! Values are decoded per texel before any weight is applied, so filtering happens in linear light, on true
//! vectors and on premultiplied colour.

use crate::error::{Error, Result};
use crate::texel::DType;

/// Meaning of the colour codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Proportional to light (or to whatever the data measure).
    #[default]
    Linear,
    /// IEC 61966-2-1; alpha is linear.
    Srgb,
    /// Unit vectors. Integers: `(code - 2^(b-1)) / (2^(b-1) - 1)`, at least -1, so that code 128 (32768) is
    /// exactly 0 and 255 (65535) exactly 1. Floats: `2 x - 1`. Three channels; a fourth is linear.
    Normal,
}

/// Meaning of the last of two or four channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Alpha {
    /// There is no alpha; all channels are treated alike.
    #[default]
    None,
    /// Colour is independent of alpha (PNG). Filtered premultiplied, returned straight.
    Straight,
    /// Colour is already multiplied by alpha.
    Premultiplied,
}

macro_rules! named {
    ($type:ty, $($name:literal => $value:expr),+) => {
        impl $type {
            /// All values with their names.
            pub const NAMES: &'static [(&'static str, Self)] = &[$(($name, $value)),+];

            /// The value of this name.
            ///
            /// # Errors
            /// [`Error::Value`] for any other word.
            pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
                Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, v)| *v).ok_or_else(|| {
                    let names: Vec<_> = Self::NAMES.iter().map(|(n, _)| format!("{n:?}")).collect();
                    Error::value(argument, format!("{name:?}"), format!("one of {}", names.join(", ")))
                })
            }

            /// The value's name.
            pub fn name(self) -> &'static str {
                Self::NAMES.iter().find(|(_, v)| *v == self).map_or("", |(n, _)| n)
            }
        }
    };
}

named!(Encoding, "linear" => Self::Linear, "srgb" => Self::Srgb, "normal" => Self::Normal);
named!(Alpha, "none" => Self::None, "straight" => Self::Straight, "premultiplied" => Self::Premultiplied);

/// Linear light of an sRGB value, both 0..=1; odd about 0 for values outside (scRGB's rule).
pub fn srgb_to_linear(s: f64) -> f64 {
    let a = s.abs();
    let l = if a <= 0.04045 { a / 12.92 } else { ((a + 0.055) / 1.055).powf(2.4) };
    l.copysign(s)
}

/// sRGB value of linear light: the inverse of [`srgb_to_linear`].
pub fn linear_to_srgb(l: f64) -> f64 {
    let a = l.abs();
    let s = if a <= 0.04045 / 12.92 { a * 12.92 } else { 1.055 * a.powf(1.0 / 2.4) - 0.055 };
    s.copysign(l)
}

/// The number that a code stands for, without any alpha product.
pub fn decode(encoding: Encoding, dtype: DType, code: f64) -> f64 {
    let full = dtype.full_scale();
    match encoding {
        Encoding::Linear => code / full,
        Encoding::Srgb => srgb_to_linear(code / full),
        Encoding::Normal if dtype.is_integer() => {
            let half = (full + 1.0) / 2.0;
            ((code - half) / (half - 1.0)).max(-1.0)
        }
        Encoding::Normal => 2.0 * code - 1.0,
    }
}

/// The code, not yet rounded, that stands for a number: the inverse of [`decode`].
pub fn encode(encoding: Encoding, dtype: DType, value: f64) -> f64 {
    let full = dtype.full_scale();
    match encoding {
        Encoding::Linear => value * full,
        Encoding::Srgb => linear_to_srgb(value) * full,
        Encoding::Normal if dtype.is_integer() => {
            let half = (full + 1.0) / 2.0;
            value * (half - 1.0) + half
        }
        Encoding::Normal => 0.5 * value + 0.5,
    }
}

/// Which encoding and product apply to each channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Meaning of colour codes.
    pub encoding: Encoding,
    /// Meaning of the last channel.
    pub alpha: Alpha,
    /// Number of channels.
    pub channels: usize,
}

impl Format {
    /// Checks that the parts fit together.
    ///
    /// # Errors
    /// [`Error::Value`] when alpha is asked of one or three channels, or normals of fewer than three.
    pub fn new(encoding: Encoding, alpha: Alpha, channels: usize) -> Result<Self> {
        if alpha != Alpha::None && !matches!(channels, 2 | 4) {
            return Err(Error::value(
                "alpha",
                format!("{:?} for {channels} channel(s)", alpha.name()),
                "\"none\", or an image of 2 or 4 channels whose last is alpha",
            ));
        }
        if encoding == Encoding::Normal && !matches!(channels, 3 | 4) {
            return Err(Error::value(
                "encoding",
                format!("\"normal\" for {channels} channel(s)"),
                "an image of 3 or 4 channels",
            ));
        }
        Ok(Self { encoding, alpha, channels })
    }

    /// Index of the alpha channel, if there is one.
    pub fn alpha_channel(self) -> Option<usize> {
        (self.alpha != Alpha::None).then(|| self.channels - 1)
    }

    /// Encoding of channel `c`: a second or fourth channel of sRGB or normal data is linear.
    pub fn channel_encoding(self, c: usize) -> Encoding {
        let extra = match self.encoding {
            Encoding::Linear => false,
            Encoding::Srgb => (self.channels == 2 && c == 1) || (self.channels == 4 && c == 3),
            Encoding::Normal => c >= 3,
        };
        if extra { Encoding::Linear } else { self.encoding }
    }

    /// Whether colour must be multiplied by alpha when it is read.
    pub fn multiplies(self) -> bool {
        self.alpha == Alpha::Straight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel::Texel;

    #[test]
    fn every_code_survives_the_round_trip() {
        for encoding in [Encoding::Linear, Encoding::Srgb, Encoding::Normal] {
            for code in 0..=65_535u16 {
                let back = encode(encoding, DType::U16, decode(encoding, DType::U16, f64::from(code)));
                // Normal code 0 means the same as code 1.
                let expected = if encoding == Encoding::Normal { code.max(1) } else { code };
                assert_eq!(u16::from_f64(back), expected, "{encoding:?}");
            }
        }
    }

    #[test]
    fn known_values() {
        assert_eq!(decode(Encoding::Normal, DType::U8, 128.0), 0.0);
        assert_eq!(decode(Encoding::Normal, DType::U8, 255.0), 1.0);
        assert_eq!(decode(Encoding::Normal, DType::F32, 0.5), 0.0);
        assert_eq!(u8::from_f64(encode(Encoding::Srgb, DType::U8, 0.5)), 188);
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1e-8);
    }

    #[test]
    fn impossible_formats_are_refused() {
        assert!(Format::new(Encoding::Linear, Alpha::Straight, 3).is_err());
        assert!(Format::new(Encoding::Normal, Alpha::None, 2).is_err());
        assert!(Format::new(Encoding::Srgb, Alpha::Straight, 2).is_ok());
    }
}
