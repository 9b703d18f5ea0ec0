//! Area: the mean over the footprint, fast and nearly exact.
//!
//! A soft parallelogram: a texel's weight is `T(k1, p) T(k2, q)` and a term for slanted sides, with `p` and `q` its distances
//! from the footprint's centre lines, `k1` and `k2` half the footprint's heights, and `T` a box softened by the
//! reconstruction's tent, divided by the sum of weights: [`Soft`]. A softness of 1 gives the edge the variance of the tent,
//! 1/6, in every direction, as the bilinear reconstruction has it: only corners are wrong. On coarser levels, whose texels
//! are means of squares, it is [`COARSE`].
//!
//! The level is the one where the smaller height has [`TARGET`] to twice that many texels; towards the coarser end
//! the next level is blended in. On level 0 the weights are the exact ones of [`super::exact`] as far as the estimate of
//! [`error`] exceeds [`TRUSTED`]; so a small footprint is integrated exactly.
//!
//! Cost: 40 to 100 texels at ratio 1, in proportion to the ratio beyond; footprints longer than
//! [`LONGEST`] widths are widened. Error: `docs/filters.md`.

use super::exact::mean_on_level;
use super::rows::{Slabs, Weights, lifted};
use super::sum::{Placed, Sum, Wrapped, placed, rows_mean};
use super::{Query, Reader, bilinear, lerp4};
use crate::kernel::soft_codes;
use crate::kernel::window::{self, Soft, Spans};
use crate::num::{Real, ceil, floor, log2};
use crate::texel::{DType, Texel};
use crate::texture::Decode;

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
/// Footprints thinner than this, in texels, have no soft weights; twice as wide ones have nothing else.
const NARROW: f64 = 0.05;
/// Footprints thinner than this, in texels, are left to [`super::exact`].
const THIN: f64 = 0.01;

/// The filter at one place. Never inlined: once for each kind of texture is enough.
#[inline(never)]
pub(crate) fn area<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    let [[a, b], [c, d]] = query.jacobian_tx.m;
    let squares = [a * a + c * c, b * b + d * d];
    if !(squares[0] + squares[1]).is_finite() {
        return bilinear(r, r.last_level(), query.s, query.t);
    }
    let longest = squares[0].max(squares[1]).sqrt();
    let height = if longest > 0.0 { query.jacobian_tx.det().abs() / longest } else { 0.0 };
    let height = height.max(longest / LONGEST);
    let (level, fraction) = level((height / TARGET) as f32, r.last_level());
    blended(r, level, fraction, query, TRUSTED)
}

/// `log2(ratio)`, cut to the levels, as a whole number and the rest; 0 for a rest below the band, which is most and needs no
/// logarithm.
#[inline(always)]
fn level(ratio: f32, last: usize) -> (usize, f32) {
    if ratio <= 1.0 {
        return (0, 0.0);
    }
    let bits = ratio.to_bits();
    let octave = (bits >> 23) as usize - 127;
    if octave >= last {
        return (last, 0.0);
    }
    let mantissa = f32::from_bits(bits & 0x007f_ffff | 1f32.to_bits());
    // A little below 2^(1 - BAND).
    (octave, if mantissa < 1.68 { 0.0 } else { log2(mantissa) })
}

/// The mean over the footprint on a level, towards the coarser end blended with the next; on level 0 by soft weights as far
/// as their estimated error, a share of the contrast, is less than `trusted`.
#[inline(always)]
pub(super) fn blended<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    fraction: f32,
    query: &Query,
    trusted: f64,
) -> [T::Real; 4] {
    let fine = on_level(r, level, query, trusted);
    let share = (fraction - (1.0 - BAND)) / BAND;
    if share <= 0.0 {
        return fine;
    }
    lerp4(fine, on_level(r, level + 1, query, trusted), T::Real::from_f64(f64::from(share)))
}

