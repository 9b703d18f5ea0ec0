//! How far a texture strays from planes: square blocks of the bilinear reconstruction, each with its mean, the slopes of
//! a plane through it and the largest distance from that plane.
//!
//! With texel centres on whole numbers, cell `k` of an axis lies between texels `k` and `k + 1`. The blocks of level `l`
//! have `2^l` by `2^l` cells, from cell [`FIRST`] on, so that the texels on both sides of every edge are in, wrapped as
//! the texture is. Level [`FINEST`] is made from texels: the mean is the exact integral, the slopes are the least
//! squares' over the block's texels, and because the reconstruction is bilinear between texels, none of it strays
//! further than the farthest texel. Each coarser level is made from four blocks: their means, differences of these,
//! and at the corners the distance of planes plus what a block strays itself.
//!
//! Cost: 64 bytes a block of 64 texels, a third more for the coarser levels; one pass over the texels.

use crate::error::Result;
use crate::par;
use crate::wrap::Wrap;

/// The first cell of the first block, along both axes.
pub const FIRST: i64 = -2;
/// The finest level: cells on a side, as a power of two.
pub const FINEST: u32 = 3;
/// Cells on a side of a finest block.
const SIDE: usize = 1 << FINEST;
/// More than what rounding takes from a bound in singles, relatively.
const OUTWARD: f64 = 1.0 + 1e-6;

/// A block: up to four channels, as they are averaged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// The mean; the plane's height at the centre.
    pub mean: [f32; 4],
    /// The plane's slopes along x and y, a texel.
    pub slope: [[f32; 4]; 2],
    /// Nothing in the block is farther from the plane than this.
    pub stray: [f32; 4],
}

impl Block {
    /// The plane at (x, y) from the block's centre.
    #[inline(always)]
    pub fn plane(&self, x: f64, y: f64) -> [f64; 4] {
        std::array::from_fn(|c| {
            f64::from(self.mean[c]) + x * f64::from(self.slope[0][c]) + y * f64::from(self.slope[1][c])
        })
    }
}

/// The blocks of one size.
#[derive(Debug)]
struct Grid {
    columns: usize,
    rows: usize,
    blocks: Vec<Block>,
}

/// All blocks of one group of channels.
#[derive(Debug)]
pub struct Bounds {
    grids: Vec<Grid>,
    /// Cells along both axes.
    cells: [i64; 2],
    /// The mean of one period of the reconstruction along periodic axes; of all texels along others.
    pub mean: [f64; 4],
    /// No texel is farther from the mean than this.
    pub stray: f64,
    /// The largest absolute value of a texel.
    pub largest: f64,
    /// Whether all texels are finite.
    pub is_finite: bool,
}

impl Bounds {
    /// Blocks of a texture of `size` texels; `texel(x, y)` is called with places from [`FIRST`] on, wrapped already
    /// by the caller.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`].
    pub fn new(
        size: [usize; 2],
        wrap: [Wrap; 2],
        texel: impl Fn(i64, i64) -> [f64; 4] + Sync,
    ) -> Result<Self> {
        // Cells FIRST ..= n.
        let cells = size.map(|n| n as i64 + 1 - FIRST);
        let [columns, rows] = cells.map(|n| (n as usize).div_ceil(SIDE));
        let mut blocks = vec![Block::default(); columns * rows];
        par::for_each(blocks.chunks_mut(columns), |j, row| {
            for (i, block) in row.iter_mut().enumerate() {
                let at = [i, j].map(|k| (k * SIDE) as i64 + FIRST);
                *block = finest(at, &texel);
            }
            Ok(())
        })?;
        let mut grids = vec![Grid { columns, rows, blocks }];
        let mut half = SIDE as f64 / 2.0;
        while let Some(fine) = grids.last().filter(|g| g.columns > 1 || g.rows > 1) {
            grids.push(coarser(fine, half));
            half *= 2.0;
        }
        let mut made = Self { grids, cells, mean: [0.0; 4], stray: 0.0, largest: 0.0, is_finite: true };
        made.whole(size, wrap, &texel);
        Ok(made)
    }

