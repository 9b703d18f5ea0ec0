//! Means of the bilinear picture over boxes of up to two texels: four by four taps.
//!
//! The mean over [x - h, x + h] x [y - k, y + k] is a weighted sum of 4 x 4 texels whose weights are products. Along an
//! axis, for a box whose middle is `d` past texel 0, 0 <= d < 1 and h <= 1, the integrals of the tents are
//!
//! ```text
//! w(-1) = max(0, h - d)^2 / 4h        w(2) = max(0, d + h - 1)^2 / 4h
//! w(1)  = d + w(-1) - 2 w(2)          w(0) = 1 - w(-1) - w(1) - w(2)
//! ```
//!
//! since weights of all texels sum to 1 and their first moment is `d`. Texel 0 is the base: what is summed are the others'
//! differences from it, first down the columns, then along the row, so that equal texels give exactly their value:
//!
//! ```text
//! b + (((a - b) w(-1) + (c - b) w(1)) + (e - b) w(2))
//! ```
//!
//! An upright box has no covariance of columns and rows; a footprint that leans has some, `c`. To first order in it the mean
//! gains `c` times the second derivative across, which is a product again, of the weights' derivatives by `d`:
//!
//! ```text
//! w'(-1) = -max(0, h - d) / 2h        w'(2) = max(0, d + h - 1) / 2h        w'(1) = 1 + w'(-1) - 2 w'(2)
//! ```
//!
//! Bytes of up to four channels are summed in 16 bits: texels in units of 1/128, weights of 1/32768, each product
//! rounded to nearest; everything else as numbers, never fused.

#![allow(clippy::needless_range_loop, reason = "several arrays are walked along together")]

#[cfg(target_arch = "x86_64")]
mod avx2;
mod bytes;
#[cfg(test)]
mod tests;

use super::sample::{Real, Sample};
use super::{Isa, Job};
use crate::error::{Error, Result};
use crate::kernel::{Work, compiled_for};
pub(super) use bytes::bytes;

/// Boxes that are worked on at once.
const CHUNK: usize = 64;
/// Texels a side of what a box reads.
const TAPS: usize = 4;
/// Elements of a row of texels that are read at once: four texels of up to four channels.
const ROW: usize = 16;
/// Covariances in texels squared: those that are left out, and the largest.
const LEAN: [f32; 2] = [0.025, 0.4];
/// Half the side of the smallest box, in texels; and that of the largest.
const HALF: [f32; 2] = [1.0 / 1024.0, 1.0];

/// A run of boxes.
#[derive(Clone, Copy, Debug)]
pub struct Boxes<'b> {
    /// Columns of the middles, in pixels of the source.
    pub x: &'b [f32],
    /// Rows of the middles.
    pub y: &'b [f32],
    /// Half the sides across and down: of the first box, and what each next one adds. Cut to at most 1.
    pub half: [[f32; 2]; 2],
    /// Covariance of columns and rows, likewise. Cut to at most 0.4.
    pub lean: [f32; 2],
}

/// Where the results go.
pub enum Out<'o, T: Sample> {
    /// Rounded to elements.
    Elements(&'o mut [T]),
    /// As they are.
    Numbers(&'o mut [T::Acc]),
}

impl<T: Sample> Out<'_, T> {
    fn len(&self) -> usize {
        match self {
            Self::Elements(out) => out.len(),
            Self::Numbers(out) => out.len(),
        }
    }

    #[inline(always)]
    fn put(&mut self, at: usize, value: T::Acc) {
        match self {
            Self::Elements(out) => out[at] = T::put(value),
            Self::Numbers(out) => out[at] = value,
        }
    }
}

/// Means over boxes, packed, rounded to elements. A box whose middle is not finite has no defined value. The
/// interpolation of the job is not read.
///
/// # Errors
/// [`Error::Value`] when the numbers of boxes and output pixels differ.
pub fn boxes<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    boxes: &Boxes<'_>,
    taps: &mut Taps,
    out: &mut [T],
) -> Result<()> {
    run(isa, job, boxes, taps, Out::Elements(out))
}

