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
    /// Cells of levels of these sizes; `texel(l, x, y)` is a texel of level `l` from -1 to one beyond the last, wrapped.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub fn new(
        sizes: &[[usize; 2]],
        wrap: [Wrap; 2],
        texel: impl Fn(usize, i64, i64) -> [f64; 4] + Sync,
    ) -> Result<Self> {
        let mut grids: Vec<Grid> = Vec::with_capacity(sizes.len());
        for (level, &[w, h]) in sizes.iter().enumerate() {
            let [columns, rows] = [w, h].map(|n| n.div_ceil(CELL));
            let mut variance = vec![0.0f32; columns * rows];
            let finer = grids.last();
            let coarser = sizes.get(level + 1).copied();
            par::for_each(variance.chunks_mut(columns), |j, row| {
                for (i, cell) in row.iter_mut().enumerate() {
                    let lost = finer.map_or(0.0, |g| 0.25 * mean(g, [i, j], [columns, rows]));
                    let delta = coarser.map_or(0.0, |size| delta(level, [w, h], size, [i, j], &texel));
                    // What is not finite needs all the care there is.
                    let sum = lost + delta;
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

/// The mean squared difference of a cell's texels from the next level, the largest of the channels.
fn delta(
    level: usize,
    [w, h]: [usize; 2],
    coarse: [usize; 2],
    cell: [usize; 2],
    texel: &impl Fn(usize, i64, i64) -> [f64; 4],
) -> f64 {
    let scale = [coarse[0] as f64 / w as f64, coarse[1] as f64 / h as f64];
    // As many texels from one end as from the other: a mirrored texture has the mirrored table.
    let span = |k: usize, n: usize| {
        let cells = n.div_ceil(CELL);
        (k * n / cells) as i64..((k + 1) * n).div_ceil(cells) as i64
    };
    let place = |k: i64, axis: usize| {
        let x = (k as f64 + 0.5) * scale[axis] - 0.5;
        (floor(x), x - floor(x) as f64)
    };
    // The coarser texels around the cell, once.
    let corner = [0, 1].map(|axis| place(span(cell[axis], [w, h][axis]).start, axis).0);
    const AROUND: usize = CELL + 4;
    let reach: [usize; 2] = [0, 1].map(|axis| {
        let last = span(cell[axis], [w, h][axis]).end - 1;
        ((place(last, axis).0 + 1 - corner[axis]).max(0) as usize + 1).min(AROUND)
    });
    let mut around = [[[0.0f64; 4]; AROUND]; AROUND];
    for (y, row) in around.iter_mut().enumerate().take(reach[1]) {
        for (x, slot) in row.iter_mut().enumerate().take(reach[0]) {
            *slot = texel(level + 1, corner[0] + x as i64, corner[1] + y as i64);
        }
    }
    let mut sum = [0.0; 4];
    let mut count = 0.0;
    for y in span(cell[1], h) {
        let (j, fy) = place(y, 1);
        let j = (j - corner[1]) as usize;
        for x in span(cell[0], w) {
            let (i, fx) = place(x, 0);
            let i = (i - corner[0]) as usize;
            let fine = texel(level, x, y);
            count += 1.0;
            for c in 0..4 {
                let line = |j: usize| around[j][i][c] + fx * (around[j][i + 1][c] - around[j][i][c]);
                let off = fine[c] - (line(j) + fy * (line(j + 1) - line(j)));
                sum[c] += off * off;
            }
        }
    }
    sum.into_iter().fold(0.0, |a: f64, s| if s <= a { a } else { s }) / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_is_nothing_and_noise_is_its_variance() {
        let sizes = [[64, 64], [32, 32], [16, 16], [8, 8], [4, 4], [2, 2], [1, 1]];
        let flat = Detail::new(&sizes, [Wrap::Repeat; 2], |_, _, _| [3.0; 4]).expect("no interruption");
        assert_eq!(flat.at(2, 10.0, 60.0), 0.0);
        // A checker of single texels: level 1 is grey, and each texel is one away from it.
        let checker = |l: usize, x: i64, y: i64| {
            let value = if l == 0 { ((x + y) & 1) as f64 * 2.0 } else { 1.0 };
            [value, 0.0, 0.0, 0.0]
        };
        let made = Detail::new(&sizes, [Wrap::Repeat; 2], checker).expect("no interruption");
        for level in 0..6 {
            assert_eq!(made.at(level, 33.0, 1.0), 0.25f32.powi(level as i32), "level {level}");
        }
    }
}
