//! Bilinear: the tensor product of linear interpolation between texel centres.

use super::{Reader, lerp4, whole_and_part};
use crate::texel::Texel;
use crate::texture::Decode;

/// With `x = s - 1/2 = i + a` and `y = t - 1/2 = j + b`, `a` and `b` in `[0, 1)`:
/// `(1-a)(1-b) T(i,j) + a(1-b) T(i+1,j) + (1-a)b T(i,j+1) + ab T(i+1,j+1)`, computed as three linear
/// interpolations so that equal texels give exactly their value. Cost: four texels.
#[inline(always)]
pub(crate) fn bilinear<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    s: f64,
    t: f64,
) -> [T::Real; 4] {
    let (s, t) = r.on_level(level, s, t);
    let (i, a) = whole_and_part::<T::Real>(s - 0.5);
    let (j, b) = whole_and_part::<T::Real>(t - 0.5);
    let [t00, t10, t01, t11] = r.taps(level, i, j);
    lerp4(lerp4(t00, t10, a), lerp4(t01, t11, a), b)
}

/// Value and derivatives by s and t (texels of level 0) on level 0:
/// `d/da = (1-b)(T(i+1,j) - T(i,j)) + b(T(i+1,j+1) - T(i,j+1))`, and likewise by b.
/// On a texel centre's line, where the slope jumps, the slope towards larger coordinates is given.
/// Along the picture as stored: where a mirrored copy runs backwards the caller turns the sign.
pub(crate) fn bilinear_gradient<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    s: f64,
    t: f64,
) -> [[T::Real; 4]; 3] {
    let (s, t) = r.on_level(0, s, t);
    let (i, a) = whole_and_part::<T::Real>(s - 0.5);
    let (j, b) = whole_and_part::<T::Real>(t - 0.5);
    let [t00, t10, t01, t11] = r.taps(0, i, j);
    let difference =
        |p: [T::Real; 4], q: [T::Real; 4]| -> [T::Real; 4] { std::array::from_fn(|k| q[k] - p[k]) };
    [
        lerp4(lerp4(t00, t10, a), lerp4(t01, t11, a), b),
        lerp4(difference(t00, t10), difference(t01, t11), b),
        lerp4(difference(t00, t01), difference(t10, t11), a),
    ]
}