/// [`boxes`] as numbers.
///
/// # Errors
/// As [`boxes`].
pub fn box_numbers<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    boxes: &Boxes<'_>,
    taps: &mut Taps,
    out: &mut [T::Acc],
) -> Result<()> {
    run(isa, job, boxes, taps, Out::Numbers(out))
}

fn run<T: Sample>(
    isa: Isa,
    job: &Job<'_, T>,
    boxes: &Boxes<'_>,
    taps: &mut Taps,
    mut out: Out<'_, T>,
) -> Result<()> {
    let (count, channels) = (boxes.x.len(), job.source.channels);
    if boxes.y.len() != count || count.checked_mul(channels) != Some(out.len()) {
        let got = format!("{} elements for {count} columns and {} rows", out.len(), boxes.y.len());
        return Err(Error::value("out", got, "one pixel a box"));
    }
    for start in (0..count).step_by(CHUNK) {
        let n = CHUNK.min(count - start);
        taps.n = n;
        compiled_for(isa, Weigh { boxes, start, taps });
        let pixels = start * channels..(start + n) * channels;
        let out = match &mut out {
            Out::Elements(out) => Out::Elements(&mut out[pixels]),
            Out::Numbers(out) => Out::Numbers(&mut out[pixels]),
        };
        T::boxes(isa, job, taps, out);
    }
    Ok(())
}

/// First texels and weights of a chunk of boxes: room that every call uses anew.
pub struct Taps {
    /// Boxes in the chunk.
    n: usize,
    /// Whether any box leans.
    leans: bool,
    /// Column and row of texel 0 of each box.
    at: [[i32; CHUNK]; 2],
    /// `w(-1), w(1), w(2)` across and down; then their derivatives, those down times the covariance.
    weights: [[[f32; CHUNK]; 3]; 4],
    /// The same in units of 1/32768, twice in each number.
    words: [[[u32; CHUNK]; 3]; 4],
}

/// Indices into [`Taps::weights`].
const ACROSS: usize = 0;
const DOWN: usize = 1;
const SLOPE_ACROSS: usize = 2;
const SLOPE_DOWN: usize = 3;

impl Default for Taps {
    fn default() -> Self {
        Self {
            n: 0,
            leans: false,
            at: [[0; CHUNK]; 2],
            weights: [[[0.0; CHUNK]; 3]; 4],
            words: [[[0; CHUNK]; 3]; 4],
        }
    }
}

impl Taps {
    /// Some weights of box `i`.
    #[inline(always)]
    fn of<A: Real>(&self, which: usize, i: usize) -> [A; 3] {
        std::array::from_fn(|k| A::of(f64::from(self.weights[which][k][i])))
    }
}

struct Weigh<'w, 'b> {
    boxes: &'w Boxes<'b>,
    start: usize,
    taps: &'w mut Taps,
}

impl Work for Weigh<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { boxes, start, taps } = self;
        let n = taps.n;
        let [lean, grows] = boxes.lean;
        let lean = lean + grows * start as f32;
        let last_lean = lean + grows * n as f32;
        taps.leans = lean.abs() > LEAN[0] || last_lean.abs() > LEAN[0];
        let (weights, slopes) = taps.weights.split_at_mut(2);
        for (axis, at) in [boxes.x, boxes.y].into_iter().enumerate() {
            let at = &at[start..start + n];
            let whole = &mut taps.at[axis][..n];
            let [before, after, last] = &mut weights[axis];
            let (before, after, last) = (&mut before[..n], &mut after[..n], &mut last[..n]);
            let [first, step] = boxes.half[axis];
            let first = first + step * start as f32;
            for i in 0..n {
                let h = between(first + step * (i as i32) as f32, HALF);
                let floor = at[i].floor();
                let d = at[i] - floor;
                let share = 0.25 / h;
                let (left, right) = (above(h - d), above(d + h - 1.0));
                whole[i] = nearest(between(floor, PLACES));
                before[i] = left * left * share;
                last[i] = right * right * share;
                after[i] = d + before[i] - 2.0 * last[i];
            }
            if taps.leans {
                let [before, after, last] = &mut slopes[axis];
                let (before, after, last) = (&mut before[..n], &mut after[..n], &mut last[..n]);
                for i in 0..n {
                    let along = (i as i32) as f32;
                    let h = between(first + step * along, HALF);
                    let d = at[i] - at[i].floor();
                    let factor =
                        if axis == 0 { 1.0 } else { between(lean + grows * along, [-LEAN[1], LEAN[1]]) };
                    let share = 0.5 / h;
                    let (left, right) = (above(h - d) * share, above(d + h - 1.0) * share);
                    before[i] = -left * factor;
                    last[i] = right * factor;
                    after[i] = (1.0 - left - 2.0 * right) * factor;
                }
            }
        }
    }
}

