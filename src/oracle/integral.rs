//! The integral of the reconstruction over a polygon of the pixel's plane.
//!
//! The polygon is cut along the pulled-back edges of the reconstruction's cells. On each piece the
//! reconstruction is one polynomial of the texture position: a product of the kernel's weights. The weights,
//! not the colours, are integrated, by Gauss-Legendre on triangles, so the cost hardly depends on the number
//! of channels. For affine maps with a box or tent the integrand is a polynomial and the rule is exact to
//! its degree. For projective maps and the Gaussian it is smooth, and two rules are compared: where they
//! differ by more than the tolerance the triangle is cut in four.
//!
//! Everything happens in the *pixel's* plane, so footprints of no area (lines, points) need no special case.

use super::gauss::{self, Node};
use super::options::Reconstruction;
use super::polygon::{Form, Point, Polygon, twice_area};
use super::signal::Signal;
use crate::error::{Error, Result};

/// Where the pixel's plane lands on the texture, in texels: (x / w, y / w).
#[derive(Clone, Copy, Debug)]
pub(super) struct Map {
    pub(super) x: Form,
    pub(super) y: Form,
    pub(super) w: Form,
}

impl Map {
    pub(super) const ONE: Form = Form { a: 0.0, b: 0.0, c: 1.0 };

    /// The map whose two coordinates are linear.
    pub(super) fn affine(x: Form, y: Form) -> Self {
        Self { x, y, w: Self::ONE }
    }

    pub(super) fn is_affine(&self) -> bool {
        self.w == Self::ONE
    }

    pub(super) fn at(&self, p: Point) -> [f64; 2] {
        let w = self.w.at(p);
        [self.x.at(p) / w, self.y.at(p) / w]
    }

    /// The same map with x, y and w negated: no position moves.
    pub(super) fn negated(&self) -> Self {
        Self { x: self.x.negated(), y: self.y.negated(), w: self.w.negated() }
    }

    /// The map moved by whole periods so that `p` lands near the texture, where numbers are finest.
    pub(super) fn near(&self, signal: &Signal, p: Point) -> Self {
        let at = self.at(p);
        let [x, y] =
            [0, 1].map(|i| if at[i].is_finite() { signal.axes[i].periods_below(at[i]) } else { 0.0 });
        Self { x: self.x.plus(-x, self.w), y: self.y.plus(-y, self.w), w: self.w }
    }

    /// Area on the texture of a unit area of the pixel's plane, for affine maps.
    fn density(&self) -> f64 {
        (self.x.a * self.y.b - self.x.b * self.y.a).abs()
    }
}

/// Weight of the pixel filter at a point of its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weight {
    /// A constant: the box and its parts.
    Uniform(f64),
    /// The tent, on squares that its ridges do not cross.
    Tent,
    /// `scale * exp(-r² * half_precision)`.
    Gaussian { scale: f64, half_precision: f64 },
}

impl Weight {
    pub(super) fn at(self, [s, t]: Point) -> f64 {
        match self {
            Self::Uniform(weight) => weight,
            Self::Tent => (1.0 - s.abs()) * (1.0 - t.abs()),
            Self::Gaussian { scale, half_precision } => scale * (-(s * s + t * t) * half_precision).exp(),
        }
    }
}

/// Rules for one kind of integrand: the finer gives the value, the coarser, if there is one, the error.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    coarse: Option<Vec<Node>>,
    fine: Vec<Node>,
}

impl Rules {
    pub(super) fn new(reconstruction: Reconstruction, weight: Weight, affine: bool) -> Self {
        let degree = 2 * reconstruction.degree();
        let degree = match weight {
            Weight::Uniform(_) => degree,
            Weight::Tent => degree + 2,
            Weight::Gaussian { .. } => degree + 6,
        };
        if affine && !matches!(weight, Weight::Gaussian { .. }) {
            Self { coarse: None, fine: gauss::triangle(degree) }
        } else {
            Self { coarse: Some(gauss::triangle(degree + 2)), fine: gauss::triangle(degree + 4) }
        }
    }
}

/// Columns and rows of cells under the most pieces that one footprint may be cut into.
const MOST_CUT: f64 = (1u64 << 23) as f64;
/// Most whole cells that are summed, not cut.
const MOST_SUMMED: f64 = (1u64 << 28) as f64;
/// How often a triangle is cut in four.
const DEEPEST: u32 = 12;

/// Sums the integral over one polygon after the other.
pub(super) struct Integrator<'a> {
    pub(super) signal: &'a Signal,
    pub(super) weight: Weight,
    pub(super) rules: &'a Rules,
    /// Error that a unit of the pixel's area may have.
    pub(super) tolerance: f64,
    /// The integral so far.
    pub(super) sum: Vec<f64>,
    /// Estimated error of the sum.
    pub(super) error: f64,
    taps: Vec<f64>,
}