    /// Mean, largest distance from it and largest value.
    fn whole(&mut self, size: [usize; 2], wrap: [Wrap; 2], texel: &impl Fn(i64, i64) -> [f64; 4]) {
        let weight = |axis: usize, i: usize| {
            let n = size[axis];
            let at_end = n > 1 && (i == 0 || i + 1 == n);
            if wrap[axis] == Wrap::Mirror101 && at_end { 0.5 } else { 1.0 }
        };
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let w = weight(0, x) * weight(1, y);
                total += w;
                for (c, value) in texel(x as i64, y as i64).into_iter().enumerate() {
                    sum[c] += w * value;
                    low[c] = low[c].min(value);
                    high[c] = high[c].max(value);
                    self.is_finite &= value.is_finite();
                }
            }
        }
        // Texels around the texture too: the border colour, the extra ones.
        for y in FIRST..size[1] as i64 + 2 {
            let across = y < 0 || y >= size[1] as i64;
            let columns = if across { FIRST..size[0] as i64 + 2 } else { FIRST..0 };
            let others = if across { 0..0 } else { size[0] as i64..size[0] as i64 + 2 };
            for x in columns.chain(others) {
                for (c, value) in texel(x, y).into_iter().enumerate() {
                    low[c] = low[c].min(value);
                    high[c] = high[c].max(value);
                    self.is_finite &= value.is_finite();
                }
            }
        }
        self.mean = sum.map(|s| s / total);
        for c in 0..4 {
            self.stray = self.stray.max(high[c] - self.mean[c]).max(self.mean[c] - low[c]);
            self.largest = self.largest.max(high[c].abs()).max(low[c].abs());
        }
    }

    /// The coarsest level.
    pub fn coarsest(&self) -> u32 {
        FINEST + self.grids.len() as u32 - 1
    }

    /// The block at a place of a level's grid; the nearest where there is none.
    #[inline(always)]
    pub fn block(&self, level: u32, i: i64, j: i64) -> &Block {
        let grid = &self.grids[(level - FINEST) as usize];
        let i = i.clamp(0, grid.columns as i64 - 1) as usize;
        let j = j.clamp(0, grid.rows as i64 - 1) as usize;
        &grid.blocks[j * grid.columns + i]
    }

    /// Whether the block's whole square is described, not only what part of it the texture has.
    #[inline(always)]
    pub fn is_complete(&self, level: u32, i: i64, j: i64) -> bool {
        level == FINEST || ((i + 1) << level <= self.cells[0] && (j + 1) << level <= self.cells[1])
    }

    /// Bytes of the blocks.
    pub fn nbytes(&self) -> usize {
        self.grids.iter().map(|g| size_of_val(g.blocks.as_slice())).sum()
    }
}

/// A block of the finest level, its first cell at `at`.
fn finest(at: [i64; 2], texel: &impl Fn(i64, i64) -> [f64; 4]) -> Block {
    const TEXELS: usize = SIDE + 1;
    let mut values = [[0.0f64; 4]; TEXELS * TEXELS];
    let mut mean = [0.0; 4];
    let mut slope = [[0.0; 4]; 2];
    for y in 0..TEXELS {
        let row = if y == 0 || y == SIDE { 0.5 } else { 1.0 };
        for x in 0..TEXELS {
            let weight = if x == 0 || x == SIDE { 0.5 * row } else { row };
            let value = texel(at[0] + x as i64, at[1] + y as i64);
            values[y * TEXELS + x] = value;
            let from = [x, y].map(|k| k as f64 - SIDE as f64 / 2.0);
            for c in 0..4 {
                mean[c] += weight * value[c];
                slope[0][c] += from[0] * value[c];
                slope[1][c] += from[1] * value[c];
            }
        }
    }
    // The sum of squares of -4..=4, in nine rows.
    const SQUARES: f64 = 60.0 * TEXELS as f64;
    let mean = mean.map(|m| (m / (SIDE * SIDE) as f64) as f32);
    let slope = slope.map(|s| s.map(|s| (s / SQUARES) as f32));
    let mut block = Block { mean, slope, stray: [0.0; 4] };
    let mut stray = [0.0f64; 4];
    for (k, value) in values.iter().enumerate() {
        let [x, y] = [k % TEXELS, k / TEXELS].map(|k| k as f64 - SIDE as f64 / 2.0);
        let plane = block.plane(x, y);
        for c in 0..4 {
            let off = (value[c] - plane[c]).abs();
            stray[c] = if off <= stray[c] { stray[c] } else { off };
        }
    }
    block.stray = outward(stray);
    block
}

/// Bounds in singles that are no smaller; what is not finite becomes infinite.
fn outward(stray: [f64; 4]) -> [f32; 4] {
    stray.map(|s| if s.is_finite() { (s * OUTWARD) as f32 } else { f32::INFINITY })
}

