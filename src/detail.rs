//! How much a texture changes from level to level of its pyramid, and where: what predicts the error of a filter.
//!
//! `delta_l^2` is the mean squared difference of level `l` from level `l + 1`, interpolated: what a coarser level lacks.
//! A texel of level `l` is a mean of finer ones and lacks a share of what they lack: with `lost_0 = 0` and
//! `lost_(l+1) = (lost_l + delta_l^2)/4`, `lost_l` is the variance of what a texel of level `l` does not show of the
//! texture below it, were it sampled at random. The table of level `l` holds `lost_l + delta_l^2`, the largest of the
//! channels, for cells of 4 x 4 texels; between their centres it is interpolated, so that what follows from it is
//! continuous.
//!
//! Cost: 4 bytes for 16 texels of every level; one pass over the levels.

use crate::error::Result;
use crate::num::floor;
use crate::par;
use crate::wrap::Wrap;

/// Texels of a level on a side of a cell.
const CELL: usize = 4;

/// One level's cells.
#[derive(Debug)]
struct Grid {
    columns: usize,
    rows: usize,
    variance: Vec<f32>,
}

/// The cells of all levels, in the square of the unit of averages.
#[derive(Debug)]
pub struct Detail {
    grids: Vec<Grid>,
    /// Texels of level 0 along both axes.
    size: [f64; 2],
    wrap: [Wrap; 2],
}

impl Detail {
    /// Cells of levels of these sizes; `row(l, y, out)` gives the texels of row `y` of level `l`, wrapped, from column -1 to
    /// one beyond the last; `y` is as far outside as these.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub fn new(
        sizes: &[[usize; 2]],
        wrap: [Wrap; 2],
        row: impl Fn(usize, i64, &mut [[f32; 4]]) + Sync,
    ) -> Result<Self> {
        let mut grids: Vec<Grid> = Vec::with_capacity(sizes.len());
        for (level, &[w, h]) in sizes.iter().enumerate() {
            let [columns, rows] = [w, h].map(|n| n.div_ceil(CELL));
            let mut variance = vec![0.0f32; columns * rows];
            let finer = grids.last();
            let lack = sizes.get(level + 1).map(|coarse| Lack::new(level, [w, h], *coarse));
            par::for_each(variance.chunks_mut(columns), |j, cells| {
                if let Some(lack) = &lack {
                    lack.cells(&row, j, cells);
                }
                for (i, cell) in cells.iter_mut().enumerate() {
                    let lost = finer.map_or(0.0, |g| 0.25 * mean(g, [i, j], [columns, rows]));
                    // What is not finite needs all the care there is.
                    let sum = lost + f64::from(*cell);
                    *cell = if sum.is_finite() { sum as f32 } else { f32::MAX };
                }
                Ok(())
            })?;
            grids.push(Grid { columns, rows, variance });
        }
        let size = sizes.first().map_or([1.0; 2], |s| s.map(|n| n as f64));
        Ok(Self { grids, size, wrap })
    }

    /// The variance at (s, t), texels of level 0 (reduced to where the texture is), on a level.
    #[inline(always)]
    pub fn at(&self, level: usize, s: f64, t: f64) -> f32 {
        let grid = &self.grids[level.min(self.grids.len() - 1)];
        let (x, fx) = self.cell(0, s, grid.columns);
        let (y, fy) = self.cell(1, t, grid.rows);
        let row = |y: usize| {
            let row = &grid.variance[y * grid.columns..][..grid.columns];
            row[x[0]] + fx * (row[x[1]] - row[x[0]])
        };
        let (above, below) = (row(y[0]), row(y[1]));
        above + fy * (below - above)
    }

    /// The two cells around a place of an axis, and how far it is on the way to the second.
    #[inline(always)]
    fn cell(&self, axis: usize, place: f64, n: usize) -> ([usize; 2], f32) {
        let x = place * (n as f64 / self.size[axis]) - 0.5;
        let k = floor(x);
        let part = (x - k as f64) as f32;
        if k >= 0 && k + 1 < n as i64 {
            return ([k as usize, k as usize + 1], part);
        }
        let at = |k: i64| match self.wrap[axis] {
            Wrap::Repeat => k.rem_euclid(n as i64) as usize,
            _ => k.clamp(0, n as i64 - 1) as usize,
        };
        ([at(k), at(k + 1)], part)
    }

    /// Bytes of the cells.
    pub fn nbytes(&self) -> usize {
        self.grids.iter().map(|g| size_of_val(g.variance.as_slice())).sum()
    }
}

