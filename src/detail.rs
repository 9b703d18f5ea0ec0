//! How much a texture changes from level to level of its pyramid, and where: what predicts the error of a filter.
//!
//! `delta_l^2` is the mean squared difference of level `l` from level `l + 1`, interpolated: what a coarser level lacks.
//! A texel of level `l` is a mean of finer ones and lacks a share of what they lack: with `lost_0 = 0` and
//! `lost_(l+1) = (lost_l + delta_l^2)/4`, `lost_l` is the variance of what a texel of level `l` does not show of the
//! texture below it, were it sampled at random. What is asked for is `V_l = lost_l + delta_l^2`, the largest of the
//! channels, around a footprint: its mean over a piece of the texture about as large.
//!
//! So there is a grid for every size of footprint. The cells of grid `r`, from 1 on, are 2 x 2 texels of level `r`, and each
//! holds `V_0` to `V_r`, side by side: one look-up finds all levels. Between the centres of cells, and between grids, they
//! are interpolated, so that what follows from them is continuous.
//!
//! Cost: 0.4 bytes a texel of level 0; one pass over the levels.

use crate::error::Result;
use crate::num::floor;
use crate::par;
use crate::wrap::Wrap;

/// More levels than any texture has.
pub const LEVELS: usize = 48;

/// Cells for footprints of one size.
#[derive(Debug)]
struct Grid {
    columns: usize,
    rows: usize,
    /// Numbers of a cell.
    depth: usize,
    /// The upper halves of singles.
    variance: Vec<u16>,
}

impl Grid {
    fn cell(&self, column: usize, row: usize) -> &[u16] {
        &self.variance[(row * self.columns + column) * self.depth..][..self.depth]
    }
}

/// What each level lacks, in the square of the unit of averages.
#[derive(Debug)]
pub struct Detail {
    /// From grid 1 on.
    grids: Vec<Grid>,
    /// Texels of level 0 along both axes.
    size: [f64; 2],
    wrap: [Wrap; 2],
}

