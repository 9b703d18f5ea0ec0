//! Auto: the cheapest answer that is good enough, chosen pixel by pixel.
//!
//! Up to a texel a pixel nothing is lost between pixels, and the bilinear value at the centre is what interpolating peers
//! show: a map that only moves or enlarges leaves texels as they are. From [`FULL`] on it is the mean over the footprint,
//! by whatever is predicted ([`predict`]) to be wrong by less than [`predict::TARGET`] of full scale: one trilinear
//! look-up where the texture is flat or smooth, else the soft parallelogram of [`super::area`] on the coarsest level
//! that will do, else exact weights. Between any two of them one fades into the other, so nothing jumps.
//!
//! With a tolerance the error is bounded instead of predicted: [`within`].

mod cells;
mod fold;
mod polygon;
mod predict;
mod shape;
mod within;

use super::effort::{self, Effort};
use super::{Filter, Query, Reader, area, bilinear, blended, exact, lerp4, mipmap};
use crate::lod;
use crate::num::Real;
use crate::texel::Texel;
use crate::texture::Decode;
use predict::Choice;
pub(crate) use shape::{Shape, Shapes};
use within::Found;

/// Length of the footprint's major axis, in texels, from which the mean alone is shown.
const FULL: f64 = 1.25;

/// The share of the mean where the footprint's major axis has `sigma1` texels; the rest is interpolation.
pub fn mean_share(sigma1: f64) -> f64 {
    // NaN: the mean alone.
    let x = if sigma1 < FULL { (sigma1 - 1.0) / (FULL - 1.0) } else { 1.0 };
    let x = x.max(0.0);
    x * x * (3.0 - 2.0 * x)
}

/// The filter at one place, for a footprint of this shape; `ease` times the usual error will do.
#[inline(never)]
pub(crate) fn auto<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    shape: &Shape,
    ease: f64,
) -> [T::Real; 4] {
    let sigma1 = shape.sigma1;
    if sigma1 <= 1.0 {
        return bilinear(r, 0, query.s, query.t);
    }
    let mean = mean(r, query, shape, ease);
    let share = mean_share(sigma1);
    if share == 1.0 {
        return mean;
    }
    lerp4(bilinear(r, 0, query.s, query.t), mean, T::Real::from_f64(share))
}

/// Whether one look-up will do for all of a pixel, whatever its shape.
#[inline(never)]
pub(crate) fn is_smooth<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> bool {
    predict::choose(r, query, &Shape::new(query.jacobian_tx), 1.0).is_some_and(|choice| choice.share == 0.0)
}

/// The mean over the footprint, about as exact as was decided.
#[inline(always)]
fn mean<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    shape: &Shape,
    ease: f64,
) -> [T::Real; 4] {
    let Some(choice) = predict::choose(r, query, shape, ease) else {
        return area(r, query);
    };
    let Choice { smooth, share, level, trusted } = choice;
    if share == 0.0 {
        return mipmap(r, Filter::Trilinear, query.s, query.t, smooth);
    }
    let (whole, fraction) = lod::split(level);
    let detailed = blended(r, whole, fraction, query, trusted);
    if share == 1.0 {
        return detailed;
    }
    let smooth = mipmap(r, Filter::Trilinear, query.s, query.t, smooth);
    lerp4(smooth, detailed, T::Real::from_f64(f64::from(share)))
}

/// The mean over the footprint, wrong by `tolerance` at most, in units of the result.
///
/// A result with straight alpha is a quotient `p/a`. If numerator and denominator are wrong by `e` at most, it is wrong
/// by `e (1 + |p/a|)/(a - e)` at most: where that is too much, they are asked for again, within less.
#[inline(never)]
pub(crate) fn auto_within<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    tolerance: f64,
) -> [T::Real; 4] {
    found_within(r, query, tolerance).average
}

fn found_within<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    tolerance: f64,
) -> Found<T::Real> {
    let exactly = |reads: f64| {
        let reads = reads + effort::under(query, 0.0);
        Found { average: exact(r, query), reads, lod: 0.0 }
    };
    let Some(bounds) = r.layers.bounds else {
        return exactly(0.0);
    };
    let unit = r.decode.outside([1.0; 4])[0].to_f64();
    let mut least = tolerance * unit;
    let mut reads = 0.0;
    for _ in 0..3 {
        let found = within::within(r, bounds, query, least);
        let average = found.average;
        reads += found.reads;
        let found = Found { reads, ..found };
        let Some(alpha) = r.decode.divisor(average) else {
            return found;
        };
        let alpha = alpha.to_f64();
        let largest = r.finish(average).into_iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        let needed = tolerance * alpha / (1.0 + largest + tolerance);
        if least <= needed {
            return found;
        }
        least = 0.5 * needed;
    }
    exactly(reads)
}

/// What [`auto_within`] spends.
pub(super) fn effort_within<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    query: &Query,
    tolerance: f64,
) -> Effort {
    let found = found_within(r, query, tolerance);
    Effort::new(found.reads, found.lod as f32)
}

/// What [`auto`] spends: the texels, not the entries of the table by which it decides.
pub(super) fn effort<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query, ease: f64) -> Effort {
    let shape = Shape::new(query.jacobian_tx);
    if shape.sigma1 <= 1.0 {
        return Effort::new(4.0, 0.0);
    }
    let point = if shape.sigma1 < FULL { 4.0 } else { 0.0 };
    let Some(Choice { smooth, share, level, .. }) = predict::choose(r, query, &shape, ease) else {
        return Effort::new(4.0, r.last_level() as f32);
    };
    let levels = if lod::split(smooth).1 > 0.0 { 2.0 } else { 1.0 };
    let look_up = if share < 1.0 { 4.0 * levels } else { 0.0 };
    let texels = if share > 0.0 { effort::under(query, level.floor()) } else { 0.0 };
    Effort::new(point + look_up + texels, smooth + share * (level - smooth))
}
