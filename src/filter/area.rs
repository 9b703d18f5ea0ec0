//! Area: the mean over the footprint, fast and nearly exact.
//!
//! A soft parallelogram: a texel's weight is `T(k1, p) T(k2, q)`, with `p` and `q` its distances from the footprint's
//! centre lines, `k1` and `k2` half the footprint's heights, and `T` a step softened by the reconstruction's tent,
//!
//! ```text
//! T(k, p) = S(k - |p|) + S(k + |p|) - 1,      S(z) = 1/2 + c (1 - |c|/2),  c = clamp(z / w, -1, 1)
//! ```
//!
//! divided by the sum of weights. `w = 1` gives the edge the variance of the tent, 1/6, in every direction, as the
//! bilinear reconstruction has it: only corners are wrong. On coarser levels, whose texels are means of squares,
//! `w` is [`COARSE`].
//!
//! The level is the one where the smaller height has [`TARGET`] to twice that many texels; towards the coarser end
//! the next level is blended in. On level 0, where corners count most (error about `(0.03 + 0.42 rho)/A` of the
//! contrast, `A` the area and `rho` the cosine between the sides), the weights are the exact ones of
//! [`super::exact`] as far as that estimate exceeds [`TRUSTED`]; so a small footprint is integrated exactly.
//!
//! Cost: 40 to 100 texels at ratio 1, in proportion to the ratio beyond; footprints longer than
//! [`LONGEST`] widths are widened. Error: `docs/filters.md`.

use super::exact::mean_on_level;
use super::rows::Weights;
use super::sum::{Placed, Sum, placed};
use super::{Query, Reader, bilinear, lerp4};
use crate::lod;
use crate::num::{Real, log2};
use crate::texel::Texel;
use crate::texture::Decode;
use std::cell::RefCell;

/// Texels in the smaller height, on the finest level that is read for it.
const TARGET: f64 = 3.0;
/// Share of an octave over which the coarser level is blended in.
const BAND: f32 = 0.25;
/// Softness of edges on levels beyond the first.
const COARSE: f64 = 0.7;
/// Estimated error, as a share of the contrast, up to which level 0 is read by soft weights alone.
const TRUSTED: f64 = 0.004;
/// Longest footprint, in widths.
const LONGEST: f64 = 512.0;

thread_local! {
    static ROW: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// The filter at one place.
pub(crate) fn area<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    let axes = query.jacobian_tx.axes();
    if !axes.sigma1.is_finite() {
        return bilinear(r, r.last_level(), query.s, query.t);
    }
    let [[a, b], [c, d]] = query.jacobian_tx.m;
    let longest = (a * a + c * c).max(b * b + d * d).sqrt();
    let height = if longest > 0.0 { query.jacobian_tx.det().abs() / longest } else { 0.0 };
    let height = height.max(axes.sigma1 / LONGEST);
    let (level, fraction) = lod::split(lod::clamp(log2((height / TARGET) as f32), r.last_level()));
    let fine = on_level(r, level, query);
    let share = (fraction - (1.0 - BAND)) / BAND;
    if share <= 0.0 {
        return fine;
    }
    lerp4(fine, on_level(r, level + 1, query), T::Real::from_f64(f64::from(share)))
}

/// The mean over the footprint on one level.
fn on_level<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, level: usize, query: &Query) -> [T::Real; 4] {
    let place = placed(r, level, query);
    let [[a, b], [c, d]] = place.jacobian.m;
    let (len1, len2) = ((a * a + c * c).sqrt(), (b * b + d * d).sqrt());
    let area = place.jacobian.det().abs();
    let height = area / len1.max(len2);
    // How much of the soft weights to use: none on the coarsest level, whose footprints have no bounds.
    let trust = if level == r.last_level() || height.is_nan() || height <= 1.0 {
        0.0
    } else if level == 0 {
        let cosine = (a * b + c * d).abs() / (len1 * len2);
        2.0 - (0.03 + 0.42 * cosine) / area / TRUSTED
    } else {
        2.0 * (height - 1.0)
    };
    let trust = trust.clamp(0.0, 1.0);
    let exact = |r| mean_on_level(r, level, query);
    if trust == 0.0 {
        return exact(r);
    }
    let soft = soft(r, level, &place, if level == 0 { 1.0 } else { COARSE });
    if trust == 1.0 { soft } else { lerp4(exact(r), soft, T::Real::from_f64(trust)) }
}

/// One pair of sides: the distance of a point from their centre line is `normal . (x, y)`.
struct Strip {
    normal: [f64; 2],
    half: f64,
    soft: f64,
}

impl Strip {
    /// Weight at a distance.
    #[inline]
    fn weight(&self, distance: f64) -> f64 {
        let step = |z: f64| {
            let c = (z / self.soft).clamp(-1.0, 1.0);
            0.5 + c * (1.0 - 0.5 * c.abs())
        };
        let p = distance.abs();
        step(self.half - p) + step(self.half + p) - 1.0
    }

    /// Where a row, `dy` above the centre, lies within the strip.
    fn interval(&self, dy: f64) -> (f64, f64) {
        let (reach, offset) = (self.half + self.soft, self.normal[1] * dy);
        let slope = self.normal[0];
        if slope.abs() < 1e-12 {
            return if offset.abs() < reach { (-f64::INFINITY, f64::INFINITY) } else { (1.0, -1.0) };
        }
        let (p, q) = ((-reach - offset) / slope, (reach - offset) / slope);
        (p.min(q), p.max(q))
    }
}

fn soft<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    place: &Placed,
    softness: f64,
) -> [T::Real; 4] {
    let [[a, b], [c, d]] = place.jacobian.m;
    let area = place.jacobian.det().abs();
    // The sides along (x, y) have the distance area / |(x, y)|.
    let strip = |x: f64, y: f64| {
        let length = (x * x + y * y).sqrt();
        Strip { normal: [-y / length, x / length], half: 0.5 * area / length, soft: softness }
    };
    let strips = [strip(b, d), strip(a, c)];
    let reach = |p: f64, q: f64| {
        let grown = |side: f64, strip: &Strip| 0.5 * side.abs() * (1.0 + softness / strip.half);
        grown(p, &strips[0]) + grown(q, &strips[1])
    };
    let (width, height) = (reach(a, b), reach(c, d));
    let centre = [place.near(0, width), place.near(1, height)];
    let mut sum = Sum::new(r, level, centre);
    ROW.with_borrow_mut(|weights| {
        let mut y = (centre[1] - height).ceil();
        while y <= centre[1] + height {
            let dy = y - centre[1];
            let (p, q) = (strips[0].interval(dy), strips[1].interval(dy));
            let first = (centre[0] + p.0.max(q.0)).ceil();
            let count = ((centre[0] + p.1.min(q.1)).floor() - first).max(-1.0) + 1.0;
            weights.clear();
            let start = first - centre[0];
            let [p, q] =
                [&strips[0], &strips[1]].map(|s| (s.normal[0], s.normal[0] * start + s.normal[1] * dy));
            weights.extend((0..count as usize).map(|k| {
                let k = k as f64;
                strips[0].weight(p.1 + p.0 * k) * strips[1].weight(q.1 + q.0 * k)
            }));
            sum.row(r, level, &Weights { row: y as i64, first: first as i64, weights, middle: 0..0 });
            y += 1.0;
        }
    });
    sum.mean()
}
