//! Exact: the mean of the bilinear reconstruction of level 0 over the footprint.
//!
//! The weights come from [`super::rows`]: closed integrals, exact to rounding for parallelograms of any shape
//! down to lines and points, on every wrap mode. Sums are f64 differences from one of the texels, so a constant
//! texture gives its constant.
//!
//! Cost: about as many operations as the footprint has texels plus those that its outline crosses; along an axis
//! that does not repeat, what lies outside the picture costs nothing. Along one that does, a footprint longer
//! than 32 768 texels is read as one of that length.
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

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The filter at one place.
pub(crate) fn exact<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, query: &Query) -> [T::Real; 4] {
    if !query.jacobian_tx.is_finite() {
        return bilinear(r, r.last_level(), query.s, query.t);
    }
    mean_on_level(r, 0, query)
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
