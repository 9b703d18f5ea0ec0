//! Nearest: the texel that contains the point.

use super::Reader;
use crate::num::floor;
use crate::texel::Texel;
use crate::texture::Decode;

/// Beyond this, coordinates have no fraction left.
const WHOLE: f64 = (1u64 << 53) as f64;

/// Texel `(floor(s), floor(t))` of a level, s and t in texels of level 0. Cost: one texel.
#[inline(always)]
pub(crate) fn nearest<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    s: f64,
    t: f64,
) -> [T::Real; 4] {
    let (base, plane) = (&r.layers.planes[0], &r.layers.planes[level]);
    let [wu, wv] = r.layers.wrap;
    // Rounded down before wrapping, so that a mirrored texel owns the mirror of its edges. The quotient is
    // exact at whole periods.
    let along = |wrap: crate::wrap::Wrap, x: f64, from: i32, to: i32| {
        let (from, to) = (f64::from(from), f64::from(to));
        let x = if from == to { x } else { (x.clamp(-1e300, 1e300) * to) / from };
        let index = match wrap.period(to) {
            Some(period) if x.abs() >= WHOLE => x.rem_euclid(period) as i64,
            _ => floor(x.clamp(-WHOLE, WHOLE)),
        };
        wrap.index(index, to as i64)
    };
    match (along(wu, s, base.width, plane.width), along(wv, t, base.height, plane.height)) {
        (Some(x), Some(y)) => r.decode.texel(plane.texel(x as i32, y as i32)),
        _ => r.outside,
    }
}
