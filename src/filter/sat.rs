//! Summed-area table: the mean of the texels, as squares, over the upright rectangle around the footprint.
//!
//! The rectangle has the footprint's bounds for sides, `|a| + |b|` by `|c| + |d|`, and at least one texel: the
//! mean over the unit square around a place is the bilinear reconstruction there, so a magnified texture is
//! interpolated.
//!
//! Source: F. Crow, "Summed-area tables for texture mapping", SIGGRAPH 1984. Cost: four reads of the table inside the
//! picture with whole corners, at most 36 with fractional ones, whatever the extent. Error: an oblique footprint
//! is blurred, most at 45 degrees, where the rectangle is twice its area. A footprint that is not finite is
//! the whole texture.

use super::{Query, Reader, bilinear};
use crate::texel::Texel;
use crate::texture::Decode;

/// The filter at one place. The layers have their table (see `Texture::table`).
#[inline(never)]
pub(crate) fn sat<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    let Some(table) = r.layers.sums else {
        return bilinear(r, 0, query.s, query.t);
    };
    let plane = &r.layers.planes[0];
    let size = [f64::from(plane.width), f64::from(plane.height)];
    let side = |axis: usize, place: f64| {
        let [a, b] = query.jacobian_tx.m[axis];
        let place = r.layers.wrap[axis].period(size[axis]).map_or(place, |period| place.rem_euclid(period));
        let half = 0.5 * (a.abs() + b.abs()).max(1.0);
        (place - half, place + half)
    };
    let [(x0, x1), (y0, y1)] = [side(0, query.s), side(1, query.t)];
    let mean = if query.jacobian_tx.is_finite() && [x0, x1, y0, y1].iter().all(|x| x.abs() < 1e300) {
        table.mean_rect::<4>(x0, y0, x1, y1)
    } else {
        table.mean_rect::<4>(0.0, 0.0, size[0], size[1])
    };
    r.decode.outside(mean)
}
