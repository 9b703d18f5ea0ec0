//! From output pixels to input pixels, with derivatives.

use super::query_at;
use super::remap::Map;
use crate::error::{Error, Result};
use crate::filter::Query;
use crate::footprint::Bend;
use crate::jacobian::Jacobian;

/// Where each output pixel lies in the input; pixel centres at whole numbers.
#[derive(Clone, Copy, Debug)]
pub enum Mapping<'a> {
    /// `(x, y) = A (X, Y, 1)`.
    Affine([[f64; 3]; 2]),
    /// `(x w, y w, w) = H (X, Y, 1)`; places with w = 0 are not finite.
    Projective([[f64; 3]; 3]),
    /// One place for each output pixel, in single precision.
    Single(Maps<'a, f32>),
    /// One place for each output pixel, in double precision.
    Double(Maps<'a, f64>),
}

/// The x and y of every output pixel, row by row: element `i * step` of each slice.
#[derive(Clone, Copy, Debug)]
pub struct Maps<'a, U> {
    /// Input columns.
    pub x: &'a [U],
    /// Input rows.
    pub y: &'a [U],
    /// 1 for two arrays, 2 for one of pairs.
    pub step: usize,
    /// Length after which the map's x and y begin anew, if they do: across such a jump the derivative goes on.
    pub period: [Option<f64>; 2],
}

impl<'a, U> Maps<'a, U> {
    /// Maps from interleaved pairs.
    pub fn pairs(xy: &'a [U], period: [Option<f64>; 2]) -> Self {
        Self { x: xy, y: xy.get(1..).unwrap_or(&[]), step: 2, period }
    }
}

/// Derivative along one axis from the places before, at and after a pixel; NaN stands for "none".
///
/// The mean of both differences, or the one that there is. Where one is over twice the other plus one
/// pixel, the map jumps between these two pixels (a cut, a fold, the edge of a face), and the smaller of them
/// is the derivative on this pixel's side. Differences of nearly whole periods are taken modulo the period.
#[inline(always)]
pub(super) fn difference(before: f64, here: f64, after: f64, period: Option<f64>) -> f64 {
    let (back, forward) = (shortest(here - before, period), shortest(after - here, period));
    let (long_back, long_forward) =
        (back.abs() > 2.0 * forward.abs() + 1.0, forward.abs() > 2.0 * back.abs() + 1.0);
    let longer = if long_forward { back } else { 0.5 * (back + forward) };
    let both = if long_back { forward } else { longer };
    let other = if forward.is_finite() { forward } else { 0.0 };
    let one = if back.is_finite() { back } else { other };
    // Choices between numbers at hand, and no branches: so a loop over it becomes lanes.
    if back.is_finite() & forward.is_finite() { both } else { one }
}

/// Place, Jacobian, and relative slope of the denominator, by the quotient rule: `d(X/w) = (dX - (X/w) dw)/w`.
#[inline(always)]
pub(super) fn perspective(
    [[a, b, c], [d, e, f], [g, h, i]]: &[[f64; 3]; 3],
    x: f64,
    y: f64,
) -> ([f64; 2], [[f64; 2]; 2], [f64; 2]) {
    let w = 1.0 / (g * x + h * y + i);
    let (px, py) = ((a * x + b * y + c) * w, (d * x + e * y + f) * w);
    let jacobian = [[(a - px * g) * w, (b - px * h) * w], [(d - py * g) * w, (e - py * h) * w]];
    ([px, py], jacobian, [g * w, h * w])
}

/// A difference without whole periods.
#[inline(always)]
fn shortest(d: f64, period: Option<f64>) -> f64 {
    match period {
        Some(p) if d.is_finite() => d - p * (d / p).round(),
        _ => d,
    }
}