/// 1.5 * 2^23: adding it to a number below 2^22 in size leaves the nearest integer in the low bits of the sum.
const ROUND: f32 = 12_582_912.0;
/// Places that are told apart, far beyond any picture whose places are singles.
const PLACES: [f32; 2] = [-4_194_303.0, 4_194_303.0];

/// The nearest integer of a number below 2^22 in size; unlike a cast it is one instruction for eight.
#[inline(always)]
fn nearest(x: f32) -> i32 {
    (x + ROUND).to_bits() as i32 - ROUND.to_bits() as i32
}

#[inline(always)]
fn above(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

#[inline(always)]
fn between(x: f32, [low, high]: [f32; 2]) -> f32 {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// Whether all boxes of a chunk are inside, as [`inside`] says for one.
fn all_inside<T>(job: &Job<'_, T>, taps: &Taps) -> bool {
    let s = &job.source;
    let ends = |axis: usize| {
        let at = &taps.at[axis][..taps.n];
        at.iter().fold([i32::MAX, i32::MIN], |[low, high], x| [low.min(*x), high.max(*x)])
    };
    let ([left, right], [top, bottom]) = (ends(0), ends(1));
    let last = |x: i32| x as usize + TAPS - 2;
    left >= 1
        && top >= 1
        && last(right) < s.width
        && last(bottom) < s.height
        && last(bottom) * s.row_stride + (right as usize - 1) * s.channels + ROW <= s.data.len()
}

/// Where the four rows of a box start, wherever that is.
#[inline(always)]
fn start<T>(job: &Job<'_, T>, taps: &Taps, i: usize) -> usize {
    let (x, y) = (taps.at[0][i] as usize, taps.at[1][i] as usize);
    (y - 1) * job.source.row_stride + (x - 1) * job.source.channels
}

/// Where the four rows of a box start in the source, from texel -1 on; `None` where they are not all inside, or fewer than
/// [`ROW`] elements are left from there.
#[inline(always)]
fn inside<T>(job: &Job<'_, T>, taps: &Taps, i: usize) -> Option<usize> {
    let s = &job.source;
    let (x, y) = (taps.at[0][i] as isize as usize, taps.at[1][i] as isize as usize);
    // Negative places are huge ones.
    let is_inside = |i: usize, n: usize| i.wrapping_sub(1) < n.saturating_sub(TAPS - 1);
    if !is_inside(x, s.width) || !is_inside(y, s.height) {
        return None;
    }
    let start = start(job, taps, i);
    (start + (TAPS - 1) * s.row_stride + ROW <= s.data.len()).then_some(start)
}

/// The four rows of a box that reads beyond the source, or close to its end.
#[cold]
fn gathered<T: Sample>(
    job: &Job<'_, T>,
    taps: &Taps,
    i: usize,
    channels: std::ops::Range<usize>,
) -> [[T; ROW]; TAPS] {
    let s = &job.source;
    let mut rows = [[T::default(); ROW]; TAPS];
    for (k, row) in rows.iter_mut().enumerate() {
        let y = job.edges[1].index(i64::from(taps.at[1][i]) + k as i64 - 1, s.height as i64);
        for j in 0..TAPS {
            let x = job.edges[0].index(i64::from(taps.at[0][i]) + j as i64 - 1, s.width as i64);
            let texel = match (x, y) {
                (Some(x), Some(y)) => &s.data[y * s.row_stride + x * s.channels..][..s.channels],
                _ => job.border,
            };
            let n = channels.len();
            row[j * n..(j + 1) * n].copy_from_slice(&texel[channels.clone()]);
        }
    }
    rows
}

/// Means as numbers: the definition for all elements but bytes.
pub(super) fn numbers<T: Sample>(isa: Isa, job: &Job<'_, T>, taps: &Taps, out: Out<'_, T>) {
    match job.source.channels {
        1 => compiled_for(isa, Numbers::<T, 1> { job, taps, out }),
        2 => compiled_for(isa, Numbers::<T, 2> { job, taps, out }),
        3 => compiled_for(isa, Numbers::<T, 3> { job, taps, out }),
        4 => compiled_for(isa, Numbers::<T, 4> { job, taps, out }),
        _ => each_channel(job, taps, out),
    }
}

struct Numbers<'n, 'a, 'o, T: Sample, const C: usize> {
    job: &'n Job<'a, T>,
    taps: &'n Taps,
    out: Out<'o, T>,
}

impl<T: Sample, const C: usize> Work for Numbers<'_, '_, '_, T, C> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { job, taps, mut out } = self;
        let (data, stride) = (job.source.data, job.source.row_stride);
        for i in 0..taps.n {
            match inside(job, taps, i) {
                Some(start) => {
                    let row = |k: usize| {
                        let at = start + k * stride;
                        <&[T; ROW]>::try_from(&data[at..at + ROW]).expect("as many")
                    };
                    mean::<T, C>([row(0), row(1), row(2), row(3)], taps, i, i * C, &mut out);
                }
                None => {
                    let rows = gathered(job, taps, i, 0..C);
                    mean::<T, C>([&rows[0], &rows[1], &rows[2], &rows[3]], taps, i, i * C, &mut out);
                }
            }
        }
    }
}

