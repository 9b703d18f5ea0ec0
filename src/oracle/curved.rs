//! Truth for warps by any map: adaptive cubature over triangles on which the map is taken as linear.
//!
//! A square of the pixel is integrated twice, exactly, for the map's linear interpolant on 2 and on 8
//! triangles. The map, not the texture, is what is approximated, so the cost follows the map's curvature and
//! not the number of texels. The error falls with the square of the side, so a third of the difference is
//! added (Richardson) and all of it reported. While a pixel's estimate is above the tolerance, those of its
//! squares that have more than their share of it are cut in four.

use super::crew::Crew;
use super::integral::{Integrator, Map};
use super::pixel::Pixel;
use super::polygon::{Form, Point, Polygon};
use super::signal::Signal;
use super::warp::{Field, check};
use crate::error::{Error, Result};

/// Any map: positions on the output to positions on the input, pixel centres at integers on both.
pub type Curve<'a> = dyn FnMut(&[[f64; 2]]) -> Result<Vec<[f64; 2]>> + 'a;

/// Pixels whose squares are refined together.
const BLOCK: usize = 4096;
/// Squares that one pixel may be cut into.
const SQUARE_BUDGET: u32 = 4096;
/// How often a square is halved.
const DEEPEST: u32 = 12;
/// Texels by which the map may leave its linear interpolant where the texture shows no difference.
const FLAT_ENOUGH: f64 = 0.5;
/// Cells along the edges of, and inside, a triangle of a repeated texture that are still summed.
const MOST_CELLS: [f64; 2] = [65_536.0, 4_194_304.0];

/// A part of a pixel's plane that waits for its integral.
#[derive(Clone, Copy, Debug)]
struct Square {
    pixel: usize,
    from: Point,
    side: f64,
    depth: u32,
}

/// Both integrals over a square.
#[derive(Clone, Debug, Default)]
struct Outcome {
    coarse: Vec<f64>,
    fine: Vec<f64>,
    /// Quadrature error of the fine one, and all that was too large to be cut.
    error: f64,
    flat: bool,
}

impl Outcome {
    /// What the finer triangles changed, channel by channel.
    fn changes(&self) -> impl Iterator<Item = f64> + '_ {
        self.fine.iter().zip(&self.coarse).map(|(fine, coarse)| fine - coarse)
    }

    fn worst(&self) -> f64 {
        self.changes().fold(0.0, |most: f64, change| most.max(change.abs()))
    }
}

/// One pixel's squares that need no more cutting.
#[derive(Clone, Debug)]
struct Tally {
    sum: Vec<f64>,
    /// Sum of the changes and of their squares, channel by channel.
    changes: Vec<[f64; 2]>,
    error: f64,
    spent: u32,
}

impl Tally {
    fn new(channels: usize) -> Self {
        Self { sum: vec![0.0; channels], changes: vec![[0.0; 2]; channels], error: 0.0, spent: 0 }
    }

    /// Adds a square. The error falls with the square of the side, so a third of the last change is missing.
    fn accept(&mut self, outcome: &Outcome) {
        let parts = self.sum.iter_mut().zip(&mut self.changes).zip(&outcome.fine);
        for (((sum, changes), fine), change) in parts.zip(outcome.changes()) {
            *sum += fine + change / 3.0;
            changes[0] += change;
            changes[1] += change * change;
        }
        self.error += outcome.error;
    }

    /// The change of the whole pixel, which is the classical estimate, and the root of the sum of the
    /// squared changes, in case they cancel by chance.
    fn error(&self) -> f64 {
        let change = |[sum, squares]: &[f64; 2]| sum.abs() + squares.sqrt();
        self.changes.iter().map(change).fold(0.0, f64::max) + self.error
    }
}

impl Square {
    /// Nine nodes, row by row.
    fn nodes(&self) -> [Point; 9] {
        std::array::from_fn(|k| {
            let half = 0.5 * self.side;
            [self.from[0] + half * (k % 3) as f64, self.from[1] + half * (k / 3) as f64]
        })
    }

    fn parts(&self) -> [Self; 4] {
        let side = 0.5 * self.side;
        [[0.0, 0.0], [side, 0.0], [0.0, side], [side, side]].map(|[s, t]| Self {
            from: [self.from[0] + s, self.from[1] + t],
            side,
            depth: self.depth + 1,
            ..*self
        })
    }
}