/// Second derivatives by xx, xy and yy from the steps to the neighbours and the mixed difference; `None` where these jump.
#[inline(always)]
fn bend(x: [f64; 2], y: [f64; 2], xy: f64) -> Option<[f64; 3]> {
    let jumps = |[back, forward]: [f64; 2]| {
        let (back, forward) = (back.abs(), forward.abs());
        back.max(forward) > 2.0 * back.min(forward) + 1.0
    };
    let h = [x[0] + x[1], xy, y[0] + y[1]];
    let small = xy.abs() <= 1.0 + x[0].abs() + x[1].abs() + y[0].abs() + y[1].abs();
    (h.iter().all(|h| h.is_finite()) && small && !jumps(x) && !jumps(y)).then_some(h)
}

impl<U: Copy + Into<f64>> Maps<'_, U> {
    fn at(&self, values: &[U], i: usize) -> f64 {
        values[i * self.step].into()
    }

    /// The place of a pixel; with its `shape`, or without.
    fn query(&self, [column, row]: [usize; 2], [width, height]: [usize; 2], shape: bool) -> Query {
        let i = row * width + column;
        let axis = |values: &[U], period| {
            let here = self.at(values, i);
            let inner = shape && column > 0 && column + 1 < width && row > 0 && row + 1 < height;
            let at = |exists: bool, i: usize| if exists { self.at(values, i) } else { f64::NAN };
            let left = at(column > 0, i.wrapping_sub(1));
            let right = at(column + 1 < width, i + 1);
            let above = at(row > 0, i.wrapping_sub(width));
            let below = at(row + 1 < height, i + width);
            let slopes = [difference(left, here, right, period), difference(above, here, below, period)];
            let bend = if inner {
                let near = |i: usize| here + shortest(self.at(values, i) - here, period);
                let (left, right, above, below) =
                    (near(i - 1), near(i + 1), near(i - width), near(i + width));
                let across = |d: usize| near(i - width - d) + near(i + width + d);
                let xy = 0.25 * ((across(1) - near(i - width + 1)) - near(i + width - 1));
                bend([left - here, right - here], [above - here, below - here], xy)
            } else {
                None
            };
            (here, slopes, bend)
        };
        let (x, dx, bend_x) = axis(self.x, self.period[0]);
        let (y, dy, bend_y) = axis(self.y, self.period[1]);
        let bend = match (bend_x, bend_y) {
            (Some(x), Some(y)) => Bend::Curved([x, y]),
            // Not asked for, at an edge of the map, or beside a jump.
            _ => Bend::None,
        };
        query_at(x, y, Jacobian::new([dx, dy]), bend)
    }

    fn check(&self, width: usize, height: usize) -> Result<()> {
        let pixels = width * height;
        let fits = match self.step {
            1 => self.x.len() == pixels && self.y.len() == pixels,
            2 => self.x.len() == 2 * pixels && self.y.len() + 1 == 2 * pixels,
            _ => false,
        };
        if fits {
            return Ok(());
        }
        let got = format!("{} and {} numbers, {} apart", self.x.len(), self.y.len(), self.step);
        Err(Error::value(
            "map",
            got,
            format!("one place, 1 or 2 numbers apart, for each of {width}x{height} pixels"),
        ))
    }
}

