//! Small numeric helpers that know nothing about images.

/// Base-2 logarithm of a positive finite number, the same bits on every platform.
///
/// Splits `x = 2^e * m` with `m` in `[sqrt(1/2), sqrt(2))`, then sums
/// `log2(m) = 2/ln 2 * (s + s^3/3 + s^5/5 + s^7/7 + s^9/9)`, `s = (m - 1)/(m + 1)`.
/// Exact at powers of two; absolute error below 3e-7. Subnormals give a value below -126.
/// Zero gives `-inf`, infinity `inf`, NaN and negative numbers NaN.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    if x.is_nan() || x <= 0.0 || x.is_infinite() {
        return if x == 0.0 {
            f32::NEG_INFINITY
        } else if x == f32::INFINITY {
            x
        } else {
            f32::NAN
        };
    }
    let (x, shift) = if x < f32::MIN_POSITIVE { (x * 16_777_216.0, -24.0) } else { (x, 0.0) };
    log2_of_normal(x) + shift
}

/// As [`log2`], for positive normal numbers alone: without branches, so that loops over it become lanes.
#[inline(always)]
pub fn log2_of_normal(x: f32) -> f32 {
    // Subtracting the bits of sqrt(1/2) moves the exponent's step to sqrt(1/2).
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let offset = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let exponent = (offset as i32) >> 23;
    let m = f32::from_bits((offset & 0x007f_ffff).wrapping_add(SQRT_HALF_BITS));
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let series = 1.0 + q * (1.0 / 3.0 + q * (0.2 + q * (1.0 / 7.0 + q * (1.0 / 9.0))));
    exponent as f32 + s * series * (2.0 / std::f32::consts::LN_2)
}

/// Single or double precision: what values are computed in.
pub trait Real:
    Copy
    + Default
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::AddAssign
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The nearest value.
    fn from_f64(x: f64) -> Self;
    /// The value as a double, exactly.
    fn to_f64(self) -> f64;
    /// The slice, tagged with its type.
    fn tagged(slice: &mut [Self]) -> RealsMut<'_>;
}

/// Numbers to be written, in either precision. Work that takes them so is compiled once, in this crate, and not anew in
/// each crate that calls it.
pub enum RealsMut<'a> {
    /// In single precision.
    F32(&'a mut [f32]),
    /// In double precision.
    F64(&'a mut [f64]),
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn tagged(slice: &mut [Self]) -> RealsMut<'_> {
        RealsMut::F32(slice)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    fn tagged(slice: &mut [Self]) -> RealsMut<'_> {
        RealsMut::F64(slice)
    }
}

/// The largest whole number not above `x`, for `|x| < 2^63`; NaN gives 0.
///
/// `f64::floor` is a call into the C library where the build's baseline lacks SSE4.1; this is four instructions.
#[inline(always)]
pub fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(x < towards_zero as f64)
}

/// The smallest whole number not below `x`, for `|x| < 2^63`; NaN gives 0.
#[inline(always)]
pub fn ceil(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero + i64::from(x > towards_zero as f64)
}

/// Linear interpolation that returns `a` exactly when `a == b`.
#[inline(always)]
pub fn lerp<R: Real>(a: R, b: R, t: R) -> R {
    a + t * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log2_is_exact_at_powers_of_two_and_close_elsewhere() {
        for e in -149..128 {
            let x = 2f64.powi(e) as f32;
            assert_eq!(log2(x), e as f32, "2^{e}");
        }
        for i in 0..200_000 {
            let x = 1e-6f32 * 1.000_15f32.powi(i);
            assert!(
                (f64::from(log2(x)) - f64::from(x).log2()).abs() < 3e-7 * f64::from(x).log2().abs().max(1.0),
                "{x}"
            );
        }
    }

    #[test]
    fn floor_is_the_librarys() {
        for k in -4000..4000 {
            let x = f64::from(k) / 16.0;
            for x in [x, x.next_up(), x.next_down(), x * 1e9, x * 1e15] {
                assert_eq!(floor(x) as f64, x.floor(), "{x}");
                assert_eq!(ceil(x) as f64, x.ceil(), "{x}");
            }
        }
    }

    #[test]
    fn log2_of_the_rest() {
        assert_eq!(log2(0.0), f32::NEG_INFINITY);
        assert_eq!(log2(f32::INFINITY), f32::INFINITY);
        assert!(log2(-1.0).is_nan() && log2(f32::NAN).is_nan());
    }
}
