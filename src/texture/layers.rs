//! A texture as filters read it: planes of up to four channels, and what their codes mean.

use crate::bounds::Bounds;
use crate::detail::Detail;
use crate::encode::{Encoding, Format, decode};
use crate::kernel::lanes::Lanes;
use crate::kernel::plane::Plane;
use crate::num::Real;
use crate::sat::SummedAreaTable;
use crate::texel::{DType, Texel};
use crate::wrap::Wrap;
use std::sync::OnceLock;

/// One group of up to four channels of a texture.
pub(crate) struct Layers<'a, T: Texel> {
    /// Level 0, and the others where they were asked for.
    pub planes: Vec<Plane<'a, T>>,
    pub wrap: [Wrap; 2],
    /// Border colour as results have it: linear, premultiplied.
    pub border: [f64; 4],
    pub decoder: Decoder,
    /// Sums of level 0 in the space of the results, where they were asked for.
    pub sums: Option<&'a SummedAreaTable>,
    /// Bounds of level 0 in the space of averages, where they were asked for.
    pub bounds: Option<&'a Bounds>,
    /// What each level lacks, where it was asked for.
    pub detail: Option<&'a Detail>,
}

/// From codes to numbers that may be averaged, and from averages to results.
#[derive(Clone, Copy)]
pub(crate) struct Decoder {
    pub full_scale: f64,
    /// Table of colour codes, for integers that are not linear.
    table: Option<&'static [f32]>,
    /// The lane that is linear although the others are not; 4 for none.
    linear_lane: usize,
    /// The lane that the others are multiplied by; 4 for none.
    alpha_lane: usize,
}

impl Decoder {
    pub fn new<T: Texel>(format: Format, group: usize) -> Self {
        let table = code_table(format.encoding, T::DTYPE);
        let linear_lane = (0..format.channels).find(|c| format.channel_encoding(*c) != format.encoding);
        let alpha_lane = if format.multiplies() { format.alpha_channel() } else { None };
        // Only textures of up to four channels, one group, have either.
        debug_assert!(group == 0 || alpha_lane.is_none());
        Self {
            full_scale: T::DTYPE.full_scale(),
            table,
            linear_lane: linear_lane.unwrap_or(4),
            alpha_lane: alpha_lane.unwrap_or(4),
        }
    }

    /// Whether codes are proportional to results, so that one division after filtering decodes them.
    pub fn is_plain(&self) -> bool {
        self.table.is_none() && self.alpha_lane == 4
    }
}

/// Results of all codes of an integer type, unless codes are proportional to them.
fn code_table(encoding: Encoding, dtype: DType) -> Option<&'static [f32]> {
    static TABLES: [OnceLock<Vec<f32>>; 4] = [const { OnceLock::new() }; 4];
    let slot = match (encoding, dtype) {
        (Encoding::Srgb, DType::U8) => 0,
        (Encoding::Normal, DType::U8) => 1,
        (Encoding::Srgb, DType::U16) => 2,
        (Encoding::Normal, DType::U16) => 3,
        _ => return None,
    };
    let last = dtype.full_scale() as u32;
    Some(
        TABLES[slot]
            .get_or_init(|| (0..=last).map(|c| decode(encoding, dtype, f64::from(c)) as f32).collect()),
    )
}

/// How one texture's codes are read; two types, so that the common case has no branches.
pub(crate) trait Decode<T: Texel>: Copy + Sync {
    /// Whether averages are averages of the codes themselves.
    const CODES: bool = false;
    /// A texel's codes as numbers to average.
    fn texel(&self, codes: [T; 4]) -> [T::Real; 4];
    /// Two texels' codes as singles to average.
    #[inline(always)]
    fn pair<L: Lanes>(&self, codes: &[T; 8]) -> L {
        let [a, b, c, d, e, f, g, h] = *codes;
        let ([a, b, c, d], [e, f, g, h]) = (self.texel([a, b, c, d]), self.texel([e, f, g, h]));
        L::load(&[a, b, c, d, e, f, g, h].map(|x| x.to_f64() as f32))
    }
    /// The number that [`Decode::finish`] turns into `value`.
    fn outside(&self, value: [f64; 4]) -> [T::Real; 4];
    /// An average as a result.
    fn finish(&self, average: [T::Real; 4]) -> [T::Real; 4];
    /// What the other lanes of an average are divided by, if they are.
    fn divisor(&self, _average: [T::Real; 4]) -> Option<T::Real> {
        None
    }
    /// The derivative of the result, from the average and its derivative.
    fn finish_slope(&self, average: [T::Real; 4], slope: [T::Real; 4]) -> [T::Real; 4];
}