impl Mapping<'_> {
    /// The map of a 3x3 matrix: affine where its last row is (0, 0, c).
    pub fn from_matrix(h: [[f64; 3]; 3]) -> Self {
        let [[a, b, c], [d, e, f], [g, i, w]] = h;
        let affine = [[a / w, b / w, c / w], [d / w, e / w, f / w]];
        // Where the division overflows, places are not finite, which the other form can tell.
        let finite = w.is_finite() && affine.iter().flatten().all(|x| x.is_finite());
        if g == 0.0 && i == 0.0 && finite { Self::Affine(affine) } else { Self::Projective(h) }
    }

    /// Checks that there is a place for each pixel and that matrices are finite.
    pub(super) fn check(&self, width: usize, height: usize) -> Result<()> {
        let finite = |rows: &[[f64; 3]]| {
            if rows.iter().flatten().all(|v| v.is_finite()) {
                Ok(())
            } else {
                Err(Error::value("mapping", format!("{rows:?}"), "finite numbers"))
            }
        };
        match self {
            Self::Affine(rows) => finite(rows),
            Self::Projective(rows) => finite(rows),
            Self::Single(maps) => maps.check(width, height),
            Self::Double(maps) => maps.check(width, height),
        }
    }

    /// Place and footprint of one output pixel; maps tell the `shape` only where it is asked for.
    #[inline(always)]
    pub(crate) fn query(&self, at: [usize; 2], size: [usize; 2], shape: bool) -> Query {
        let [x, y] = at.map(|k| k as f64);
        match self {
            Self::Affine([[a, b, c], [d, e, f]]) => {
                let jacobian = Jacobian::new([[*a, *b], [*d, *e]]);
                query_at(a * x + b * y + c, d * x + e * y + f, jacobian, Bend::None)
            }
            Self::Projective(rows) => {
                let ([px, py], jacobian, bend) = perspective(rows, x, y);
                query_at(px, py, Jacobian::new(jacobian), Bend::Perspective(bend))
            }
            Self::Single(maps) => maps.query(at, size, shape),
            Self::Double(maps) => maps.query(at, size, shape),
        }
    }

    /// The matrix, row by row; the identity for maps.
    pub(super) fn matrix(&self) -> [f64; 9] {
        match self {
            Self::Affine([[a, b, c], [d, e, f]]) => [*a, *b, *c, *d, *e, *f, 0.0, 0.0, 1.0],
            Self::Projective([[a, b, c], [d, e, f], [g, h, i]]) => [*a, *b, *c, *d, *e, *f, *g, *h, *i],
            Self::Single(_) | Self::Double(_) => [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        }
    }

    /// The same places without footprints; `matrix` is that of [`Mapping::matrix`].
    pub(super) fn plain<'m>(&'m self, matrix: &'m [f64; 9]) -> Map<'m> {
        match self {
            Self::Affine(_) | Self::Projective(_) => Map::Matrix(matrix),
            Self::Single(maps) if maps.step == 2 => Map::SinglePairs(maps.x),
            Self::Single(maps) => Map::Single(maps.x, maps.y),
            Self::Double(maps) if maps.step == 2 => Map::DoublePairs(maps.x),
            Self::Double(maps) => Map::Double(maps.x, maps.y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perspective_derivatives_are_those_of_the_quotient() {
        let map = Mapping::Projective([[2.0, 0.3, 5.0], [-0.2, 1.5, 3.0], [0.01, 0.02, 1.0]]);
        let place = |x: f64, y: f64| {
            let w = 0.01 * x + 0.02 * y + 1.0;
            [(2.0 * x + 0.3 * y + 5.0) / w, (-0.2 * x + 1.5 * y + 3.0) / w]
        };
        for (x, y) in [(0usize, 0usize), (7, 3), (40, 90)] {
            let (fx, fy, e) = (x as f64, y as f64, 1e-4);
            let got = map.query([x, y], [100, 100], false);
            assert!((got.s - 0.5 - place(fx, fy)[0]).abs() < 1e-12);
            for i in 0..2 {
                let dx = (place(fx + e, fy)[i] - place(fx - e, fy)[i]) / (2.0 * e);
                let dy = (place(fx, fy + e)[i] - place(fx, fy - e)[i]) / (2.0 * e);
                assert!(
                    (got.jacobian_tx.m[i][0] - dx).abs() < 1e-7
                        && (got.jacobian_tx.m[i][1] - dy).abs() < 1e-7
                );
            }
        }
    }

    #[test]
    fn differences_ignore_cuts_and_periods() {
        assert_eq!(difference(1.0, 2.0, 3.5, None), 1.25);
        assert_eq!(difference(f64::NAN, 2.0, 3.5, None), 1.5);
        assert_eq!(difference(f64::NAN, 2.0, f64::INFINITY, None), 0.0);
        assert_eq!(difference(98.0, 99.0, 0.0, Some(100.0)), 1.0);
        assert_eq!(difference(98.0, 99.0, 700.0, None), 1.0);
    }
}
