//! What the area filters share: where a footprint stands among the texels of a level, and weighted sums of rows.

use super::rows::{Bounds, Weights};
use super::{Query, Reader};
use crate::jacobian::Jacobian;
use crate::num::{Real, floor};
use crate::texel::Texel;
use crate::texture::Decode;
use crate::wrap::Wrap;

/// Longest extent, in texels, of a footprint along an axis that repeats itself.
const LONGEST: f64 = 32_768.0;

/// A footprint on a level, the centre of texel (0, 0) at 0.
pub(super) struct Placed {
    pub centre: [f64; 2],
    pub jacobian: Jacobian,
    pub bounds: [Bounds; 2],
}

/// Brings a finite footprint to a level, near the origin by whole periods: the picture there is the same.
pub(super) fn placed<T: Texel, D>(r: &Reader<'_, T, D>, level: usize, query: &Query) -> Placed {
    let (base, plane) = (&r.layers.planes[0], &r.layers.planes[level]);
    let [kx, ky] = r.scale[level];
    let mut jacobian = query.jacobian_tx.scaled(kx, ky);
    let axis = |axis: usize, place: f64, row: &mut [f64; 2]| {
        let (full, n) = if axis == 0 { (base.width, plane.width) } else { (base.height, plane.height) };
        let (wrap, scale) = (r.layers.wrap[axis], r.scale[level][axis]);
        let Some(period) = wrap.period(full.into()) else {
            return (place * scale - 0.5, bounds(wrap, n.into()));
        };
        if n == 1 {
            // One texel without end.
            return (0.0, Bounds { first: 0.0, last: 0.0 });
        }
        let extent = row[0].abs() + row[1].abs();
        if extent > LONGEST {
            *row = row.map(|x| x * (LONGEST / extent));
        }
        let endless = Bounds { first: f64::NEG_INFINITY, last: f64::INFINITY };
        (place.rem_euclid(period) * scale - 0.5, endless)
    };
    let [row_x, row_y] = &mut jacobian.m;
    let (x, x_bounds) = axis(0, query.s, row_x);
    let (y, y_bounds) = axis(1, query.t, row_y);
    Placed { centre: [x, y], jacobian, bounds: [x_bounds, y_bounds] }
}

impl Placed {
    /// Moves a centre from where nothing but one colour lies within `reach` to the nearest such place.
    pub fn near(&self, axis: usize, reach: f64) -> f64 {
        let Bounds { first, last } = self.bounds[axis];
        self.centre[axis].clamp(first - reach - 2.0, last + reach + 2.0)
    }
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
pub(super) struct Sum {
    reference: [f64; 4],
    total: [f64; 4],
    weight: f64,
}

impl Sum {
    /// An empty sum; the reference is the texel nearest to `centre`.
    pub fn new<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, level: usize, centre: [f64; 2]) -> Self {
        let [x, y] = centre.map(|c| floor(c.clamp(-1e9, 1e9) + 0.5) as i32);
        let reference = r.tap(level, x, y).map(|v| {
            let v = v.to_f64();
            if v.is_finite() { v } else { 0.0 }
        });
        Self { reference, total: [0.0; 4], weight: 0.0 }
    }

    #[inline]
    fn add(&mut self, weight: f64, texel: [impl Real; 4]) {
        self.weight += weight;
        for ((total, value), reference) in self.total.iter_mut().zip(texel).zip(self.reference) {
            *total += weight * (value.to_f64() - reference);
        }
    }

    /// Adds a row of texels.
    pub fn row<T: Texel, D: Decode<T>>(&mut self, r: &Reader<'_, T, D>, level: usize, row: &Weights<'_>) {
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

    /// The sum divided by the weights.
    pub fn mean<R: Real>(&self) -> [R; 4] {
        std::array::from_fn(|lane| R::from_f64(self.reference[lane] + self.total[lane] / self.weight))
    }
}
