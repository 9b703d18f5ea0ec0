//! The mipmap filters of OpenGL 4.6, section 8.14: nearest or bilinear in a level, nearest or blended
//! between levels. L. Williams, "Pyramidal parametrics", SIGGRAPH 1983.
//!
//! At a level of detail of 0 and below, level 0 is read by the same in-level filter, so nothing jumps where
//! minification becomes magnification. Cost: one to eight texels. Error: an isotropic footprint is
//! assumed; a long one is blurred across or aliased along (see `LodRule`).

use super::{Filter, Reader, bilinear, lerp4, nearest};
use crate::lod;
use crate::num::Real;
use crate::texel::Texel;
use crate::texture::Decode;

/// One of the four mipmap filters at (s, t) with a level of detail that has its bias already.
#[inline(always)]
pub(crate) fn mipmap<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    filter: Filter,
    s: f64,
    t: f64,
    lod: f32,
) -> [T::Real; 4] {
    let lod = lod::clamp(lod, r.last_level());
    match filter {
        Filter::NearestMipmapNearest => nearest(r, lod::nearest(lod), s, t),
        Filter::LinearMipmapNearest => bilinear(r, lod::nearest(lod), s, t),
        Filter::NearestMipmapLinear => blend(lod, |level| nearest(r, level, s, t)),
        _ => blend(lod, |level| bilinear(r, level, s, t)),
    }
}

/// Two levels, weighted by the fraction of the level of detail; one where the fraction is zero.
#[inline(always)]
fn blend<R: Real>(lod: f32, mut read: impl FnMut(usize) -> [R; 4]) -> [R; 4] {
    let (level, fraction) = lod::split(lod);
    let fine = read(level);
    if fraction == 0.0 {
        return fine;
    }
    lerp4(fine, read(level + 1), R::from_f64(f64::from(fraction)))
}
