//! Anisotropic: trilinear probes along the footprint's major axis, on the level of its minor axis.
//!
//! The footprint's width along its axes are the singular values `sigma1 >= sigma2` of the Jacobian in texels.
//! Probes have the width `w = max(sigma2, sigma1/max_anisotropy)` and read level `log2(w)`. With
//! `n = max(1, sigma1/w)`, probe `i` stands `i d` from the centre along the major axis, `i = -k..=k`,
//! `k = ceil((n-1)/2)`; its weight is its overlap with the footprint, `clamp(n/2 + 1/2 - |i|, 0, 1)`, so the
//! outermost two come in gradually and nothing jumps when their number changes. The spacing `d` is chosen so
//! that the probes' variance plus one probe's own, `w^2/12`, is that of the footprint, `sigma1^2/12`:
//! `d^2 = w^2 (n^2 - 1)/12 / var(i)`; it is `w` for odd n. A ratio of 1 is exactly one trilinear read.
//!
//! The idea: J. McCormack and others, "Feline: fast elliptical lines for anisotropic texture mapping",
//! SIGGRAPH 1999; here with a box along the line, because the truth is a box.
//! Cost: `2k + 1` trilinear reads, at most `max_anisotropy + 2`, and never more than [`MOST`]` + 2`.

use super::{Filter, Query, Reader, mipmap};
use crate::num::{Real, log2};
use crate::texel::Texel;
use crate::texture::Decode;

/// The longest footprint, in widths, that is followed where no other limit is given: a line without width
/// would need probes without end.
const MOST: f64 = 1024.0;
/// Texels that no texture has, and whose fourth power a double still holds: footprints this long see the
/// coarsest level.
const BEYOND: f64 = 1e30;

/// The filter at one place; `lod_bias` is added to the level of the probes.
#[inline(always)]
pub(crate) fn anisotropic<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    max_anisotropy: f64,
    lod_bias: f32,
) -> [T::Real; 4] {
    let axes = query.jacobian_tx.axes();
    let width = axes.sigma2.max(axes.sigma1 / max_anisotropy.min(MOST));
    let lod = log2(width as f32) + lod_bias;
    let ratio = axes.sigma1 / width;
    // Magnified along both axes, a point, or beyond all bounds: nothing that more probes could show.
    if axes.sigma1 <= 1.0 || axes.sigma1 > BEYOND || ratio.is_nan() || ratio <= 1.0 {
        return mipmap(r, Filter::Trilinear, query.s, query.t, lod);
    }
    let k = ((ratio - 1.0) / 2.0).ceil();
    let weight = |i: f64| (0.5 * ratio + 0.5 - i.abs()).clamp(0.0, 1.0);
    // The weights sum to the ratio: all but the outermost are 1.
    let inner = k - 1.0;
    let second_moment = inner * (inner + 1.0) * (2.0 * inner + 1.0) / 3.0 + 2.0 * weight(k) * k * k;
    if second_moment == 0.0 {
        // A ratio within an ulp of 1: the outer probes have no weight.
        return mipmap(r, Filter::Trilinear, query.s, query.t, lod);
    }
    let spacing = width * ((ratio * ratio - 1.0) / 12.0 / (second_moment / ratio)).sqrt();
    let step = axes.major.map(|m| m * spacing);
    // A running mean: equal probes give their value, whatever the weights round to.
    let mut mean = [T::Real::ZERO; 4];
    let mut total = 0.0;
    let mut i = -k;
    while i <= k {
        let weight = weight(i);
        total += weight;
        let share = T::Real::from_f64(if total > 0.0 { weight / total } else { 0.0 });
        let probe = mipmap(r, Filter::Trilinear, query.s + i * step[0], query.t + i * step[1], lod);
        for (mean, value) in mean.iter_mut().zip(probe) {
            *mean += share * (value - *mean);
        }
        i += 1.0;
    }
    mean
}
