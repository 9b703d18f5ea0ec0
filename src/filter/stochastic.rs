//! Stochastic: one random texel, whose expectation is the mean of the bilinear reconstruction over the footprint.
//!
//! Two uniform numbers choose a point of the footprint, two more one of the four texels around it with its
//! bilinear weight: texel `floor(x + xi)` with `x` from the centre of texel 0. Source: M. Pharr, B. Wronski,
//! M. Salvi, M. Fajardo, "Filtering after shading with stochastic texture filtering", I3D 2024.
//!
//! The numbers depend on the seed and on the sample's place in its batch alone: 64 bits each from the finaliser of
//! SplitMix64 (G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014) over
//! a counter, so threads and order change nothing. Cost: one texel. Error: that of one random texel; the mean
//! over n seeds has its variance divided by n. A footprint that is not finite is the whole texture.

use super::{Query, Reader};
use crate::num::floor;
use crate::texel::Texel;
use crate::texture::Decode;

/// The filter at one place, with one seed.
#[inline(never)]
pub(crate) fn stochastic<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    seed: u64,
) -> [T::Real; 4] {
    let plane = &r.layers.planes[0];
    let key = mix(seed).wrapping_add(query.index.wrapping_mul(2));
    let [[p, q], [xi, eta]] = [mix(key), mix(key.wrapping_add(1))].map(two_uniform);
    let size = [f64::from(plane.width), f64::from(plane.height)];
    if !query.jacobian_tx.is_finite() {
        return r.tap(0, floor(p * size[0]) as i32, floor(q * size[1]) as i32);
    }
    let (p, q) = (p - 0.5, q - 0.5);
    let texel = |axis: usize, centre: f64, xi: f64| {
        let [a, b] = query.jacobian_tx.m[axis];
        // Reduced first, so that the offset keeps its digits; one texel outside says as much as any.
        let wrap = r.layers.wrap[axis];
        let place = wrap.period(size[axis]).map_or(centre, |period| centre.rem_euclid(period));
        let (reduced, _) = wrap.reduce(place + a * p + b * q, size[axis]);
        floor(reduced.clamp(-2.0, size[axis] + 2.0) - 0.5 + xi) as i32
    };
    r.tap(0, texel(0, query.s, xi), texel(1, query.t, eta))
}

/// SplitMix64's output function, after one step of its counter.
fn mix(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Two numbers in [0, 1) from the halves of a word.
fn two_uniform(bits: u64) -> [f64; 2] {
    const STEP: f64 = 1.0 / 4_294_967_296.0;
    // The middle of each step: an expectation of exactly one half.
    [(bits >> 32) as f64, (bits & 0xffff_ffff) as f64].map(|b| (b + 0.5) * STEP)
}
