//! From a footprint to the weights of texels, row by row: exact integrals of the bilinear reconstruction.
//!
//! With texel centres on whole numbers, a texel (i, j) weighs the mean of `L(x - i) L(y - j)` over the
//! footprint, `L(z) = max(0, 1 - |z|)`. The footprint is cut along y into slabs whose two sides are straight,
//! slabs at the rows of texel centres, and these where a side crosses a column. On such a piece
//!
//! ```text
//! density(y) * mean over x in left(y)..right(y) of L(x - i) * L(y - j),      density = width / area
//! ```
//!
//! is a cubic in y, so two Gauss points integrate it exactly. The mean over a span is a sum of positive terms
//! and has a limit where the span is a point, and so has the density (a trapezoid) where the area is zero:
//! nothing cancels in slivers, lines need no other method.
//!
//! Cost: two spans a piece, and a piece for each row and each column that a side crosses. Beyond an edge where
//! the picture no longer changes, whatever lies there is one piece.

use crate::jacobian::Jacobian;
use crate::kernel::window::Slab;
use crate::num::floor;

/// Slabs with less than this share of the footprint are left out.
const NEGLIGIBLE: f64 = 1e-14;
/// Half the distance of the Gauss points, in half pieces.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// A footprint without horizontal overhang: up to three slabs, upwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    pub parts: [Slab; 3],
    /// Share of the footprint per height at the bottom and at the top of each.
    density: [[f64; 2]; 3],
}

impl Slabs {
    /// The parallelogram with the Jacobian's columns for sides; not both of height 0 (see [`lifted`]).
    pub fn parallelogram(j: Jacobian) -> Self {
        // A side turned round is the same side, and the order of the two does not matter: make both go
        // upwards, the first to the right of the second.
        let column = |k: usize| {
            let [x, y] = [j.m[0][k], j.m[1][k]];
            if y < 0.0 { [-x, -y] } else { [x, y] }
        };
        let (mut p, mut q) = (column(0), column(1));
        if p[0] * q[1] < q[0] * p[1] {
            std::mem::swap(&mut p, &mut q);
        }
        let (low, high) = (p[1].min(q[1]), p[1].max(q[1]));
        let share = low / high;
        let x = -0.5 * (p[0] + q[0]);
        let (y0, y3) = (-0.5 * (low + high), 0.5 * (low + high));
        // The right side goes along p, then q; the left along q, then p.
        let (r1, l1, r2, l2) = if p[1] <= q[1] {
            (x + p[0], x + q[0] * share, x + p[0] + q[0] * (1.0 - share), x + q[0])
        } else {
            (x + p[0] * share, x + q[0], x + p[0], x + q[0] + p[0] * (1.0 - share))
        };
        let (top, d) = (-x, 1.0 / high);
        let (y1, y2) = (y0 + low, y3 - low);
        let parts = [
            Slab { y: [y0, y1], left: [x, l1], right: [x, r1] },
            Slab { y: [y1, y2], left: [l1, l2], right: [r1, r2] },
            Slab { y: [y2, y3], left: [l2, top], right: [r2, top] },
        ];
        Self { parts, density: [[0.0, d], [d, d], [d, 0.0]] }
    }
}

/// A Jacobian of nearly the same footprint, at least a trifle high: 1e-12 of its width, at least 1e-12.
pub(super) fn lifted(j: Jacobian) -> Jacobian {
    let [[a, b], [c, d]] = j.m;
    let least = 1e-12 * (a.abs() + b.abs()).max(1.0);
    if c.abs().max(d.abs()) < least { Jacobian::new([[a, b], [0.0, least]]) } else { j }
}

/// Between which texels the picture changes along one axis; infinite where it repeats itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub first: f64,
    pub last: f64,
}

/// Weights of a row under construction. Texel `base + k` has `point[k]` and the sum of `step[..=k]`.
#[derive(Default)]
struct Row {
    point: Vec<f64>,
    step: Vec<f64>,
    /// Touched: `start..end`.
    start: usize,
    end: usize,
    /// From here to `right` all weights are the same.
    left: usize,
    right: usize,
}

impl Row {
    fn resize(&mut self, len: usize) {
        if self.point.len() < len {
            self.point.resize(len, 0.0);
            self.step.resize(len, 0.0);
        }
        self.forget();
    }

    fn forget(&mut self) {
        (self.start, self.end, self.left, self.right) = (usize::MAX, 0, 0, usize::MAX);
    }
}

/// Memory for rows, kept from one footprint to the next.
#[derive(Default)]
pub(super) struct Scratch {
    lower: Row,
    upper: Row,
}