/// The next level; `half` is half the side of the finer one's blocks, in texels.
fn coarser(fine: &Grid, half: f64) -> Grid {
    let (columns, rows) = (fine.columns.div_ceil(2), fine.rows.div_ceil(2));
    let mut blocks = Vec::with_capacity(columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let has = [2 * i + 1 < fine.columns, 2 * j + 1 < fine.rows];
            let child = |dx: usize, dy: usize| &fine.blocks[(2 * j + dy) * fine.columns + 2 * i + dx];
            let present: Vec<(usize, usize)> = [(0, 0), (1, 0), (0, 1), (1, 1)]
                .into_iter()
                .filter(|(dx, dy)| (*dx == 0 || has[0]) && (*dy == 0 || has[1]))
                .collect();
            let average = |f: &dyn Fn(&Block, f64, f64) -> f64| {
                let sum: f64 = present.iter().map(|&(dx, dy)| f(child(dx, dy), sign(dx), sign(dy))).sum();
                sum / present.len() as f64
            };
            let slope: [[f32; 4]; 2] = std::array::from_fn(|axis| {
                std::array::from_fn(|c| {
                    let value = if has[axis] {
                        average(&|b, x, y| f64::from(b.mean[c]) * if axis == 0 { x } else { y }) / half
                    } else {
                        average(&|b, _, _| f64::from(b.slope[axis][c]))
                    };
                    value as f32
                })
            });
            // Where a half is missing the mean of the other is not at the centre.
            let mean: [f32; 4] = std::array::from_fn(|c| {
                average(&|b, x, y| {
                    let off = |axis: usize, side: f64| {
                        if has[axis] { 0.0 } else { side * half * f64::from(slope[axis][c]) }
                    };
                    f64::from(b.mean[c]) - off(0, x) - off(1, y)
                }) as f32
            });
            let mut block = Block { mean, slope, stray: [0.0; 4] };
            let mut stray = [0.0f64; 4];
            for &(dx, dy) in &present {
                let b = child(dx, dy);
                let plane = block.plane(sign(dx) * half, sign(dy) * half);
                for c in 0..4 {
                    let tilt = |axis: usize| {
                        half * (f64::from(b.slope[axis][c]) - f64::from(block.slope[axis][c])).abs()
                    };
                    let off =
                        (f64::from(b.mean[c]) - plane[c]).abs() + tilt(0) + tilt(1) + f64::from(b.stray[c]);
                    stray[c] = if off <= stray[c] { stray[c] } else { off };
                }
            }
            block.stray = outward(stray);
            blocks.push(block);
        }
    }
    Grid { columns, rows, blocks }
}

/// Which way a half lies from the middle.
fn sign(half: usize) -> f64 {
    if half == 0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(x: i64, y: i64) -> [f64; 4] {
        let h = (x.wrapping_mul(0x9E37_79B9) ^ y.wrapping_mul(0x85EB_CA6B)).wrapping_mul(0xC2B2_AE35);
        let v = |k: u32| ((h >> k) & 255) as f64;
        [v(3), v(11), v(19), 255.0]
    }

    #[test]
    fn nothing_strays_further_than_it_says() {
        for (w, h) in [(1usize, 1usize), (5, 40), (37, 23), (64, 64)] {
            let texel = |x: i64, y: i64| noise(x.rem_euclid(w as i64), y.rem_euclid(h as i64));
            let made = Bounds::new([w, h], [Wrap::Repeat; 2], texel).expect("no interruption");
            assert!(made.is_finite);
            for level in FINEST..=made.coarsest() {
                let side = 1i64 << level;
                for y in FIRST..=h as i64 {
                    for x in FIRST..=w as i64 {
                        // The texel at a block's far edge belongs to both.
                        let (i, j) = ((x - FIRST) / side, (y - FIRST) / side);
                        let block = made.block(level, i, j);
                        let from = |at: i64, k: i64| (at - FIRST - k * side) as f64 - side as f64 / 2.0;
                        let plane = block.plane(from(x, i), from(y, j));
                        for (c, value) in texel(x, y).into_iter().enumerate() {
                            assert!((value - plane[c]).abs() <= f64::from(block.stray[c]) * 1.000_001);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn ramps_are_planes_and_means_are_integrals() {
        let ramp = |x: i64, y: i64| [0.5 * x as f64, -0.25 * y as f64, x as f64 + y as f64, 7.0];
        let made = Bounds::new([61, 61], [Wrap::Clamp; 2], ramp).expect("no interruption");
        let root = made.block(made.coarsest(), 0, 0);
        assert!(root.stray.iter().all(|s| *s < 1e-4), "{root:?}");
        assert_eq!(root.slope[0], [0.5, 0.0, 1.0, 0.0]);
        // 64 cells from -2 on: the middle is at 30.
        assert_eq!(root.mean, [15.0, -7.5, 60.0, 7.0]);
    }
}