impl Signal {
    /// Warps by any map, called with many output positions (x, y) at once and answering with input
    /// positions; each value is the integral of reconstruction(map(x + s, y + t)) weight(s, t) ds dt.
    ///
    /// Where the map is not finite the value is the border colour. A jump by about a whole period of a
    /// repeated axis (the seam of a panorama) is taken as no jump, provided that a square's half covers less
    /// than half a period. A pixel is cut into at most 4096 squares; what is open then is in its error.
    ///
    /// # Errors
    /// [`Error::Value`] for an empty output, a tolerance that is not above 0 and a map that answers with
    /// another number of positions; the map's own errors; [`Error::Interrupted`] if the crew is.
    pub fn warp_curved(
        &self,
        map: &mut Curve<'_>,
        [width, height]: [usize; 2],
        pixel: &Pixel,
        tolerance: f64,
        crew: &mut Crew<'_>,
    ) -> Result<Field> {
        check(width, height, tolerance)?;
        let channels = self.channels();
        let mut field = Field { values: Vec::new(), errors: Vec::new() };
        let area: f64 = pixel.squares.iter().map(|[from, to]| (to[0] - from[0]) * (to[1] - from[1])).sum();
        for start in (0..width * height).step_by(BLOCK) {
            let count = BLOCK.min(width * height - start);
            let center = |i: usize| [((start + i) % width) as f64, ((start + i) / width) as f64];
            let mut tallies = vec![Tally::new(channels); count];
            let mut squares: Vec<Square> = (0..count)
                .flat_map(|i| pixel.squares.iter().map(move |&[from, to]| (i, from, to)))
                .map(|(i, from, to)| Square { pixel: i, from, side: to[0] - from[0], depth: 0 })
                .collect();
            while !squares.is_empty() {
                let outcomes = self.integrate_squares(map, &squares, &center, pixel, tolerance, crew)?;
                let mut open = tallies.clone();
                let mut coarse = vec![false; count];
                for (square, outcome) in squares.iter().zip(&outcomes) {
                    open[square.pixel].accept(outcome);
                    coarse[square.pixel] |= square.depth == 0 || !outcome.flat;
                }
                let done: Vec<_> =
                    open.iter().zip(coarse).map(|(t, c)| !c && t.error() <= tolerance).collect();
                let mut next = Vec::new();
                for (square, outcome) in squares.iter().zip(&outcomes) {
                    let tally = &mut tallies[square.pixel];
                    let share = square.side * square.side / area;
                    let small = outcome.flat
                        && square.depth > 0
                        && outcome.worst() <= 0.25 * tolerance * share
                        && outcome.error <= 0.25 * tolerance * share;
                    if done[square.pixel] || small || square.depth >= DEEPEST || tally.spent >= SQUARE_BUDGET
                    {
                        tally.accept(outcome);
                    } else {
                        tally.spent += 4;
                        next.extend(square.parts());
                    }
                }
                squares = next;
            }
            if pixel.squares.is_empty() {
                let centers: Vec<_> = (0..count).map(center).collect();
                for (tally, at) in tallies.iter_mut().zip(ask(map, &centers)?) {
                    tally.sum = self.point([at[0] + 0.5, at[1] + 0.5]);
                }
            }
            for tally in tallies {
                let error = tally.error();
                let estimate = self.finish(tally.sum, error);
                field.values.extend(estimate.values);
                field.errors.push(estimate.error);
            }
        }
        Ok(field)
    }

    fn integrate_squares(
        &self,
        map: &mut Curve<'_>,
        squares: &[Square],
        center: &(impl Fn(usize) -> [f64; 2] + Sync),
        pixel: &Pixel,
        tolerance: f64,
        crew: &mut Crew<'_>,
    ) -> Result<Vec<Outcome>> {
        let places: Vec<_> = squares
            .iter()
            .flat_map(|square| {
                let [x, y] = center(square.pixel);
                square.nodes().map(|[s, t]| [x + s, y + t])
            })
            .collect();
        let images = ask(map, &places)?;
        let mut outcomes = vec![Outcome::default(); squares.len()];
        let work = outcomes.chunks_mut(16).zip(squares.chunks(16)).zip(images.chunks(16 * 9));
        crew.each(work, |((outcomes, squares), images)| {
            for ((outcome, square), image) in outcomes.iter_mut().zip(squares).zip(images.chunks(9)) {
                // Input pixel 0 is the centre of texel 0, half a texel from the outer edge.
                let mut image: [Point; 9] = std::array::from_fn(|k| image[k].map(|x| x + 0.5));
                self.close_seams(&mut image);
                *outcome = self.integrate_square(square, &image, pixel, tolerance);
            }
            Ok(())
        })?;
        Ok(outcomes)
    }