impl Detail {
    /// Of levels of these sizes; `row(l, y, out)` gives the texels of row `y` of level `l`, wrapped, from column -1 to one
    /// beyond the last; `y` is as far outside as these.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub fn new(
        sizes: &[[usize; 2]],
        wrap: [Wrap; 2],
        row: impl Fn(usize, i64, &mut [[f32; 4]]) + Sync,
    ) -> Result<Self> {
        let mut grids: Vec<Grid> = Vec::with_capacity(sizes.len());
        let lack = |level: usize, cells: [usize; 2]| {
            sizes.get(level + 1).map(|coarse| Lack::new(level, sizes[level], *coarse, cells))
        };
        for level in 1..sizes.len().max(2) {
            let size = sizes.get(level).copied().unwrap_or([1, 1]);
            let [columns, rows] = size.map(|n| n.div_ceil(2));
            let depth = level + 1;
            let first = if level == 1 { lack(0, [columns, rows]) } else { None };
            let own = lack(level, [columns, rows]);
            let mut variance = vec![0u16; columns * rows * depth];
            let finer = grids.last();
            par::for_each(variance.chunks_mut(columns * depth), |j, codes| {
                let mut cells = vec![0.0f32; codes.len()];
                if let Some(finer) = finer {
                    for (i, cell) in cells.chunks_exact_mut(depth).enumerate() {
                        mean(finer, [i, j], [columns, rows], &mut cell[..level]);
                    }
                }
                let mut lacking = vec![0.0; columns];
                if let Some(first) = &first {
                    first.cells(&row, j, &mut lacking);
                    cells.iter_mut().step_by(depth).zip(&lacking).for_each(|(v, delta)| *v = sound(*delta));
                }
                lacking.fill(0.0);
                if let Some(own) = &own {
                    own.cells(&row, j, &mut lacking);
                }
                for (cell, delta) in cells.chunks_exact_mut(depth).zip(&lacking) {
                    cell[level] = sound(0.25 * cell[level - 1] + delta);
                }
                codes.iter_mut().zip(cells).for_each(|(code, cell)| *code = halved(cell));
                Ok(())
            })?;
            grids.push(Grid { columns, rows, depth, variance });
        }
        let size = sizes.first().map_or([1.0; 2], |s| s.map(|n| n as f64));
        Ok(Self { grids, size, wrap })
    }

    /// The variances of all levels from 0 to beyond `lambda` around (s, t), texels of level 0 (reduced to where the texture is),
    /// for a footprint `2^lambda` texels long. `lambda` is not negative; levels that there are not have the coarsest's.
    #[inline(always)]
    pub fn around(&self, lambda: f32, [s, t]: [f64; 2], found: &mut [f32; LEVELS]) {
        let last = self.grids.len();
        let whole = lambda as usize;
        let (grid, part) = if whole == 0 { (1, 0.0) } else { (whole, lambda - whole as f32) };
        let (grid, part) = if grid < last { (grid, part) } else { (last, 0.0) };
        self.at(grid, [s, t], found);
        if part > 0.0 {
            let mut wider = [0.0; LEVELS];
            self.at(grid + 1, [s, t], &mut wider);
            for (found, wider) in found.iter_mut().zip(wider).take(grid + 1) {
                *found += part * (wider - *found);
            }
            found[grid + 1] = wider[grid + 1];
        } else if grid + 1 < LEVELS {
            found[grid + 1] = found[grid];
        }
    }

    /// The numbers of a grid at a place.
    #[inline(always)]
    fn at(&self, grid: usize, [s, t]: [f64; 2], found: &mut [f32; LEVELS]) {
        let grid = &self.grids[grid - 1];
        let (x, fx) = self.cell(0, s, grid.columns);
        let (y, fy) = self.cell(1, t, grid.rows);
        let corners =
            [grid.cell(x[0], y[0]), grid.cell(x[1], y[0]), grid.cell(x[0], y[1]), grid.cell(x[1], y[1])];
        let numbers = corners[0].iter().zip(corners[1]).zip(corners[2].iter().zip(corners[3]));
        for (found, ((a, b), (c, d))) in found.iter_mut().zip(numbers) {
            let [a, b, c, d] = [*a, *b, *c, *d].map(whole);
            let (above, below) = (a + fx * (b - a), c + fx * (d - c));
            *found = above + fy * (below - above);
        }
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

/// The largest number that is kept: three quarters of the largest single.
const MOST: f32 = f32::from_bits(0x7f40_0000);

/// What is not finite needs all the care there is.
fn sound(variance: f32) -> f32 {
    if variance <= MOST { variance } else { MOST }
}

/// The upper half of a number that is not negative, rounded up: eight bits of precision are plenty.
fn halved(x: f32) -> u16 {
    ((x.to_bits() + 0xffff) >> 16) as u16
}

#[inline(always)]
fn whole(half: u16) -> f32 {
    f32::from_bits(u32::from(half) << 16)
}

/// The means of a finer grid's cells under a cell of a grid of `size`.
fn mean(fine: &Grid, cell: [usize; 2], size: [usize; 2], means: &mut [f32]) {
    let span = |k: usize, n: usize, fine: usize| {
        let first = k * fine / n;
        (first, ((k + 1) * fine).div_ceil(n).clamp(first + 1, fine))
    };
    let (x0, x1) = span(cell[0], size[0], fine.columns);
    let (y0, y1) = span(cell[1], size[1], fine.rows);
    let share = 1.0 / ((x1 - x0) * (y1 - y0)) as f32;
    for y in y0..y1 {
        for x in x0..x1 {
            means.iter_mut().zip(fine.cell(x, y)).for_each(|(mean, v)| *mean += share * whole(*v));
        }
    }
}

/// What a level has that the next one lacks.
struct Lack {
    level: usize,
    size: [usize; 2],
    coarse: [usize; 2],
    /// Cells along both axes.
    cells: [usize; 2],
    /// For each column: the coarser texel left of it, counted from the one before the first, and how far it is on the way to
    /// the next.
    columns: Vec<(u32, f32)>,
}

impl Lack {
    fn new(level: usize, size: [usize; 2], coarse: [usize; 2], cells: [usize; 2]) -> Self {
        let columns = (0..size[0]).map(|x| {
            let (i, part) = between(x, size[0], coarse[0]);
            ((i + 1) as u32, part)
        });
        Self { level, size, coarse, cells, columns: columns.collect() }
    }

    /// The mean squared differences of a row of cells, the largest of the channels.
    fn cells(&self, row: &impl Fn(usize, i64, &mut [[f32; 4]]), j: usize, cells: &mut [f32]) {
        let ([w, h], [columns, rows]) = (self.size, self.cells);
        let mut fine = vec![[0.0; 4]; w + 2];
        let [mut above, mut below, mut middle] = [0; 3].map(|_| vec![[0.0f32; 4]; self.coarse[0] + 2]);
        let mut squares = vec![[0.0f32; 4]; w];
        let mut held = None;
        for y in span(j, h, rows) {
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
            let across = span(i, w, columns);
            let count = (across.len() * span(j, h, rows).len()) as f32;
            let mut sum = [0.0f32; 4];
            for square in &squares[across] {
                for c in 0..4 {
                    sum[c] += square[c];
                }
            }
            // What is no number is the largest.
            *cell = sum.into_iter().fold(0.0, |a: f32, s| if s <= a { a } else { s }) / count;
        }
    }
}

/// The texels, of `n`, of cell `k` of so many. As many from one end as from the other: a mirrored texture has the mirrored
/// table.
fn span(k: usize, n: usize, cells: usize) -> std::ops::Range<usize> {
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
        let mut found = [1.0; LEVELS];
        flat.around(2.5, [10.0, 60.0], &mut found);
        assert_eq!(found[..5], [0.0, 0.0, 0.0, 0.0, 1.0]);
        // A checker of single texels: level 1 is grey, and each texel is one away from it.
        let checker = |l: usize, y: i64, out: &mut [[f32; 4]]| {
            for (x, texel) in (-1..).zip(out) {
                *texel = [if l == 0 { ((x + y) & 1) as f32 * 2.0 } else { 1.0 }, 0.0, 0.0, 0.0];
            }
        };
        let made = Detail::new(&sizes, [Wrap::Repeat; 2], checker).expect("no interruption");
        for lambda in [0.0, 0.7, 1.0, 2.5, 5.75] {
            made.around(lambda, [33.0, 1.0], &mut found);
            for level in 0..=lambda as i32 {
                assert_eq!(found[level as usize], 0.25f32.powi(level), "level {level} of {lambda}");
            }
        }
    }

    /// Where one half of a texture is flat and the other noise, small footprints see one of them, large ones the mean.
    #[test]
    fn small_footprints_see_what_is_near_and_large_ones_all() {
        let sizes = [[64, 64], [32, 32], [16, 16], [8, 8], [4, 4], [2, 2], [1, 1]];
        let half = |l: usize, y: i64, out: &mut [[f32; 4]]| {
            for (x, texel) in (-1i64..).zip(out) {
                let noisy = l == 0 && x.rem_euclid(64) >= 32;
                *texel = [if noisy { ((x + y) & 1) as f32 * 2.0 } else { 1.0 }; 4];
            }
        };
        let made = Detail::new(&sizes, [Wrap::Repeat; 2], half).expect("no interruption");
        let mut found = [0.0; LEVELS];
        let mut at = |lambda, s| {
            made.around(lambda, [s, 20.0], &mut found);
            found[0]
        };
        assert_eq!((at(1.0, 10.0), at(1.0, 50.0)), (0.0, 1.0));
        assert_eq!((at(6.0, 10.0), at(6.0, 50.0)), (0.5, 0.5));
        assert!(made.nbytes() < 64 * 64);
    }
}