/// The mean of a finer grid's cells under a cell of a grid of `size`.
fn mean(fine: &Grid, cell: [usize; 2], size: [usize; 2]) -> f64 {
    let span = |k: usize, n: usize, fine: usize| {
        let first = k * fine / n;
        (first, ((k + 1) * fine).div_ceil(n).clamp(first + 1, fine))
    };
    let (x0, x1) = span(cell[0], size[0], fine.columns);
    let (y0, y1) = span(cell[1], size[1], fine.rows);
    let sum: f64 = (y0..y1)
        .map(|y| fine.variance[y * fine.columns..][x0..x1].iter().map(|v| f64::from(*v)).sum::<f64>())
        .sum();
    sum / ((x1 - x0) * (y1 - y0)) as f64
}

/// What a level has that the next one lacks.
struct Lack {
    level: usize,
    size: [usize; 2],
    coarse: [usize; 2],
    /// For each column: the coarser texel left of it, counted from the one before the first, and how far it is on the way to
    /// the next.
    columns: Vec<(u32, f32)>,
}

impl Lack {
    fn new(level: usize, size: [usize; 2], coarse: [usize; 2]) -> Self {
        let columns = (0..size[0]).map(|x| {
            let (i, part) = between(x, size[0], coarse[0]);
            ((i + 1) as u32, part)
        });
        Self { level, size, coarse, columns: columns.collect() }
    }

    /// The mean squared differences of a row of cells, the largest of the channels.
    fn cells(&self, row: &impl Fn(usize, i64, &mut [[f32; 4]]), j: usize, cells: &mut [f32]) {
        let [w, h] = self.size;
        let mut fine = vec![[0.0; 4]; w + 2];
        let [mut above, mut below, mut middle] = [0; 3].map(|_| vec![[0.0f32; 4]; self.coarse[0] + 2]);
        let mut squares = vec![[0.0f32; 4]; w];
        let mut held = None;
        for y in span(j, h) {
            let (i, part) = between(y, h, self.coarse[1]);
            if held != Some(i) {
                row(self.level + 1, i, &mut above);
                row(self.level + 1, i + 1, &mut below);
                held = Some(i);
            }
            row(self.level, y as i64, &mut fine);
            for ((middle, above), below) in middle.iter_mut().zip(&above).zip(&below) {
                for c in 0..4 {
                    middle[c] = above[c] + part * (below[c] - above[c]);
                }
            }
            for ((sum, fine), (i, part)) in squares.iter_mut().zip(&fine[1..]).zip(&self.columns) {
                let (left, right) = (middle[*i as usize], middle[*i as usize + 1]);
                for c in 0..4 {
                    let off = fine[c] - (left[c] + part * (right[c] - left[c]));
                    sum[c] += off * off;
                }
            }
        }
        for (i, cell) in cells.iter_mut().enumerate() {
            let columns = span(i, w);
            let count = (columns.len() * span(j, h).len()) as f32;
            let mut sum = [0.0f32; 4];
            for square in &squares[columns] {
                for c in 0..4 {
                    sum[c] += square[c];
                }
            }
            // What is no number is the largest.
            *cell = sum.into_iter().fold(0.0, |a: f32, s| if s <= a { a } else { s }) / count;
        }
    }
}

/// The texels of cell `k` among `n`. As many from one end as from the other: a mirrored texture has the mirrored table.
fn span(k: usize, n: usize) -> std::ops::Range<usize> {
    let cells = n.div_ceil(CELL);
    k * n / cells..((k + 1) * n).div_ceil(cells)
}

/// Texel `k` of `n` among `coarse` ones: the one before it, from -1 on, and how far it is on the way to the next.
fn between(k: usize, n: usize, coarse: usize) -> (i64, f32) {
    let x = (k as f64 + 0.5) * (coarse as f64 / n as f64) - 0.5;
    (floor(x), (x - floor(x) as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_is_nothing_and_noise_is_its_variance() {
        let sizes = [[64, 64], [32, 32], [16, 16], [8, 8], [4, 4], [2, 2], [1, 1]];
        let flat = Detail::new(&sizes, [Wrap::Repeat; 2], |_, _, out| out.fill([3.0; 4]));
        let flat = flat.expect("no interruption");
        assert_eq!(flat.at(2, 10.0, 60.0), 0.0);
        // A checker of single texels: level 1 is grey, and each texel is one away from it.
        let checker = |l: usize, y: i64, out: &mut [[f32; 4]]| {
            for (x, texel) in (-1..).zip(out) {
                *texel = [if l == 0 { ((x + y) & 1) as f32 * 2.0 } else { 1.0 }, 0.0, 0.0, 0.0];
            }
        };
        let made = Detail::new(&sizes, [Wrap::Repeat; 2], checker).expect("no interruption");
        for level in 0..6 {
            assert_eq!(made.at(level, 33.0, 1.0), 0.25f32.powi(level as i32), "level {level}");
        }
    }
}
