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
//! [`super::probes`] reads lines in lanes; textures of doubles are read here, probe by probe.
//! Cost: `2k + 1` trilinear reads, at most `max_anisotropy + 2`, and never more than [`MOST`]` + 2`.

use super::probes::BLOCK;
use super::{Filter, Query, Reader, mipmap};
use crate::jacobian::Jacobian;
use crate::lod::level_of;
use crate::num::Real;
use crate::texel::Texel;
use crate::texture::Decode;

/// The longest footprint, in widths, that is followed where no other limit is given: a line without width
/// would need probes without end.
const MOST: f64 = 1024.0;
/// Texels that no texture has, and whose fourth power a double still holds: footprints this long see the
/// coarsest level.
const BEYOND: f64 = 1e30;
/// Ratios nearer to 1 than this are 1: the rounding of a round footprint is not followed.
const ROUND: f64 = 1.0 + 1e-9;

/// Where the probes of a footprint stand and how they are weighted.
#[derive(Clone, Copy)]
pub(super) struct Line {
    /// From one probe to the next, in texels of level 0.
    pub step: [f64; 2],
    /// Probes on either side of the middle one.
    pub half: f32,
    /// Weight of the outermost two; that of the others is 1.
    pub outer: f32,
    /// One over the sum of weights.
    pub share: f32,
}

/// The lines of a block, number by number.
pub(super) struct Lines {
    pub step: [[f64; BLOCK]; 2],
    pub half: [f32; BLOCK],
    pub outer: [f32; BLOCK],
    pub share: [f32; BLOCK],
}

impl Lines {
    /// One probe each.
    pub const POINTS: Self =
        Self { step: [[0.0; BLOCK]; 2], half: [0.0; BLOCK], outer: [0.0; BLOCK], share: [1.0; BLOCK] };

    /// Line `i`.
    #[inline(always)]
    pub fn at(&self, i: usize) -> Line {
        let step = [self.step[0][i], self.step[1][i]];
        Line { step, half: self.half[i], outer: self.outer[i], share: self.share[i] }
    }

    /// Finds the lines of Jacobians, and the levels of detail of their probes.
    #[inline(always)]
    pub fn find(&mut self, m: &[[f64; BLOCK]; 4], max_anisotropy: f64, lod: &mut [f32; BLOCK]) {
        let [a, b, c, d] = m;
        for i in 0..BLOCK {
            let (line, level) = line([a[i], b[i], c[i], d[i]], max_anisotropy);
            (self.step[0][i], self.step[1][i]) = (line.step[0], line.step[1]);
            (self.half[i], self.outer[i], self.share[i], lod[i]) = (line.half, line.outer, line.share, level);
        }
    }
}

/// The line of a Jacobian a, b, c, d, and the level of detail of its probes. Without branches, so that a loop over it
/// becomes lanes.
#[inline(always)]
fn line([a, b, c, d]: [f64; 4], max_anisotropy: f64) -> (Line, f32) {
    let jacobian = Jacobian { m: [[a, b], [c, d]] };
    let most = if max_anisotropy < MOST { max_anisotropy } else { MOST };
    let sigma1 = jacobian.sigma1();
    let quotient = jacobian.det().abs() / sigma1;
    let sigma2 = if quotient < sigma1 { quotient } else { sigma1 };
    let least = sigma1 / most;
    let width = if sigma2 < least { least } else { sigma2 };
    let ratio = sigma1 / width;
    let width = if ratio < ROUND { sigma1 } else { width };

    let half = ((ratio - 1.0) * 0.5).ceil();
    let outer = 0.5 * ratio + 0.5 - half;
    // The weights sum to the ratio: all but the outermost are 1.
    let inner = half - 1.0;
    let second_moment = inner * (inner + 1.0) * (2.0 * inner + 1.0) / 3.0 + 2.0 * outer * half * half;
    // The major axis bisects the directions of the two conformal parts; not yet a unit vector.
    let p = 0.5 * ((a * a + b * b) - (c * c + d * d));
    let q = a * c + b * d;
    let r = (p * p + q * q).sqrt();
    let x = if p >= 0.0 { p + r } else { q };
    let y = if p >= 0.0 { q } else { r - p };
    let square = x * x + y * y;
    let variance = width * width * (ratio * ratio - 1.0) / 12.0;
    let spacing = (variance * ratio / (second_moment * square)).sqrt();
    // Magnified along both axes, a point, or beyond all bounds: nothing that more probes could show.
    let is_long =
        (sigma1 > 1.0) & (sigma1 <= BEYOND) & (ratio >= ROUND) & (second_moment > 0.0) & (square > 0.0);
    let step = if is_long { [x * spacing, y * spacing] } else { [0.0; 2] };
    let half = if is_long { half as f32 } else { 0.0 };
    (Line { step, half, outer: outer as f32, share: (1.0 / ratio) as f32 }, level_of(width))
}

/// The filter at one place; `lod_bias` is added to the level of the probes.
pub(crate) fn anisotropic<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    max_anisotropy: f64,
    lod_bias: f32,
) -> [T::Real; 4] {
    let [[a, b], [c, d]] = query.jacobian_tx.m;
    let (line, lod) = line([a, b, c, d], max_anisotropy);
    let probe = |i: f64| {
        let (s, t) = (query.s + i * line.step[0], query.t + i * line.step[1]);
        mipmap(r, Filter::Trilinear, s, t, lod + lod_bias)
    };
    // A running mean: equal probes give their value, whatever the weights round to.
    let mut mean = probe(0.0);
    let mut total = 1.0;
    let half = f64::from(line.half);
    let mut i = 1.0;
    while i <= half {
        let weight = if i < half { 1.0 } else { f64::from(line.outer) };
        for value in [probe(-i), probe(i)] {
            total += weight;
            let share = T::Real::from_f64(weight / total);
            for (mean, value) in mean.iter_mut().zip(value) {
                *mean += share * (value - *mean);
            }
        }
        i += 1.0;
    }
    mean
}
