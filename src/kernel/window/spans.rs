//! Weights by integrals along rows.

use super::soft::ramp;
use super::{CHUNK, Lanes, Mean, Source, Sum};
use crate::num::{ceil, floor};

/// Longest row, in texels.
pub const LONGEST: usize = 128;

/// Half the distance of the Gauss points, in half pieces.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Part of a footprint between two heights, relative to its centre, with straight sides.
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    /// Bottom and top.
    pub y: [f64; 2],
    /// Left side at the bottom and at the top.
    pub left: [f64; 2],
    /// Right side, likewise.
    pub right: [f64; 2],
}

/// A footprint cut where its sides bend, at rows of texel centres, and then evenly so that no side moves by more than a
/// texel on a piece. Of each piece two Gauss points; at each, texel i weighs `S(right - i) - S(left - i)`, shared by the two
/// rows around it, with the integral of the tent `S(z) = 1/2 + c (1 - |c|/2)`, `c = clamp(z, -1, 1)`.
///
/// The quadrature is exact but where a side crosses a column within a piece, and there the integrand bends gently.
#[derive(Clone, Copy, Debug)]
pub struct Spans<'a> {
    /// In texels, the centre of texel (0, 0) at 0.
    pub centre: [f64; 2],
    /// Upwards; some may have no height. Together at most [`LONGEST`] - 4 texels wide.
    pub slabs: &'a [Slab],
}

/// The two rows of texels that a piece of a footprint lies between, under construction.
trait Pair<L> {
    /// Adds weights: those of a row that runs from `left` to `right`, in texels from the first, times `height`; the upper row
    /// gets `share` of them.
    fn add(&mut self, left: f64, right: f64, height: L, share: L);
    /// Adds the lower row, which is `row`, to the sum; the upper one becomes the lower.
    fn next<S: Source>(&mut self, row: i64, source: &mut S, sum: &mut Sum<L>);
}

/// Eight weights from texel `at` on.
#[inline(always)]
fn weights<L: Lanes>(left: f64, right: f64, at: f64, height: L) -> L {
    let steps = L::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let to = L::splat((right - at) as f32).sub(steps);
    let from = L::splat((left - at) as f32).sub(steps);
    height.mul(ramp(to).sub(ramp(from)))
}

/// Rows of at most eight texels, from `base` on.
struct Narrow<L> {
    base: i64,
    lower: L,
    upper: L,
}

impl<L: Lanes> Pair<L> for Narrow<L> {
    #[inline(always)]
    fn add(&mut self, left: f64, right: f64, height: L, share: L) {
        let weights = weights(left, right, 0.0, height);
        let above = weights.mul(share);
        self.upper = self.upper.add(above);
        self.lower = self.lower.add(weights.sub(above));
    }

    #[inline(always)]
    fn next<S: Source>(&mut self, row: i64, source: &mut S, sum: &mut Sum<L>) {
        sum.add(source, row, self.base, self.lower);
        (self.lower, self.upper) = (self.upper, L::splat(0.0));
    }
}

/// A row of any length; touched: `start..end`.
#[derive(Clone)]
struct Row {
    weights: [f32; LONGEST + 3 * CHUNK],
    start: usize,
    end: usize,
}

impl Row {
    const EMPTY: Self = Self { weights: [0.0; LONGEST + 3 * CHUNK], start: usize::MAX, end: 0 };

    /// Eight weights from `at` on.
    #[inline(always)]
    fn chunk(&mut self, at: usize) -> Option<&mut [f32; CHUNK]> {
        self.weights.get_mut(at..at + CHUNK)?.try_into().ok()
    }

    #[inline(always)]
    fn add<L: Lanes>(&mut self, at: usize, weights: L) {
        if let Some(chunk) = self.chunk(at) {
            *chunk = L::load(chunk).add(weights).store();
        }
    }

    #[inline(always)]
    fn touch(&mut self, start: usize, end: usize) {
        self.start = self.start.min(start);
        self.end = self.end.max(end);
    }
}

/// Rows of any length, from `base` on.
struct Wide {
    base: i64,
    rows: [Row; 2],
    /// Which of them is the lower one.
    lower: usize,
}