/// The mean of box `i` over four rows of `C` channels, stored from `at` on.
#[inline(always)]
fn mean<T: Sample, const C: usize>(
    rows: [&[T; ROW]; TAPS],
    taps: &Taps,
    i: usize,
    at: usize,
    out: &mut Out<'_, T>,
) {
    let mut base = [T::Acc::default(); ROW];
    let mut down = [T::Acc::default(); ROW];
    let weights = taps.of(DOWN, i);
    for k in 0..ROW {
        base[k] = rows[1][k].get();
        down[k] = base[k] + rest([rows[0][k].get(), base[k], rows[2][k].get(), rows[3][k].get()], weights);
    }
    let mut means: [T::Acc; C] = std::array::from_fn(|c| {
        let four = four::<T::Acc, C>(&down, c);
        four[1] + rest(four, taps.of(ACROSS, i))
    });
    if taps.leans {
        let weights = taps.of(SLOPE_DOWN, i);
        for k in 0..ROW {
            down[k] = rest([rows[0][k].get(), base[k], rows[2][k].get(), rows[3][k].get()], weights);
        }
        for (c, mean) in means.iter_mut().enumerate() {
            *mean = *mean + rest(four::<T::Acc, C>(&down, c), taps.of(SLOPE_ACROSS, i));
        }
    }
    for (c, mean) in means.into_iter().enumerate() {
        out.put(at + c, mean);
    }
}

/// The texels of a row in one channel.
#[inline(always)]
fn four<A: Real, const C: usize>(row: &[A; ROW], c: usize) -> [A; TAPS] {
    [row[c], row[C + c], row[2 * C + c], row[3 * C + c]]
}

/// What the others add to the base.
#[inline(always)]
fn rest<A: Real>([a, b, c, e]: [A; TAPS], [before, after, last]: [A; 3]) -> A {
    ((a - b) * before + (c - b) * after) + (e - b) * last
}

/// More than four channels, one by one.
fn each_channel<T: Sample>(job: &Job<'_, T>, taps: &Taps, mut out: Out<'_, T>) {
    let channels = job.source.channels;
    for i in 0..taps.n {
        for c in 0..channels {
            let rows = gathered(job, taps, i, c..c + 1);
            let rows = [&rows[0], &rows[1], &rows[2], &rows[3]];
            mean::<T, 1>(rows, taps, i, i * channels + c, &mut out);
        }
    }
}
