//! Truth for warps by a matrix: every output pixel is integrated over its own square on the *output*.

use super::crew::Crew;
use super::integral::{Integrator, Map};
use super::pixel::Pixel;
use super::polygon::{Form, Point, Polygon};
use super::signal::{Estimate, Signal};
use crate::error::{Error, Result};

/// The pixels of a warp, row by row, and the estimated error of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// `width * height * channels` numbers.
    pub values: Vec<f64>,
    /// `width * height` numbers; 0 where the integral is in closed form.
    pub errors: Vec<f64>,
}

/// Cells of a repeated texture under a square that are cut before the square is divided.
const MOST_CELLS: f64 = 4096.0;
/// Cells of a repeated texture under one pixel that are cut at all.
const CELL_BUDGET: f64 = (1u64 << 18) as f64;
/// How often a pixel is halved on each side.
const DEEPEST: u32 = 10;
/// Share of the largest `w` below which a position counts as lying on the horizon.
const HORIZON: f64 = 1e-10;

impl Signal {
    /// Warps by a matrix that takes output pixel (x, y, 1) to input pixel (x w, y w, w), pixel centres at
    /// integers: each value is the integral of reconstruction(matrix(x + s, y + t)) weight(s, t) ds dt.
    ///
    /// Affine matrices are exact to rounding for box and tent. Under a perspective the pixel's square is cut
    /// along the pulled-back edges of all cells, which are straight there, and each piece is integrated by
    /// Gauss-Legendre until two rules agree to `tolerance`. Behind the horizon (w < 0) the matrix is
    /// applied as it stands. Where a repeated texture runs towards the horizon, more than 2^18 cells of one
    /// pixel are replaced by the mean texel, and what that may cost is part of the error.
    ///
    /// # Errors
    /// [`Error::Value`] for an empty output, a matrix with an entry that is not finite, a tolerance that is
    /// not above 0, and affine footprints that would take minutes. [`Error::Interrupted`] if the crew is.
    pub fn warp(
        &self,
        matrix: [[f64; 3]; 3],
        [width, height]: [usize; 2],
        pixel: &Pixel,
        tolerance: f64,
        crew: &mut Crew<'_>,
    ) -> Result<Field> {
        check(width, height, tolerance)?;
        if !matrix.iter().flatten().all(|x| x.is_finite()) {
            return Err(Error::value("mapping", "a matrix that is not finite", "finite numbers"));
        }
        let affine = matrix[2][0] == 0.0 && matrix[2][1] == 0.0 && matrix[2][2] != 0.0;
        let matrix = if affine { matrix.map(|row| row.map(|x| x / matrix[2][2])) } else { matrix };
        let mut field =
            Field { values: vec![0.0; width * height * self.channels()], errors: vec![0.0; width * height] };
        let rows = field.values.chunks_mut(width * self.channels()).zip(field.errors.chunks_mut(width));
        crew.each(rows.enumerate(), |(y, (values, errors))| {
            let pixels = values.chunks_mut(self.channels()).zip(errors).enumerate();
            for (x, (values, error)) in pixels {
                let map = map_around(&matrix, [x as f64, y as f64]);
                let estimate = if pixel.squares.is_empty() {
                    self.finish(self.point(map.at([0.0; 2])), 0.0)
                } else if affine {
                    self.affine_pixel("mapping", map, pixel, tolerance)?
                } else {
                    self.projective_pixel(map, pixel, tolerance)
                };
                values.copy_from_slice(&estimate.values);
                *error = estimate.error;
            }
            Ok(())
        })?;
        Ok(field)
    }

    fn projective_pixel(&self, map: Map, pixel: &Pixel, tolerance: f64) -> Estimate {
        let mut work = Projective {
            integrator: Integrator::new(self, pixel.weight, &pixel.projective, tolerance),
            budget: CELL_BUDGET,
        };
        // Level by level, so that the budget goes to large squares first.
        let mut squares = pixel.squares.clone();
        for depth in 0..=DEEPEST {
            let open: Vec<_> =
                squares.into_iter().filter(|&square| !work.add(&map, square, depth == DEEPEST)).collect();
            squares = open.into_iter().flat_map(quarters).collect();
        }
        self.finish(work.integrator.sum, work.integrator.error)
    }
}

/// Refuses sizes and tolerances that make no sense.
pub(super) fn check(width: usize, height: usize, tolerance: f64) -> Result<()> {
    if width == 0 || height == 0 || width.saturating_mul(height) > 1 << 32 {
        return Err(Error::value("shape", format!("({height}, {width})"), "1 to 2^32 pixels"));
    }
    if tolerance > 0.0 && tolerance.is_finite() {
        Ok(())
    } else {
        Err(Error::value("tol", tolerance, "a finite number above 0"))
    }
}