impl<L: Lanes> Pair<L> for Wide {
    #[inline(always)]
    fn add(&mut self, left: f64, right: f64, height: L, share: L) {
        // `left` is at least 0: texels further left than its cell weigh nothing.
        let (first, last) = (left as usize, right as usize + 1);
        let [p, q] = &mut self.rows;
        let (lower, upper) = if self.lower == 0 { (p, q) } else { (q, p) };
        let mut at = first;
        while at <= last {
            let weights = weights(left, right, at as f64, height);
            let above = weights.mul(share);
            upper.add(at, above);
            lower.add(at, weights.sub(above));
            at += CHUNK;
        }
        lower.touch(first, last + 1);
        upper.touch(first, last + 1);
    }

    #[inline(always)]
    fn next<S: Source>(&mut self, row: i64, source: &mut S, sum: &mut Sum<L>) {
        let lower = &mut self.rows[self.lower];
        let mut at = lower.start;
        while at < lower.end {
            if let Some(chunk) = lower.chunk(at) {
                let weights = L::load(chunk);
                *chunk = [0.0; CHUNK];
                sum.add(source, row, self.base + at as i64, weights);
            }
            at += CHUNK;
        }
        (lower.start, lower.end) = (usize::MAX, 0);
        self.lower = 1 - self.lower;
    }
}

impl Mean for Spans<'_> {
    #[inline(always)]
    fn over<L: Lanes, S: Source>(&self, source: S) -> [f32; 4] {
        let (mut left, mut right) = (f64::MAX, f64::MIN);
        for slab in self.slabs {
            left = left.min(slab.left[0].min(slab.left[1]));
            right = right.max(slab.right[0].max(slab.right[1]));
        }
        let base = floor(self.centre[0] + left);
        if floor(self.centre[0] + right) + 2 - base <= CHUNK as i64 {
            let pair = Narrow { base, lower: L::splat(0.0), upper: L::splat(0.0) };
            self.by::<L, S, _>(base, pair, source)
        } else {
            // One further left, for what its rounding may do.
            let base = base - 1;
            let pair = Wide { base, rows: [Row::EMPTY; 2], lower: 0 };
            self.by::<L, S, _>(base, pair, source)
        }
    }
}

impl Spans<'_> {
    #[inline(always)]
    fn by<L: Lanes, S: Source, P: Pair<L>>(&self, base: i64, mut pair: P, mut source: S) -> [f32; 4] {
        let (x0, y0) = (self.centre[0] - base as f64, self.centre[1]);
        let mut sum = Sum::<L>::new();
        let mut row = None;
        for slab in self.slabs.iter().filter(|s| s.y[1] > s.y[0]) {
            let [bottom, top] = slab.y;
            let inverse = 1.0 / (top - bottom);
            let slope = [(slab.left[1] - slab.left[0]) * inverse, (slab.right[1] - slab.right[0]) * inverse];
            let steepest = slope[0].abs().max(slope[1].abs());
            let mut from = bottom;
            let mut cell = floor(y0 + from);
            while from < top {
                let to = top.min((cell + 1) as f64 - y0);
                if row.is_some_and(|row| row < cell) {
                    pair.next(cell - 1, &mut source, &mut sum);
                }
                row = Some(cell);
                let pieces = ceil(steepest * (to - from)).max(1);
                let half = if pieces == 1 { 0.5 * (to - from) } else { 0.5 * (to - from) / pieces as f64 };
                let height = L::splat(half as f32);
                for piece in 0..pieces {
                    let middle = from + half * (2 * piece + 1) as f64;
                    for node in [-GAUSS, GAUSS] {
                        let y = middle + half * node;
                        let share = L::splat((y0 + y - cell as f64) as f32);
                        let left = x0 + slab.left[0] + slope[0] * (y - bottom);
                        let right = x0 + slab.right[0] + slope[1] * (y - bottom);
                        pair.add(left, right, height, share);
                    }
                }
                from = to.max(from);
                cell += 1;
            }
        }
        if let Some(row) = row {
            pair.next(row, &mut source, &mut sum);
            pair.next(row + 1, &mut source, &mut sum);
        }
        sum.mean()
    }
}