/// The mean over the footprint on one level.
#[inline(always)]
fn on_level<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    query: &Query,
    trusted: f64,
) -> [T::Real; 4] {
    let place = placed(r, level, query);
    let [[a, b], [c, d]] = place.jacobian.m;
    let lengths = [(a * a + c * c).sqrt(), (b * b + d * d).sqrt()];
    let area = place.jacobian.det().abs();
    let longest = lengths[0].max(lengths[1]);
    let height = area / longest;
    // How much of the soft weights to use: none on the coarsest level, whose footprints have no bounds.
    let trust = if level == r.last_level() || height.is_nan() {
        0.0
    } else if level == 0 {
        let cosine = (a * b + c * d) / (lengths[0] * lengths[1]);
        (2.0 - error(longest, height, cosine) / trusted).min(height / NARROW - 1.0)
    } else {
        2.0 * (height - 1.0)
    };
    let trust = trust.clamp(0.0, 1.0);
    if trust == 0.0 {
        return hard(r, level, &place, height, query);
    }
    let softness = if level == 0 { 1.0 } else { COARSE };
    let soft = soft(r, level, &place, Soft::new([[a, c], [b, d]], lengths, area, softness));
    if trust == 1.0 {
        return soft;
    }
    lerp4(hard(r, level, &place, height, query), soft, T::Real::from_f64(trust))
}

/// The error of soft weights on level 0, as a share of the contrast of white noise (its standard deviation), for sides
/// of which the longer has `longest` texels, with this height above it and this cosine between them:
///
/// ```text
/// .04/((1 + 4 h^2) sqrt(l)) + (.012 + .12 rho^2)/(h l)
/// ```
///
/// The first term is for strips narrower than the tent, whose profile depends on the direction; the second is for corners.
/// Fitted to differences from exact weights, at random places and angles, for heights from 0.1 to 8 texels, sides up to 30
/// and cosines up to .8: of errors above .001 it is at most a tenth below any, and up to four times above.
fn error(longest: f64, height: f64, cosine: f64) -> f64 {
    let narrow = 0.04 / ((1.0 + 4.0 * height * height) * longest.sqrt());
    narrow + (0.012 + 0.12 * cosine * cosine) / (height * longest)
}

/// The mean by weights that are exact, or nearly so.
fn hard<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    place: &Placed,
    height: f64,
    query: &Query,
) -> [T::Real; 4] {
    let [[a, b], [c, d]] = place.jacobian.m;
    let extent = [0.5 * (a.abs() + b.abs()) + 1.0, 0.5 * (c.abs() + d.abs()) + 1.0];
    if T::DTYPE == DType::F64
        || height.is_nan()
        || height < THIN
        || 2.0 * extent[0].max(extent[1]) > (window::LONGEST - 4) as f64
    {
        return mean_on_level(r, level, query);
    }
    let centre = [place.near(0, extent[0]), place.near(1, extent[1])];
    let slabs = Slabs::parallelogram(lifted(place.jacobian)).parts;
    let footprint = Spans { centre, slabs: &slabs };
    rows_mean(r, level, centre, |texels| window::spans(r.isa, &footprint, texels))
}

/// The mean by soft weights.
#[inline(always)]
fn soft<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    place: &Placed,
    footprint: Soft,
) -> [T::Real; 4] {
    let [x, y] = footprint.extent;
    let centre = [place.near(0, x), place.near(1, y)];
    let footprint = Soft { centre, ..footprint };
    if T::DTYPE == DType::F64 {
        return soft_in_doubles(r, level, &footprint);
    }
    if let Some((plane, outside)) = r.bytes(level)
        && soft_codes::fits(&footprint, &plane)
    {
        let rest = Wrapped { plane: &plane, wrap: r.layers.wrap, outside };
        return soft_codes::soft(r.isa, &footprint, &plane, &rest).map(T::Real::from_f64);
    }
    rows_mean(r, level, centre, |texels| window::soft(r.isa, &footprint, texels))
}

/// [`window::soft`] for textures whose results are doubles.
fn soft_in_doubles<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    footprint: &Soft,
) -> [T::Real; 4] {
    let ([cx, cy], height) = (footprint.centre, footprint.extent[1]);
    let mut sum = Sum::new(r, level, footprint.centre);
    let mut weights = Vec::new();
    let rows = footprint.rows();
    for row in ceil(cy - height)..=floor(cy + height) {
        let dy = row as f64 - cy;
        let [left, right] = rows.at(dy);
        let first = ceil(cx + left);
        weights.clear();
        weights.extend((first..=floor(cx + right)).map(|x| footprint.weight([x as f64 - cx, dy])));
        if !weights.is_empty() {
            sum.row(r, level, &Weights { row, first, weights: &weights, middle: 0..0 });
        }
    }
    sum.mean()
}
