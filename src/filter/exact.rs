//! Exact: the mean of the bilinear reconstruction of level 0 over the footprint.
//!
//! The weights come from [`super::rows`]: closed integrals, exact to rounding for parallelograms of any shape
//! down to lines and points, on every wrap mode. Sums are f64 differences from one of the texels, so a constant
//! texture gives its constant.
//!
//! Cost: about as many operations as the footprint has texels plus those that its outline crosses; along an axis
//! that does not repeat, what lies outside the picture costs nothing. Along one that does, a footprint longer
//! than [`LONGEST`] texels is read as one of that length.
//!
//! Source: the footprint as a parallelogram: A. Schilling, G. Knittel, W. Strasser, "Texram: a smart memory for
//! texturing", IEEE CG&A 1996; exact box filtering by integrals along the outline: E. Catmull, "A hidden-surface
//! algorithm with anti-aliasing", SIGGRAPH 1978.

use super::rows::{Bounds, Scratch, Slabs, Weights, lifted, walk};
use super::{Query, Reader, bilinear};
use crate::num::{Real, floor};
use crate::texel::Texel;
use crate::texture::Decode;
use crate::wrap::Wrap;
use std::cell::RefCell;

/// Longest extent, in texels, of a footprint along an axis that repeats itself.
const LONGEST: f64 = 32_768.0;
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
    let [kx, ky] = r.scale[level];
    let mut jacobian = query.jacobian_tx.scaled(kx, ky);
    if jacobian.m.iter().flatten().all(|x| x.abs() < POINT) {
        return bilinear(r, level, query.s, query.t);
    }
    let (base, plane) = (&r.layers.planes[0], &r.layers.planes[level]);
    let axis = |axis: usize, place: f64, row: &mut [f64; 2]| {
        let (full, n) = if axis == 0 { (base.width, plane.width) } else { (base.height, plane.height) };
        let (wrap, scale) = (r.layers.wrap[axis], r.scale[level][axis]);
        let Some(period) = wrap.period(full.into()) else {
            return (place * scale - 0.5, bounds(wrap, n.into()));
        };
        let extent = row[0].abs() + row[1].abs();
        if extent > LONGEST {
            *row = row.map(|x| x * (LONGEST / extent));
        }
        // Whole periods away the picture is the same.
        let endless = Bounds { first: f64::NEG_INFINITY, last: f64::INFINITY };
        (place.rem_euclid(period) * scale - 0.5, endless)
    };
    let [row_x, row_y] = &mut jacobian.m;
    let (x, x_bounds) = axis(0, query.s, row_x);
    let (y, y_bounds) = axis(1, query.t, row_y);
    let origin = (floor(x.clamp(-1e9, 1e9) + 0.5) as i32, floor(y.clamp(-1e9, 1e9) + 0.5) as i32);
    let reference = r.tap(level, origin.0, origin.1).map(|v| {
        let v = v.to_f64();
        if v.is_finite() { v } else { 0.0 }
    });
    let mut sum = Sum { reference, total: [0.0; 4], weight: 0.0 };
    let slabs = Slabs::parallelogram(lifted(jacobian));
    SCRATCH.with_borrow_mut(|scratch| {
        walk([x, y], &slabs, [x_bounds, y_bounds], scratch, |row| sum.row(r, level, &row));
    });
    sum.mean().map(T::Real::from_f64)
}

/// Texels beyond which an axis that does not repeat itself shows one colour.
fn bounds(wrap: Wrap, n: f64) -> Bounds {
    let (first, last) = match wrap {
        Wrap::Border | Wrap::Extend => (-1.0, n),
        Wrap::MirrorOnce => (-n, n - 1.0),
        _ => (0.0, n - 1.0),
    };
    Bounds { first, last }
}

/// A weighted sum of texels, less a reference: exactly that where all texels are equal.
struct Sum {
    reference: [f64; 4],
    total: [f64; 4],
    weight: f64,
}

impl Sum {
    #[inline]
    fn add(&mut self, weight: f64, texel: [impl Real; 4]) {
        self.weight += weight;
        for ((total, value), reference) in self.total.iter_mut().zip(texel).zip(self.reference) {
            *total += weight * (value.to_f64() - reference);
        }
    }

    fn row<T: Texel, D: Decode<T>>(&mut self, r: &Reader<'_, T, D>, level: usize, row: &Weights<'_>) {
        let plane = &r.layers.planes[level];
        let wrap = r.layers.wrap[1];
        let y = match i32::try_from(row.row) {
            Ok(y) if y >= plane.rows.0 && y <= plane.rows.1 => Some(row.row),
            _ => wrap.index(row.row, plane.height.into()),
        };
        let Some(y) = y.map(|y| y as i32) else {
            let weight = row.weights.iter().sum();
            return self.add(weight, r.outside());
        };
        let (left, right) = (row.middle.start, row.middle.end);
        let period = r.layers.wrap[0].period(plane.width.into()).map_or(usize::MAX, |p| p as usize);
        if right.saturating_sub(left) <= period {
            return self.texels(r, level, y, row.first, row.weights);
        }
        // Whole periods of one weight: a period, that many times.
        let whole = (right - left) / period;
        let weight = row.weights[left];
        let rest = left + whole * period;
        self.texels(r, level, y, row.first, &row.weights[..left]);
        let mut once = Self { total: [0.0; 4], weight: 0.0, ..*self };
        for x in row.first + left as i64..row.first + (left + period) as i64 {
            once.add(1.0, r.tap(level, x as i32, y));
        }
        let times = weight * whole as f64;
        self.weight += times * once.weight;
        for (total, once) in self.total.iter_mut().zip(once.total) {
            *total += times * once;
        }
        self.texels(r, level, y, row.first + rest as i64, &row.weights[rest..]);
    }

    /// Texels of row `y` from `first` on, each with its weight.
    fn texels<T: Texel, D: Decode<T>>(
        &mut self,
        r: &Reader<'_, T, D>,
        level: usize,
        y: i32,
        first: i64,
        weights: &[f64],
    ) {
        let plane = &r.layers.planes[level];
        let last = first + weights.len() as i64 - 1;
        let inside = first >= plane.columns.0.into() && last <= plane.columns.1.into();
        if inside && y >= plane.rows.0 && y <= plane.rows.1 {
            for (x, weight) in (first as i32..).zip(weights) {
                if *weight != 0.0 {
                    self.add(*weight, r.decode.texel(plane.texel(x, y)));
                }
            }
        } else {
            for (x, weight) in (first..).zip(weights) {
                if *weight != 0.0 {
                    self.add(*weight, r.tap(level, x as i32, y));
                }
            }
        }
    }

    fn mean(&self) -> [f64; 4] {
        std::array::from_fn(|lane| self.reference[lane] + self.total[lane] / self.weight)
    }
}