/// The weights of one row of texels, `weights[k]` for texel `first + k`; they are all the same in `middle`.
pub(super) struct Weights<'a> {
    pub row: i64,
    pub first: i64,
    pub weights: &'a [f64],
    pub middle: std::ops::Range<usize>,
}

/// The mean over a span, as weights: cells are numbered by the texel at their left.
struct Span {
    left_cell: i64,
    right_cell: i64,
    /// Weights of the left cell's two texels and of the right cell's two.
    ends: [f64; 4],
    /// Weight of each whole cell between them.
    inner: f64,
}

struct Walk<'s> {
    scratch: &'s mut Scratch,
    base: i64,
    x: Bounds,
}

/// Calls `emit` with the weights of every row that the footprint around `centre` touches, upwards. They sum
/// to 1 but for rounding. `x` and `y` are bounds in texels, the centre of texel 0 at 0.
pub(super) fn walk(
    centre: [f64; 2],
    slabs: &Slabs,
    [x, y]: [Bounds; 2],
    scratch: &mut Scratch,
    mut emit: impl FnMut(Weights<'_>),
) {
    let ends = slabs.parts.iter().flat_map(|s| [s.left, s.right]).flatten();
    let (low, high) = ends.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let cell_of = |v: f64, b: Bounds| floor(v.clamp(b.first - 1.0, b.last));
    let base = cell_of(centre[0] + low, x) - 2;
    let len = (cell_of(centre[0] + high, x) - base + 5) as usize;
    scratch.lower.resize(len);
    scratch.upper.resize(len);
    let mut walk = Walk { scratch, base, x };
    let mut row = None;
    let parts = slabs.parts.iter().zip(slabs.density);
    for (slab, density) in parts.filter(|(s, d)| (s.y[1] - s.y[0]) * d[0].max(d[1]) > NEGLIGIBLE) {
        let mut from = slab.y[0];
        let mut cell = cell_of(centre[1] + from, y);
        loop {
            // The cell above the last row has no end.
            let edge = if cell as f64 >= y.last { f64::INFINITY } else { (cell + 1) as f64 - centre[1] };
            let to = edge.min(slab.y[1]);
            if to > from {
                let mut current = row.unwrap_or(cell);
                while current < cell {
                    walk.finish_row(current, &mut emit);
                    current += 1;
                    if current < cell {
                        // Nothing lies between here and the cell.
                        walk.finish_row(current, &mut emit);
                        current = cell;
                    }
                }
                row = Some(cell);
                let fraction = if (cell as f64) < y.first {
                    [1.0, 0.0]
                } else if cell as f64 >= y.last {
                    [0.0, 0.0]
                } else {
                    [centre[1] - cell as f64, 1.0]
                };
                walk.strip(slab, density, centre[0], from, to, fraction);
            }
            if edge >= slab.y[1] {
                break;
            }
            from = to.max(from);
            cell += 1;
        }
    }
    if let Some(row) = row {
        walk.finish_row(row, &mut emit);
        walk.finish_row(row + 1, &mut emit);
    }
}

impl Walk<'_> {
    /// Hands out the lower row, which nothing above touches; the upper becomes the lower.
    fn finish_row(&mut self, index: i64, emit: &mut impl FnMut(Weights<'_>)) {
        let row = &mut self.scratch.lower;
        if row.start < row.end {
            let mut running = 0.0;
            let (start, end) = (row.start, row.end);
            for (point, step) in row.point[start..end].iter_mut().zip(&mut row.step[start..end]) {
                running += *step;
                *point += running;
                *step = 0.0;
            }
            let middle = if row.left < row.right { row.left - start..row.right - start } else { 0..0 };
            let weights = &row.point[start..end];
            emit(Weights { row: index, first: self.base + start as i64, weights, middle });
            row.point[start..end].fill(0.0);
        }
        row.forget();
        std::mem::swap(&mut self.scratch.lower, &mut self.scratch.upper);
    }

    /// The part of a slab between two rows of texel centres; `y` from its centre lies at
    /// `fraction[0] + y fraction[1]` of the way from the lower to the upper.
    fn strip(&mut self, slab: &Slab, density: [f64; 2], centre: f64, from: f64, to: f64, fraction: [f64; 2]) {
        let height = slab.y[1] - slab.y[0];
        let line = |v: [f64; 2]| (v[0], (v[1] - v[0]) / height);
        let (density, left, right) = (line(density), line(slab.left), line(slab.right));
        let at = |(v, slope): (f64, f64), y: f64| v + slope * (y - slab.y[0]);
        let mut cuts = [left, right].map(|side| Cuts::new(side, centre, at(side, from), self.x));
        let mut y = from;
        while y < to {
            let next = |c: &Cuts| slab.y[0] + c.offset();
            let end = to.min(next(&cuts[0])).min(next(&cuts[1]));
            for cut in cuts.iter_mut().filter(|c| next(c) <= end) {
                cut.at += cut.step;
            }
            if end <= y {
                continue;
            }
            let (mid, half) = (0.5 * (y + end), 0.5 * (end - y));
            let cells = [left, right]
                .map(|side| floor((centre + at(side, mid)).clamp(self.x.first - 1.0, self.x.last)));
            for node in [-GAUSS, GAUSS] {
                let v = mid + half * node;
                let weight = half * at(density, v);
                let f = (fraction[0] + v * fraction[1]).clamp(0.0, 1.0);
                let span = self.span(centre + at(left, v), centre + at(right, v), cells);
                self.scratch.lower.add(&span, weight * (1.0 - f), self.base);
                self.scratch.upper.add(&span, weight * f, self.base);
            }
            y = end;
        }
    }

    /// The mean over `left..right`, which lie in these cells.
    fn span(&self, left: f64, right: f64, [left_cell, right_cell]: [i64; 2]) -> Span {
        // The outermost cells have no end and one colour, that of their only texel.
        let (before, after) = ((left_cell as f64) < self.x.first, (right_cell as f64) >= self.x.last);
        if left_cell >= right_cell {
            let middle = (0.5 * (left + right) - left_cell as f64).clamp(0.0, 1.0);
            let weight = if before {
                1.0
            } else if left_cell as f64 >= self.x.last {
                0.0
            } else {
                middle
            };
            let ends = [1.0 - weight, weight, 0.0, 0.0];
            return Span { left_cell, right_cell: left_cell, ends, inner: 0.0 };
        }
        let mut a = ((left_cell + 1) as f64 - left).max(0.0);
        let mut b = (right - right_cell as f64).max(0.0);
        let whole = (right_cell - left_cell - 1) as f64;
        if !before {
            a = a.min(1.0);
        }
        if !after {
            b = b.min(1.0);
        }
        let width = a + b + whole;
        if width == 0.0 {
            return Span { left_cell, right_cell: left_cell, ends: [0.0, 1.0, 0.0, 0.0], inner: 0.0 };
        }
        let inner = 1.0 / width;
        let (a, b) = if before { ([0.0, a], b) } else { ([0.5 * a * a, a * (1.0 - 0.5 * a)], b) };
        let b = if after { [b, 0.0] } else { [b * (1.0 - 0.5 * b), 0.5 * b * b] };
        let ends = [a[0] * inner, a[1] * inner, b[0] * inner, b[1] * inner];
        Span { left_cell, right_cell, ends, inner }
    }
}

impl Row {
    #[inline]
    fn add(&mut self, span: &Span, weight: f64, base: i64) {
        if weight == 0.0 {
            return;
        }
        let (i, k) = ((span.left_cell - base) as usize, (span.right_cell - base) as usize);
        self.point[i] += weight * span.ends[0];
        self.point[i + 1] += weight * span.ends[1];
        self.point[k] += weight * span.ends[2];
        self.point[k + 1] += weight * span.ends[3];
        if k > i + 1 {
            // Each whole cell gives half its weight to the texel on either side.
            let half = 0.5 * weight * span.inner;
            self.step[i + 1] += half;
            self.step[i + 2] += half;
            self.step[k] -= half;
            self.step[k + 1] -= half;
        }
        self.start = self.start.min(i);
        self.end = self.end.max(k + 2);
        self.left = self.left.max(i + 2);
        self.right = self.right.min(k);
    }
}

/// Where one side crosses columns of texel centres, upwards.
struct Cuts {
    /// The next column.
    at: f64,
    step: f64,
    /// Where the side starts, in texels, and its slope.
    origin: f64,
    slope: f64,
    bounds: Bounds,
}

impl Cuts {
    /// `side` starts at `side.0` from the centre with the slope `side.1`; the first cut comes after `x`.
    fn new(side: (f64, f64), centre: f64, x: f64, bounds: Bounds) -> Self {
        let x = centre + x;
        let (at, step) = if side.1 > 0.0 {
            ((x.max(bounds.first - 0.5).floor() + 1.0), 1.0)
        } else {
            ((x.min(bounds.last + 0.5).ceil() - 1.0), -1.0)
        };
        Self { at, step, origin: centre + side.0, slope: side.1, bounds }
    }

    /// Height of the next cut above the side's start; infinite when there is none.
    fn offset(&self) -> f64 {
        let beyond = if self.step > 0.0 { self.at > self.bounds.last } else { self.at < self.bounds.first };
        if beyond || self.slope == 0.0 { f64::INFINITY } else { (self.at - self.origin) / self.slope }
    }
}
