//! Nearest: the texel that contains the point.

use super::Reader;
use crate::num::floor;
use crate::texel::Texel;
use crate::texture::Decode;

/// Texel `(floor(s), floor(t))` of a level, s and t in texels of level 0. Cost: one texel.
#[inline(always)]
pub(crate) fn nearest<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    s: f64,
    t: f64,
) -> [T::Real; 4] {
    let (s, t) = r.on_level(level, s, t);
    r.tap(level, floor(s) as i32, floor(t) as i32)
}