/// The matrix as a map of one pixel's plane to texels.
fn map_around(matrix: &[[f64; 3]; 3], [x, y]: Point) -> Map {
    let [first, second, third] = matrix.map(|[a, b, c]| Form { a, b, c: a * x + b * y + c });
    // Input pixel 0 is the centre of texel 0, half a texel from the outer edge.
    Map { x: first.plus(0.5, third), y: second.plus(0.5, third), w: third }
}

/// The four quarters of a square.
fn quarters([from, to]: [Point; 2]) -> [[Point; 2]; 4] {
    let (s, t) = (0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]));
    [[from, [s, t]], [[s, from[1]], [to[0], t]], [[from[0], t], [s, to[1]]], [[s, t], to]]
}

struct Projective<'a> {
    integrator: Integrator<'a>,
    budget: f64,
}

impl Projective<'_> {
    /// Adds a square of the pixel's plane, or answers `false` if it must be divided first.
    fn add(&mut self, map: &Map, [from, to]: [Point; 2], last: bool) -> bool {
        let rectangle = Polygon::rectangle(from, to);
        let depths = rectangle.corners().iter().map(|&corner| map.w.at(corner));
        let (low, high) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), w| (l.min(w), h.max(w)));
        let periodic = self.integrator.signal.axes.iter().any(|axis| axis.period().is_some());
        let rim = HORIZON * high.abs().max(low.abs());
        if low > rim || high < -rim {
            let map = if low > 0.0 { *map } else { map.negated() };
            let [columns, rows] = self.integrator.extent(&rectangle, &map);
            let cells = columns * rows;
            if !periodic || cells <= MOST_CELLS.min(self.budget) {
                if periodic {
                    self.budget -= cells;
                }
                let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
                self.integrator.add(&rectangle, &map.near(self.integrator.signal, middle));
                return true;
            }
        } else if !periodic {
            // Cells without an outer end reach the horizon, so both sides can be cut as they are.
            let (_, front) = rectangle.split(map.w.plus(-rim, Map::ONE));
            let (behind, _) = rectangle.split(map.w.plus(rim, Map::ONE));
            self.integrator.add(&front, map);
            self.integrator.add(&behind, &map.negated());
            return true;
        }
        let mean = last || self.budget < MOST_CELLS || self.mean_suffices(map, from, to);
        if mean {
            self.add_mean(map, from, to);
        }
        mean
    }

    fn mean_suffices(&self, map: &Map, from: Point, to: Point) -> bool {
        self.doubt(map, from, to) * self.integrator.signal.spread() <= self.integrator.tolerance
    }

    /// Share of a rectangle's footprint that may lie in periods which its rim cuts: their values are not the
    /// mean's. Two over the number of periods across the footprint's narrow side, at most 1.
    fn doubt(&self, map: &Map, from: Point, to: Point) -> f64 {
        let [u, v] = self.integrator.signal.axes;
        let (Some(across), Some(down)) = (u.period(), v.period()) else { return 1.0 };
        let at = |s: f64, t: f64| {
            let [x, y] = map.at([s, t]);
            [x / across as f64, y / down as f64]
        };
        let (a, b, c) = (at(from[0], from[1]), at(to[0], from[1]), at(from[0], to[1]));
        let (e, f) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let longest = (e[0] * e[0] + e[1] * e[1] + f[0] * f[0] + f[1] * f[1]).sqrt();
        let narrow = (e[0] * f[1] - e[1] * f[0]).abs() / longest;
        if narrow > 2.0 { 2.0 / narrow } else { 1.0 }
    }

    fn add_mean(&mut self, map: &Map, from: Point, to: Point) {
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        let share = (to[0] - from[0]) * (to[1] - from[1]) * self.integrator.weight.at(middle);
        let crosses = {
            let depths =
                Polygon::rectangle(from, to).corners().iter().map(|&p| map.w.at(p) > 0.0).collect::<Vec<_>>();
            depths.iter().any(|d| *d != depths[0])
        };
        let doubt = if crosses { 1.0 } else { self.doubt(map, from, to) };
        let integrator = &mut self.integrator;
        integrator.sum.iter_mut().zip(integrator.signal.mean()).for_each(|(s, m)| *s += share * m);
        integrator.error += share * doubt * integrator.signal.spread();
    }
}