/// Weights of at most 4 x 4 texels.
type Tally = [f64; 16];

impl<'a> Integrator<'a> {
    pub(super) fn new(signal: &'a Signal, weight: Weight, rules: &'a Rules, tolerance: f64) -> Self {
        let sum = vec![0.0; signal.channels()];
        Self { signal, weight, rules, tolerance, sum, error: 0.0, taps: Vec::new() }
    }

    /// Columns and rows of cells that the polygon's image touches. `w` must not change sign on it.
    pub(super) fn extent(&self, polygon: &Polygon, map: &Map) -> [f64; 2] {
        let mut limits = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for &corner in polygon.corners() {
            for (limit, x) in limits.iter_mut().zip(map.at(corner)) {
                *limit = [limit[0].min(x), limit[1].max(x)];
            }
        }
        [0, 1].map(|i| {
            let count = limits[i][1] - limits[i][0] + 2.0;
            match self.signal.axes[i].period() {
                Some(_) => count,
                None => count.min(2.0 * self.signal.axes[i].len() as f64 + 6.0),
            }
        })
    }

    /// Refuses footprints that would take minutes.
    pub(super) fn check_extent(&self, argument: &'static str, polygon: &Polygon, map: &Map) -> Result<()> {
        let [columns, rows] = self.extent(polygon, map);
        let width = self.signal.axes[0].period().map_or(columns, |p| columns.min(p as f64));
        let fits = if self.sums_whole_cells(map) {
            columns + rows <= MOST_CUT && width * rows <= MOST_SUMMED
        } else {
            columns * rows <= 2.0 * MOST_CUT
        };
        if fits {
            return Ok(());
        }
        Err(Error::value(
            argument,
            format!("a footprint of {columns:.3e} by {rows:.3e} texels"),
            "one that the reference can cut into cells within seconds: up to millions of texels along its \
             edges and 2^28 inside (box, affine) or 2^24 inside (other filters)",
        ))
    }

    fn sums_whole_cells(&self, map: &Map) -> bool {
        map.is_affine() && matches!(self.weight, Weight::Uniform(_)) && map.density() > 0.0
    }

    /// Adds the integral over a convex polygon on which the map's `w` is positive, but for its rim.
    pub(super) fn add(&mut self, polygon: &Polygon, map: &Map) {
        let outline = self
            .sums_whole_cells(map)
            .then(|| polygon.corners().iter().map(|&corner| map.at(corner)).collect::<Vec<_>>());
        let axis = self.signal.axes[1];
        let (first, last) = cells(polygon, |p| axis.cell(map.at(p)[1]));
        let mut rest = *polygon;
        for row in first..=last {
            let (low, high) = axis.edges(row);
            let strip = if row < last {
                let (strip, above) = rest.split(map.y.plus(-high, map.w));
                rest = above;
                strip
            } else {
                rest
            };
            let whole = outline.as_ref().and_then(|outline| {
                let ((a, b), (c, d)) = (chord(outline, low)?, chord(outline, high)?);
                Some(self.signal.axes[0].whole_cells(a.max(c), b.min(d)))
            });
            match whole {
                Some((from, to)) if from < to => {
                    let edge = |k: i64| map.x.plus(-self.signal.axes[0].edges(k).0, map.w);
                    let (left, others) = strip.split(edge(from));
                    let (_, right) = others.split(edge(to));
                    self.add_row(&left, map, row);
                    self.add_whole_cells(from, to, row, map.density());
                    self.add_row(&right, map, row);
                }
                _ => self.add_row(&strip, map, row),
            }
        }
    }

    /// Adds the part of the polygon that lies in one row of cells.
    fn add_row(&mut self, polygon: &Polygon, map: &Map, row: i64) {
        if polygon.is_flat() {
            return;
        }
        let axis = self.signal.axes[0];
        let (first, last) = cells(polygon, |p| axis.cell(map.at(p)[0]));
        let mut rest = *polygon;
        for column in first..last {
            let (piece, right) = rest.split(map.x.plus(-axis.edges(column).1, map.w));
            rest = right;
            self.add_piece(&piece, map, column, row);
        }
        self.add_piece(&rest, map, last, row);
    }

    /// Adds cells that lie inside the footprint with all four corners: each has the area `1 / density`.
    fn add_whole_cells(&mut self, from: i64, to: i64, row: i64, density: f64) {
        let Weight::Uniform(weight) = self.weight else { return };
        let [u, v] = self.signal.axes;
        let weights = self.signal.reconstruction.cell_weights();
        // A sum a row, not one for all, keeps the rounding of large footprints small.
        let mut add = |columns: std::ops::Range<i64>, times: f64| {
            let mut strip = vec![0.0; self.sum.len()];
            for (j, wy) in v.taps(row).zip(weights) {
                for column in columns.clone() {
                    for (i, wx) in u.taps(column).zip(weights) {
                        let texel = self.signal.texel(i, j);
                        strip.iter_mut().zip(texel).for_each(|(s, t)| *s += wx * wy * t);
                    }
                }
            }
            self.sum.iter_mut().zip(strip).for_each(|(s, t)| *s += times * weight / density * t);
        };
        match u.period() {
            Some(period) if to - from >= period => {
                let periods = (to - from) / period;
                add(from..from + period, periods as f64);
                add(from + periods * period..to, 1.0);
            }
            _ => add(from..to, 1.0),
        }
    }

