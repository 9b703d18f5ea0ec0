//! Exact: the mean of the bilinear reconstruction of level 0 over the footprint.
//!
//! The weights come from [`super::rows`]: closed integrals, exact to rounding for parallelograms of any shape
//! down to lines and points, on every wrap mode. Sums are f64 differences from one of the texels, so a constant
//! texture gives its constant.
//!
//! Cost: about as many operations as the footprint has texels plus those that its outline crosses; along an axis
//! that does not repeat, what lies outside the picture costs nothing. A footprint whose bounding box holds more
//! than [`MOST`] texels is read on the first level where it holds fewer: its inside is as exact, and what its
//! rim gets wrong is a few thousandths of the contrast at most.
//!
//! Source: the footprint as a parallelogram: A. Schilling, G. Knittel, W. Strasser, "Texram: a smart memory for
//! texturing", IEEE CG&A 1996; exact box filtering by integrals along the outline: E. Catmull, "A hidden-surface
//! algorithm with anti-aliasing", SIGGRAPH 1978.

use super::rows::{Scratch, Slabs, lifted, walk};
use super::sum::{Placed, Sum, placed};
use super::{Query, Reader, bilinear};
use crate::texel::Texel;
use crate::texture::Decode;
use std::cell::RefCell;

/// Below this extent, in texels, a footprint is a point.
const POINT: f64 = 1e-9;

/// Texels of a level that one footprint may touch.
const MOST: f64 = 1_048_576.0;

/// Periods that one footprint may touch.
const PERIODS: f64 = 1024.0;

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The filter at one place.
#[inline(never)]
pub(crate) fn exact<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    if !query.jacobian_tx.is_finite() {
        return bilinear(r, r.last_level(), query.s, query.t);
    }
    let query = &cut(r, query);
    mean_on_level(r, bounded_level(r, query), query)
}

/// The footprint with no more than [`PERIODS`] along an axis that repeats: the mean of more of them differs by a
/// thousandth of the contrast at most, and their number has no end.
fn cut<T: Texel, D>(r: &Reader<'_, T, D>, query: &Query) -> Query {
    let base = &r.layers.planes[0];
    let mut query = *query;
    for (axis, n) in [base.width, base.height].into_iter().enumerate() {
        if let Some(period) = r.layers.wrap[axis].period(n.into()) {
            let most = PERIODS * period;
            query.jacobian_tx.m[axis] = query.jacobian_tx.m[axis].map(|x| x.clamp(-most, most));
        }
    }
    query
}

/// The finest level on which the footprint's bounding box, as far as there are texels, holds at most [`MOST`].
fn bounded_level<T: Texel, D>(r: &Reader<'_, T, D>, query: &Query) -> usize {
    let base = &r.layers.planes[0];
    let extent = |axis: usize, n: i32| {
        let [dx, dy] = query.jacobian_tx.m[axis].map(f64::abs);
        let endless = r.layers.wrap[axis].period(n.into()).is_some();
        if endless { dx + dy } else { (dx + dy).min(3.0 * f64::from(n)) }
    };
    let texels = (extent(0, base.width) + 1.0) * (extent(1, base.height) + 1.0);
    let too_many = (texels / MOST).log2() / 2.0;
    // An infinite product of finite extents gives the coarsest level.
    if too_many <= 0.0 { 0 } else { (too_many.ceil() as usize).min(r.layers.planes.len() - 1) }
}

/// The mean of the bilinear reconstruction of one level over the footprint, which is finite.
pub(super) fn mean_on_level<T: Texel, D: Decode<T>>(
    r: &Reader<'_, T, D>,
    level: usize,
    query: &Query,
) -> [T::Real; 4] {
    let Placed { centre, jacobian, bounds } = placed(r, level, query);
    if jacobian.m.iter().flatten().all(|x| x.abs() < POINT) {
        return bilinear(r, level, query.s, query.t);
    }
    let mut sum = Sum::new(r, level, centre);
    let slabs = Slabs::parallelogram(lifted(jacobian));
    SCRATCH.with_borrow_mut(|scratch| {
        walk(centre, &slabs, bounds, scratch, |row| sum.row(r, level, &row));
    });
    sum.mean()
}