    fn integrate_square(
        &self,
        square: &Square,
        image: &[Point; 9],
        pixel: &Pixel,
        tolerance: f64,
    ) -> Outcome {
        let nodes = square.nodes();
        let integrate = |triangles: &[[usize; 3]]| {
            let mut integrator = Integrator::new(self, pixel.weight, &pixel.affine, 0.25 * tolerance);
            for corners in triangles {
                add_triangle(&mut integrator, corners.map(|k| nodes[k]), corners.map(|k| image[k]));
            }
            (integrator.sum, integrator.error)
        };
        let (coarse, _) = integrate(&[[0, 2, 8], [0, 8, 6]]);
        let (fine, mut error) = integrate(&[
            [0, 1, 4],
            [0, 4, 3],
            [1, 2, 5],
            [1, 5, 4],
            [3, 4, 7],
            [3, 7, 6],
            [4, 5, 8],
            [4, 8, 7],
        ]);
        let bend = |a: usize, middle: usize, b: usize| {
            [0, 1].into_iter().map(move |i| (0.5 * (image[a][i] + image[b][i]) - image[middle][i]).abs())
        };
        let bends = [[0, 1, 2], [0, 3, 6], [0, 4, 8], [2, 5, 8], [6, 7, 8]];
        let bent = bends.iter().flat_map(|&[a, m, b]| bend(a, m, b)).any(|d| d > FLAT_ENOUGH);
        // Both results may miss the rim of the map's domain in the same way.
        let inside = image.iter().filter(|at| at.iter().all(|x| x.is_finite())).count();
        let rim = inside != 0 && inside != 9;
        if rim {
            error += square.side * square.side * pixel.weight.at(nodes[4]) * self.spread();
        }
        let flat = !bent && !rim;
        Outcome { coarse, fine, error, flat }
    }

    /// Takes whole periods out of jumps between neighbouring nodes, where the steps on both sides of the
    /// middle node differ by about that much. The longer step is the one that jumps.
    fn close_seams(&self, image: &mut [Point; 9]) {
        for (axis, rule) in self.axes.iter().enumerate() {
            let Some(period) = rule.period() else { continue };
            let period = period as f64;
            let jumps = |a: f64, b: f64, c: f64| {
                let (first, second) = (b - a, c - b);
                let periods = ((second - first) / period).round() * period;
                if !periods.is_finite() {
                    (0.0, 0.0)
                } else if first.abs() > second.abs() {
                    (periods, 0.0)
                } else {
                    (0.0, -periods)
                }
            };
            for row in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|k| image[3 * row + k][axis]);
                let (first, second) = jumps(a, b, c);
                image[3 * row + 1][axis] += first;
                image[3 * row + 2][axis] += first + second;
            }
            let [a, b, c] = [0, 3, 6].map(|k| image[k][axis]);
            let (first, second) = jumps(a, b, c);
            for k in 0..3 {
                image[3 + k][axis] += first;
                image[6 + k][axis] += first + second;
            }
        }
    }
}

/// Calls the map and counts its answers.
fn ask(map: &mut Curve<'_>, places: &[Point]) -> Result<Vec<[f64; 2]>> {
    let images = map(places)?;
    if images.len() == places.len() {
        return Ok(images);
    }
    let expected = format!("{} for as many arguments", places.len());
    Err(Error::value("mapping", format!("{} positions", images.len()), expected))
}

/// Adds a triangle whose corners land on `image`, for the map that is linear in between.
fn add_triangle(integrator: &mut Integrator<'_>, corners: [Point; 3], image: [Point; 3]) {
    let signal = integrator.signal;
    if !image.iter().flatten().all(|x| x.is_finite()) {
        integrator.add_constant(corners, signal.border());
        return;
    }
    let [p, q, r] = corners;
    let (e, f) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
    let det = e[0] * f[1] - e[1] * f[0];
    let form = |i: usize| {
        let (first, second) = (image[1][i] - image[0][i], image[2][i] - image[0][i]);
        let a = (first * f[1] - second * e[1]) / det;
        let b = (second * e[0] - first * f[0]) / det;
        Form { a, b, c: image[0][i] - a * p[0] - b * p[1] }
    };
    let map = Map::affine(form(0), form(1)).near(signal, p);
    let polygon = Polygon::new(&corners);
    let [columns, rows] = integrator.extent(&polygon, &map);
    if columns + rows <= MOST_CELLS[0] && columns * rows <= MOST_CELLS[1] {
        integrator.add(&polygon, &map);
    } else {
        let share = integrator.add_constant(corners, signal.mean());
        integrator.error += share * signal.spread();
    }
}
