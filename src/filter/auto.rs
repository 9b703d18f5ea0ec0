//! Auto without a tolerance: the interpolation where a pixel is smaller than a texel, the mean over its
//! footprint where it is larger.
//!
//! Up to `sigma1 = 1` texel a pixel nothing is lost between pixels, and the bilinear value at the centre is what
//! interpolating peers show: a map that only moves or magnifies leaves texels as they are. From [`FULL`] on it
//! is [`super::area`], whose error is a few thousandths of the contrast at any ratio; between the two one
//! fades into the other, so nothing jumps. Cost: that of the filters it chooses.

use super::{Query, Reader, area, bilinear, lerp4};
use crate::num::Real;
use crate::texel::Texel;
use crate::texture::Decode;

/// Length of the footprint's major axis, in texels, from which the mean alone is shown.
const FULL: f64 = 1.25;

/// The filter at one place.
pub(crate) fn auto<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    let sigma1 = query.jacobian_tx.sigma1();
    if sigma1 <= 1.0 {
        return bilinear(r, 0, query.s, query.t);
    }
    let mean = area(r, query);
    if sigma1.is_nan() || sigma1 >= FULL {
        return mean;
    }
    let x = (sigma1 - 1.0) / (FULL - 1.0);
    let share = x * x * (3.0 - 2.0 * x);
    lerp4(bilinear(r, 0, query.s, query.t), mean, T::Real::from_f64(share))
}