    /// Adds the part of the polygon that lies in one cell.
    fn add_piece(&mut self, polygon: &Polygon, map: &Map, column: i64, row: i64) {
        if polygon.is_flat() {
            return;
        }
        let [u, v] = self.signal.axes;
        self.taps.clear();
        for j in v.taps(row) {
            for i in u.taps(column) {
                self.taps.extend_from_slice(self.signal.texel(i, j));
            }
        }
        for triangle in polygon.triangles() {
            self.add_triangle(triangle, map, [column, row], DEEPEST);
        }
    }

    /// Adds one colour all over a triangle and returns the triangle's weight.
    pub(super) fn add_constant(&mut self, [a, b, c]: [Point; 3], colour: &[f64]) -> f64 {
        let area = twice_area([a, b, c]);
        let weights = self.rules.fine.iter().map(|node| node.weight * self.weight.at(node.inside([a, b, c])));
        let share = area * weights.sum::<f64>();
        self.sum.iter_mut().zip(colour).for_each(|(s, v)| *s += share * v);
        share
    }

    fn add_triangle(&mut self, triangle: [Point; 3], map: &Map, cell: [i64; 2], depth: u32) {
        let fine = self.tally(&self.rules.fine, triangle, map, cell);
        let error = self.rules.coarse.as_ref().map_or(0.0, |coarse| {
            let mut difference = self.tally(coarse, triangle, map, cell);
            difference.iter_mut().zip(fine).for_each(|(d, f)| *d -= f);
            (0..self.sum.len()).map(|c| self.weighted(&difference, c).abs()).fold(0.0, f64::max)
        });
        if error > self.tolerance * 0.5 * twice_area(triangle) && depth > 0 {
            let [a, b, c] = triangle;
            let middle = |p: Point, q: Point| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                self.add_triangle(part, map, cell, depth - 1);
            }
            return;
        }
        for c in 0..self.sum.len() {
            self.sum[c] += self.weighted(&fine, c);
        }
        self.error += error;
    }

    /// Integrals of the kernel's weights, times the pixel filter, over a triangle: one for each tap.
    fn tally(&self, rule: &[Node], triangle: [Point; 3], map: &Map, [column, row]: [i64; 2]) -> Tally {
        let [u, v] = self.signal.axes;
        let side = self.signal.reconstruction.degree() + 1;
        let area = twice_area(triangle);
        let mut tally = [0.0; 16];
        for node in rule {
            let point = node.inside(triangle);
            let [x, y] = map.at(point);
            let (across, down) = (u.weights(column, x), v.weights(row, y));
            let weight = node.weight * area * self.weight.at(point);
            for j in 0..side {
                for i in 0..side {
                    tally[j * side + i] += weight * down[j] * across[i];
                }
            }
        }
        tally
    }

    /// One channel of the cell's taps, weighted.
    fn weighted(&self, tally: &Tally, channel: usize) -> f64 {
        self.taps.iter().skip(channel).step_by(self.sum.len()).zip(tally).map(|(t, w)| t * w).sum()
    }
}

/// The first and the last cell that a polygon's corners lie in.
fn cells(polygon: &Polygon, cell: impl Fn(Point) -> i64) -> (i64, i64) {
    let of = polygon.corners().iter().map(|&corner| cell(corner));
    of.fold((i64::MAX, i64::MIN), |(low, high), k| (low.min(k), high.max(k)))
}

/// Where the horizontal line at `y` enters and leaves a convex outline.
fn chord(outline: &[[f64; 2]], y: f64) -> Option<(f64, f64)> {
    let mut ends: Option<(f64, f64)> = None;
    for (i, &[x0, y0]) in outline.iter().enumerate() {
        let [x1, y1] = outline[(i + 1) % outline.len()];
        if (y0 <= y) == (y1 <= y) {
            continue;
        }
        let x = x0 + (y - y0) / (y1 - y0) * (x1 - x0);
        ends = Some(ends.map_or((x, x), |(low, high)| (low.min(x), high.max(x))));
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_a_diamond() {
        let diamond = [[0.0, -2.0], [2.0, 0.0], [0.0, 2.0], [-2.0, 0.0]];
        assert_eq!(chord(&diamond, 1.0), Some((-1.0, 1.0)));
        assert_eq!(chord(&diamond, 3.0), None);
    }
}