/// Codes proportional to results.
#[derive(Clone, Copy)]
pub(crate) struct Plain {
    pub full_scale: f64,
}

impl<T: Texel> Decode<T> for Plain {
    const CODES: bool = true;

    #[inline(always)]
    fn texel(&self, codes: [T; 4]) -> [T::Real; 4] {
        [codes[0].to_real(), codes[1].to_real(), codes[2].to_real(), codes[3].to_real()]
    }

    #[inline(always)]
    fn pair<L: Lanes>(&self, codes: &[T; 8]) -> L {
        T::lanes(codes)
    }

    fn outside(&self, value: [f64; 4]) -> [T::Real; 4] {
        value.map(|v| T::Real::from_f64(v * self.full_scale))
    }

    #[inline(always)]
    fn finish(&self, average: [T::Real; 4]) -> [T::Real; 4] {
        if !T::DTYPE.is_integer() {
            return average;
        }
        // A true division: the average of equal codes is then the correctly rounded quotient.
        let full = T::Real::from_f64(self.full_scale);
        [average[0] / full, average[1] / full, average[2] / full, average[3] / full]
    }

    fn finish_slope(&self, _average: [T::Real; 4], slope: [T::Real; 4]) -> [T::Real; 4] {
        Decode::<T>::finish(self, slope)
    }
}

/// Any code: tables for integers, alpha products.
impl<T: Texel> Decode<T> for Decoder {
    #[inline(always)]
    fn texel(&self, codes: [T; 4]) -> [T::Real; 4] {
        let mut values = [T::Real::ZERO; 4];
        for (lane, (value, code)) in values.iter_mut().zip(codes).enumerate() {
            *value = match self.table {
                Some(table) if lane != self.linear_lane => T::Real::from_f64(f64::from(table[code.index()])),
                _ if T::DTYPE.is_integer() => code.to_real() / T::Real::from_f64(self.full_scale),
                _ => code.to_real(),
            };
        }
        if self.alpha_lane < 4 {
            let alpha = values[self.alpha_lane];
            for (lane, value) in values.iter_mut().enumerate() {
                if lane != self.alpha_lane {
                    *value = *value * alpha;
                }
            }
        }
        values
    }

    #[inline(always)]
    fn pair<L: Lanes>(&self, codes: &[T; 8]) -> L {
        // Bytes of colours or normals without alpha, the usual case: no lane is another's exception.
        if T::DTYPE == DType::U8
            && self.alpha_lane.min(self.linear_lane) == 4
            && let Some(Ok(table)) = self.table.map(<&[f32; 256]>::try_from)
        {
            // A loop: the closure of `map` may be left as a call.
            let mut values = [0.0; 8];
            for (value, code) in values.iter_mut().zip(codes) {
                *value = table[code.index() & 255];
            }
            return L::load(&values);
        }
        let [a, b, c, d, e, f, g, h] = *codes;
        let ([a, b, c, d], [e, f, g, h]) = (self.texel([a, b, c, d]), self.texel([e, f, g, h]));
        L::load(&[a, b, c, d, e, f, g, h].map(|x| x.to_f64() as f32))
    }

    fn outside(&self, value: [f64; 4]) -> [T::Real; 4] {
        value.map(T::Real::from_f64)
    }

    #[inline(always)]
    fn finish(&self, mut average: [T::Real; 4]) -> [T::Real; 4] {
        if self.alpha_lane < 4 {
            let alpha = average[self.alpha_lane];
            for (lane, value) in average.iter_mut().enumerate() {
                if lane != self.alpha_lane {
                    // Where nothing is opaque there is no colour: black, not 0/0.
                    *value = if alpha == T::Real::ZERO { T::Real::ZERO } else { *value / alpha };
                }
            }
        }
        average
    }

    fn divisor(&self, average: [T::Real; 4]) -> Option<T::Real> {
        average.get(self.alpha_lane).copied()
    }

    fn finish_slope(&self, average: [T::Real; 4], slope: [T::Real; 4]) -> [T::Real; 4] {
        if self.alpha_lane == 4 {
            return slope;
        }
        let straight = Decode::<T>::finish(self, average);
        let (alpha, alpha_slope) = (average[self.alpha_lane], slope[self.alpha_lane]);
        std::array::from_fn(|lane| {
            if lane == self.alpha_lane {
                slope[lane]
            } else if alpha == T::Real::ZERO {
                T::Real::ZERO
            } else {
                (slope[lane] - straight[lane] * alpha_slope) / alpha
            }
        })
    }
}
