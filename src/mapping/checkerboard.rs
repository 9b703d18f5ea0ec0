//! The checkerboard that shows a mapping, as a point value and exactly filtered.
//!
//! White where ⌊cells·u⌋ + ⌊cells·v⌋ is even. With the square wave s(x) = (−1)^⌊x⌋ the value is ½ + ½ s(x) s(y),
//! so the mean over a parallelogram P is ½ + ½ M, M = (1/|P|) ∬ s(x) s(y), and by Green's theorem
//! ∬ s(x) s(y) dx dy = ∮ T(x) s(y) dy with T' = s. Between crossings of cell borders T is linear and s constant,
//! so the trapezoidal rule on each piece of the four sides is exact. Coordinates are taken from the footprint's
//! centre, and T from there, so that small footprints lose no digits.

use super::batch::{Numbers, Output, check_length, run};
use crate::error::{Error, Result};
use crate::jacobian::Jacobian;
use glam::DVec2;

/// A footprint that reaches over more cells than this, or without bound, is the grey mean.
const MOST_CELLS: f64 = 65536.0;
/// Footprints thinner than this share of their length are lines.
const THIN: f64 = 1e-10;

/// 1 on a white cell, 0 on a black one; NaN for a coordinate that is not finite.
pub fn point(uv: DVec2, cells: DVec2) -> f64 {
    let p = (uv * cells).floor();
    if !p.is_finite() {
        return f64::NAN;
    }
    if is_even(p.x) == is_even(p.y) { 1.0 } else { 0.0 }
}

/// The mean over the parallelogram that the Jacobian spans around uv: exact to about 1e-6 for slivers, better
/// else. A footprint that spans more than 65536 cells, or is infinite, is ½; NaN for a coordinate that is not finite.
///
/// ```
/// use glam::DVec2;
/// use multum::{Jacobian, mapping::checkerboard};
/// // A pixel of one cell, centred on the border of two cells of a row.
/// let j = Jacobian::new([[0.1, 0.0], [0.0, 0.1]]);
/// let grey = checkerboard::filtered(DVec2::new(0.3, 0.35), j, DVec2::splat(10.0));
/// assert!((grey - 0.5).abs() < 1e-12);
/// ```
pub fn filtered(uv: DVec2, jacobian: Jacobian, cells: DVec2) -> f64 {
    let p = uv * cells;
    if !p.is_finite() {
        return f64::NAN;
    }
    let [[ax, bx], [ay, by]] = jacobian.m;
    let (a, b) = (DVec2::new(ax, ay) * cells, DVec2::new(bx, by) * cells);
    let span = a.abs() + b.abs();
    let reach = span.x + span.y;
    if reach.is_nan() || reach > MOST_CELLS {
        return 0.5;
    }
    let start = p.floor();
    let sign = if is_even(start.x) == is_even(start.y) { 0.5 } else { -0.5 };
    let grid = Grid { fraction: p - start };
    let area = a.perp_dot(b);
    let length = a.length().max(b.length());
    let mean = if area.abs() <= THIN * length * length.min(1.0) {
        if length == 0.0 {
            return 0.5 + sign;
        }
        grid.line(a, b)
    } else {
        let corners = [-(a + b) * 0.5, (a - b) * 0.5, (a + b) * 0.5, (b - a) * 0.5];
        (0..4).map(|i| grid.side(corners[i], corners[(i + 1) % 4])).sum::<f64>() / area
    };
    0.5 + sign * mean.clamp(-1.0, 1.0)
}

fn is_even(x: f64) -> bool {
    x % 2.0 == 0.0
}

fn wave(k: f64) -> f64 {
    if is_even(k) { 1.0 } else { -1.0 }
}

/// Cell borders as seen from a point at this fraction of its cell; cells are counted from that one.
struct Grid {
    fraction: DVec2,
}

impl Grid {
    /// Calls `piece(t0, t1, cell)` for every stretch of the segment `from + t (to − from)` inside one cell.
    fn walk(&self, from: DVec2, to: DVec2, mut piece: impl FnMut(f64, f64, DVec2)) {
        let d = to - from;
        let mut cell = (self.fraction + from).floor();
        let mut t = 0.0;
        // Every step crosses one border, and the span limits the borders.
        loop {
            let exit = |i: usize| {
                if d[i] == 0.0 {
                    return f64::INFINITY;
                }
                let border = if d[i] > 0.0 { cell[i] + 1.0 } else { cell[i] };
                (border - self.fraction[i] - from[i]) / d[i]
            };
            let (tx, ty) = (exit(0), exit(1));
            let next = tx.min(ty).clamp(t, 1.0);
            piece(t, next, cell);
            if tx.min(ty) >= 1.0 {
                return;
            }
            t = next;
            let axis = usize::from(ty < tx);
            cell[axis] += d[axis].signum();
        }
    }

    /// ∫ T(x) s(y) dy along a side.
    fn side(&self, from: DVec2, to: DVec2) -> f64 {
        let d = to - from;
        if d.y == 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        self.walk(from, to, |t0, t1, cell| {
            // T(0) = 0 at the centre, slope 1 in even cells and -1 in odd ones.
            let k = cell.x;
            let height = |t: f64| {
                let x = from.x + t * d.x;
                if is_even(k) { x - k } else { (k + 1.0 - 2.0 * self.fraction.x) - x }
            };
            sum += 0.5 * (height(t0) + height(t1)) * (t1 - t0) * wave(cell.y);
        });
        sum * d.y
    }

    /// The mean over a parallelogram without width: a segment, weighted by the trapezoid that is the sum
    /// of two uniform movements along it.
    fn line(&self, a: DVec2, b: DVec2) -> f64 {
        let (long, short) = if a.length() >= b.length() { (a, b) } else { (b, a) };
        let length = long.length();
        let second = short.dot(long / length).abs();
        let (inner, outer) = (0.5 * (length - second), 0.5 * (length + second));
        let ramp = |t: f64| t * t / (2.0 * length * second);
        let share = |t: f64| {
            if t.abs() <= inner {
                0.5 + t / length
            } else if t < 0.0 {
                ramp((t + outer).max(0.0))
            } else {
                1.0 - ramp((outer - t).max(0.0))
            }
        };
        let end = long * (outer / length);
        let mut sum = 0.0;
        self.walk(-end, end, |t0, t1, cell| {
            let at = |t: f64| share((2.0 * t - 1.0) * outer);
            sum += (at(t1) - at(t0)) * wave(cell.x) * wave(cell.y);
        });
        sum
    }
}

/// The checkerboard at every uv, 1 number a point: [`point`] without a Jacobian, else [`filtered`].
///
/// # Errors
/// [`Error::Value`] for cell counts that are not positive and finite, and for arrays of different counts.
pub fn batch(uv: Numbers<'_>, jacobian: Option<Numbers<'_>>, cells: DVec2, out: Output<'_>) -> Result<()> {
    if !(cells.cmpgt(DVec2::ZERO).all() && cells.is_finite()) {
        return Err(Error::value("cells", cells, "positive numbers"));
    }
    let count = uv.len() / 2;
    if let Some(j) = jacobian {
        check_length("jacobian", j.len(), 4 * count)?;
    }
    run(count, out, None, [1, 1], false, &|i, out, _| {
        let uv = uv.pair(i);
        out[0] = jacobian.map_or_else(|| point(uv, cells), |j| filtered(uv, j.jacobian(i), cells));
        Ok(())
    })
}
