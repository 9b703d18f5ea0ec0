//! What the area filters share: where a footprint stands among the texels of a level, and weighted sums of rows.

use super::rows::{Bounds, Weights};
use super::{Query, Reader};
use crate::jacobian::Jacobian;
use crate::kernel::lanes::Lanes;
use crate::kernel::plane::Plane;
use crate::kernel::soft_codes::{READ, Texels};
use crate::kernel::window::{CHUNK, Source};
use crate::num::{Real, floor};
use crate::texel::{DType, Texel};
use crate::texture::Decode;
use crate::wrap::{Wrap, modulo};

/// Longest extent, in texels, of a footprint along an axis that repeats itself.
const LONGEST: f64 = 32_768.0;

/// A footprint on a level, the centre of texel (0, 0) at 0.
pub(super) struct Placed {
    pub centre: [f64; 2],
    pub jacobian: Jacobian,
    pub bounds: [Bounds; 2],
}

/// Brings a finite footprint to a level, near the origin by whole periods: the picture there is the same.
#[inline(always)]
pub(super) fn placed<T: Texel, D>(r: &Reader<'_, T, D>, level: usize, query: &Query) -> Placed {
    let (base, plane) = (&r.layers.planes[0], &r.layers.planes[level]);
    let [kx, ky] = r.scale[level];
    let mut jacobian = query.jacobian_tx.scaled(kx, ky);
    let [row_x, row_y] = &mut jacobian.m;
    let [wu, wv] = r.layers.wrap;
    let (x, x_bounds) = placed_along(wu, [base.width, plane.width], kx, query.s, row_x);
    let (y, y_bounds) = placed_along(wv, [base.height, plane.height], ky, query.t, row_y);
    Placed { centre: [x, y], jacobian, bounds: [x_bounds, y_bounds] }
}

/// One axis of [`placed`]: texels of level 0 and of the level are `full` and `n`.
#[inline(always)]
fn placed_along(
    wrap: Wrap,
    [full, n]: [i32; 2],
    scale: f64,
    place: f64,
    row: &mut [f64; 2],
) -> (f64, Bounds) {
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
    let place = if place >= 0.0 && place < period { place } else { modulo(place, period) };
    (place * scale - 0.5, endless)
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

/// Calls `mean` with the texels around a place, less a reference; adds that to the result.
#[inline(always)]
pub(super) fn rows_mean<'r, 'l, T: Texel, D: Decode<T>>(
    r: &'r Reader<'l, T, D>,
    level: usize,
    centre: [f64; 2],
    mean: impl FnOnce(Around<'r, 'l, T, D>) -> [f32; 4],
) -> [T::Real; 4] {
    let reference = reference(r, level, centre);
    let difference = mean(Around { r, level, reference: reference.map(|x| x.to_f64() as f32) });
    std::array::from_fn(|c| reference[c] + T::Real::from_f64(f64::from(difference[c])))
}

/// The texels of a level, less a reference.
pub(super) struct Around<'r, 'l, T: Texel, D> {
    r: &'r Reader<'l, T, D>,
    level: usize,
    reference: [f32; 4],
}

impl<T: Texel, D: Decode<T>> Source for Around<'_, '_, T, D> {
    const FLOAT: bool = matches!(T::DTYPE, DType::F16 | DType::F32 | DType::F64);

    #[inline(always)]
    fn chunk<L: Lanes>(&mut self, row: i64, first: i64) -> [L; 4] {
        let plane = &self.r.layers.planes[self.level];
        let [a, b, c, d] = self.reference;
        let reference = L::load(&[a, b, c, d, a, b, c, d]);
        let (x, y) = (first as i32, row as i32);
        if !plane.covers(x, y, x + CHUNK as i32 - 1, y) {
            let texels = self.across(x, y);
            let ([a, b, c, d], _) = texels.as_chunks::<8>() else { unreachable!() };
            return [L::load(a), L::load(b), L::load(c), L::load(d)];
        }
        let (at, step) = (plane.at(x, y), 2 * plane.lanes);
        let level = self.level;
        [
            self.r.pair::<L>(level, at).sub(reference),
            self.r.pair::<L>(level, at + step).sub(reference),
            self.r.pair::<L>(level, at + 2 * step).sub(reference),
            self.r.pair::<L>(level, at + 3 * step).sub(reference),
        ]
    }
}

impl<T: Texel, D: Decode<T>> Around<'_, '_, T, D> {
    /// A chunk that is not wholly in the picture or its apron.
    #[inline(never)]
    fn across(&self, x: i32, y: i32) -> [f32; 4 * CHUNK] {
        let plane = &self.r.layers.planes[self.level];
        let [wu, wv] = self.r.layers.wrap;
        let row = if (plane.rows.0..=plane.rows.1).contains(&y) {
            Some(y)
        } else {
            wv.index(y.into(), plane.height.into()).map(|y| y as i32)
        };
        let column = |x: i32| {
            if (plane.columns.0..=plane.columns.1).contains(&x) {
                Some(x)
            } else {
                wu.index(x.into(), plane.width.into()).map(|x| x as i32)
            }
        };
        let mut texels = [0.0; 4 * CHUNK];
        for (x, texel) in (x..).zip(texels.chunks_exact_mut(4)) {
            let values = match (column(x), row) {
                (Some(x), Some(y)) => self.r.decode.texel(plane.texel(x, y)),
                _ => self.r.outside(),
            };
            for ((slot, value), reference) in texel.iter_mut().zip(values).zip(self.reference) {
                *slot = value.to_f64() as f32 - reference;
            }
        }
        texels
    }
}

/// Bytes of a level by its wrap modes.
pub(super) struct Wrapped<'a> {
    pub plane: &'a Plane<'a, u8>,
    pub wrap: [Wrap; 2],
    pub outside: [u8; 4],
}

impl Texels for Wrapped<'_> {
    #[inline(never)]
    fn eight(&self, x: i32, y: i32, texels: &mut [u8; READ]) {
        let &Plane { data, lanes, channels, columns, rows, width, height, .. } = self.plane;
        let [wu, wv] = self.wrap;
        let along = |i: i32, (first, last): (i32, i32), wrap: Wrap, n: i32| {
            if i >= first && i <= last { Some(i) } else { wrap.index(i.into(), n.into()).map(|i| i as i32) }
        };
        let row = along(y, rows, wv, height);
        for (x, texel) in (x..).zip(texels.chunks_exact_mut(lanes)).take(8) {
            let code = match (along(x, columns, wu, width), row) {
                (Some(x), Some(y)) => &data[self.plane.at(x, y)..][..channels],
                _ => &self.outside[..channels],
            };
            texel[..channels].copy_from_slice(code);
        }
    }
}

/// The texel nearest to a place, zero where it is not finite.
#[inline(always)]
fn reference<T: Texel, D: Decode<T>>(r: &Reader<'_, T, D>, level: usize, centre: [f64; 2]) -> [T::Real; 4] {
    let [x, y] = centre.map(|c| floor(c.clamp(-1e9, 1e9) + 0.5) as i32);
    let plane = &r.layers.planes[level];
    if T::DTYPE.is_integer() && plane.is_readable(x, y) {
        return r.decode.texel(plane.texel(x, y));
    }
    r.tap(level, x, y).map(|v| if v.to_f64().is_finite() { v } else { T::Real::ZERO })
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
        let reference = reference(r, level, centre).map(Real::to_f64);
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
