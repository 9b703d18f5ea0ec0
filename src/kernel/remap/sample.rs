//! Element types that can be interpolated, and how a sum becomes an element again.

use super::boxes::{self, Out, Taps};
use super::{Job, Points};
use crate::kernel::Isa;
use half::f16;
use std::ops::{Add, Mul, Sub};

/// The numbers that arithmetic is done in.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
{
    /// The nearest number of this type.
    fn of(x: f64) -> Self;
    /// The number as a double.
    fn wide(self) -> f64;
}

impl Real for f32 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

/// An element of a picture.
///
/// [`Sample::put`] rounds to the nearest value, ties to the even one, and saturates; NaN becomes the
/// smallest value of an integer type.
pub trait Sample: Copy + Default + Send + Sync + 'static {
    /// `f32`, or `f64` for `f64` elements.
    type Acc: Real;
    /// The element as a number.
    fn get(self) -> Self::Acc;
    /// The element nearest to a number.
    fn put(x: Self::Acc) -> Self;
    /// Does the whole run with vectors of `isa`; `false` where there is no such kernel.
    fn vector(_isa: Isa, _job: &Job<'_, Self>, _points: &Points<'_, Self::Acc>, _out: &mut [Self]) -> bool {
        false
    }
    /// Means over a chunk of boxes.
    fn boxes(isa: Isa, job: &Job<'_, Self>, taps: &mut Taps, out: Out<'_, Self>) {
        boxes::numbers(isa, job, taps, out);
    }
}

/// 1.5 * 2^23: adding it to a number below 2^22 in size leaves the nearest integer, ties to even, in the
/// low bits of the sum.
const ROUND: f32 = 12_582_912.0;

macro_rules! integer_sample {
    ($type:ty $(, $vector:path $(, $boxes:path)?)?) => {
        impl Sample for $type {
            type Acc = f32;
            #[inline(always)]
            fn get(self) -> f32 {
                f32::from(self)
            }
            #[inline(always)]
            fn put(x: f32) -> Self {
                let low = if x > <$type>::MIN as f32 { x } else { <$type>::MIN as f32 };
                let x = if low < <$type>::MAX as f32 { low } else { <$type>::MAX as f32 };
                (x + ROUND).to_bits() as $type
            }
            $(fn vector(isa: Isa, job: &Job<'_, Self>, points: &Points<'_, f32>, out: &mut [Self]) -> bool {
                $vector(isa, job, points, out)
            }
            $(fn boxes(isa: Isa, job: &Job<'_, Self>, taps: &mut Taps, out: Out<'_, Self>) {
                $boxes(isa, job, taps, out);
            })?)?
        }
    };
}

integer_sample!(u8, super::vector_u8, boxes::bytes);
integer_sample!(u16, super::vector_u16);
integer_sample!(i16);

impl Sample for f32 {
    type Acc = f32;
    #[inline(always)]
    fn get(self) -> f32 {
        self
    }
    #[inline(always)]
    fn put(x: f32) -> Self {
        x
    }
    fn vector(isa: Isa, job: &Job<'_, Self>, points: &Points<'_, f32>, out: &mut [Self]) -> bool {
        super::vector_f32(isa, job, points, out)
    }
}

impl Sample for f16 {
    type Acc = f32;
    #[inline(always)]
    fn get(self) -> f32 {
        self.to_f32()
    }
    #[inline(always)]
    fn put(x: f32) -> Self {
        Self::from_f32(x)
    }
}

impl Sample for f64 {
    type Acc = f64;
    #[inline(always)]
    fn get(self) -> f64 {
        self
    }
    #[inline(always)]
    fn put(x: f64) -> Self {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_round_half_to_even_and_saturate() {
        for (x, y) in
            [(0.5, 0), (1.5, 2), (2.5, 2), (2.51, 3), (254.5, 254), (255.5, 255), (-7.0, 0), (1e9, 255)]
        {
            assert_eq!(u8::put(x), y, "{x}");
        }
        assert_eq!((u8::put(f32::NAN), i16::put(f32::NAN), u16::put(f32::INFINITY)), (0, -32_768, 65_535));
        for x in -32_768..=32_767i16 {
            assert_eq!(i16::put(x.get()), x);
            assert_eq!(i16::put(x.get() + 0.49), x);
            assert_eq!(u16::put((x as u16).get() - 0.49), x as u16);
        }
        assert_eq!((i16::put(-2.5), i16::put(-3.5), i16::put(-0.5)), (-2, -4, 0));
    }
}
